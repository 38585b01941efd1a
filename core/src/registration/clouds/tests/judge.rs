//! What the judge lets pass, and what not, at poses that are set, not found.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};

use super::super::judge::judge;
use super::super::rival::is_ambiguous;
use super::*;

/// Four walls of these corners.
fn walls(corners: [[f64; 2]; 4]) -> Vec<Segment> {
    let next = corners.iter().cycle().skip(1);
    (corners.iter().zip(next))
        .map(|(a, b)| Segment::new(Point2::from(*a), Point2::from(*b)))
        .collect()
}

fn at(pose: Pose2) -> Found {
    Found {
        pose,
        iterations: 1,
        is_settled: true,
    }
}

/// Normals of noisy points in a corridor lean either way, which must not look like walls across.
#[test]
fn noise_does_not_tell_the_way_along_a_corridor() {
    let judge_config = JudgeConfig::default();
    for seed in 0..30 {
        let here = Pose2::new(0.0, 0.1, 0.05);
        let fixed = look(&corridor(), &here, 0.025, 2 * seed);
        let moving = look(&corridor(), &here, 0.025, 2 * seed + 1);
        let along = here.inverse() * Pose2::new(0.5, 0.0, 0.0) * here;
        let found = judge(&moving, &fixed, &at(along), &judge_config);
        assert!(
            matches!(found.verdict, Verdict::Degenerate { .. }),
            "{seed}: {found:?}"
        );
        // Of the way along nothing is known, of the rest all: no variance is negative.
        let cov = found.estimate.cov;
        let variances = cov.symmetric_eigenvalues();
        assert!(
            variances.min() > 0.0 && variances.max() > 1e5,
            "{seed}: {cov}"
        );
        assert!(cov[(1, 1)] < 1e4 && cov[(2, 2)] < 1e4, "{seed}: {cov}");
    }
}

/// In a long corridor with an end the side walls agree at every pose along it. Only the end tells
/// that it is wrong.
#[test]
fn a_pose_that_slipped_along_a_corridor_is_another_minimum() {
    let corridor = walls([[-60.0, -1.0], [4.0, -1.0], [4.0, 1.0], [-60.0, 1.0]]);
    let config = JudgeConfig::default();
    let truth = Pose2::new(0.3, 0.1, 0.1);
    for seed in 0..10 {
        let fixed = look(&corridor, &Pose2::identity(), 0.01, 2 * seed);
        let moving = look(&corridor, &truth, 0.01, 2 * seed + 1);
        let right = judge(&moving, &fixed, &at(truth), &config);
        assert_eq!(right.verdict, Verdict::Converged, "{seed}: {right:?}");
        for slip in [-0.6, -0.4, 0.4, 0.6] {
            let slipped = Pose2::new(slip, 0.0, 0.0) * truth;
            let wrong = judge(&moving, &fixed, &at(slipped), &config);
            assert_ne!(
                wrong.verdict,
                Verdict::Converged,
                "{seed} {slip}: {wrong:?}"
            );
        }
    }
}

/// A square room looks the same after a quarter turn, and the start says which is meant. A room
/// with a niche does not, so that even a pose far from the start is believed.
#[test]
fn a_pose_far_from_the_start_is_believed_only_where_none_nearer_is_as_good() {
    let square = walls([[-3.0, -3.0], [3.0, -3.0], [3.0, 3.0], [-3.0, 3.0]]);
    let truth = Pose2::new(0.2, -0.1, 0.1);
    let config = JudgeConfig::default();
    for (walls, other, is_symmetric) in [
        (square, Pose2::new(0.0, 0.0, FRAC_PI_2) * truth, true),
        (room(), truth, false),
    ] {
        let fixed = look(&walls, &Pose2::identity(), 0.01, 1);
        let moving = look(&walls, &truth, 0.01, 2);
        let found = judge(&moving, &fixed, &at(other), &config);
        assert_eq!(found.verdict, Verdict::Converged, "{found:?}");
        let far = other * Pose2::new(0.0, 0.0, -FRAC_PI_2);
        assert_eq!(
            is_ambiguous(&moving, &fixed, &far, &found, &config),
            is_symmetric
        );
        // From near it nobody looks for others.
        let near = other * Pose2::new(0.1, 0.1, 0.9 * FRAC_PI_4);
        assert!(!is_ambiguous(&moving, &fixed, &near, &found, &config));
    }
}

/// The information is the mean of many: by the squares of one cloud's noisy normals it would be too
/// large along a corridor, by both clouds' it is that of the walls, which is none.
#[test]
fn what_noisy_normals_say_along_a_corridor_is_nothing_in_the_mean() {
    let config = JudgeConfig::default();
    let (mut by_both, mut by_one) = (0.0, 0.0);
    for seed in 0..60 {
        let here = Pose2::identity();
        let fixed = look(&corridor(), &here, 0.03, 2 * seed);
        let moving = look(&corridor(), &here, 0.03, 2 * seed + 1);
        by_both += super::super::judge::information_along_x(&moving, &fixed, &config);
        let squares = fixed
            .surfaces()
            .iter()
            .flatten()
            .map(|s| s.normal.x * s.normal.x);
        by_one += squares.sum::<f64>();
    }
    assert!(
        by_one > 0.0 && by_both.abs() < 0.2 * by_one,
        "{by_both} {by_one}"
    );
}
