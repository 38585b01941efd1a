//! Which landmark a line is matched to, and that the report says why.

use std::f64::consts::PI;

use nalgebra::{Vector2, Vector3};

use super::super::*;
use super::{ONCE, feature, odometry, plain, some_state};
use crate::geom::CHI2_2DOF_99;

#[test]
fn lines_matched_together_outvote_a_nearer_wrong_wall() {
    // Walls 0.3 m apart one behind the other; then the robot moves 0.2 m towards them unnoticed.
    let walls = [1.0, 1.3, 1.6].map(|r| feature(0.0, r));
    let with = |method| {
        let mut config = plain();
        config.association.method = method;
        // The nearest one is matched, however near the next one is.
        config.association.ambiguity = 0.0;
        config.association.new_gate = 16.0;
        let mut slam = EkfSlam::new(config).unwrap();
        for _ in 0..5 {
            slam.update(&walls, &ONCE).unwrap();
        }
        let unsure = Matrix3::from_diagonal(&Vector3::new(0.02, 1e-6, 1e-6));
        slam.predict(&odometry(Pose2::identity(), unsure)).unwrap();
        // The line that is nearer to another wall's place than to its own comes first.
        let seen = [1.3, 1.0, 1.6].map(|r| feature(0.0, r - 0.2));
        let report = slam.update(&seen, &ONCE).unwrap();
        let ids: Vec<_> = report
            .matches
            .iter()
            .map(|m| (m.feature, m.landmark.0))
            .collect();
        (ids, slam.pose.x())
    };
    let (together, x) = with(AssociationMethod::Joint);
    assert_eq!(together, [(0, 1), (1, 0), (2, 2)]);
    assert!((x - 0.2).abs() < 0.02, "{x}");
    let (nearest, x) = with(AssociationMethod::Nearest);
    assert!(nearest.contains(&(0, 0)), "{nearest:?}");
    assert!((x - 0.2).abs() > 0.1, "{x}");
}

#[test]
fn both_faces_of_a_thin_wall_are_two_landmarks() {
    let mut slam = EkfSlam::new(plain()).unwrap();
    slam.update(&[feature(0.0, 1.0)], &ONCE).unwrap();
    let exact = |x: f64| odometry(Pose2::new(x, 0.0, 0.0), Matrix3::identity() * 1e-6);
    slam.predict(&exact(2.0)).unwrap();
    let report = slam.update(&[feature(PI, 1.0)], &ONCE).unwrap();
    assert_eq!((report.matches.len(), report.added.len()), (0, 1));
}

#[test]
fn wall_seen_in_two_parts_across_a_door_is_two_landmarks_until_the_parts_meet() {
    let mut slam = EkfSlam::new(plain()).unwrap();
    let part = |from: f64, to: f64| LineFeature {
        ends: [Point2::new(1.0, from), Point2::new(1.0, to)],
        ..feature(0.0, 1.0)
    };
    slam.update(&[part(-2.0, -0.5)], &ONCE).unwrap();
    assert_eq!(
        slam.update(&[part(0.5, 2.0)], &ONCE).unwrap().added.len(),
        1
    );
    let report = slam
        .update(&[part(-2.0, -0.5), part(0.5, 2.0)], &ONCE)
        .unwrap();
    assert_eq!(report.matches.len(), 2);
    assert!(report.matches.iter().all(|m| m.d2 < CHI2_2DOF_99));
}

