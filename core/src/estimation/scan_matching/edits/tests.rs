//! A person's changes persist: while the map is extended, redrawn, saved and pruned.

use super::super::tests::course::{LAP, drive, feed};
use super::*;
use crate::estimation::ScanMatcherConfig;
use crate::geom::{Length, Pose2};
use crate::map::{CellIndex, CellState};
use crate::snapshot::Reader;

/// One lap, and places in the map.
fn mapped() -> ScanMatcher {
    let mut matcher = ScanMatcher::new(ScanMatcherConfig::default()).unwrap();
    feed(&mut matcher, &drive(&LAP, Pose2::new(-5.0, -4.0, 0.0), 5));
    matcher.finish();
    matcher.redraw_at_once();
    matcher
}

/// Converts to the map frame, which begins in a corner of the building.
fn map(x: f64, y: f64) -> Point2<f64> {
    Point2::new(x + 5.0, y + 4.0)
}

fn occupied(matcher: &ScanMatcher, low: Point2<f64>, high: Point2<f64>) -> usize {
    let grid = matcher.grid();
    let (first, last) = (grid.cell_at(low), grid.cell_at(high));
    let lies_within = |at: Point2<f64>| at > low && at < high;
    (first.col..=last.col)
        .flat_map(|col| (first.row..=last.row).map(move |row| CellIndex { col, row }))
        .filter(|cell| lies_within(grid.centre_of(*cell)))
        .filter(|cell| grid.state(*cell) == CellState::Occupied)
        .count()
}

/// Around the niche on the outer wall in the south.
fn niche() -> [Point2<f64>; 4] {
    let (low, high) = (map(-2.2, -4.95), map(-1.0, -4.4));
    [
        low,
        Point2::new(high.x, low.y),
        high,
        Point2::new(low.x, high.y),
    ]
}

#[test]
fn what_was_erased_is_gone_until_it_is_seen_again() {
    let mut matcher = mapped();
    let [low, _, high, _] = niche();
    assert!(occupied(&matcher, low, high) > 10);
    matcher.edit(EditKind::Erase, &niche()).unwrap();
    assert_eq!(occupied(&matcher, low, high), 0);
    let blocks = matcher.grid().block_count();
    matcher.redraw_at_once();
    assert_eq!(occupied(&matcher, low, high), 0, "drawn anew");
    assert_eq!(matcher.grid().block_count(), blocks);
    // Past it once more.
    matcher.go_on(crate::estimation::Start::Left);
    feed(
        &mut matcher,
        &drive(&LAP[..1], Pose2::new(-5.0, -4.0, -1.5), 6),
    );
    assert!(occupied(&matcher, low, high) > 10, "seen again");
    let seen = occupied(&matcher, low, high);
    matcher.redraw_at_once();
    assert!(
        occupied(&matcher, low, high) > seen / 2,
        "drawn anew, and seen again"
    );
    assert!(matcher.undo_edit() && !matcher.undo_edit());
    assert!(occupied(&matcher, low, high) >= seen / 2);
}

#[test]
fn a_wall_stands_though_beams_go_through_it() {
    for kind in [EditKind::Wall, EditKind::Glass] {
        let mut matcher = mapped();
        // Across the southern corridor, where nothing is.
        let (from, to) = (map(0.3, -4.8), map(0.3, -3.2));
        let stands = |matcher: &ScanMatcher| {
            let low = Point2::new(from.x - 0.12, from.y);
            occupied(matcher, low, Point2::new(to.x + 0.12, to.y)) > 30
        };
        assert!(!stands(&matcher));
        matcher.edit(kind, &[from, to]).unwrap();
        assert!(stands(&matcher));
        matcher.go_on(crate::estimation::Start::Left);
        feed(
            &mut matcher,
            &drive(&LAP[..1], Pose2::new(-5.0, -4.0, -1.5), 6),
        );
        assert!(stands(&matcher), "driven through");
        matcher.redraw_at_once();
        assert!(stands(&matcher), "drawn anew");
        let mut bytes = vec![];
        matcher.save(&mut bytes);
        let config = ScanMatcherConfig::default();
        let mut again = ScanMatcher::restore(&mut Reader::new(&bytes), config).unwrap();
        assert!(again.edits().eq(matcher.edits()));
        again.finish();
        again.prune();
        again.redraw_at_once();
        assert!(stands(&again), "saved and pruned");
        let shown: Vec<ShownEdit> = again.edits().collect();
        assert_eq!((shown.len(), shown[0].kind), (1, kind));
        assert!((shown[0].corners[1] - to).length() < 0.15);
        // When erased with all its corners, it is removed.
        let around = [
            Point2::new(from.x - 0.3, from.y - 0.1),
            Point2::new(from.x + 0.3, from.y - 0.1),
            Point2::new(to.x + 0.3, to.y + 0.1),
            Point2::new(to.x - 0.3, to.y + 0.1),
        ];
        again.edit(EditKind::Erase, &around).unwrap();
        again.redraw_at_once();
        assert!(!stands(&again));
    }
}

#[test]
fn changes_that_cannot_be_are_refused() {
    let mut matcher = mapped();
    let [a, b, ..] = niche();
    let nowhere = Point2::new(f64::NAN, 0.0);
    assert_eq!(
        matcher.edit(EditKind::Erase, &[a, b]),
        Err(EditError::Corners {
            corners: 2,
            least: 3
        })
    );
    assert_eq!(
        matcher.edit(EditKind::Wall, &[a, nowhere]),
        Err(EditError::Nowhere)
    );
    assert_eq!(matcher.edits().len(), 0);
}
