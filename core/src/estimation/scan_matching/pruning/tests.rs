//! A building that is driven through repeatedly needs no more memory, and its map stays right.

use nalgebra::Vector3;

use super::super::tests::course::{LAP, Step, drive, feed};
use super::*;
use crate::estimation::{PoseGraph, ScanMatcherConfig, Start};
use crate::geom::Length;

fn begin() -> Pose2 {
    Pose2::new(-5.0, -4.0, 0.0)
}

fn worst(matcher: &ScanMatcher, steps: &[Step]) -> f64 {
    let poses: Vec<Pose2> = matcher.trajectory().map(|(_, pose)| pose).collect();
    let last = &poses[poses.len() - steps.len()..];
    let off = last
        .iter()
        .zip(steps)
        .map(|(pose, step)| (pose.position() - begin().delta_to(&step.truth).position()).length());
    off.fold(0.0, f64::max)
}

#[test]
fn runs_that_follow_each_other_cost_no_more_than_some_of_them() {
    let mut matcher = ScanMatcher::new(ScanMatcherConfig::default()).unwrap();
    let (mut sizes, mut at) = (vec![], begin());
    for run in 0..8 {
        matcher.go_on(Start::Left);
        let steps = drive(&LAP, at, 20 + run);
        at = steps.last().unwrap().truth;
        feed(&mut matcher, &steps);
        matcher.finish();
        let off = worst(&matcher, &steps);
        assert!(off < 0.12, "run {run}: {off}");
        assert!(
            matcher.graph().marginals().is_some(),
            "run {run}: one graph"
        );
        let mut bytes = vec![];
        matcher.save(&mut bytes);
        sizes.push((
            matcher.keyframes.len(),
            matcher.graph().edges().len(),
            bytes.len(),
        ));
    }
    let (first, last) = (sizes[0], sizes[7]);
    assert!(last.0 < 5 * first.0 && last.2 < 5 * first.2, "{sizes:?}");
    // Nor does it grow any more.
    assert!(
        last.0 < sizes[5].0 * 5 / 4 && last.1 < sizes[5].1 * 3 / 2,
        "{sizes:?}"
    );
}

#[test]
fn what_was_driven_once_is_kept() {
    let mut matcher = ScanMatcher::new(ScanMatcherConfig::default()).unwrap();
    feed(&mut matcher, &drive(&LAP, begin(), 1));
    matcher.finish();
    assert_eq!(matcher.prune(), Pruned::default());
}

/// The covariance of a motion past a pose is that of the two motions together: the same as in the
/// graph.
#[test]
fn motions_past_a_pose_are_known_as_well_as_the_graph_says() {
    let turned = |cov: Matrix3<f64>, by: f64| {
        let turn = Pose2::new(0.0, 0.0, by).rotation();
        turn * cov * turn.transpose()
    };
    let known = [
        turned(Matrix3::from_diagonal(&Vector3::new(1e-4, 9e-4, 1e-5)), 0.4),
        turned(
            Matrix3::from_diagonal(&Vector3::new(4e-4, 1e-4, 3e-5)),
            -1.1,
        ),
    ];
    let motions = [Pose2::new(2.0, -1.0, 0.7), Pose2::new(-1.5, 3.0, -2.0)];
    for (flip_first, flip_second) in [(false, false), (true, false), (false, true), (true, true)] {
        // Ends 0 and 2, with the hub between them.
        let edge = |from: usize, to: usize, at: usize, flip: bool| Edge {
            from: if flip { to } else { from },
            to: if flip { from } else { to },
            motion: motions[at],
            information: known[at].try_inverse().unwrap(),
            cauchy: None,
        };
        let edges = [edge(0, 1, 0, flip_first), edge(1, 2, 1, flip_second)];
        let step = |flip: bool, at: usize| {
            if flip {
                motions[at].inverse()
            } else {
                motions[at]
            }
        };
        let mut graph = PoseGraph::default();
        graph.add_pose(Pose2::identity());
        graph.add_pose(step(flip_first, 0));
        graph.add_pose(step(flip_first, 0) * step(flip_second, 1));
        for edge in edges {
            graph.add_edge(edge);
        }
        let expected = graph.relative_cov(0, 2).unwrap();
        let [a, b] = edges.map(|edge| Arm::of(&edge, 1).unwrap());
        for (one, other) in [(&a, &b), (&b, &a)] {
            let joined = one.joined_to(other, 1).unwrap();
            assert_eq!((joined.from, joined.to), (0, 2));
            let off = joined.motion.minus(&graph.poses()[2]);
            assert!(off.amax() < 1e-12, "{off}");
            let mut past = PoseGraph::default();
            past.add_pose(Pose2::identity());
            past.add_pose(joined.motion);
            past.add_edge(Edge {
                from: 0,
                to: 1,
                ..joined
            });
            let cov = past.relative_cov(0, 1).unwrap();
            let scale = expected.abs().max();
            assert!(
                (cov - expected).abs().max() < 1e-9 * scale.max(1e-3),
                "{cov} {expected}"
            );
        }
        // Used three times, the first counts as three times as uncertain.
        let thrice = a.joined_to(&b, 3).unwrap();
        let once = a.joined_to(&b, 1).unwrap();
        assert!(thrice.information.trace() < once.information.trace());
    }
}
