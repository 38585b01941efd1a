//! A second run in the map of a first one, from a known and from an unknown place.

use super::super::tests::course::{LAP, Step, drive, feed, points_of, scan_at, update};
use super::*;
use crate::estimation::ScanMatcherConfig;
use crate::geom::Length;

/// The largest distance, m, of trajectory positions from the truth, for the scans from `first` on,
/// in the frame in which the map began.
fn worst(matcher: &ScanMatcher, first: usize, steps: &[Step], begin: Pose2) -> f64 {
    let poses: Vec<Pose2> = matcher.trajectory().map(|(_, pose)| pose).collect();
    let pairs = poses[first..].iter().zip(steps);
    let off = pairs.map(|(pose, step)| {
        let truth = begin.delta_to(&step.truth);
        (pose.position() - truth.position()).length()
    });
    off.fold(0.0, f64::max)
}

/// Where the first run begins.
fn begin() -> Pose2 {
    Pose2::new(-5.0, -4.0, 0.0)
}

/// The map of one lap.
fn first_run() -> (ScanMatcher, Vec<Step>) {
    let steps = drive(&LAP, begin(), 5);
    let mut matcher = ScanMatcher::new(ScanMatcherConfig::default()).unwrap();
    feed(&mut matcher, &steps);
    (matcher, steps)
}

#[test]
fn a_robot_that_was_left_goes_on_where_it_was() {
    let (mut matcher, steps) = first_run();
    matcher.go_on(Start::Left);
    let end = steps.last().unwrap().truth;
    let again = drive(&LAP[..2], end, 6);
    feed(&mut matcher, &again);
    matcher.finish();
    assert!(matcher.is_placed());
    let off = worst(&matcher, steps.len(), &again, begin());
    assert!(off < 0.1, "{off}");
    let stamps: Vec<Stamp> = matcher.trajectory().map(|(stamp, _)| stamp).collect();
    assert!(stamps.windows(2).all(|pair| pair[0] < pair[1]));
}

#[test]
fn a_robot_that_stands_about_somewhere_is_found_near_there() {
    let (mut matcher, steps) = first_run();
    let truth = Pose2::new(5.0, 0.0, 1.5);
    let told = begin().delta_to(&(truth * Pose2::new(0.4, -0.3, 0.2)));
    matcher.go_on(Start::At(told));
    let again = drive(&[LAP[1], LAP[2]], truth, 7);
    feed(&mut matcher, &again);
    matcher.finish();
    let off = worst(&matcher, steps.len(), &again, begin());
    assert!(off < 0.1, "{off}");
}

#[test]
fn a_robot_that_may_be_anywhere_maps_a_piece_until_it_is_found() {
    for (seed, heading) in [(8, 1.6), (9, -2.5)] {
        let (mut matcher, steps) = first_run();
        let keyframes = matcher.keyframes.len();
        let shown = matcher.grid().block_count();
        matcher.go_on(Start::Anywhere);
        assert!(!matcher.is_placed());
        assert_eq!(matcher.grid().block_count(), 0, "the piece is shown alone");
        let again = drive(
            &[LAP[1], LAP[2], LAP[3], LAP[0]],
            Pose2::new(5.0, 0.0, heading),
            seed,
        );
        let mut placed_at = None;
        for (at, step) in again.iter().enumerate() {
            feed(&mut matcher, std::slice::from_ref(step));
            if matcher.is_placed() && placed_at.is_none() {
                placed_at = Some(at);
                assert!(
                    matcher.grid().block_count() >= shown,
                    "the whole map is shown"
                );
            }
        }
        matcher.finish();
        assert!(matcher.is_placed(), "{placed_at:?} of {}", again.len());
        let off = worst(&matcher, steps.len(), &again, begin());
        assert!(off < 0.1, "{seed}: {off}");
        assert!(matcher.keyframes.len() > keyframes);
        let estimate = matcher.estimate();
        assert!(estimate.cov[(0, 0)].sqrt() < 0.2, "{}", estimate.cov);
    }
}

#[test]
fn a_robot_that_was_carried_away_is_searched_for() {
    let (mut matcher, steps) = first_run();
    matcher.go_on(Start::Left);
    let again = drive(&[LAP[2], LAP[3], LAP[0]], Pose2::new(5.0, 2.0, 1.6), 8);
    feed(&mut matcher, &again[..1]);
    assert!(!matcher.is_placed());
    feed(&mut matcher, &again[1..]);
    matcher.finish();
    assert!(matcher.is_placed());
    let off = worst(&matcher, steps.len(), &again, begin());
    assert!(off < 0.1, "{off}");
}

#[test]
fn what_was_seen_elsewhere_is_never_placed_and_dropped_by_the_next_run() {
    let (mut matcher, _) = first_run();
    matcher.finish();
    let (submaps, places) = (matcher.submaps.len(), matcher.trajectory.len());
    let blocks = matcher.grid().block_count();
    matcher.go_on(Start::Anywhere);
    // A hall of its own, no part of which is in the map.
    let hall = |at: Pose2| {
        let walls: Vec<_> = [
            (-9.0, -7.0),
            (9.0, -7.0),
            (9.0, 7.0),
            (-9.0, 7.0),
            (-9.0, -7.0),
        ]
        .windows(2)
        .map(|w| {
            let [a, b] = [w[0], w[1]].map(|(x, y)| Point2::new(x, y));
            crate::geom::Segment::new(a, b)
        })
        .collect();
        (walls, at)
    };
    let mut rng = <rand_chacha::ChaCha8Rng as rand::SeedableRng>::seed_from_u64(1);
    for step in 0..200_u64 {
        let (walls, pose) = hall(Pose2::new(0.02 * step as f64 - 2.0, 0.0, 0.0));
        let stamp = Stamp(200_000 * (step + 1));
        let scan = scan_at(&walls, &pose, stamp, &mut rng);
        let points = points_of(&scan);
        matcher.odometry(&crate::robot::Odometry {
            from: Stamp(200_000 * step),
            to: stamp,
            motion: Pose2::new(0.02, 0.0, 0.0),
            cov: pose_cov(0.005, 0.005),
        });
        update(&mut matcher, &points);
    }
    matcher.finish();
    assert!(!matcher.is_placed());
    matcher.go_on(Start::Left);
    assert!(matcher.is_placed());
    assert_eq!(matcher.submaps.len(), submaps);
    assert_eq!(matcher.trajectory.len(), places);
    assert_eq!(matcher.grid().block_count(), blocks);
}
