//! Touches compared with sampled distances; contacts and bumpers.

use proptest::prelude::*;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use super::*;
use crate::geom::Length;
use crate::robot::BodyShape;
use crate::sim::{Material, Wall};

fn caster(segments: &[Segment]) -> Caster {
    let wall = |&segment: &Segment| Wall {
        segment,
        material: Material::Opaque,
    };
    Caster::new(segments.iter().map(wall).collect())
}

fn segment() -> impl Strategy<Value = Segment> {
    (-3.0..3.0_f64, -3.0..3.0_f64, -2.0..2.0_f64, -2.0..2.0_f64)
        .prop_map(|(x, y, dx, dy)| Segment::new(Point2::new(x, y), Point2::new(x + dx, y + dy)))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(500))]

    #[test]
    fn touch_is_where_the_distance_first_falls_to_the_radius(s in segment(), angle in -3.2..3.2_f64, radius in 0.05..0.5_f64) {
        let from = Point2::origin();
        prop_assume!(s.distance(from) > radius);
        let direction = Vector2::new(libm::cos(angle), libm::sin(angle));
        let step = 1e-3;
        let sampled = (0..8000).map(|i| f64::from(i) * step).find(|t| s.distance(from + direction * *t) < radius);
        match (touch_of_segment(&s, from, direction, radius), sampled) {
            (Some((reach, normal)), Some(t)) => {
                prop_assert!(reach <= t && t - reach < 1.5 * step, "{reach} {t}");
                prop_assert!((s.distance(from + direction * reach) - radius).abs() < 1e-9);
                prop_assert!((normal.length() - 1.0).abs() < 1e-9 && normal.dot(&direction) <= 0.0);
            }
            // Grazing between two samples is no contradiction.
            (Some((reach, _)), None) => prop_assert!(s.distance(from + direction * (reach + step)) > radius - step || reach > 7.9),
            (None, Some(t)) => prop_assert!(false, "touches at {t}"),
            (None, None) => {}
        }
    }

    #[test]
    fn never_inside_of_a_wall_and_never_through_it_at_any_speed(
        walls in proptest::collection::vec(segment(), 1..25),
        ways in proptest::collection::vec((-3.2..3.2_f64, 0.0..1.0_f64), 1..40),
        fastest in 0.001..5.0_f64,
    ) {
        let model = RobotModel::rp6();
        let room = [(-4.0, -4.0), (4.0, -4.0), (4.0, 4.0), (-4.0, 4.0)].map(|(x, y)| Point2::new(x, y));
        let mut segments: Vec<Segment> = walls;
        segments.extend(crate::geom::sides_of(&room).map(|(a, b)| Segment::new(*a, *b)));
        segments.retain(|s| s.distance(Point2::origin()) > model.radius());
        let caster = caster(&segments);
        let mut body = Body::new(&model, &Pose2::identity(), &mut ChaCha8Rng::seed_from_u64(0));
        for (angle, part) in ways {
            let before = body.position;
            body.move_by(Vector2::new(libm::cos(angle), libm::sin(angle)) * (part * fastest), &caster, &[]);
            for s in &segments {
                prop_assert!(s.distance(body.position) >= model.radius() - 1e-9, "inside by {}", model.radius() - s.distance(body.position));
            }
            prop_assert!((body.position - before).length() <= part * fastest + 1e-9);
            prop_assert!(body.position.x.abs() < 4.0 && body.position.y.abs() < 4.0);
        }
    }
}

/// A body 50 cm long and 30 cm wide.
fn long() -> RobotModel {
    RobotModel {
        length: 0.5,
        width: 0.3,
        shape: BodyShape::Rectangle,
        ..RobotModel::rp6()
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(150))]

    #[test]
    fn no_place_of_a_wall_is_ever_inside_of_an_outline_and_a_motion_that_is_free_is_done_whole(
        walls in proptest::collection::vec(segment(), 1..12),
        ways in proptest::collection::vec((-3.2..3.2_f64, 0.0..0.02_f64, -0.05..0.05_f64), 1..60),
    ) {
        let model = long();
        let outline = model.outline(0.0).unwrap();
        let mut segments: Vec<Segment> = walls;
        segments.retain(|s| s.distance(Point2::origin()) > model.radius());
        let caster = caster(&segments);
        let mut body = Body::new(&model, &Pose2::identity(), &mut ChaCha8Rng::seed_from_u64(0));
        for (angle, length, turn) in ways {
            let way = Vector2::new(libm::cos(angle), libm::sin(angle)) * length;
            let before = body.pose();
            let lost = body.move_outline(&outline, (way, turn), &caster, &[]);
            // Points of the walls, every millimetre or so, in the frame of the body.
            let depth = |pose: &Pose2| {
                let inverse = pose.inverse();
                let points = segments.iter().flat_map(|s| (0..=2000).map(move |i| s.a + s.vector() * (f64::from(i) / 2000.0)));
                let into = points.map(|p| inverse * p).map(|p| (0.25 - p.x.abs()).min(0.15 - p.y.abs()));
                into.fold(f64::NEG_INFINITY, f64::max)
            };
            prop_assert!(depth(&body.pose()) <= 1e-9, "{} m inside", depth(&body.pose()));
            let whole = (0..=20).map(|i| f64::from(i) / 20.0).map(|part| {
                depth(&Pose2::new(before.x() + way.x * part, before.y() + way.y * part, before.heading() + turn * part))
            });
            let aim = Pose2::new(before.x() + way.x, before.y() + way.y, before.heading() + turn);
            let is_done = (body.position - aim.position()).length() < 1e-9 && wrap(body.heading - aim.heading()).abs() < 1e-9;
            // Sampled every fraction of a millimetre; samples decide nothing at smaller distances.
            match whole.fold(f64::NEG_INFINITY, f64::max) {
                deepest if deepest < -2e-3 => prop_assert!(is_done && lost.length() < 1e-12, "{deepest}: {:?} not {aim:?}", body.pose()),
                deepest if deepest > 2e-3 => prop_assert!(!is_done, "{deepest}"),
                _ => {}
            }
        }
    }
}

