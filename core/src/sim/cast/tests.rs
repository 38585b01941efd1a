//! Rays, fans and clearances compared with trying all walls one by one.

use proptest::prelude::*;

use super::*;
use crate::geom::Segment;

fn wall(ax: f64, ay: f64, bx: f64, by: f64) -> Wall {
    Wall {
        segment: Segment::new(Point2::new(ax, ay), Point2::new(bx, by)),
        material: Material::Opaque,
    }
}

fn brute_force(
    walls: &[Wall],
    origin: Point2<f64>,
    direction: Vector2<f64>,
    max_range: f64,
) -> Option<f64> {
    walls
        .iter()
        .filter_map(|w| w.segment.hit_by_ray(origin, direction))
        .filter(|d| *d <= max_range)
        .min_by(f64::total_cmp)
}

fn check(walls: &[Wall], origin: Point2<f64>, angle: f64, max_range: f64) {
    let direction = Vector2::new(libm::cos(angle), libm::sin(angle));
    let caster = Caster::new(walls.to_vec());
    let hit = caster.cast(origin, direction, max_range);
    let expect = brute_force(walls, origin, direction, max_range);
    match (hit, expect) {
        (Some(hit), Some(expect)) => {
            assert!(
                (hit.distance - expect).abs() < 1e-9,
                "{hit:?} against {expect}"
            );
            let surface = walls[hit.surface].segment;
            assert!(surface.distance(origin + direction * hit.distance) < 1e-6);
        }
        (None, None) => {}
        (hit, expect) => panic!("{hit:?} against {expect:?} from {origin} at {angle}"),
    }
}

fn walls(most: usize) -> impl Strategy<Value = Vec<Wall>> {
    let one = (
        -20.0..20.0_f64,
        -20.0..20.0_f64,
        -6.0..6.0_f64,
        -6.0..6.0_f64,
    )
        .prop_map(|(x, y, dx, dy)| wall(x, y, x + dx, y + dy));
    proptest::collection::vec(one, 0..most)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn first_hit_is_the_nearest_of_all_walls(
        walls in walls(60), x in -30.0..30.0_f64, y in -30.0..30.0_f64, angle in -3.2..3.2_f64, range in 0.1..60.0_f64,
    ) {
        check(&walls, Point2::new(x, y), angle, range);
    }

    #[test]
    fn fans_find_what_single_rays_find_to_the_bit(
        walls in walls(60), x in -30.0..30.0_f64, y in -30.0..30.0_f64, heading in -9.0..9.0_f64, range in 0.1..60.0_f64,
        beams in 1..80_usize, first in -4.0..4.0_f64, part in 0.05..1.0_f64,
    ) {
        let caster = Caster::new(walls);
        let mut fan = Fan::new(beams, first, part * std::f64::consts::TAU / beams as f64).unwrap();
        let origin = Point2::new(x, y);
        // Again from elsewhere: nothing of the first cast may remain.
        caster.cast_fan(Point2::new(y, x), 1.0, 50.0, &mut fan);
        caster.cast_fan(origin, heading, range, &mut fan);
        for beam in 0..beams {
            let alone = caster.cast(origin, fan.direction(beam).unwrap(), range);
            prop_assert_eq!(fan.distances()[beam], alone.map_or(f64::INFINITY, |hit| hit.distance));
            prop_assert_eq!(fan.surface(beam), alone.map(|hit| hit.surface));
        }
    }

    #[test]
    fn axis_aligned_rays_and_walls_on_cell_borders_are_no_exception(
        corners in proptest::collection::vec((-8..8_i32, -8..8_i32, 1..5_i32, any::<bool>()), 1..40),
        x in -9..9_i32, y in -9..9_i32, quarter in 0..4_i32,
    ) {
        let walls: Vec<Wall> = corners.iter().map(|&(x, y, length, upright)| {
            let (x, y, length) = (f64::from(x), f64::from(y), f64::from(length));
            if upright { wall(x, y, x, y + length) } else { wall(x, y, x + length, y) }
        }).collect();
        // Half a metre off the lattice, so the ray does not run along a wall or through its end.
        let origin = Point2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
        check(&walls, origin, f64::from(quarter) * std::f64::consts::FRAC_PI_2, 50.0);
    }

    #[test]
    fn clearance_is_the_least_distance(walls in walls(40), x in -30.0..30.0_f64, y in -30.0..30.0_f64, reach in 0.1..9.0_f64) {
        let point = Point2::new(x, y);
        let expect = walls.iter().map(|w| w.segment.distance(point)).fold(reach, f64::min);
        prop_assert_eq!(Caster::new(walls).clearance(point, reach), expect);
    }
}

