//! Matching compared with known poses, central differences, Monte Carlo runs, and in corridors.

use nalgebra::Point2;
use proptest::prelude::*;

use super::super::{register, sums};
use super::*;
use crate::geom::{Length, wrap};
use crate::map::{SurfelConfig, SurfelMap};

pub(in crate::registration) type Corner = (f64, f64);

/// Points every 5 cm along segments, normals to the left of their direction.
pub(in crate::registration) fn walls(segments: &[(Corner, Corner)]) -> Vec<OrientedPoint> {
    let mut points = vec![];
    for &((ax, ay), (bx, by)) in segments {
        let (a, b) = (Point2::new(ax, ay), Point2::new(bx, by));
        let along = (b - a) / (b - a).length();
        let normal = Vector2::new(-along.y, along.x);
        let n = ((b - a).length() / 0.05) as usize;
        points.extend((0..n).map(|i| OrientedPoint {
            position: a + along * (i as f64 * 0.05 + 0.01),
            normal,
        }));
    }
    points
}

pub(in crate::registration) fn room() -> Vec<OrientedPoint> {
    walls(&[
        ((-3.0, -2.0), (3.0, -2.0)),
        ((3.0, -2.0), (3.0, 2.0)),
        ((3.0, 2.0), (-1.0, 2.0)),
        ((-3.0, 1.0), (-3.0, -2.0)),
    ])
}

pub(in crate::registration) fn seen_from(
    points: &[OrientedPoint],
    pose: &Pose2,
) -> Vec<OrientedPoint> {
    let back = pose.inverse();
    points
        .iter()
        .map(|p| OrientedPoint {
            position: back * p.position,
            normal: back.rotate(p.normal),
        })
        .collect()
}

pub(in crate::registration) fn map_of(points: &[OrientedPoint]) -> SurfelMap {
    let mut map = SurfelMap::new(SurfelConfig {
        half_side: 16.0,
        ..SurfelConfig::default()
    });
    map.insert(points.iter().copied());
    map
}

fn weak(pose: Pose2) -> Prior {
    Prior {
        pose,
        information: Matrix3::from_diagonal_element(1e-3),
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 100, ..ProptestConfig::default() })]
    #[test]
    fn comes_back_to_the_true_pose(
        x in -0.2..0.2_f64, y in -0.2..0.2_f64, t in -0.1..0.1_f64, h in -3.1..3.1_f64,
    ) {
        let truth = Pose2::new(0.5, -0.3, h);
        let start = Pose2::new(0.5 + x, -0.3 + y, h + t);
        let found = register(&seen_from(&room(), &truth), &map_of(&room()), &start, &weak(start), &MatchConfig::default());
        prop_assert_eq!(found.verdict, Verdict::Converged);
        prop_assert!((found.estimate.pose.position() - truth.position()).length() < 2e-3, "{:?}", found);
        prop_assert!(wrap(found.estimate.pose.heading() - h).abs() < 1e-3);
        prop_assert!(found.overlap > 0.95 && found.estimate.cov.cholesky().is_some());
    }

    #[test]
    fn hessian_and_gradient_are_those_of_central_differences(
        x in -0.05..0.05_f64, y in -0.05..0.05_f64, t in -0.02..0.02_f64, method in 0..2_usize,
    ) {
        let (_, method, _) = RegistrationMethod::ALL[method];
        // With a kernel so wide that it has no effect, the cost is half the sum of squares.
        let (points, map, config) = (room(), map_of(&room()), MatchConfig { method, ..MatchConfig::default() });
        let cost = |dx: f64, dy: f64, dt: f64| {
            let pose = Pose2::new(x + dx, y + dy, t + dt);
            0.5 * sums(&points, &map, &pose, 1e6, &config).squares
        };
        let found = sums(&points, &map, &Pose2::new(x, y, t), 1e6, &config);
        let h = 1e-7;
        let numeric = Vector3::new(
            cost(h, 0.0, 0.0) - cost(-h, 0.0, 0.0), cost(0.0, h, 0.0) - cost(0.0, -h, 0.0), cost(0.0, 0.0, h) - cost(0.0, 0.0, -h),
        ) / (2.0 * h);
        // A point that changes its cell between the two sides causes a jump; few starts meet one.
        prop_assume!((numeric - found.gradient).length() < 10.0);
        prop_assert!((numeric - found.gradient).length() < 1e-3 * (1.0 + found.gradient.length()), "{} {}", numeric, found.gradient);
    }
}

#[test]
fn distances_to_points_come_back_as_well_and_take_more_iterations() {
    let truth = Pose2::new(0.5, -0.3, 0.4);
    let start = Pose2::new(0.6, -0.25, 0.43);
    let by = |method| {
        let config = MatchConfig {
            method,
            max_iterations: 200,
            ..MatchConfig::default()
        };
        let points = seen_from(&room(), &truth);
        let found = register(&points, &map_of(&room()), &start, &weak(start), &config);
        let off = (found.estimate.pose.position() - truth.position()).length();
        (off, found.iterations)
    };
    let (line, point) = (
        by(RegistrationMethod::PointToLine),
        by(RegistrationMethod::PointToPoint),
    );
    // Surfels lie where points were seen, up to half a cell beside those of this scan.
    assert!(line.0 < 2e-3 && point.0 < 0.03, "{line:?} {point:?}");
    assert!(point.1 > line.1, "{line:?} {point:?}");
}