#[test]
fn an_outline_slides_along_a_wall_touches_it_once_and_cannot_turn_in_a_narrow_corridor() {
    let walls = [
        Segment::new(Point2::new(-5.0, 0.2), Point2::new(5.0, 0.2)),
        Segment::new(Point2::new(-5.0, -0.2), Point2::new(5.0, -0.2)),
    ];
    let caster = caster(&walls);
    let mut rng = ChaCha8Rng::seed_from_u64(0);
    let mut body = Body::new(&long(), &Pose2::identity(), &mut rng);
    let outline = long().outline(0.0).unwrap();
    for _ in 0..200 {
        body.move_outline(&outline, (Vector2::new(0.005, 0.001), 0.0), &caster, &[]);
        body.feel((Vector2::new(0.005, 0.0), 0.0), &caster, &[]);
    }
    // Its side is 15 cm from its middle.
    assert!((body.position - Point2::new(1.0, 0.05)).length() < 1e-4);
    assert_eq!(body.contacts.walls, 1);
    body.move_outline(&outline, (Vector2::new(0.0, -0.05), 0.0), &caster, &[]);
    for _ in 0..200 {
        body.move_outline(&outline, (Vector2::zeros(), 0.01), &caster, &[]);
    }
    // A corner meets a wall where 0.25 sin h + 0.15 cos h = 0.2.
    let most = libm::asin(0.2 / libm::hypot(0.25, 0.15)) - libm::atan2(0.15, 0.25);
    assert!(
        (body.heading - most).abs() < 1e-3,
        "{} {most}",
        body.heading
    );
}

#[test]
fn slides_along_a_wall_and_stops_in_a_corner() {
    let model = RobotModel::rp6();
    let caster = caster(&[
        Segment::new(Point2::new(1.0, -5.0), Point2::new(1.0, 1.0)),
        Segment::new(Point2::new(1.0, 1.0), Point2::new(-5.0, 1.0)),
    ]);
    let mut body = Body::new(
        &model,
        &Pose2::identity(),
        &mut ChaCha8Rng::seed_from_u64(0),
    );
    body.move_by(Vector2::new(2.0, 0.5), &caster, &[]);
    assert!((body.position - Point2::new(1.0 - model.radius(), 0.5)).length() < 1e-4);
    body.move_by(Vector2::new(2.0, 3.0), &caster, &[]);
    let corner = Point2::new(1.0 - model.radius(), 1.0 - model.radius());
    assert!(
        (body.position - corner).length() < 1e-4,
        "{}",
        body.position
    );
}

#[test]
fn a_long_touch_is_one_contact_and_presses_the_bumper_on_its_side() {
    let model = RobotModel::rp6();
    let caster = caster(&[Segment::new(Point2::new(0.3, -5.0), Point2::new(0.3, 5.0))]);
    let mut rng = ChaCha8Rng::seed_from_u64(0);
    for (heading, expect) in [
        (0.0, (true, true)),
        (0.5, (false, true)),
        (-0.5, (true, false)),
    ] {
        let mut body = Body::new(
            &model,
            &Pose2::new(0.0, 0.0, heading),
            &mut ChaCha8Rng::seed_from_u64(0),
        );
        for _ in 0..200 {
            let way = Tracks {
                left: 0.001_5,
                right: 0.001_5,
            };
            body.step(&way, &caster, &[], &mut rng);
        }
        assert_eq!(body.contacts.walls, 1);
        let bumpers = body.bumpers();
        assert_eq!(
            (bumpers.left, bumpers.right),
            expect,
            "at {heading}: {}",
            body.heading
        );
        for _ in 0..20 {
            let way = Tracks {
                left: -0.001_5,
                right: -0.001_5,
            };
            body.step(&way, &caster, &[], &mut rng);
        }
        assert_eq!(body.bumpers(), Bumpers::default());
    }
}
