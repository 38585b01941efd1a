//! Maps of two runs become one, and those of different buildings do not.

use nalgebra::Point2;

use super::super::tests::course::{LAP, Step, drive, feed, points_of, scan_at, update};
use super::*;
use crate::estimation::ScanMatcherConfig;
use crate::geom::{Length, Pose2, Segment};
use crate::robot::Odometry;

fn mapped(steps: &[Step]) -> ScanMatcher {
    let mut matcher = ScanMatcher::new(ScanMatcherConfig::default()).unwrap();
    feed(&mut matcher, steps);
    matcher
}

#[test]
fn maps_of_two_runs_lie_on_one_another() {
    // From another corner, rotated by a right angle, and in the opposite direction.
    let begin = Pose2::new(-5.0, -4.0, 0.0);
    let first = drive(&LAP, begin, 1);
    let second = drive(&[LAP[0], LAP[3], LAP[2]], Pose2::new(5.0, 4.0, -1.5), 2);
    let merged = mapped(&first).merged(mapped(&second)).unwrap();
    let matcher = merged.matcher;
    let truth = first.iter().chain(&second);
    let poses: Vec<Pose2> = matcher.trajectory().map(|(_, pose)| pose).collect();
    assert_eq!(poses.len(), first.len() + second.len());
    for (pose, step) in poses.iter().zip(truth) {
        let off = pose.minus(&begin.delta_to(&step.truth));
        assert!(off.xy().length() < 0.12 && off.z.abs() < 0.04, "{off}");
    }
    assert!(merged.stamp_shift > 0);
    let stamps: Vec<Stamp> = matcher.trajectory().map(|(stamp, _)| stamp).collect();
    assert!(stamps.windows(2).all(|pair| pair[0] < pair[1]));
    assert!(matcher.graph().marginals().is_some(), "one graph");
    for record in matcher.closure_records() {
        if let crate::estimation::ClosureFate::Accepted { edge } = record.fate {
            assert_eq!(matcher.graph().edge(edge).unwrap().motion, record.motion);
        }
    }
    // A run goes on where the second ended.
    let mut matcher = matcher;
    let end = second.last().unwrap().truth;
    matcher.go_on(crate::estimation::Start::Left);
    let third = drive(&[LAP[1]], end, 3);
    feed(&mut matcher, &third);
    let off = matcher
        .estimate()
        .pose
        .minus(&begin.delta_to(&third.last().unwrap().truth));
    assert!(off.xy().length() < 0.12, "{off}");
}

#[test]
fn a_map_of_another_building_is_refused_in_words() {
    let first = mapped(&drive(&LAP, Pose2::new(-5.0, -4.0, 0.0), 1));
    // A triangular hall.
    let corners = [(-8.0, -6.0), (9.0, -5.0), (0.0, 9.0), (-8.0, -6.0)];
    let corner = |(x, y): (f64, f64)| Point2::new(x, y);
    let walls: Vec<Segment> = (corners.windows(2))
        .map(|w| Segment::new(corner(w[0]), corner(w[1])))
        .collect();
    let mut rng = <rand_chacha::ChaCha8Rng as rand::SeedableRng>::seed_from_u64(1);
    let mut other = ScanMatcher::new(ScanMatcherConfig::default()).unwrap();
    let mut pose = Pose2::new(-3.0, -3.0, 0.0);
    for step in 0..160_u64 {
        let turn = if step % 40 > 25 { 0.1 } else { 0.0 };
        let motion = Pose2::new(0.05, 0.0, turn);
        pose = pose * motion;
        let stamp = Stamp(200_000 * (step + 1));
        other.odometry(&Odometry {
            from: Stamp(200_000 * step),
            to: stamp,
            motion,
            cov: pose_cov(0.005, 0.005),
        });
        update(
            &mut other,
            &points_of(&scan_at(&walls, &pose, stamp, &mut rng)),
        );
    }
    let error = first.clone().merged(other).unwrap_err();
    assert!(matches!(error, MapMergeError::NotProved { .. }), "{error}");
    assert!(error.to_string().contains("not proved"), "{error}");
    let empty = ScanMatcher::new(ScanMatcherConfig::default()).unwrap();
    let error = first.merged(empty).unwrap_err();
    assert_eq!(error, MapMergeError::Empty { which: "second" });
}
