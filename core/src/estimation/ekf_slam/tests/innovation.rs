//! Innovations of a scan: each against the dense matrices of the textbook, and whether their bounds
//! hold over whole runs.

use nalgebra::{DMatrix, Vector2};

use super::super::super::innovation::{Innovations, MeanInnovation};
use super::super::*;
use super::run::{Run, drive_ring};
use super::{ONCE, dense, feature, plain, point, some_state};
use crate::features::PointKind;
use crate::geom::wrap;

/// S = H P Hᵀ + R with full matrices.
fn dense_cov(slam: &EkfSlam, row: usize, by: [&DMatrix<f64>; 2], r: &Matrix2<f64>) -> DMatrix<f64> {
    let p = dense(slam);
    let mut h = DMatrix::zeros(2, p.nrows());
    h.view_mut((0, 0), (2, 3)).copy_from(by[0]);
    h.view_mut((0, row), (2, 2)).copy_from(by[1]);
    &h * p * h.transpose() + DMatrix::from_fn(2, 2, |i, j| r[(i, j)])
}

/// The mean weighted by 1 / S, and its variance, by the textbook formula for the mean of two.
fn mean_of(pairs: [(f64, f64); 2]) -> (f64, f64) {
    let [(a, var_a), (b, var_b)] = pairs;
    let mean = (a * var_b + b * var_a) / (var_a + var_b);
    (mean, var_a * var_b / (var_a + var_b))
}

fn assert_is(found: Option<MeanInnovation>, (mean, variance): (f64, f64)) {
    let found = found.unwrap();
    assert!((found.mean - mean).abs() < 1e-12, "{found:?}, not {mean}");
    let off = found.sigma * found.sigma - variance;
    assert!(off.abs() < 1e-12, "{found:?}, not σ² {variance}");
}

#[test]
fn innovations_are_seen_less_expected_each_after_the_correction_by_the_one_before() {
    let mut slam = some_state();
    let mut by_hand = slam.clone();
    let seen = [(0, 0.01, -0.02, 0), (1, -0.015, 0.03, 30)].map(|(wall, turn, shift, beam)| {
        let expected = slam.expect(wall).line;
        LineFeature {
            first_beam: beam,
            last_beam: beam + 20,
            ..feature(expected.alpha + turn, expected.r + shift)
        }
    });
    let [first, second] = [0, 1].map(|wall| {
        let expected = by_hand.expect(wall);
        let row = ROBOT + 2 * wall;
        let by_pose = DMatrix::from_fn(2, 3, |i, j| expected.jacobian.by_pose[(i, j)]);
        let by_own = DMatrix::from_fn(2, 2, |i, j| expected.jacobian.by_own[(i, j)]);
        let s = dense_cov(&by_hand, row, [&by_pose, &by_own], &seen[wall].cov);
        let line = seen[wall].line;
        let turn = wrap(line.alpha() - expected.line.alpha);
        let shift = line.r() - expected.line.r;
        by_hand.correct(wall, &seen[wall]);
        [(turn, s[(0, 0)]), (shift, s[(1, 1)])]
    });
    let report = slam.update(&[seen[0], seen[1], feature(2.9, 4.0)], &ONCE);
    let report = report.unwrap();
    let found = report.innovations();
    assert_is(found.alpha, mean_of([first[0], second[0]]));
    assert_is(found.r, mean_of([first[1], second[1]]));
    assert_eq!((found.x, found.y), (None, None));
    let counts = report.feature_counts();
    assert_eq!((counts.seen, counts.matched, counts.new), (3, 2, Some(1)));
}

#[test]
fn innovation_of_a_point_is_where_it_was_seen_less_where_it_was_expected() {
    let kind = PointKind::Corner;
    let mut slam = some_state();
    slam.config.landmarks = LandmarkKinds::Points;
    slam.config.point_sigma = 0.0;
    let known = point(Point2::new(2.0, 0.5), kind);
    slam.update_with_points(&[], &[known], &ONCE).unwrap();
    let (expected, off) = (
        slam.expect_point(&slam.points[0]),
        Vector2::new(0.01, -0.015),
    );
    let by_pose = DMatrix::from_fn(2, 3, |i, j| expected.jacobian.by_pose[(i, j)]);
    let by_own = DMatrix::from_fn(2, 2, |i, j| expected.jacobian.by_own[(i, j)]);
    let s = dense_cov(&slam, slam.points[0].row, [&by_pose, &by_own], &known.cov);
    let seen = point(expected.position + off, kind);
    let report = slam.update_with_points(&[], &[seen], &ONCE).unwrap();
    let found = report.innovations();
    assert_is(found.x, (off.x, s[(0, 0)]));
    assert_is(found.y, (off.y, s[(1, 1)]));
    assert_eq!((found.alpha, found.r), (None, None));
    let counts = report.feature_counts();
    assert_eq!((counts.seen, counts.matched, counts.new), (1, 1, Some(0)));
}

/// The part of all means that lies within two standard deviations of 0.
fn part_within(runs: &[Run], which: impl Fn(&Innovations) -> Option<MeanInnovation>) -> f64 {
    let all = runs.iter().flat_map(|run| &run.innovations);
    let means: Vec<_> = all.filter_map(which).collect();
    assert!(means.len() > 1000, "{} scans", means.len());
    let within = means.iter().filter(|m| m.mean.abs() <= 2.0 * m.sigma);
    within.count() as f64 / means.len() as f64
}

#[test]
fn the_bounds_of_an_honest_filter_hold_95_of_100_innovations() {
    let config = EkfConfig {
        consistency: Consistency::FirstEstimates,
        ..plain()
    };
    let runs: Vec<Run> = (0..10)
        .map(|seed| drive_ring(config, 8.0, 6.0, 1, seed))
        .collect();
    let [alpha, r] = [part_within(&runs, |i| i.alpha), part_within(&runs, |i| i.r)];
    println!("within 2σ: α {alpha:.3}, r {r:.3}");
    for part in [alpha, r] {
        assert!((0.93..0.98).contains(&part), "{part}, 0.954 is honest");
    }
}