#[test]
fn corners_of_closed_rooms_have_no_crack() {
    // Through the exact corner in floating point: every ray must end.
    let shape = crate::sim::Shape::Circle {
        centre: Point2::new(0.3, 0.1),
        radius: 3.0,
    };
    let walls: Vec<Wall> = shape
        .segments()
        .iter()
        .map(|s| Wall {
            segment: *s,
            material: Material::Opaque,
        })
        .collect();
    let caster = Caster::new(walls.clone());
    for origin in [
        Point2::new(0.3, 0.1),
        Point2::new(1.0, -1.0),
        Point2::new(-0.7, 0.33),
    ] {
        for wall in &walls {
            let direction = (wall.segment.a - origin).normalize();
            assert!(caster.cast(origin, direction, 10.0).is_some());
        }
    }
}

#[test]
fn rays_that_are_not_finite_hit_nothing() {
    let caster = Caster::new(vec![wall(1.0, -1.0, 1.0, 1.0)]);
    let ahead = Vector2::new(1.0, 0.0);
    assert_eq!(
        caster
            .cast(Point2::origin(), ahead, 5.0)
            .map(|h| h.distance),
        Some(1.0)
    );
    assert_eq!(caster.cast(Point2::origin(), ahead, 0.5), None);
    assert_eq!(caster.cast(Point2::new(f64::NAN, 0.0), ahead, 5.0), None);
    assert_eq!(
        caster.cast(Point2::origin(), Vector2::new(f64::NAN, 0.0), 5.0),
        None
    );
    assert_eq!(
        caster.cast(Point2::new(f64::INFINITY, 0.0), ahead, 5.0),
        None
    );
    assert_eq!(Caster::new(vec![]).cast(Point2::origin(), ahead, 5.0), None);
}

#[test]
fn fans_begin_on_walls_and_corners_and_outside_of_the_building() {
    let walls = vec![
        wall(0.0, 0.0, 4.0, 0.0),
        wall(4.0, 0.0, 4.0, 3.0),
        wall(4.0, 3.0, 0.0, 3.0),
        wall(0.0, 3.0, 0.0, 0.0),
        wall(1.0, 1.0, 3.0, 2.0),
    ];
    let caster = Caster::new(walls);
    let mut fan = Fan::new(97, -3.0, std::f64::consts::TAU / 97.0).unwrap();
    for (x, y) in [
        (2.0, 1.5),
        (4.0, 3.0),
        (2.0, 0.0),
        (-1e6, 1.0),
        (900.0, -900.0),
        (f64::NAN, 0.0),
    ] {
        let origin = Point2::new(x, y);
        caster.cast_fan(origin, 0.3, 1e7, &mut fan);
        for beam in 0..97 {
            let alone = caster.cast(origin, fan.direction(beam).unwrap(), 1e7);
            let alone = alone.map_or(f64::INFINITY, |hit| hit.distance);
            assert_eq!(fan.distances()[beam], alone, "beam {beam} from {origin}");
        }
    }
    assert!(Fan::new(361, 0.0, 0.0175).is_none());
    assert!(Fan::new(4, f64::NAN, 0.1).is_none());
    assert!(Fan::new(4, 0.0, -0.1).is_none());
}

#[test]
fn rays_on_the_border_of_two_cells_arrive() {
    // A ray that never leaves its row once crept along the border because of rounding errors, until
    // it was given up.
    let walls = vec![
        wall(-3.0, -2.0, 5.0, -2.0),
        wall(5.0, -2.0, 5.0, 4.0),
        wall(5.0, 4.0, -3.0, 4.0),
        wall(-3.0, 4.0, -3.0, -2.0),
    ];
    let caster = Caster::new(walls.clone());
    let size = 1.0 / caster.per_metre;
    for border in 2..8 {
        let origin = caster.low + Vector2::new(size, size) * f64::from(border);
        for quarter in 0..4 {
            let angle = f64::from(quarter) * std::f64::consts::FRAC_PI_2;
            check(&walls, origin, angle, 50.0);
        }
    }
}
