//! Sweeps with a known error, compared with the error and the pose found; and central differences.

use nalgebra::Point2;
use proptest::prelude::*;

use super::super::gauss_newton::tests::{map_of, room, seen_from, walls};
use super::super::register;
use super::*;
use crate::geom::Length;
use crate::map::SurfelMap;

/// The surfaces in the order in which a turning lidar at `end` meets them, in 24 parts, each moved
/// by odometry with the error `error`.
fn swept(
    surfaces: &[OrientedPoint],
    end: &Pose2,
    error: &MotionError,
) -> Vec<(f64, Vec<OrientedPoint>)> {
    const PARTS: usize = 24;
    let mut seen = seen_from(surfaces, end);
    seen.sort_by(|a, b| {
        let bearing = |p: &OrientedPoint| libm::atan2(p.position.y, p.position.x);
        bearing(a).total_cmp(&bearing(b))
    });
    let each = seen.len().div_ceil(PARTS);
    let parts = seen.chunks(each).enumerate();
    parts
        .map(|(part, points)| {
            let left = 1.0 - (part as f64 + 0.5) / PARTS as f64;
            // What the correction should undo.
            (left, seen_from(points, &error.correction(end, left)))
        })
        .collect()
}

fn parts(swept: &[(f64, Vec<OrientedPoint>)]) -> Vec<Part<'_>> {
    let part = |(left, points): &'_ (f64, Vec<OrientedPoint>)| (*left, points.len());
    assert!(swept.iter().map(part).all(|(left, _)| left < 1.0));
    swept
        .iter()
        .map(|(left, points)| Part {
            points,
            left: *left,
        })
        .collect()
}

/// For points without noise, each of which counts.
fn exact() -> MatchConfig {
    MatchConfig {
        sigma: 0.005,
        redundancy: 1.0,
        ..MatchConfig::default()
    }
}

/// Odometry that leads to `pose` with errors of 0.1 m and 0.1 rad.
fn believed(pose: Pose2) -> RollingPrior {
    RollingPrior {
        by_odometry: Prior {
            pose,
            information: Matrix3::from_diagonal(&Vector3::new(4e3, 4e3, 2e3)),
        },
        error: Vector3::zeros(),
        error_information: Matrix3::from_diagonal_element(100.0),
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 60, ..ProptestConfig::default() })]
    #[test]
    fn the_pose_at_the_end_comes_back_within_its_covariance(
        errors in prop::collection::vec(-1.0..1.0_f64, 3 * PIECES), h in -3.1..3.1_f64,
    ) {
        let truth = Pose2::new(0.5, -0.3, h);
        let piece = |at: usize| Vector3::new(
            0.015 * errors[3 * at], 0.015 * errors[3 * at + 1], 0.03 * errors[3 * at + 2],
        );
        let error = MotionError(std::array::from_fn(piece));
        let swept = swept(&room(), &truth, &error);
        let by_odometry = truth.plus(&-error.sum());
        let map = map_of(&room());
        let config = exact();
        let found = register_rolling(&parts(&swept), &map, &by_odometry, &believed(by_odometry), &config);
        // A part of the sweep that meets only one wall says nothing along it: if the errors are
        // uneven, the pose is as far off as its covariance says. Without noise it is within that.
        let found = found.found;
        let off = found.estimate.pose.minus(&truth);
        let cholesky = found.estimate.cov.cholesky();
        prop_assert!(cholesky.is_some());
        let squared = cholesky.map_or(f64::NAN, |cholesky| off.dot(&cholesky.solve(&off)));
        prop_assert!(squared < 1.0, "{squared} {found:?}");
        prop_assert!(off.length() < 0.3 * error.sum().length() + 0.012, "{off} {error:?}");
        prop_assert!(found.information.symmetric_eigenvalues().min() > -1e-6);
    }

    #[test]
    fn equations_are_those_of_central_differences(
        at in prop::collection::vec(-1.0..1.0_f64, COORDINATES),
    ) {
        let map = map_of(&room());
        let sweep = swept(&room(), &Pose2::identity(), &MotionError::even(&Vector3::zeros()));
        let sweep = parts(&sweep);
        let config = MatchConfig::default();
        let prior = believed(Pose2::new(0.01, -0.02, 0.005));
        let place = |x: &Gradient| {
            let block = |at: usize| x.fixed_rows::<3>(3 * at).into_owned();
            let error = MotionError(std::array::from_fn(|piece| block(piece + 1)));
            (Pose2::identity().plus(&block(0)), error)
        };
        // With a kernel so wide that it has no effect, the cost is half the sum of squares.
        let together = |x: &Gradient| {
            let (pose, error) = place(x);
            Together::of(sweep.iter().map(|part| {
                let pose = error.pose(&pose, part.left);
                (part.left, sums(part.points, &map, &pose, 1e6, &config))
            }))
        };
        let cost = |x: &Gradient| {
            let (pose, error) = place(x);
            let begin = pose.minus(&prior.by_odometry.pose) - error.sum();
            let of_errors: f64 = error.0.iter()
                .map(|e| PIECES as f64 * e.dot(&(prior.error_information * e)))
                .sum();
            let of_begin = begin.dot(&(prior.by_odometry.information * begin));
            0.5 * (together(x).sums.squares + of_begin + of_errors)
        };
        let x = Gradient::from_fn(|row, _| 0.01 * at[row]);
        let mut equations = together(&x);
        let (pose, error) = place(&x);
        equations.believe(&prior, &pose, &error);
        let h = 1e-7;
        let numeric = Gradient::from_fn(|row, _| {
            let step = Gradient::from_fn(|at, _| if at == row { h } else { 0.0 });
            (cost(&(x + step)) - cost(&(x - step))) / (2.0 * h)
        });
        // A point that changes its cell between the two sides causes a jump; few starts meet one.
        let off = (numeric - equations.gradient).length();
        prop_assume!(off < 10.0);
        prop_assert!(off < 1e-3 * (1.0 + equations.gradient.length()), "{numeric} {}", equations.gradient);
    }
}

