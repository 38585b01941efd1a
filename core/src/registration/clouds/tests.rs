//! Every method on rooms and corridors whose pose is known; the parts compared with brute force.

mod advice;
mod basin;
mod judge;
mod trace;

use nalgebra::Point2;
use proptest::prelude::*;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use super::bearings::Bearings;
use super::neighbours::Neighbours;
use super::*;
use crate::geom::{Length, Segment, unit_vector};
use crate::lanes::{Kernel, Lanes};
use crate::points::fixture::normal;
use crate::registration::Verdict;

/// A room of 8 m x 6 m with a pillar and a niche.
fn room() -> Vec<Segment> {
    let corners = [
        [-3.0, -2.0],
        [5.0, -2.0],
        [5.0, 1.0],
        [6.0, 1.0],
        [6.0, 4.0],
        [-3.0, 4.0],
    ];
    let pillar = [[1.5, 1.0], [2.0, 1.0], [2.0, 1.5], [1.5, 1.5]];
    let ring = |corners: &[[f64; 2]]| {
        let next = corners.iter().cycle().skip(1);
        let wall =
            |(a, b): (&[f64; 2], &[f64; 2])| Segment::new(Point2::from(*a), Point2::from(*b));
        corners.iter().zip(next).map(wall).collect::<Vec<_>>()
    };
    [ring(&corners), ring(&pillar)].concat()
}

/// Two walls 2 m apart, without ends in sight.
fn corridor() -> Vec<Segment> {
    let wall = |y| Segment::new(Point2::new(-100.0, y), Point2::new(100.0, y));
    vec![wall(-1.0), wall(1.0)]
}

/// What 360 beams see from `pose`, up to 8 m, with this much noise.
fn look(walls: &[Segment], pose: &Pose2, sigma: f64, seed: u64) -> Cloud {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let beams = (0..360).filter_map(|degree| {
        let bearing = f64::from(degree - 180).to_radians();
        let direction = pose.rotate(unit_vector(bearing));
        let hits = walls
            .iter()
            .filter_map(|w| w.hit_by_ray(pose.position(), direction));
        let range = hits.min_by(f64::total_cmp).filter(|range| *range < 8.0)?;
        Some(Point2::from(
            unit_vector(bearing) * (range + sigma * normal(&mut rng)),
        ))
    });
    Cloud::scan(beams.collect()).unwrap()
}

fn register(moving: &Cloud, fixed: &Cloud, method: &CloudMethod) -> Registration {
    let start = Pose2::identity();
    register_clouds(moving, fixed, &start, method, &JudgeConfig::default())
}

#[test]
fn every_method_finds_the_motion_between_two_scans_of_a_room() {
    let truth = Pose2::new(0.25, -0.15, 0.12);
    for seed in 0..5 {
        let fixed = look(&room(), &Pose2::identity(), 0.01, 2 * seed);
        let moving = look(&room(), &truth, 0.01, 2 * seed + 1);
        for (name, method) in CloudMethod::all() {
            let found = register(&moving, &fixed, &method);
            let off = found.estimate.pose.minus(&truth);
            let (shift, turn) = (off.xy().length(), off.z.abs());
            // Methods that pair points with points err by the distance between samples.
            let most = match name {
                "point-to-line" | "surface-to-surface" | "correlation" => (0.005, 0.002),
                _ => (0.06, 0.02),
            };
            assert!(
                shift < most.0 && turn < most.1,
                "{name} {seed}: {shift} {turn} {found:?}"
            );
            assert_eq!(
                found.verdict,
                Verdict::Converged,
                "{name} {seed}: {found:?}"
            );
            assert!(
                found.overlap > 0.5 && found.iterations > 0,
                "{name} {seed}: {found:?}"
            );
        }
    }
}

#[test]
fn every_method_says_that_a_corridor_tells_nothing_of_the_way_along() {
    let (here, there) = (Pose2::new(0.0, 0.1, 0.05), Pose2::new(0.2, -0.1, 0.15));
    let (fixed, moving) = (
        look(&corridor(), &here, 0.01, 1),
        look(&corridor(), &there, 0.01, 2),
    );
    for (name, method) in CloudMethod::all() {
        let found = register(&moving, &fixed, &method);
        let Verdict::Degenerate { direction } = found.verdict else {
            panic!("{name}: {found:?}");
        };
        let axis = here.inverse().rotate(nalgebra::Vector2::x());
        assert!(
            direction.dot(&axis).abs() > 0.99,
            "{name}: {direction} {axis}"
        );
        // Across the corridor and in its heading it is still right.
        let off = (here * found.estimate.pose).minus(&there);
        assert!(off.y.abs() < 0.03 && off.z.abs() < 0.02, "{name}: {off}");
    }
}

