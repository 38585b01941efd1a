//! In: a [`Grid`] and points. Out: the rectangle of cells that planning between them needs.

use nalgebra::Point2;

use super::{GridSpace, Unknown, Within};
use crate::map::{CellRect, Grid};
use crate::plan::path::NoPath;
use crate::plan::query::Query;

/// The rectangle of everything the grid holds and of all `points`, with `spare` cells around;
/// `None` if a point is not finite or lies more than `farthest` cells off.
#[must_use]
pub fn rect_around(
    grid: &Grid,
    points: &[Point2<f64>],
    spare: i32,
    farthest: i32,
) -> Option<CellRect> {
    let first = grid.cell_at(*points.first()?);
    let mut rect = grid.bounds().unwrap_or(CellRect {
        min: first,
        max: first,
    });
    let held = rect;
    for &point in points {
        if !(point.x.is_finite() && point.y.is_finite()) {
            return None;
        }
        let cell = grid.cell_at(point);
        let off = |at: i32, low: i32, high: i32| {
            at.saturating_sub(high).max(low.saturating_sub(at)) > farthest
        };
        if off(cell.col, held.min.col, held.max.col) || off(cell.row, held.min.row, held.max.row) {
            return None;
        }
        rect = rect.around(CellRect::of(cell));
    }
    Some(rect.grown(spare))
}

/// A goal farther than this off a grid is refused, m.
const FARTHEST_OFF: f64 = 50.0;
/// Cells around a grid that may be driven through.
const SPARE_CELLS: i32 = 20;

impl GridSpace {
    /// Takes a snapshot of everything in the grid, and of start and goal.
    ///
    /// # Errors    [`NoPath::GoalBlocked`] if one of them is far off the grid.
    pub(in crate::plan) fn of_query(
        grid: &Grid,
        query: &Query,
        keep: f64,
        unknown: Unknown,
        within: &Within,
    ) -> Result<Self, NoPath> {
        let farthest = (FARTHEST_OFF / grid.resolution()) as i32;
        let rect = rect_around(grid, &[query.start, query.goal], SPARE_CELLS, farthest);
        let rect = rect.ok_or(NoPath::GoalBlocked(query.goal))?;
        Ok(Self::within(grid, rect, keep, unknown, within))
    }
}