#[test]
fn corridor_reports_the_direction_along_it_and_keeps_the_prior_there() {
    let corridor = walls(&[((-5.0, -1.0), (5.0, -1.0)), ((5.0, 1.0), (-5.0, 1.0))]);
    let start = Pose2::new(0.15, 0.1, 0.03);
    let prior = Prior {
        pose: start,
        information: Matrix3::from_diagonal_element(1.0),
    };
    let found = register(
        &corridor,
        &map_of(&corridor),
        &start,
        &prior,
        &MatchConfig::default(),
    );
    let Verdict::Degenerate { direction } = found.verdict else {
        panic!("{found:?}")
    };
    assert!(direction.y.abs() < 0.01, "{direction}");
    let pose = found.estimate.pose;
    assert!(
        (pose.x() - 0.15).abs() < 0.01 && pose.y().abs() < 1e-3,
        "{pose:?}"
    );
    assert!(found.estimate.cov[(0, 0)] > 0.5 && found.estimate.cov[(1, 1)] < 1e-4);
}

#[test]
fn noisy_normals_along_a_corridor_do_not_pull_the_pose_off_a_weak_prior() {
    use rand::{RngExt, SeedableRng};
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(1);
    // Normals 0.1 rad off: they seem to determine the direction along the walls with a hundredth of
    // the points' information.
    let mut crooked = || {
        let mut points = walls(&[((-5.0, -1.0), (5.0, -1.0)), ((5.0, 1.0), (-5.0, 1.0))]);
        for point in &mut points {
            let turn = Pose2::new(0.0, 0.0, rng.random_range(-0.17..0.17));
            point.normal = turn.rotate(point.normal);
        }
        points
    };
    let (map, points) = (map_of(&crooked()), crooked());
    let start = Pose2::new(0.15, 0.05, 0.02);
    let found = register(&points, &map, &start, &weak(start), &MatchConfig::default());
    let Verdict::Degenerate { direction } = found.verdict else {
        panic!("{found:?}")
    };
    assert!(direction.x.abs() > 0.99, "{direction}");
    // A prior of 30 m keeps the position along the corridor to the millimetre, and its own
    // uncertainty there.
    let pose = found.estimate.pose;
    assert!((pose.x() - 0.15).abs() < 5e-3, "{pose:?}");
    assert!(pose.y().abs() < 0.01 && pose.heading().abs() < 2e-3);
    assert!(found.estimate.cov[(0, 0)] > 900.0, "{:?}", found.estimate);
}

#[test]
fn silencing_a_motion_leaves_what_is_said_of_the_others() {
    let free = Vector3::new(0.6, 0.8, -0.3);
    let hessian = Matrix3::new(4.0, 1.0, 0.5, 1.0, 3.0, -0.2, 0.5, -0.2, 2.0);
    let mut sums = Sums {
        hessian,
        gradient: Vector3::new(1.0, -2.0, 0.5),
        matched: 0,
        inliers: 0,
        squares: 0.0,
    };
    let gradient = sums.gradient;
    sums.silence(&free);
    assert!((sums.hessian * free).length() < 1e-12 && sums.gradient.dot(&free).abs() < 1e-12);
    // Where the direction along it is free, what remains is the minimum of the cost: the Schur
    // complement.
    for other in [Vector3::x(), Vector3::new(0.2, -1.0, 0.7)] {
        let cost = |t: f64| {
            let step = other + free * t;
            0.5 * step.dot(&(hessian * step)) + gradient.dot(&step)
        };
        let best = -free.dot(&(hessian * other + gradient)) / free.dot(&(hessian * free));
        let at_rest = -free.dot(&gradient) / free.dot(&(hessian * free));
        let least = cost(best) - (0.5 * at_rest * free.dot(&gradient));
        let left = 0.5 * other.dot(&(sums.hessian * other)) + sums.gradient.dot(&other);
        assert!((left - least).abs() < 1e-12, "{left} {least}");
    }
}

#[test]
fn too_few_points_are_told_and_the_start_is_kept() {
    let points = room();
    let start = Pose2::new(0.0, 0.0, 0.0);
    let found = register(
        &points[..5],
        &map_of(&points),
        &start,
        &weak(start),
        &MatchConfig::default(),
    );
    assert_eq!(found.verdict, Verdict::TooFewPoints { found: 5 });
    assert!((found.estimate.pose.position() - start.position()).length() < 1e-12);
}

#[test]
fn covariance_is_that_of_a_monte_carlo_run_when_points_err_alone() {
    use rand::{RngExt, SeedableRng};
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(4);
    let (points, map) = (room(), map_of(&room()));
    let sigma = 0.01;
    let config = MatchConfig {
        sigma,
        redundancy: 1.0,
        last_kernel: 0.5,
        first_kernel: 0.5,
        ..MatchConfig::default()
    };
    let (mut sum, runs) = (Matrix3::zeros(), 300);
    let mut cov = Matrix3::zeros();
    for _ in 0..runs {
        let noisy: Vec<_> = points
            .iter()
            .map(|p| {
                let (u, v): (f64, f64) = (rng.random(), rng.random());
                let normal =
                    (-2.0 * libm::log(1.0 - u)).sqrt() * libm::cos(std::f64::consts::TAU * v);
                OrientedPoint {
                    position: p.position + p.normal * (sigma * normal),
                    ..*p
                }
            })
            .collect();
        let start = Pose2::identity();
        let found = register(&noisy, &map, &start, &weak(start), &config);
        let p = found.estimate.pose;
        let e = Vector3::new(p.x(), p.y(), p.heading());
        sum += e * e.transpose();
        cov = found.estimate.cov;
    }
    let sample = sum / f64::from(runs);
    for i in 0..3 {
        let ratio = sample[(i, i)] / cov[(i, i)];
        // 300 runs: the ratio has a standard deviation of 8 %.
        assert!((0.7..1.35).contains(&ratio), "axis {i}: {ratio}");
    }
}