/// A method is right within the covariance that it claims: NEES with 3 degrees of freedom.
#[test]
fn covariances_of_points_to_lines_are_honest() {
    let (mut nees, mut count) = (0.0, 0.0);
    let method = CloudMethod::Icp(IcpConfig::default());
    for seed in 0..150 {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut number = || 0.1 * normal(&mut rng);
        let truth = Pose2::new(number(), number(), number());
        let fixed = look(&room(), &Pose2::identity(), 0.02, 1000 + seed);
        let moving = look(&room(), &truth, 0.02, 2000 + seed);
        let found = register(&moving, &fixed, &method);
        assert_eq!(found.verdict, Verdict::Converged, "{seed}");
        nees += found.estimate.nees(&truth).unwrap();
        count += 1.0;
    }
    let mean = nees / count;
    assert!((1.5..4.5).contains(&mean), "{mean}");
}

#[test]
fn another_room_is_no_place_to_be() {
    let fixed = look(&room(), &Pose2::identity(), 0.01, 1);
    let elsewhere = [[-1.0, -1.5], [1.2, -0.4], [0.3, 2.5], [-2.0, 0.8]];
    let next = elsewhere.iter().cycle().skip(1);
    let walls: Vec<_> = (elsewhere.iter().zip(next))
        .map(|(a, b)| Segment::new(Point2::from(*a), Point2::from(*b)))
        .collect();
    let moving = look(&walls, &Pose2::new(-0.4, 0.3, 0.0), 0.01, 2);
    for (name, method) in CloudMethod::all() {
        let found = register(&moving, &fixed, &method);
        assert_ne!(found.verdict, Verdict::Converged, "{name}: {found:?}");
    }
}

#[test]
fn clouds_of_nothing_or_of_one_place_are_answered() {
    let room = look(&room(), &Pose2::identity(), 0.01, 1);
    let clouds = [
        vec![],
        vec![Point2::new(1.0, 2.0)],
        vec![Point2::new(1.0, 2.0); 50],
        vec![Point2::origin(); 3],
    ];
    for points in clouds {
        let as_scan = Cloud::scan(points.clone()).unwrap();
        let as_any = Cloud::any(points).unwrap();
        for cloud in [as_scan, as_any] {
            for (name, method) in CloudMethod::all() {
                for (moving, fixed) in [(&cloud, &room), (&room, &cloud), (&cloud, &cloud)] {
                    let found = register(moving, fixed, &method);
                    assert_ne!(found.verdict, Verdict::Converged, "{name}: {found:?}");
                    assert!(found.estimate.pose.is_finite(), "{name}: {found:?}");
                }
            }
        }
    }
    let nan = vec![Point2::new(0.0, 1.0), Point2::new(f64::NAN, 0.0)];
    assert_eq!(
        Cloud::scan(nan).unwrap_err(),
        CloudError::NotFinite { index: 1 }
    );
    let many = vec![Point2::new(0.0, 1.0); Cloud::MOST_POINTS + 1];
    assert!(matches!(
        Cloud::any(many),
        Err(CloudError::TooManyPoints { .. })
    ));
}

/// Each option of ICP finds the motion as well.
#[test]
fn every_form_of_icp_finds_the_motion() {
    let truth = Pose2::new(0.1, -0.1, 0.06);
    let fixed = look(&room(), &Pose2::identity(), 0.01, 1);
    let moving = look(&room(), &truth, 0.01, 2);
    let default = IcpConfig::default;
    let forms = [
        IcpConfig {
            selection: Selection::Random {
                count: 120,
                seed: 1,
            },
            ..default()
        },
        IcpConfig {
            selection: Selection::UniformNormals { count: 120 },
            ..default()
        },
        IcpConfig {
            selection: Selection::KeyPoints { bend: 0.3 },
            ..IcpConfig::point_to_point()
        },
        IcpConfig {
            association: Association::Nearest,
            ..default()
        },
        IcpConfig {
            association: Association::AlongNormal,
            ..default()
        },
        IcpConfig {
            weighting: Weighting::ByNormals,
            ..default()
        },
        IcpConfig {
            weighting: Weighting::ByDistance,
            ..default()
        },
        IcpConfig {
            kernel: RobustKernel::Huber,
            ..default()
        },
        IcpConfig {
            kernel: RobustKernel::None,
            kept: 0.8,
            ..default()
        },
        IcpConfig {
            is_mutual: true,
            ..default()
        },
    ];
    for form in forms {
        let found = register(&moving, &fixed, &CloudMethod::Icp(form));
        let off = found.estimate.pose.minus(&truth);
        let most = if form.metric == Metric::PointToPoint {
            0.05
        } else {
            0.01
        };
        assert!(
            off.xy().length() < most && off.z.abs() < most,
            "{form:?}: {off}"
        );
    }
}

