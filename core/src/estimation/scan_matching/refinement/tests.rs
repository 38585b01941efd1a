//! Submaps that are bent on purpose, and what must stay unchanged.

use super::super::tests::course::{LAP, Step, drive, feed};
use super::*;
use crate::estimation::ScanMatcherConfig;
use crate::geom::Length;
use crate::snapshot::Reader;

/// Twice around, with all submaps but the last closed and none refined; and the true poses of the
/// robot.
fn two_laps(config: ScanMatcherConfig) -> (ScanMatcher, Vec<Step>) {
    let steps = drive(&[LAP, LAP].concat(), Pose2::new(-5.0, -4.0, 0.0), 2);
    let mut matcher = ScanMatcher::new(config).unwrap();
    feed(&mut matcher, &steps);
    // Refinement of none has begun.
    assert!(matcher.unrefined.len() <= WAITS);
    (matcher, steps)
}

/// A submap to which closures join many others.
fn closed_best(matcher: &ScanMatcher) -> usize {
    let joined = |submap: &usize| matcher.joined_by_closures(*submap).len();
    (0..matcher.submaps.len()).max_by_key(joined).unwrap()
}

/// Bends a submap: each keyframe rotates it by `turn`, and its scans with it.
fn bend(matcher: &mut ScanMatcher, submap: usize, turn: f64) {
    let [first, behind] = matcher.keyframes_of(submap);
    let (mut bent, mut last) = (vec![], None);
    for keyframe in &matcher.keyframes[first..behind] {
        let at = keyframe.submap_from_robot;
        bent.push(match last {
            Some((before, bent)) => {
                bent * Pose2::delta_to(&before, &at) * Pose2::new(0.0, 0.0, turn)
            }
            None => at,
        });
        last = bent.last().map(|bent| (at, *bent));
    }
    matcher.carry_scans(submap, &bent);
    for (keyframe, bent) in matcher.keyframes[first..behind].iter_mut().zip(bent) {
        keyframe.submap_from_robot = bent;
    }
}

/// The largest errors of the scans of a submap relative to the one in their middle: m and rad.
fn off(matcher: &ScanMatcher, submap: usize, steps: &[Step]) -> [f64; 2] {
    let [first, behind] = matcher.scans_of(submap);
    let middle = usize::midpoint(first, behind);
    let off = (first..behind).map(|at| {
        let scans = [middle, at].map(|scan| matcher.trajectory[scan].submap_from_robot);
        let truth = [middle, at].map(|scan| steps[scan].truth);
        let found = scans[0].delta_to(&scans[1]);
        let off = truth[0].delta_to(&truth[1]).delta_to(&found);
        [off.position().coords.length(), off.heading().abs()]
    });
    off.fold([0.0, 0.0], |[shift, turn], off| {
        [f64::max(shift, off[0]), f64::max(turn, off[1])]
    })
}

#[test]
fn a_submap_that_is_bent_is_laid_as_others_have_it() {
    for turn in [0.006, -0.006] {
        let (mut matcher, steps) = two_laps(ScanMatcherConfig::default());
        let submap = closed_best(&matcher);
        bend(&mut matcher, submap, turn);
        let before = off(&matcher, submap, &steps);
        assert!(before[1] > 0.035, "the test is too easy: {before:?}");
        let version = matcher.submaps_version();
        matcher.refine(usize::MAX, true);
        let after = off(&matcher, submap, &steps);
        assert!(after[0] < 0.04 && after[1] < 0.012, "{before:?} {after:?}");
        assert!(matcher.moved_within > 0.02 && matcher.submaps_version() > version);
        assert!(matcher.unrefined.is_empty());
        assert_eq!(matcher.trajectory.len(), steps.len());
    }
}

#[test]
fn submaps_that_are_straight_stay_as_good_as_they_are() {
    let (mut matcher, steps) = two_laps(ScanMatcherConfig::default());
    let submaps = 0..matcher.submaps.len() - 1;
    let all = |matcher: &ScanMatcher| -> Vec<[f64; 2]> {
        submaps.clone().map(|s| off(matcher, s, &steps)).collect()
    };
    let before = all(&matcher);
    matcher.refine(usize::MAX, true);
    assert!(matcher.moves > 0);
    for (before, after) in before.iter().zip(all(&matcher)) {
        let [shift, turn] = [after[0] - before[0], after[1] - before[1]];
        assert!(shift < 0.02 && turn < 0.005, "{before:?} {after:?}");
    }
}

