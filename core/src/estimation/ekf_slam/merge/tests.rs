use nalgebra::{DMatrix, Point2};

use super::super::tests::{ONCE, dense, feature, plain};
use super::super::{EkfConfig, EkfSlam, ROBOT};
use super::*;
use crate::geom::Length;

/// The line x = `r` turned by `alpha`, seen from `from` to `to` along y.
fn part(alpha: f64, r: f64, from: f64, to: f64) -> LineFeature {
    let line = feature(alpha, r);
    let point = |y: f64| line.line.project(Point2::new(r, y));
    LineFeature {
        ends: [point(from), point(to)],
        ..line
    }
}

/// A filter that has seen the given lines several times.
fn knowing(lines: &[LineFeature]) -> EkfSlam {
    let mut slam = EkfSlam::new(EkfConfig {
        confirm_sightings: 1,
        ..plain()
    })
    .unwrap();
    for _ in 0..30 {
        slam.update(lines, &ONCE).unwrap();
    }
    slam
}

#[test]
fn merging_is_the_dense_measurement_that_both_are_one() {
    let mut slam = knowing(&[part(0.002, 1.0, -2.0, -0.5), part(-0.002, 1.003, 0.5, 2.0)]);
    assert_eq!(slam.landmarks.len(), 2);
    slam.landmarks[0].extent[1] = 2.0;
    let (before, about) = (dense(&slam), Point2::new(1.0, 1.0));
    let n = before.nrows();
    // H of (α₁ - α₀, r₁ - r₀ about a point of the wall), by central differences.
    let mut h = DMatrix::zeros(2, n);
    for landmark in 0..2 {
        for axis in 0..2 {
            let nudged = |by: f64| {
                let mut slam = slam.clone();
                slam.landmarks[landmark].line[axis] += by;
                slam.difference(0, 1, about).v
            };
            let column = (nudged(1e-6) - nudged(-1e-6)) / 2e-6;
            h.view_mut((0, ROBOT + 2 * landmark + axis), (2, 1))
                .copy_from(&column);
        }
    }
    let z = &h * &before * h.transpose();
    let k = &before * h.transpose() * z.try_inverse().unwrap();
    let expect = &before - &k * &h * &before;
    let line = |slam: &EkfSlam, i: usize| slam.landmarks[i].in_map(&Matrix2::identity()).0;
    let alphas = [0, 1].map(|i| line(&slam, i).alpha());
    slam.merge_all();
    let report = slam.report().clone();
    assert_eq!(slam.landmarks.len(), 1);
    assert!(report.merged[0].is_joined && report.merged[0].kept < report.merged[0].gone);
    let stays = expect
        .remove_rows(ROBOT + 2, 2)
        .remove_columns(ROBOT + 2, 2);
    assert!((dense(&slam) - stays).length() < 1e-9);
    // Both were seen equally often: the wall lies between them.
    let merged = line(&slam, 0).alpha();
    assert!(
        merged < alphas[0] && merged > alphas[1],
        "{alphas:?} {merged}"
    );
}

#[test]
fn walls_further_apart_than_one_is_thick_stay_two() {
    let slam = knowing(&[part(0.0, 1.0, -1.0, 1.0), part(0.0, 1.3, -1.0, 1.0)]);
    assert_eq!(slam.landmarks.len(), 2);
}

#[test]
fn walls_on_one_line_with_a_door_between_stay_two() {
    let slam = knowing(&[part(0.0, 1.0, -2.0, -0.5), part(0.0, 1.0, 0.5, 2.0)]);
    assert_eq!(slam.landmarks.len(), 2);
}

#[test]
fn difference_that_is_not_known_well_decides_nothing() {
    // One sighting each, with a direction known to 0.05 rad.
    let mut slam = EkfSlam::new(EkfConfig {
        confirm_sightings: 1,
        ..plain()
    })
    .unwrap();
    let vague = |from: f64, to: f64| LineFeature {
        cov: Matrix2::new(2.5e-3, 0.0, 0.0, 4e-4),
        ..part(0.0, 1.0, from, to)
    };
    slam.update(&[vague(-2.0, -0.5), vague(0.5, 2.0)], &ONCE)
        .unwrap();
    slam.landmarks[0].extent[1] = 2.0;
    slam.merge_all();
    let report = slam.report().clone();
    assert_eq!((slam.landmarks.len(), report.merged.len()), (2, 0));
}

#[test]
fn spoilt_double_is_dropped_without_a_trace() {
    let mut slam = knowing(&[part(0.0, 1.0, -2.0, -0.5), part(0.03, 1.03, 0.6, 1.4)]);
    assert_eq!(slam.landmarks.len(), 2);
    // Relative to its anchor in the middle of what was seen: up to y = 2.25.
    slam.landmarks[0].extent[1] = 3.5;
    slam.landmarks[0].sightings += 1;
    let before = dense(&slam);
    slam.merge_all();
    let report = slam.report().clone();
    let [merged] = report.merged[..] else {
        panic!("{:?}", report.merged);
    };
    assert!(!merged.is_joined && merged.d2 > 6.0);
    let rest = before
        .remove_rows(ROBOT + 2, 2)
        .remove_columns(ROBOT + 2, 2);
    assert!((dense(&slam) - rest).length() < 1e-300);
}
