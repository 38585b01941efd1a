//! Whether the map still allows the way ahead, for a disc and for an outline.

use crate::geom::{Footprint, Segment};
use crate::map::{CellIndex, CellRect, Grid};
use crate::plan::{ConfigSpace, GridSpace, Path, Unknown, follows, rect_around};

/// Cells around a path that an outline is held against.
const SPARE_CELLS: i32 = 20;

/// Whether a wall stands in the next `reach` metres of a path. The first decimetres do not count: the robot stands
/// there, and may be leaving a place that is too near to a wall.
pub(super) fn is_blocked(grid: &Grid, ahead: &Path, keep: f64, reach: f64) -> bool {
    let mut left = reach;
    let mut skip = 0.15;
    for leg in ahead.legs() {
        let length = leg.length();
        if length <= skip {
            skip -= length;
            continue;
        }
        let along = leg.vector() / length;
        let part = Segment::new(
            leg.a + along * skip,
            leg.a + along * length.min(skip + left),
        );
        skip = 0.0;
        let space = GridSpace::new(grid, rect_of(grid, &part, keep), keep, Unknown::Free);
        if !space.leg_is_free(&part) {
            return true;
        }
        left -= part.length();
        if left <= 0.0 {
            break;
        }
    }
    false
}

/// The same for an outline: the legs in the next `reach` metres, without the turn with which they begin.
pub(super) fn outline_is_blocked(
    grid: &Grid,
    ahead: &Path,
    outline: &Footprint,
    reach: f64,
) -> bool {
    let mut left = reach;
    let near = ahead.legs().take_while(|leg| {
        let is_near = left > 0.0;
        left -= leg.length();
        is_near
    });
    let count = near.count() + 1;
    let corners = ahead.points.get(..count).unwrap_or_default();
    let Some(rect) = rect_around(grid, corners, SPARE_CELLS, i32::MAX) else {
        return false;
    };
    let space = GridSpace::new(grid, rect, 0.0, Unknown::Free);
    !follows(outline, corners, None, &space)
}

/// The cells around a leg.
fn rect_of(grid: &Grid, leg: &Segment, spare: f64) -> CellRect {
    let (a, b) = (grid.cell_at(leg.a), grid.cell_at(leg.b));
    let spare = (spare / grid.resolution()).ceil() as i32 + 2;
    CellRect {
        min: CellIndex {
            col: a.col.min(b.col) - spare,
            row: a.row.min(b.row) - spare,
        },
        max: CellIndex {
            col: a.col.max(b.col) + spare + 1,
            row: a.row.max(b.row) + spare + 1,
        },
    }
}
