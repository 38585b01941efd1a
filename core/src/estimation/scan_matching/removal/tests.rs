//! A submap is taken out and put back.

use super::super::tests::course::{LAP, Step, drive, feed};
use super::*;
use crate::estimation::ScanMatcherConfig;
use crate::geom::{Length, Pose2};
use crate::map::CellState;

fn begin() -> Pose2 {
    Pose2::new(-5.0, -4.0, 0.0)
}

fn mapped(seed: u64) -> (ScanMatcher, Vec<Step>) {
    let mut matcher = ScanMatcher::new(ScanMatcherConfig::default()).unwrap();
    let steps = drive(&LAP, begin(), seed);
    feed(&mut matcher, &steps);
    (matcher, steps)
}

fn occupied(matcher: &ScanMatcher) -> usize {
    let grid = matcher.grid();
    let is_occupied = |odds: f32| grid.state_of(odds) == CellState::Occupied;
    let rect = grid.rect_where(is_occupied).unwrap();
    rect.cells()
        .filter(|c| is_occupied(grid.log_odds(*c)))
        .count()
}

/// Does what was put off.
fn settle(matcher: &mut ScanMatcher) {
    matcher.compare_all();
    matcher.refine(usize::MAX, true);
}

fn bytes(matcher: &ScanMatcher) -> Vec<u8> {
    let mut bytes = vec![];
    matcher.save(&mut bytes);
    bytes
}

#[test]
fn a_submap_is_gone_with_what_it_drew_and_its_way_stays() {
    let (mut matcher, steps) = mapped(1);
    settle(&mut matcher);
    let count = matcher.submaps.len();
    assert!(count > 3, "{count}");
    let before: Vec<Pose2> = matcher.trajectory().map(|(_, pose)| pose).collect();
    let poses: Vec<Pose2> = matcher.submaps().map(|s| s.map_from_submap).collect();
    let own: Vec<usize> = matcher.submaps().map(|s| s.keyframes).collect();
    let cells = occupied(&matcher);
    let [version, grid_version] = [matcher.submaps_version(), matcher.grid_version()];
    matcher.remove_submap(1).unwrap();
    assert!(matcher.submaps_version() > version && matcher.grid_version() > grid_version);
    let left = |of: Vec<Pose2>| [&of[..1], &of[2..]].concat();
    let now: Vec<Pose2> = matcher.submaps().map(|s| s.map_from_submap).collect();
    assert_eq!(now, left(poses), "the others stay where they are");
    assert_eq!(
        matcher.submaps().map(|s| s.keyframes).collect::<Vec<_>>(),
        [&own[..1], &own[2..]].concat()
    );
    assert!(occupied(&matcher) < cells, "what it alone saw is gone");
    assert!(matcher.graph().marginals().is_some(), "one graph");
    // The way is that of the drive, through what is gone as well.
    let after: Vec<Pose2> = matcher.trajectory().map(|(_, pose)| pose).collect();
    assert_eq!(after.len(), steps.len());
    for (a, b) in before.iter().zip(&after) {
        assert!(a.minus(b).amax() < 1e-9, "{a:?} {b:?}");
    }
    // What is left is a map: it is saved, taken up, and gone on in.
    let saved = matcher.saved(vec![]);
    let mut again = saved.matcher(ScanMatcherConfig::default()).unwrap();
    again.go_on(crate::estimation::Start::Left);
    let end = steps.last().unwrap().truth;
    let more = drive(&[LAP[0]], end, 9);
    feed(&mut again, &more);
    let off = again
        .estimate()
        .pose
        .minus(&begin().delta_to(&more.last().unwrap().truth));
    assert!(off.xy().length() < 0.15, "{off}");
}

/// But for the counts by which a change is seen.
fn content(matcher: &ScanMatcher) -> Vec<u8> {
    let mut same = matcher.clone();
    (same.moves, same.grid_version) = (0, 0);
    bytes(&same)
}

#[test]
fn what_was_taken_out_comes_back_in_turn() {
    let (mut matcher, _) = mapped(2);
    settle(&mut matcher);
    let shape = |matcher: &ScanMatcher| -> (Vec<Pose2>, Vec<usize>, Vec<Pose2>) {
        let poses = matcher.submaps().map(|s| s.map_from_submap).collect();
        let keyframes = matcher.submaps().map(|s| s.keyframes).collect();
        let way = matcher.trajectory().map(|(_, pose)| pose).collect();
        (poses, keyframes, way)
    };
    let is_same = |a: &ScanMatcher, b: &ScanMatcher| {
        let ((poses, keyframes, way), other) = (shape(a), shape(b));
        let near = |a: &[Pose2], b: &[Pose2]| {
            a.len() == b.len() && a.iter().zip(b).all(|(a, b)| a.minus(b).amax() < 0.01)
        };
        let cells = [a, b].map(|matcher| occupied(matcher) as f64);
        // What was put off may move keyframes by millimetres.
        near(&poses, &other.0)
            && keyframes == other.1
            && near(&way, &other.2)
            && (cells[0] - cells[1]).abs() < 0.03 * cells[0]
    };
    let whole = matcher.clone();
    matcher.remove_submap(1).unwrap();
    let without_one = matcher.clone();
    matcher.remove_submap(0).unwrap();
    assert!(!is_same(&matcher, &without_one) && !is_same(&without_one, &whole));
    for earlier in [&without_one, &whole] {
        let kept = content(&matcher.removals.last().unwrap().before);
        let [version, grid] = [matcher.submaps_version(), matcher.grid_version()];
        assert!(matcher.can_undo_removal() && matcher.undo_removal());
        assert!(matcher.submaps_version() > version && matcher.grid_version() > grid);
        assert_eq!(content(&matcher), kept, "to the bit");
        assert!(is_same(&matcher, earlier));
    }
    assert!(!matcher.undo_removal(), "nothing is left to put back");
}

#[test]
fn what_was_seen_since_is_not_thrown_away_by_putting_back() {
    let (mut matcher, steps) = mapped(3);
    matcher.remove_submap(1).unwrap();
    let more = drive(&[LAP[0]], steps.last().unwrap().truth, 4);
    feed(&mut matcher, &more[..5]);
    assert!(!matcher.can_undo_removal());
    let before = bytes(&matcher);
    assert!(!matcher.undo_removal());
    assert_eq!(bytes(&matcher), before);
}

#[test]
fn what_is_needed_or_missing_stays() {
    let (mut matcher, _) = mapped(4);
    let count = matcher.submaps.len();
    let before = bytes(&matcher);
    assert_eq!(
        matcher.remove_submap(count),
        Err(RemovalError::Missing {
            submap: count,
            count
        })
    );
    let submap = count - 1;
    let needed = RemovalError::Needed { submap };
    assert_eq!(matcher.remove_submap(submap), Err(needed));
    assert_eq!(bytes(&matcher), before);
    let words = needed.to_string();
    assert!(words.contains(&format!("submap {submap}")), "{words}");
}

#[test]
fn all_that_can_go_may_go() {
    let (mut matcher, steps) = mapped(5);
    while matcher.submaps.len() > 1 {
        let middle = (matcher.submaps.len() - 1) / 2;
        matcher.remove_submap(middle).unwrap();
        assert_eq!(matcher.trajectory().count(), steps.len());
    }
    assert_eq!(matcher.submaps().len(), 1);
    assert!(matcher.removals.len() <= MOST_KEPT);
}