#[test]
fn what_no_closure_joins_stays_where_it_is() {
    let (mut matcher, _) = two_laps(ScanMatcherConfig {
        close_loops: false,
        ..ScanMatcherConfig::default()
    });
    let before: Vec<_> = matcher.trajectory().collect();
    matcher.refine(usize::MAX, true);
    assert_eq!(matcher.trajectory().collect::<Vec<_>>(), before);
    assert!(matcher.unrefined.is_empty());
}

#[test]
fn a_map_that_was_saved_in_the_midst_is_refined_alike() {
    let (mut matcher, _) = two_laps(ScanMatcherConfig::default());
    let is_begun = |matcher: &ScanMatcher| {
        let first = matcher.unrefined.front().unwrap();
        first.matched > 3 && !first.places.is_empty()
    };
    while !is_begun(&matcher) {
        matcher.refine(1, true);
    }
    let mut bytes = vec![];
    matcher.save(&mut bytes);
    let mut restored =
        ScanMatcher::restore(&mut Reader::new(&bytes), ScanMatcherConfig::default()).unwrap();
    matcher.finish();
    restored.finish();
    let [mut a, mut b] = [vec![], vec![]];
    matcher.save(&mut a);
    restored.save(&mut b);
    assert!(a == b);
}

#[test]
fn a_submap_that_counts_other_keyframes_than_it_has_is_refused() {
    let (mut matcher, _) = two_laps(ScanMatcherConfig::default());
    matcher.submaps.last_mut().unwrap().own_keyframes += 3;
    let mut bytes = vec![];
    matcher.save(&mut bytes);
    let restored = ScanMatcher::restore(&mut Reader::new(&bytes), ScanMatcherConfig::default());
    let error = restored.unwrap_err().to_string();
    assert!(error.contains("another number of keyframes"), "{error}");
}

#[test]
fn what_was_drawn_is_known_after_it_was_laid_anew() {
    let (mut matcher, _) = two_laps(ScanMatcherConfig::default());
    let before: Vec<usize> = matcher.drawn_scans().collect();
    assert_eq!(before.len(), matcher.keyframes.len());
    matcher.refine(usize::MAX, true);
    assert_eq!(matcher.drawn_scans().collect::<Vec<_>>(), before);
}

fn along_x(count: u8) -> Vec<Pose2> {
    let poses = (0..count).map(|at| Pose2::new(0.25 * f64::from(at), 0.0, 0.0));
    poses.collect()
}

fn place(keyframe: usize, submap_from_robot: Pose2) -> Place {
    Place {
        keyframe,
        submap_from_robot,
        information: information(MATCH),
    }
}

#[test]
fn a_chain_goes_where_matches_have_it_and_follows_no_odd_one() {
    let poses = along_x(8);
    let moved = |pose: &Pose2| Pose2::new(pose.x(), pose.y() + 0.05, 0.0);
    let mut places: Vec<Place> = (poses.iter().enumerate())
        .map(|(at, pose)| place(at, moved(pose)))
        .collect();
    places.push(place(3, Pose2::new(1.2, -0.4, 0.5)));
    for (found, pose) in chain(&poses, &places, 0).iter().zip(&poses) {
        let off = found.minus(&moved(pose));
        // A prior of 0.1 m, against a match of 0.015 m at each keyframe.
        assert!(off.amax() < 0.004, "{off}");
    }
    // For the last three keyframes only.
    let places: Vec<Place> = (0..3).map(|at| place(at, moved(&poses[5 + at]))).collect();
    let found = chain(&poses, &places, 5);
    assert!((found[7].y() - 0.05).abs() < 0.01, "{:?}", found[7]);
    assert!(found[0].y() < found[4].y(), "{:?}", found[0]);
}

/// Two keyframes, of which the second is matched: with all weights known, so is the result.
#[test]
fn a_chain_is_the_mean_by_weight() {
    let poses = along_x(2);
    let matched = Pose2::new(0.25 + 0.01, 0.0, 0.0);
    let found = chain(&poses, &[place(1, matched)], 0);
    let [drift, step] = [DRIFT[0], STEP[0]].map(|sigma| 1.0 / (sigma * sigma));
    let off = (found[1].x() - matched.x()) / MATCH[0];
    let kernel = 1.0 / (1.0 + off * off / (KERNEL * KERNEL));
    let weight = kernel / (MATCH[0] * MATCH[0]);
    // The prior holds the first, and the first holds the second: springs in series.
    let held = drift + 1.0 / (1.0 / drift + 1.0 / step);
    let expected = 0.01 * weight / (weight + held);
    assert!(
        (found[1].x() - 0.25 - expected).abs() < 1e-6,
        "{:?}",
        found[1]
    );
    let first = expected * step / (step + drift);
    assert!((found[0].x() - first).abs() < 1e-6, "{:?}", found[0]);
}
