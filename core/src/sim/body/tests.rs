//! Touches against sampled distances, contacts and bumpers.

use proptest::prelude::*;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use super::*;
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
                prop_assert!((normal.norm() - 1.0).abs() < 1e-9 && normal.dot(&direction) <= 0.0);
            }
            // A nick between two samples is no contradiction.
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
        segments.extend((0..4).map(|i| Segment::new(room[i], room[(i + 1) % 4])));
        segments.retain(|s| s.distance(Point2::origin()) > model.radius());
        let caster = caster(&segments);
        let mut body = Body::new(&model, &Pose2::identity(), &mut ChaCha8Rng::seed_from_u64(0));
        for (angle, part) in ways {
            let before = body.position;
            body.move_by(Vector2::new(libm::cos(angle), libm::sin(angle)) * (part * fastest), &caster, &[]);
            for s in &segments {
                prop_assert!(s.distance(body.position) >= model.radius() - 1e-9, "inside by {}", model.radius() - s.distance(body.position));
            }
            prop_assert!((body.position - before).norm() <= part * fastest + 1e-9);
            prop_assert!(body.position.x.abs() < 4.0 && body.position.y.abs() < 4.0);
        }
    }
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
    assert!((body.position - Point2::new(1.0 - model.radius(), 0.5)).norm() < 1e-4);
    body.move_by(Vector2::new(2.0, 3.0), &caster, &[]);
    let corner = Point2::new(1.0 - model.radius(), 1.0 - model.radius());
    assert!((body.position - corner).norm() < 1e-4, "{}", body.position);
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
        assert_eq!(body.contacts().walls, 1);
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
