//! What the judge accepts and rejects, at poses that are set, not found.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};

use nalgebra::Vector3;

use super::super::judge::{Back, Judged, judge, seen_from_other};
use super::super::rival::is_ambiguous;
use super::*;

/// Four walls with these corners.
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

/// Normals of noisy points in a corridor lean either way; this must not look like walls across it.
#[test]
fn noise_does_not_tell_the_way_along_a_corridor() {
    let judge_config = JudgeConfig::default();
    for seed in 0..30 {
        let here = Pose2::new(0.0, 0.1, 0.05);
        let fixed = look(&corridor(), &here, 0.025, 2 * seed);
        let moving = look(&corridor(), &here, 0.025, 2 * seed + 1);
        let along = here.inverse() * Pose2::new(0.5, 0.0, 0.0) * here;
        let found = judge(&moving, &fixed, &at(along), &judge_config).registration;
        assert!(
            matches!(found.verdict, Verdict::Degenerate { .. }),
            "{seed}: {found:?}"
        );
        // Nothing is known along the corridor, all the rest is: no variance is negative.
        let cov = found.estimate.cov;
        let variances = cov.symmetric_eigenvalues();
        assert!(
            variances.min() > 0.0 && variances.max() > 1e5,
            "{seed}: {cov}"
        );
        assert!(cov[(1, 1)] < 1e4 && cov[(2, 2)] < 1e4, "{seed}: {cov}");
    }
}

/// In a long corridor with an end, the side walls agree at every pose along it. Only the end shows
/// that a pose is wrong.
#[test]
fn a_pose_that_slipped_along_a_corridor_is_another_minimum() {
    let corridor = walls([[-60.0, -1.0], [4.0, -1.0], [4.0, 1.0], [-60.0, 1.0]]);
    let config = JudgeConfig::default();
    let truth = Pose2::new(0.3, 0.1, 0.1);
    for seed in 0..10 {
        let fixed = look(&corridor, &Pose2::identity(), 0.01, 2 * seed);
        let moving = look(&corridor, &truth, 0.01, 2 * seed + 1);
        let right = judge(&moving, &fixed, &at(truth), &config).registration;
        assert_eq!(right.verdict, Verdict::Converged, "{seed}: {right:?}");
        for slip in [-0.6, -0.4, 0.4, 0.6] {
            let slipped = Pose2::new(slip, 0.0, 0.0) * truth;
            let wrong = judge(&moving, &fixed, &at(slipped), &config).registration;
            assert_ne!(
                wrong.verdict,
                Verdict::Converged,
                "{seed} {slip}: {wrong:?}"
            );
        }
    }
}

/// A square room looks the same after a quarter turn, and the start decides which is meant. A room
/// with a niche does not, so even a pose far from the start is believed.
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
        let verdict = found.registration.verdict;
        assert_eq!(verdict, Verdict::Converged, "{:?}", found.registration);
        let far = other * Pose2::new(0.0, 0.0, -FRAC_PI_2);
        assert_eq!(
            is_ambiguous(&moving, &fixed, &far, &found, &config),
            is_symmetric
        );
        // From near it, no rival is searched for.
        let near = other * Pose2::new(0.1, 0.1, 0.9 * FRAC_PI_4);
        assert!(!is_ambiguous(&moving, &fixed, &near, &found, &config));
    }
}

/// The part of a scan that a sensor with a narrow field of view sees: beams within a quarter turn
/// of a bearing.
fn half(walls: &[Segment], pose: &Pose2, middle: f64, seed: u64) -> Cloud {
    let whole = look(walls, pose, 0.01, seed);
    let is_ahead = |p: &&Point2<f64>| unit_vector(middle).dot(&p.coords) > 0.0;
    Cloud::scan(whole.points().iter().filter(is_ahead).copied().collect()).unwrap()
}

/// When turned, scans of a sensor with a narrow field of view show different things: what would
/// contradict the pose is out of sight, so the pose is ambiguous even if no rival is found.
#[test]
fn a_pose_far_from_the_start_is_not_believed_of_scans_that_look_different_ways() {
    let config = JudgeConfig::default();
    let truth = Pose2::new(0.2, -0.1, 0.1);
    let fixed = half(&room(), &Pose2::identity(), 0.8, 1);
    let moving = half(&room(), &truth, -0.8, 2);
    let found = judge(&moving, &fixed, &at(truth), &config);
    let verdict = found.registration.verdict;
    assert_eq!(verdict, Verdict::Converged, "{:?}", found.registration);
    let far = truth * Pose2::new(0.0, 0.0, -FRAC_PI_2);
    assert!(is_ambiguous(&moving, &fixed, &far, &found, &config));
    let near = truth * Pose2::new(0.1, 0.1, 0.2);
    assert!(!is_ambiguous(&moving, &fixed, &near, &found, &config));
    // It is also ambiguous if everything in sight agrees, as one wall does with another.
    let all_agree = Judged {
        is_partial: false,
        ..found
    };
    assert!(is_ambiguous(&moving, &fixed, &far, &all_agree, &config));
}

/// If a search near the start finds a pose on which as many points agree, it counts against the
/// pose found elsewhere.
#[test]
fn of_scans_that_look_different_ways_the_pose_on_which_more_agree_is_believed() {
    let config = JudgeConfig::default();
    let truth = Pose2::new(0.2, -0.1, 0.1);
    let fixed = half(&room(), &Pose2::identity(), 0.8, 1);
    let moving = half(&room(), &truth, -0.8, 2);
    let start = Pose2::identity();
    let mut found = judge(&moving, &fixed, &at(truth), &config);
    found.registration.estimate.pose = Pose2::new(0.3, 0.0, 0.0) * truth;
    assert!(found.is_partial && found.agree > 100, "{}", found.agree);
    assert!(is_ambiguous(&moving, &fixed, &start, &found, &config));
    found.agree *= 2;
    assert!(!is_ambiguous(&moving, &fixed, &start, &found, &config));
}

/// For scans that are nearly complete and without noise, a Gauss-Newton step leads back.
#[test]
fn the_points_of_the_fixed_cloud_move_a_pose_that_is_off_back_to_the_truth() {
    let config = JudgeConfig::default();
    let truth = Pose2::new(0.2, -0.1, 0.1);
    let fixed = look(&room(), &Pose2::identity(), 0.001, 1);
    let moving = look(&room(), &truth, 0.001, 2);
    for off in [
        [0.02, -0.01, 0.0],
        [-0.01, 0.015, 0.004],
        [0.0, 0.0, -0.005],
    ] {
        let pose = truth.plus(&off.into());
        let back = Back::of(&moving, &fixed, &pose, &config);
        assert!(back.free.is_none());
        let left = pose.plus(&back.step.unwrap()).minus(&truth);
        assert!(left.xy().length() < 0.004 && left.z.abs() < 0.001, "{left}");
    }
}

#[test]
fn a_change_of_the_inverse_is_that_of_the_pose_by_central_differences() {
    let pose = Pose2::new(1.2, -0.7, 2.1);
    let h = 1e-6;
    for axis in 0..3 {
        let mut change = Vector3::zeros();
        change[axis] = 1.0;
        let at = |by: f64| pose.inverse().plus(&(change * by)).inverse();
        let numeric = at(h).minus(&at(-h)) / (2.0 * h);
        let found = seen_from_other(&change, &pose);
        assert!((found - numeric).abs().max() < 1e-8, "{found} {numeric}");
    }
}

/// The mean information over many scans: with the squares of one cloud's noisy normals it would be
/// too large along a corridor; with the normals of both clouds it is that of the walls, which is
/// zero.
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