#[test]
fn matched_as_a_whole_a_bent_scan_lies_half_of_the_error_beside() {
    let truth = Pose2::new(0.5, -0.3, 0.4);
    let error = MotionError::even(&Vector3::new(0.0, 0.0, 0.08));
    let swept = swept(&room(), &truth, &error);
    let by_odometry = truth.plus(&-error.sum());
    let map = map_of(&room());
    let (prior, config) = (believed(by_odometry), exact());
    let whole: Vec<OrientedPoint> = swept.iter().flat_map(|(_, p)| p.clone()).collect();
    let unbelieving = Prior {
        pose: by_odometry,
        information: Matrix3::from_diagonal_element(1e-3),
    };
    let rigid = register(&whole, &map, &by_odometry, &unbelieving, &config);
    let rolling = register_rolling(&parts(&swept), &map, &by_odometry, &prior, &config);
    let turned = |found: &Registration| (found.estimate.pose.heading() - truth.heading()).abs();
    assert!((turned(&rigid) - 0.04).abs() < 0.015, "{rigid:?}");
    assert!(turned(&rolling.found) < 0.002, "{rolling:?}");
}

#[test]
fn a_corridor_leaves_the_way_along_it_to_odometry() {
    let corridor = walls(&[((-5.0, -1.0), (5.0, -1.0)), ((5.0, 1.0), (-5.0, 1.0))]);
    let start = Pose2::new(0.15, 0.1, 0.03);
    let error = MotionError::even(&Vector3::new(0.0, 0.0, 0.04));
    let swept = swept(&corridor, &Pose2::identity(), &error);
    let map: SurfelMap = map_of(&corridor);
    let prior = believed(start);
    let found = register_rolling(
        &parts(&swept),
        &map,
        &start,
        &prior,
        &MatchConfig::default(),
    );
    let pose = found.found.estimate.pose;
    assert!(
        matches!(found.found.verdict, Verdict::Degenerate { direction } if direction.x.abs() > 0.99),
        "{found:?}"
    );
    assert!((pose.x() - 0.15).abs() < 0.01, "{found:?}");
    assert!(
        pose.y().abs() < 0.01 && pose.heading().abs() < 0.005,
        "{found:?}"
    );
    let along = Point2::new(found.error.sum().x, 0.0);
    assert!(along.coords.length() < 0.01, "{found:?}");
}