#[test]
fn each_line_says_why_it_was_taken_for_what() {
    let mut slam = some_state();
    let ids: Vec<_> = slam.landmarks().map(|l| l.id).collect();
    // The first wall as expected; the second one a metre off, and the third beyond a door on its
    // own line.
    let expected: Vec<_> = (0..3).map(|l| slam.expect(l).line).collect();
    let door = Vector2::new(-libm::sin(expected[2].alpha), libm::cos(expected[2].alpha)) * 4.0;
    let mut beyond = feature(expected[2].alpha, expected[2].r);
    beyond.ends = beyond.ends.map(|end| end + door);
    let scan = [
        feature(expected[0].alpha, expected[0].r),
        feature(expected[1].alpha, expected[1].r + 1.0),
        beyond,
    ];
    let report = slam.update(&scan, &ONCE).unwrap();
    let of = |i: usize, landmark: usize| {
        let explanation = report.explanations().find(|e| e.feature == i).unwrap();
        let candidate = explanation
            .candidates
            .iter()
            .find(|c| c.landmark == ids[landmark]);
        (explanation.decision, *candidate.unwrap())
    };
    let (decision, candidate) = of(0, 0);
    assert_eq!(
        (decision, candidate.gate),
        (Decision::Matched(ids[0]), Gate::Match)
    );
    assert!(candidate.d2 < 1e-9 && candidate.gap < 0.0);
    let (decision, candidate) = of(1, 1);
    assert!(matches!(decision, Decision::Added(_)) && candidate.gate == Gate::Far);
    assert!((candidate.innovation[1] - 1.0).abs() < 0.1);
    let (decision, candidate) = of(2, 2);
    assert!(matches!(decision, Decision::Added(_)) && candidate.gate == Gate::Beyond);
    assert!(candidate.d2 < 9.0 && candidate.gap > 0.5);
    assert_eq!((report.matches.len(), report.nis_degrees()), (1, 2));
    assert!((report.nis - report.matches[0].d2).abs() < 1e-12);
}

/// The line x = `r` from `from` to `to` along y, turned by `alpha` about the middle of that.
fn part(alpha: f64, r: f64, [from, to]: [f64; 2]) -> LineFeature {
    let middle = Point2::new(r, 0.5 * (from + to));
    let normal = Vector2::new(libm::cos(alpha), libm::sin(alpha));
    let tangent = Vector2::new(-normal.y, normal.x) * (0.5 * (to - from));
    LineFeature {
        ends: [middle - tangent, middle + tangent],
        ..feature(alpha, normal.dot(&middle.coords))
    }
}

/// A filter that has seen the lines `times` times.
fn knowing(lines: &[LineFeature], times: usize) -> EkfSlam {
    let mut slam = EkfSlam::new(plain()).unwrap();
    for _ in 0..times {
        slam.update(lines, &ONCE).unwrap();
    }
    slam
}

/// In `office` a partition ends between two cupboards whose fronts are 10 cm apart: seen from afar,
/// the second one lies in the gate of the first; matched to it, it bent the first by two degrees.
#[test]
fn part_beside_a_wall_is_another_one_until_it_is_known_to_be_on_its_line() {
    for (times, gap, is_one) in [(3, 0.1, false), (60, 0.1, true), (3, -0.3, true)] {
        let mut slam = knowing(&[part(0.0, 4.0, [-1.5, 0.0])], times);
        let mut beside = part(0.0, 4.0, [gap, 1.5]);
        beside.cov = if is_one && gap > 0.0 {
            Matrix2::new(1e-5, 0.0, 0.0, 1e-5)
        } else {
            Matrix2::new(4e-4, 0.0, 0.0, 1e-3)
        };
        let report = slam.update(&[beside], &ONCE).unwrap();
        let found = (report.matches.len(), report.added.len());
        assert_eq!(found, (usize::from(is_one), usize::from(!is_one)), "{gap}");
        let candidate = report
            .explanations()
            .find(|e| e.feature == 0)
            .unwrap()
            .candidates[0];
        assert!(candidate.d2 < 1.0);
        assert_eq!(candidate.gate == Gate::Beyond, !is_one);
    }
}

/// One sighting in a million lies outside of the gate for new walls and makes a second landmark of
/// a wall. Among 863 000 in `office` some do; that landmark must not take its wall's sightings,
/// half of which are nearer to it.
#[test]
fn landmark_made_by_noise_starves_beside_its_wall() {
    let wall = || part(0.0, 2.0, [-1.0, 1.0]);
    let mut slam = knowing(&[wall()], 10);
    let mut spoilt = part(0.05, 2.0, [-1.0, 1.0]);
    spoilt.cov = Matrix2::new(4e-5, 0.0, 0.0, 4e-5);
    assert_eq!(slam.update(&[spoilt], &ONCE).unwrap().added.len(), 1);
    let ids: Vec<_> = slam.landmarks().map(|l| l.id).collect();
    for _ in 0..=slam.config.patience {
        // Nearer to the false landmark than to its own, and in the gate of both.
        let report = slam
            .update(&[part(0.027, 2.0, [-1.0, 1.0])], &ONCE)
            .unwrap();
        assert_eq!(report.matches.first().map(|m| m.landmark), Some(ids[0]));
    }
    assert_eq!(slam.landmarks().map(|l| l.id).collect::<Vec<_>>(), [ids[0]]);
}
