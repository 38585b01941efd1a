//! Names for cells and blocks, and the states of a cell.

use nalgebra::Point2;

/// Column and row of a grid cell; cell (0, 0) has its lower left corner at the map's origin.
/// Columns grow with x, rows with y.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct CellIndex {
    /// Along x.
    pub col: i32,
    /// Along y.
    pub row: i32,
}

/// Column and row of a square block of cells.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct BlockIndex {
    /// Along x.
    pub col: i32,
    /// Along y.
    pub row: i32,
}

/// A rectangle of cells, upper bounds excluded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CellRect {
    /// Lower left cell, inside.
    pub min: CellIndex,
    /// Upper right cell, the first outside.
    pub max: CellIndex,
}

impl CellIndex {
    /// The cell of a column and a row.
    #[must_use]
    pub const fn new(col: i32, row: i32) -> Self {
        Self { col, row }
    }

    /// The cell this many columns and rows farther; saturates.
    fn shifted(self, by: i32) -> Self {
        Self::new(self.col.saturating_add(by), self.row.saturating_add(by))
    }

    /// The cell that holds a point given in cell units; far-away and non-finite points saturate.
    #[inline]
    #[must_use]
    pub fn holding(point: Point2<f64>) -> Self {
        Self {
            col: floor(point.x),
            row: floor(point.y),
        }
    }
}

/// The greatest whole number not above `at`; saturates, 0 for NaN. Equal to `at.floor() as i32`,
/// which is a function call if the processor is not known to have the instruction.
#[inline]
pub(super) fn floor(at: f64) -> i32 {
    let towards_zero = at as i32;
    towards_zero.saturating_sub(i32::from(f64::from(towards_zero) > at))
}

impl CellRect {
    /// The rectangle of this many columns and rows from cell (0, 0) on.
    #[must_use]
    pub fn of_size(width: usize, height: usize) -> Self {
        Self {
            min: CellIndex::new(0, 0),
            max: CellIndex::new(width as i32, height as i32),
        }
    }

    /// The rectangle of one cell.
    #[must_use]
    pub fn of(cell: CellIndex) -> Self {
        Self {
            min: cell,
            max: cell.shifted(1),
        }
    }

    /// The rectangle extended by this many cells on each side.
    #[must_use]
    pub fn grown(self, by: i32) -> Self {
        Self {
            min: self.min.shifted(-by),
            max: self.max.shifted(by),
        }
    }

    /// Number of columns.
    #[must_use]
    pub fn width(&self) -> usize {
        usize::try_from(self.max.col - self.min.col).unwrap_or(0)
    }

    /// Number of rows.
    #[must_use]
    pub fn height(&self) -> usize {
        usize::try_from(self.max.row - self.min.row).unwrap_or(0)
    }

    /// The cells, row by row from the lower left one.
    pub fn cells(self) -> impl Iterator<Item = CellIndex> {
        let Self { min, max } = self;
        let row = move |row| (min.col..max.col).map(move |col| CellIndex { col, row });
        (min.row..max.row).flat_map(row)
    }

    /// Number of a cell, in rows from the lower left one; `None` outside.
    #[inline]
    #[must_use]
    pub fn index_of(self, cell: CellIndex) -> Option<usize> {
        let inside = cell.col >= self.min.col
            && cell.col < self.max.col
            && cell.row >= self.min.row
            && cell.row < self.max.row;
        inside.then(|| {
            let (col, row) = (cell.col - self.min.col, cell.row - self.min.row);
            row as usize * self.width() + col as usize
        })
    }

    /// The smallest rectangle around both.
    #[must_use]
    pub fn around(self, other: Self) -> Self {
        Self {
            min: CellIndex::new(
                self.min.col.min(other.min.col),
                self.min.row.min(other.min.row),
            ),
            max: CellIndex::new(
                self.max.col.max(other.max.col),
                self.max.row.max(other.max.row),
            ),
        }
    }
}

/// The believed state of a cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CellState {
    /// Never seen, or as likely free as not.
    Unknown,
    /// Believed free.
    Free,
    /// Believed occupied.
    Occupied,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_are_counted_downwards_as_floor_does() {
        let wholes = [0.0, 1.0, 2.0, 1e9, 2_147_483_647.0, 1e300, f64::INFINITY];
        let near = |at: f64| [at, at.next_up(), at.next_down(), at + 0.5];
        for at in wholes.into_iter().flat_map(near) {
            for at in [at, -at] {
                assert_eq!(floor(at), at.floor() as i32, "{at}");
            }
        }
        assert_eq!(floor(f64::NAN), 0);
    }
}
