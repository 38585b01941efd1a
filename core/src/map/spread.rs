//! Connected cells.
//!
//! In: a cell, the neighbours of each cell, and which cells belong. Out: all cells that can be
//! reached from it, ring by ring.

/// The cells of a raster that are at most `reach` columns and rows from a cell, including that
/// cell; row by row.
pub(crate) fn cells_around(
    cell: usize,
    reach: usize,
    width: usize,
    height: usize,
) -> impl Iterator<Item = usize> {
    let (col, row) = (cell % width, cell / width);
    let cols = col.saturating_sub(reach)..(col + reach + 1).min(width);
    let rows = row.saturating_sub(reach)..(row + reach + 1).min(height);
    rows.flat_map(move |row| cols.clone().map(move |col| row * width + col))
}

/// Cells in the order in which they were reached.
pub(crate) struct Rings {
    cells: Vec<u32>,
    /// Index at which each ring begins.
    starts: Vec<usize>,
}

/// Spreads from `seed` over the cells that `take` accepts, once each: it returns whether a cell
/// belongs and was not reached before. The caller must mark the seed as reached.
pub(crate) fn spread<N: IntoIterator<Item = usize>>(
    seed: usize,
    around: impl Fn(usize) -> N,
    mut take: impl FnMut(usize) -> bool,
) -> Rings {
    let mut cells = vec![seed as u32];
    let mut starts = vec![];
    let mut next = 0;
    while next < cells.len() {
        starts.push(next);
        let ring = next..cells.len();
        next = cells.len();
        for at in ring {
            for to in around(cells[at] as usize) {
                if take(to) {
                    cells.push(to as u32);
                }
            }
        }
    }
    Rings { cells, starts }
}

impl Rings {
    /// All cells, the nearest first.
    pub(crate) fn cells(&self) -> impl ExactSizeIterator<Item = usize> {
        self.cells.iter().map(|&cell| cell as usize)
    }

    /// The cells in bands of this many rings.
    pub(crate) fn bands(&self, rings: usize) -> impl Iterator<Item = Vec<usize>> {
        let starts = || self.starts.iter().copied().step_by(rings.max(1));
        let ends = starts().skip(1).chain([self.cells.len()]);
        let cells = |(from, to)| self.cells().take(to).skip(from).collect();
        starts().zip(ends).map(cells)
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    #[test]
    fn rings_are_the_cells_at_that_many_steps() {
        // A street that goes round the corner, and a yard beside it that does not touch it.
        let street = [0, 1, 2, 3, 13, 23, 33, 32, 31];
        let mut left: BTreeSet<usize> = street.into_iter().chain([51, 52]).collect();
        left.remove(&2);
        let around = |cell: usize| {
            [
                cell + 1,
                cell + 10,
                cell.wrapping_sub(1),
                cell.wrapping_sub(10),
            ]
        };
        let rings = spread(2, around, |cell| left.remove(&cell));
        assert_eq!(left, BTreeSet::from([51, 52]));
        let all: Vec<usize> = rings.cells().collect();
        assert_eq!(all, [2, 3, 1, 13, 0, 23, 33, 32, 31]);
        let bands: Vec<_> = rings.bands(2).collect();
        assert_eq!(
            bands,
            [vec![2, 3, 1], vec![13, 0, 23], vec![33, 32], vec![31]][..]
        );
        assert_eq!(
            rings.bands(7).map(|band| band.len()).collect::<Vec<_>>(),
            [9]
        );
    }

    #[test]
    fn a_cell_by_itself_is_one_ring() {
        let rings = spread(7, |cell| [cell + 1], |_| false);
        assert_eq!(rings.bands(3).collect::<Vec<_>>(), [vec![7]]);
    }
}
