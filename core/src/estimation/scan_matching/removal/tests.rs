//! A submap is removed and put back.

use super::super::tests::course::{LAP, Step, drive, feed};
use nalgebra::Point2;

use super::*;
use crate::estimation::EditKind;
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

/// Does postponed work, and draws the map as a changed map is drawn.
fn settle(matcher: &mut ScanMatcher) {
    matcher.compare_all();
    matcher.refine(usize::MAX, true);
    matcher.redraw_at_once();
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
    // The trajectory is that of the drive, also through what was removed.
    let after: Vec<Pose2> = matcher.trajectory().map(|(_, pose)| pose).collect();
    assert_eq!(after.len(), steps.len());
    for (a, b) in before.iter().zip(&after) {
        assert!(a.minus(b).amax() < 1e-9, "{a:?} {b:?}");
    }
    // What remains is a valid map: it can be saved, restored, and continued.
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

/// What is reported about a map, and what is drawn of it.
struct Shape {
    poses: Vec<Pose2>,
    keyframes: Vec<usize>,
    way: Vec<Pose2>,
    cells: f64,
    closures: Vec<(usize, usize)>,
    edges: usize,
    drawn: usize,
}

impl Shape {
    fn of(matcher: &ScanMatcher) -> Self {
        let accepted = matcher.records.accepted();
        let mut closures: Vec<_> = accepted.map(|(_, _, r)| (r.old, r.new)).collect();
        closures.sort_unstable();
        Self {
            poses: matcher.submaps().map(|s| s.map_from_submap).collect(),
            keyframes: matcher.submaps().map(|s| s.keyframes).collect(),
            way: matcher.trajectory().map(|(_, pose)| pose).collect(),
            cells: occupied(matcher) as f64,
            closures,
            edges: matcher.graph().edges().len(),
            drawn: matcher.keyframes.len(),
        }
    }

    /// The differences, ignoring millimetres by which postponed work may move keyframes.
    fn differs(&self, other: &Self) -> Vec<String> {
        let apart = |a: &[Pose2], b: &[Pose2]| {
            let pairs = a.iter().zip(b);
            pairs.map(|(a, b)| a.minus(b).amax()).fold(0.0, f64::max)
        };
        let counts = |s: &Self| [s.poses.len(), s.way.len(), s.edges, s.drawn];
        let mut differs = vec![];
        let mut note = |is_other: bool, what: String| {
            if is_other {
                differs.push(what);
            }
        };
        let (now, then) = (counts(self), counts(other));
        note(
            now != then,
            format!("submaps, scans, edges, keyframes: {now:?} {then:?}"),
        );
        let off = [
            apart(&self.poses, &other.poses),
            apart(&self.way, &other.way),
        ];
        note(
            off.iter().any(|off| *off > 0.01),
            format!("poses and way: {off:?}"),
        );
        let (now, then) = (&self.keyframes, &other.keyframes);
        note(now != then, format!("keyframes: {now:?} {then:?}"));
        let (now, then) = (&self.closures, &other.closures);
        note(now != then, format!("closures: {now:?} {then:?}"));
        let (now, then) = (self.cells, other.cells);
        note(
            (now - then).abs() > 0.03 * then,
            format!("cells: {now} {then}"),
        );
        differs
    }
}

#[test]
fn what_was_taken_out_comes_back_in_turn() {
    let (mut matcher, _) = mapped(2);
    settle(&mut matcher);
    let whole = Shape::of(&matcher);
    assert!(!whole.closures.is_empty(), "closures come back as well");
    matcher.remove_submap(1).unwrap();
    let without_one = Shape::of(&matcher);
    matcher.remove_submap(0).unwrap();
    assert!(!Shape::of(&matcher).differs(&without_one).is_empty());
    assert!(!without_one.differs(&whole).is_empty());
    for (number, earlier) in [(0, &without_one), (1, &whole)] {
        let [version, grid] = [matcher.submaps_version(), matcher.grid_version()];
        assert_eq!(matcher.undoable_removal(), Some(number));
        assert_eq!(matcher.undo_removal(), Some(number));
        assert!(matcher.submaps_version() > version && matcher.grid_version() > grid);
        let differs = Shape::of(&matcher).differs(earlier);
        assert!(differs.is_empty(), "{number}: {differs:?}");
        assert!(matcher.graph().marginals().is_some(), "one graph");
    }
    assert_eq!(matcher.undo_removal(), None, "nothing is left to put back");
}

#[test]
fn what_was_seen_since_stays_when_a_submap_is_put_back() {
    let (mut matcher, steps) = mapped(3);
    let mut never = matcher.clone();
    // With an edit before it, and one after it.
    let square = |x: f64, y: f64| {
        [(0.0, 0.0), (0.3, 0.0), (0.3, 0.3)].map(|(dx, dy)| Point2::new(x + dx, y + dy))
    };
    for matcher in [&mut matcher, &mut never] {
        matcher.edit(EditKind::Wall, &square(-1.0, -1.0)).unwrap();
    }
    matcher.remove_submap(1).unwrap();
    let count = matcher.submaps.len();
    let more = drive(&LAP, steps.last().unwrap().truth, 4);
    for matcher in [&mut matcher, &mut never] {
        feed(matcher, &more);
    }
    assert!(
        matcher.submaps.len() > count + 1,
        "submaps were begun since"
    );
    assert_eq!(matcher.undo_removal(), Some(1));
    settle(&mut matcher);
    settle(&mut never);
    let (now, never) = (Shape::of(&matcher), Shape::of(&never));
    assert_eq!(now.way.len(), steps.len() + more.len());
    assert_eq!(now.keyframes.len(), never.keyframes.len());
    // All lies as without the removal, except for centimetres: closures found meanwhile were
    // weighed without the submap.
    for (a, b) in now.way.iter().zip(&never.way) {
        assert!(a.minus(b).xy().length() < 0.05, "{a:?} {b:?}");
    }
    assert!(
        (now.cells - never.cells).abs() < 0.05 * never.cells,
        "{} {}",
        now.cells,
        never.cells
    );
    // It is a map like any other.
    let saved = matcher.saved(vec![]);
    saved.matcher(ScanMatcherConfig::default()).unwrap();
}

#[test]
fn what_was_taken_out_otherwise_ends_what_can_be_put_back() {
    let (mut matcher, _) = mapped(3);
    matcher.remove_submap(1).unwrap();
    let kept: Vec<bool> = (0..matcher.submaps.len()).map(|at| at != 1).collect();
    assert!(matcher.join_past(1).is_some());
    matcher.keep_submaps(&kept);
    assert_eq!(matcher.undoable_removal(), None);
    assert_eq!(matcher.undo_removal(), None);
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