/// Points without an order are registered by their surfaces too.
#[test]
fn clouds_that_no_sensor_saw_are_registered() {
    let truth = Pose2::new(0.1, -0.1, 0.06);
    let fixed = look(&room(), &Pose2::identity(), 0.01, 1);
    let moving = look(&room(), &truth, 0.01, 2);
    let shuffled = |cloud: &Cloud| {
        let points = cloud.points();
        let at = |i: usize| points[i * 101 % points.len()];
        Cloud::any((0..points.len()).map(at).collect()).unwrap()
    };
    let found = register(
        &shuffled(&moving),
        &shuffled(&fixed),
        &CloudMethod::Icp(IcpConfig::default()),
    );
    let off = found.estimate.pose.minus(&truth);
    assert!(off.xy().length() < 0.01 && off.z.abs() < 0.005, "{off}");
    assert_eq!(found.verdict, Verdict::Converged);
}

/// A search for the nearest point by its bearing.
struct Nearest<'a>(&'a Bearings, &'a Point2<f64>);

impl Kernel for Nearest<'_> {
    type Output = Option<(usize, f64)>;

    #[inline(always)]
    fn run<L: Lanes>(self, machine: L::Machine) -> Self::Output {
        self.0.nearest::<L>(machine, self.1)
    }
}

proptest! {
    #[test]
    fn the_nearest_point_by_tree_is_the_nearest_of_all(
        points in prop::collection::vec((-5.0..5.0, -5.0..5.0), 1..80),
        place in (-6.0..6.0, -6.0..6.0),
    ) {
        let points: Vec<_> = points.into_iter().map(|(x, y)| Point2::new(x, y)).collect();
        let place = Point2::new(place.0, place.1);
        let least = points.iter().map(|p| (p - place).norm_squared()).fold(f64::INFINITY, f64::min);
        let (_, square) = Neighbours::of(&points).nearest(place).unwrap();
        prop_assert!((square - least).abs() < 1e-12);
        let few = Neighbours::of(&points).nearest_few(place, 5);
        prop_assert_eq!(few.len(), points.len().min(5));
    }

    /// For a wall all round, however it bends, the bearing finds the point nearest to a place near
    /// the wall.
    #[test]
    fn the_nearest_point_by_bearing_is_the_nearest_of_a_smooth_wall(
        bend in 0.0..0.3_f64, lobes in 1..5_u32, bearing in 0.0..std::f64::consts::TAU, off in -0.2..0.2_f64,
    ) {
        let range = |b: f64| 3.0 + bend * libm::cos(f64::from(lobes) * b);
        let mut points: Vec<_> = (0..360)
            .map(|degree| f64::from(degree).to_radians())
            .map(|b| Point2::from(unit_vector(b) * range(b)))
            .collect();
        let view = Bearings::sort(&mut points);
        let place = Point2::from(unit_vector(bearing) * (range(bearing) + off));
        let least = points.iter().map(|p| (p - place).norm_squared()).fold(f64::INFINITY, f64::min);
        let (at, square) = crate::lanes::run(Nearest(&view, &place)).unwrap();
        prop_assert!((square - least).abs() < 1e-12, "{} {}", square, least);
        prop_assert!(((points[at] - place).norm_squared() - square).abs() < 1e-12);
        let [before, after] = view.about(&place);
        prop_assert!(points[before].coords.perp(&place.coords) > -1e-9);
        prop_assert!(points[after].coords.perp(&place.coords) < 1e-9);
    }
}

/// The noise that a cloud estimates is the noise that was added; corners and gaps do not count.
#[test]
fn noise_of_a_cloud_is_that_of_its_sensor() {
    for sigma in [0.005, 0.01, 0.02] {
        let mut found: Vec<f64> = (0..20)
            .filter_map(|seed| look(&room(), &Pose2::identity(), sigma, seed).sigma())
            .collect();
        found.sort_by(f64::total_cmp);
        let middle = found[10];
        assert!((0.7..1.3).contains(&(middle / sigma)), "{sigma}: {middle}");
    }
}
