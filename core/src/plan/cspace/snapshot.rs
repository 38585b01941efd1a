//! What a grid holds of a rectangle.
//!
//! In: a [`Grid`] and a rectangle of cells. Out: their states in rows; and the rectangle that planning between two points needs.

use nalgebra::Point2;

use crate::map::{CellIndex, CellRect, CellState, Grid};

/// The rectangle of everything the grid holds and of all `points`, with `spare` cells around; `None` where a point is
/// not finite or lies more than `farthest` cells off.
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
        rect.min.col = rect.min.col.min(cell.col);
        rect.min.row = rect.min.row.min(cell.row);
        rect.max.col = rect.max.col.max(cell.col.saturating_add(1));
        rect.max.row = rect.max.row.max(cell.row.saturating_add(1));
    }
    Some(CellRect {
        min: CellIndex {
            col: rect.min.col.saturating_sub(spare),
            row: rect.min.row.saturating_sub(spare),
        },
        max: CellIndex {
            col: rect.max.col.saturating_add(spare),
            row: rect.max.row.saturating_add(spare),
        },
    })
}

/// States of a rectangle, block by block.
pub(super) fn states_of(grid: &Grid, rect: CellRect) -> Vec<CellState> {
    let block_cells = crate::map::BLOCK_CELLS as i32;
    let width = rect.width();
    let mut states = vec![CellState::Unknown; width * rect.height()];
    for (block, cells) in grid.blocks_since(0) {
        let (col0, row0) = (block.col * block_cells, block.row * block_cells);
        let cols = rect.min.col.max(col0)..rect.max.col.min(col0 + block_cells);
        if cols.is_empty() {
            continue;
        }
        for row in rect.min.row.max(row0)..rect.max.row.min(row0 + block_cells) {
            let from = ((row - row0) * block_cells + cols.start - col0) as usize;
            let to = (row - rect.min.row) as usize * width + (cols.start - rect.min.col) as usize;
            let count = cols.len();
            for (state, &log_odds) in states[to..to + count]
                .iter_mut()
                .zip(&cells[from..from + count])
            {
                *state = grid.state_of(log_odds);
            }
        }
    }
    states
}

/// Unknown cells with at least five free neighbours and no occupied one count as free: they are the gaps between the
/// far ends of neighbouring beams.
pub(super) fn without_stripes(states: &[CellState], width: usize) -> Vec<CellState> {
    let mut filled = states.to_vec();
    if width < 3 {
        return filled;
    }
    for at in width + 1..states.len().saturating_sub(width + 1) {
        if states[at] != CellState::Unknown {
            continue;
        }
        let around = [
            at - width - 1,
            at - width,
            at - width + 1,
            at - 1,
            at + 1,
            at + width - 1,
            at + width,
            at + width + 1,
        ];
        let count = |state| around.iter().filter(|&&i| states[i] == state).count();
        if count(CellState::Free) >= 5 && count(CellState::Occupied) == 0 {
            filled[at] = CellState::Free;
        }
    }
    filled
}
