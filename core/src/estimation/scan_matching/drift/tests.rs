//! What is known of paths, compared with randomly drawn paths.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use super::super::super::pose_graph::{Edge, PoseGraph, information_at_end};
use super::super::ScanMatcherConfig;
use super::super::closures::tests::found;
use super::*;
use crate::geom::Length;
use crate::points::fixture;

/// What matching claims for the motion through a submap: along, across, and of the rotation.
const MEASURED: [f64; 3] = [0.05, 0.02, 0.01];

/// Submaps every 4 m along an arc whose end heads back.
fn arc() -> Vec<Pose2> {
    let step = Pose2::new(4.0, 0.0, 0.25);
    std::iter::successors(Some(Pose2::new(1.0, 2.0, 0.3)), |pose| Some(*pose * step))
        .take(13)
        .collect()
}

fn matcher_of(poses: &[Pose2]) -> ScanMatcher {
    let mut matcher = ScanMatcher::new(ScanMatcherConfig::default()).unwrap();
    let cov = Matrix3::from_diagonal(&Vector3::from(MEASURED.map(|sigma| sigma * sigma)));
    let mut graph = PoseGraph::default();
    for pose in poses {
        graph.add_pose(*pose);
    }
    for from in 0..poses.len() - 1 {
        let motion = poses[from].delta_to(&poses[from + 1]);
        graph.add_edge(Edge {
            from,
            to: from + 1,
            motion,
            information: information_at_end(&motion, &cov.try_inverse().unwrap()),
            cauchy: None,
        });
    }
    matcher.graph = graph;
    matcher
}

/// The last submap placed in the first, off from where it lies by this: in the axes of the map.
fn placed(matcher: &ScanMatcher, off: Vector3<f64>) -> Candidate {
    let poses = matcher.graph.poses();
    let (old, new) = (0, poses.len() - 1);
    let at = poses[new];
    let found_at = Pose2::new(at.x() + off.x, at.y() + off.y, at.heading() + off.z);
    let motion = poses[old].delta_to(&found_at);
    found(old, new, motion, matcher.doubts(new)[old])
}

/// Closes loops, as far as drift is learned from them.
fn close(matcher: &mut ScanMatcher, proved: &[Candidate]) {
    matcher.drift = KnownWays::of(matcher).drift_after(proved);
}

/// The paths from the last submap.
fn ways(matcher: &ScanMatcher) -> BestWays {
    matcher.best_ways(matcher.graph.poses().len() - 1)
}

#[test]
fn the_covariance_of_a_way_is_that_of_ways_drawn_by_lot() {
    let poses = arc();
    let matcher = matcher_of(&poses);
    let config = &matcher.config.closure;
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let mut normal = |sigma: f64| sigma * fixture::normal(&mut rng);
    let truth = poses.last().unwrap();
    let runs = 20_000;
    let mut sum = Matrix3::zeros();
    for _ in 0..runs {
        let mut at = poses[0];
        for pair in poses.windows(2) {
            let motion = pair[0].delta_to(&pair[1]);
            let way = config.drift * motion.position().coords.length();
            // At its end, as matching errs: shift and rotation there.
            let error = Pose2::new(
                normal(MEASURED[0]) + normal(way),
                normal(MEASURED[1]) + normal(way),
                normal(MEASURED[2]) + normal(config.drift_turn),
            );
            at = at * motion * error;
        }
        let off = at.minus(truth);
        sum += off * off.transpose();
    }
    let drawn = sum / f64::from(runs);
    let cov = matcher.known(&ways(&matcher), 0).cov;
    for (row, col) in [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)] {
        let scale = (drawn[(row, row)] * drawn[(col, col)]).sqrt();
        let off = (cov[(row, col)] - drawn[(row, col)]) / scale;
        assert!(off.abs() < 0.05, "{row}, {col}: {cov} against {drawn}");
    }
}

/// A robot that ends off to the side without having turned did not get there by turning.
#[test]
fn a_shift_that_no_turn_explains_is_more_surprising() {
    let straight: Vec<Pose2> = (0..13)
        .map(|i| Pose2::new(4.0 * f64::from(i), 0.0, 0.0))
        .collect();
    let matcher = matcher_of(&straight);
    let ways = ways(&matcher);
    let Doubt { shift, turn } = ways.doubt(0);
    let surprise = |x, y, turn| {
        matcher
            .surprise(&ways, &placed(&matcher, Vector3::new(x, y, turn)))
            .by_loops
    };
    let explained = surprise(0.0, 2.0 * shift, 2.0 * turn);
    let unexplained = surprise(0.0, 2.0 * shift, 0.0);
    assert!(explained < 6.0, "{explained}");
    assert!(unexplained > 2.0 * explained, "{unexplained}, {explained}");
    // Along the path, no rotation helps at all.
    assert!(surprise(2.0 * shift, 0.0, 0.0) > unexplained);
    assert!(surprise(0.0, 0.0, 0.0).abs() < 1e-9);
}

#[test]
fn loops_that_close_well_make_the_next_bad_one_more_surprising() {
    let mut matcher = matcher_of(&arc());
    let ways = ways(&matcher);
    let shift = ways.doubt(0).shift;
    let bad = placed(&matcher, Vector3::new(shift, 0.0, 0.0));
    let good = placed(&matcher, Vector3::new(0.1 * shift, 0.0, 0.0));
    let before = matcher.surprise(&ways, &bad).by_loops;
    // Of placements proved together, only one counts: they close one path.
    close(&mut matcher, &[good, good, good]);
    let after_one = matcher.surprise(&ways, &bad).by_loops;
    assert!(
        (after_one / before - 2.0).abs() < 0.1,
        "{after_one}, {before}"
    );
    for _ in 0..1000 {
        close(&mut matcher, &[good]);
    }
    let at_most = matcher.surprise(&ways, &bad).by_loops;
    assert!(
        (at_most - before / LEAST).abs() < 1e-9,
        "{at_most}, {before}"
    );
    // Large errors are assumed already.
    for _ in 0..10_000 {
        close(&mut matcher, &[bad]);
    }
    assert!(matcher.surprise(&ways, &bad).by_loops >= before);
}

#[test]
fn neighbours_and_what_needed_no_search_teach_nothing() {
    let mut matcher = matcher_of(&arc()[..LONG]);
    let neighbours = placed(&matcher, Vector3::zeros());
    close(&mut matcher, &[neighbours]);
    assert_eq!(matcher.drift, Drift::default());
    let mut matcher = matcher_of(&arc());
    let mut unsearched = placed(&matcher, Vector3::zeros());
    unsearched.closure.is_searched = false;
    close(&mut matcher, &[unsearched]);
    assert_eq!(matcher.drift, Drift::default());
    let searched = placed(&matcher, Vector3::zeros());
    close(&mut matcher, &[searched]);
    assert_ne!(matcher.drift, Drift::default());
}
