//! The states of the cells of a rectangle.

use nalgebra::Point2;

use super::{BLOCK, Grid};
use crate::map::{BlockIndex, CellRect, CellState};

impl Grid {
    /// The believed states of the cells of a rectangle, in rows from the lower left one; read block
    /// by block.
    #[must_use]
    pub fn states(&self, rect: CellRect) -> Vec<CellState> {
        let width = rect.width();
        let mut states = vec![CellState::Unknown; width * rect.height()];
        for (block, cells) in self.blocks_in(rect) {
            let (col0, row0) = (block.col * BLOCK, block.row * BLOCK);
            let cols = rect.min.col.max(col0)..rect.max.col.min(col0 + BLOCK);
            for row in rect.min.row.max(row0)..rect.max.row.min(row0 + BLOCK) {
                let from = ((row - row0) * BLOCK + cols.start - col0) as usize;
                let to =
                    (row - rect.min.row) as usize * width + (cols.start - rect.min.col) as usize;
                let count = cols.len();
                for (state, &log_odds) in states[to..to + count]
                    .iter_mut()
                    .zip(&cells[from..from + count])
                {
                    *state = self.state_of(log_odds);
                }
            }
        }
        states
    }

    /// Centres of the occupied cells, m, in the grid's frame; row by row.
    #[must_use]
    pub fn occupied(&self) -> Vec<Point2<f64>> {
        let is_occupied = |odds| self.state_of(odds) == CellState::Occupied;
        let rect = self.rect_where(is_occupied).into_iter();
        let cells = rect.flat_map(|rect| rect.cells());
        cells
            .filter(|cell| is_occupied(self.log_odds(*cell)))
            .map(|cell| self.centre_of(cell))
            .collect()
    }

    /// The existing blocks that a rectangle of cells meets.
    fn blocks_in(&self, rect: CellRect) -> impl Iterator<Item = (BlockIndex, &[f32])> {
        let span = |low: i32, high: i32| {
            low.div_euclid(BLOCK)..high.saturating_sub(1).div_euclid(BLOCK) + 1
        };
        let cols = span(rect.min.col, rect.max.col);
        let rows = span(rect.min.row, rect.max.row);
        let indices =
            rows.flat_map(move |row| cols.clone().map(move |col| BlockIndex { col, row }));
        indices.filter_map(|index| Some((index, self.block(index)?)))
    }
}

/// Unknown cells with at least five free neighbours and no occupied one count as free: they are the
/// gaps between the far ends of neighbouring beams.
#[must_use]
pub fn without_stripes(states: &[CellState], width: usize) -> Vec<CellState> {
    let mut filled = states.to_vec();
    if width < 3 {
        return filled;
    }
    for at in width + 1..states.len().saturating_sub(width + 1) {
        if states[at] != CellState::Unknown {
            continue;
        }
        let around = [1, width - 1, width, width + 1].map(|by| [at - by, at + by]);
        let count = |state| {
            around
                .iter()
                .flatten()
                .filter(|&&i| states[i] == state)
                .count()
        };
        if count(CellState::Free) >= 5 && count(CellState::Occupied) == 0 {
            filled[at] = CellState::Free;
        }
    }
    filled
}
