//! Space that beams passed through: what was surely free, in coarse cells of one bit each.
//!
//! In: beams, from the sensor to where they are surely free. Out: whether a place was seen as free.
//! The area grows with what is marked.
//!
//! Beams are drawn on a canvas of bits, as in a grid, and its blocks are copied tile by tile.

use nalgebra::Point2;

use crate::geom::Length;
use crate::map::{BLOCK_CELLS, BlockIndex, Canvas, CellIndex, CellLine, cells_on_ray};
use crate::snapshot::snapshot;

/// Side of a cell, m: coarse, because submaps drift by centimetres.
const CELL: f64 = 0.2;
/// The inverse of that.
const CELLS_PER_METRE: f64 = 5.0;
/// The last part of each beam that says nothing about free space, m: it may belong to the wall, or
/// to an edge that the beam touches.
const UNSURE_END: f64 = 0.3;
/// Cells along the side of a tile, which is one word.
const TILE: i32 = 8;
const TILE_CELLS: usize = TILE as usize;
/// Number of tiles by which the area grows beyond what is needed, on each side.
const MARGIN: i32 = 8;
/// Cells with an index farther from the origin than this are not stored: 100 km.
const FARTHEST: u32 = 500_000;
/// The most tiles along one side of the area: 3 km.
const MOST_TILES: i32 = 2048;

/// Space that beams passed through.
#[derive(Clone, Debug, Default)]
pub(super) struct FreeSpace {
    /// Column and row of the tile at the lower left.
    low: (i32, i32),
    cols: i32,
    rows: i32,
    tiles: Vec<u64>,
}

impl FreeSpace {
    /// Marks the space that beams passed through.
    pub(super) fn mark(&mut self, rays: impl Iterator<Item = [Point2<f64>; 2]>) {
        let mut canvas = Canvas::default();
        for [from, to] in rays {
            let way = to - from;
            let length = way.length();
            let part = (length - UNSURE_END) / length;
            if part.is_nan() || part <= 0.0 {
                continue;
            }
            let end = from + way * part;
            let (from, end) = (from * CELLS_PER_METRE, end * CELLS_PER_METRE);
            // A diagonal beam passes exactly through corners, where canvas and walk choose
            // different cells. Saved maps and pinned runs have those of the walk.
            let is_diagonal = (end.x - from.x).abs() == (end.y - from.y).abs();
            let line = CellLine::crossed(from, end).filter(|_| !is_diagonal);
            if line.is_none_or(|line| canvas.take(line).is_some()) {
                self.walk(from, end);
            }
        }
        canvas.draw(|block, rows| self.mark_block(block, &rows));
    }

    /// Marks a beam cell by cell; both ends are given in units of cells.
    fn walk(&mut self, from: Point2<f64>, end: Point2<f64>) {
        // An area that holds both ends also holds everything between them.
        if ![from, end]
            .map(CellIndex::holding)
            .into_iter()
            .all(|end| self.hold(end))
        {
            return;
        }
        cells_on_ray(from, end, |cell| {
            if let Some((tile, bit)) = self.bit(cell)
                && let Some(bits) = self.tiles.get_mut(tile)
            {
                *bits |= bit;
            }
        });
    }

    /// Marks the cells of a block, given in rows, tile by tile.
    fn mark_block(&mut self, block: BlockIndex, rows: &[u64; BLOCK_CELLS]) {
        for (band, row) in rows.as_chunks::<TILE_CELLS>().0.iter().zip(0_i32..) {
            let any = band.iter().fold(0, |any, row| any | row);
            for col in (0..TILE).filter(|col| any.to_le_bytes()[*col as usize] != 0) {
                let bits = u64::from_le_bytes(band.map(|row| row.to_le_bytes()[col as usize]));
                let in_block = |block: i32, tile: i32| (block * BLOCK_CELLS as i32) + tile * TILE;
                let first = CellIndex::new(in_block(block.col, col), in_block(block.row, row));
                if self.hold(first)
                    && let Some((tile, _)) = self.bit(first)
                    && let Some(tile) = self.tiles.get_mut(tile)
                {
                    *tile |= bits;
                }
            }
        }
    }

    /// Whether a beam passed through this place.
    pub(super) fn contains(&self, place: Point2<f64>) -> bool {
        self.bit(cell_of(place))
            .and_then(|(tile, bit)| Some(self.tiles.get(tile)? & bit != 0))
            .unwrap_or(false)
    }

    /// The centres of all cells that beams passed through.
    pub(super) fn places(&self) -> impl Iterator<Item = Point2<f64>> + '_ {
        let tiles = self
            .tiles
            .iter()
            .zip(0_i32..)
            .filter(|(bits, _)| **bits != 0);
        tiles.flat_map(move |(bits, tile)| {
            let col = (self.low.0 + tile % self.cols) * TILE;
            let row = (self.low.1 + tile / self.cols) * TILE;
            let set = (0..TILE * TILE).filter(move |bit| bits >> bit & 1 != 0);
            set.map(move |bit| {
                let middle = |cell: i32| (f64::from(cell) + 0.5) * CELL;
                Point2::new(middle(col + bit % TILE), middle(row + bit / TILE))
            })
        })
    }

    /// Whether beams passed through this place and one cell around it in every direction, not only
    /// along a wall that stands here.
    pub(super) fn contains_around(&self, place: Point2<f64>) -> bool {
        let steps = [-CELL, 0.0, CELL];
        let around = steps.iter().flat_map(|x| steps.iter().map(move |y| (x, y)));
        around
            .map(|(x, y)| Point2::new(place.x + x, place.y + y))
            .all(|near| self.contains(near))
    }

    /// Grows the area until it holds a cell; `false` if the cell is too far away.
    fn hold(&mut self, CellIndex { col, row }: CellIndex) -> bool {
        if col.unsigned_abs().max(row.unsigned_abs()) > FARTHEST {
            return false;
        }
        let at = (col.div_euclid(TILE), row.div_euclid(TILE));
        let (col, row) = (at.0 - self.low.0, at.1 - self.low.1);
        if (0..self.cols).contains(&col) && (0..self.rows).contains(&row) {
            return true;
        }
        let was = (!self.tiles.is_empty()).then(|| {
            let high = (self.low.0 + self.cols, self.low.1 + self.rows);
            (self.low, high)
        });
        let (low, high) = was.unwrap_or((at, (at.0 + 1, at.1 + 1)));
        let grown = |at: i32, low: i32, high: i32| {
            let low = if at < low { at - MARGIN } else { low };
            let high = if at >= high { at + 1 + MARGIN } else { high };
            (low, high)
        };
        let (cols, rows) = (grown(at.0, low.0, high.0), grown(at.1, low.1, high.1));
        if cols.1 - cols.0 > MOST_TILES || rows.1 - rows.0 > MOST_TILES {
            return false;
        }
        let mut larger = Self {
            low: (cols.0, rows.0),
            cols: cols.1 - cols.0,
            rows: rows.1 - rows.0,
            tiles: vec![],
        };
        larger.tiles = vec![0; (larger.cols * larger.rows) as usize];
        let shift = (self.low.0 - larger.low.0, self.low.1 - larger.low.1);
        for row in 0..self.rows {
            let from = (row * self.cols) as usize;
            let to = ((row + shift.1) * larger.cols + shift.0) as usize;
            let count = self.cols as usize;
            larger.tiles[to..to + count].copy_from_slice(&self.tiles[from..from + count]);
        }
        *self = larger;
        true
    }

    fn bit(&self, CellIndex { col, row }: CellIndex) -> Option<(usize, u64)> {
        let (col, row) = (col - self.low.0 * TILE, row - self.low.1 * TILE);
        let is_within =
            (0..self.cols * TILE).contains(&col) && (0..self.rows * TILE).contains(&row);
        is_within.then(|| tile_and_bit(col as usize, row as usize, self.cols as usize))
    }
}

snapshot!(
    FreeSpace {
        low,
        cols,
        rows,
        tiles
    },
    |free| free.is_sound(),
    "its tiles do not fill its area"
);

impl FreeSpace {
    fn is_sound(&self) -> bool {
        let spans = 0..=MOST_TILES;
        let lies_near = |at: i32| at.abs() < 1 << 20;
        lies_near(self.low.0)
            && lies_near(self.low.1)
            && spans.contains(&self.cols)
            && spans.contains(&self.rows)
            && self.tiles.len() == (self.cols * self.rows) as usize
    }
}

/// Where a cell is stored, counted from the lower left of an area with `cols` columns of tiles.
#[inline]
fn tile_and_bit(col: usize, row: usize, cols: usize) -> (usize, u64) {
    let tile = row / TILE_CELLS * cols + col / TILE_CELLS;
    let bit = row % TILE_CELLS * TILE_CELLS + col % TILE_CELLS;
    (tile, 1 << bit)
}

fn cell_of(place: Point2<f64>) -> CellIndex {
    // Kept well below the limits of a cell index, so that additions cannot overflow.
    CellIndex::holding(place.map(|v| (v * CELLS_PER_METRE).clamp(-1e6, 1e6)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn what_lies_on_a_beam_is_free_and_nothing_beside_it(
            x in -60.0..60.0_f64, y in -60.0..60.0_f64, angle in -3.1..3.1_f64,
            length in 0.5..90.0_f64, part in 0.0..1.0_f64,
        ) {
            let from = Point2::new(x, y);
            let along = crate::geom::unit_vector(angle);
            let mut free = FreeSpace::default();
            let near = Point2::new(3.0, -2.0);
            free.mark([[near, near + along]].into_iter());
            free.mark([[from, from + along * length]].into_iter());
            prop_assert!(free.contains(near + along * 0.5), "kept while the area grew");
            prop_assert!(free.contains(from + along * part * (length - UNSURE_END)));
            prop_assert!(!free.contains(from + along * (length + 0.01)));
            prop_assert!(free.places().all(|place| free.contains(place)));
            let bits: u32 = free.tiles.iter().map(|tile| tile.count_ones()).sum();
            prop_assert_eq!(free.places().count(), bits as usize);
            let beside = from + nalgebra::Vector2::new(-along.y, along.x) * 0.6;
            prop_assume!((beside - near).length() > 2.0);
            prop_assert!(!free.contains(beside));
        }
    }

    /// Near and far beams of a scan, drawn in different ways: the cells are those that a walk along
    /// each of them enters.
    #[test]
    fn cells_of_many_beams_are_those_of_each() {
        let from = Point2::new(-1.7, 2.3);
        let rays = (0..90).map(|at| {
            let along = crate::geom::unit_vector(0.07 * f64::from(at) + 0.01);
            let length = if at % 30 == 7 {
                700.0
            } else {
                0.2 + 0.4 * f64::from(at)
            };
            [from, from + along * length]
        });
        let mut free = FreeSpace::default();
        free.mark(rays.clone());
        let mut expected = std::collections::BTreeSet::new();
        for [from, to] in rays {
            let part = 1.0 - UNSURE_END / (to - from).length();
            let end = from + (to - from) * part.max(0.0);
            if part > 0.0 {
                cells_on_ray(from / CELL, end / CELL, |cell| {
                    expected.insert(cell);
                });
            }
        }
        let marked: std::collections::BTreeSet<_> = free.places().map(cell_of).collect();
        assert_eq!(marked, expected);
    }

    #[test]
    fn along_a_single_beam_nothing_is_free_all_around() {
        let mut free = FreeSpace::default();
        let beam = |y: f64| [Point2::new(0.0, y), Point2::new(4.0, y)];
        free.mark([beam(0.1)].into_iter());
        assert!(!free.contains_around(Point2::new(2.0, 0.1)));
        free.mark([beam(-0.1), beam(0.3)].into_iter());
        assert!(free.contains_around(Point2::new(2.0, 0.1)));
        assert!(!free.contains_around(Point2::new(2.0, 0.3)));
    }

    #[test]
    fn what_is_not_finite_or_too_far_is_left_out() {
        let mut free = FreeSpace::default();
        let far = Point2::new(1e9, f64::NAN);
        free.mark([[Point2::origin(), far], [far, far]].into_iter());
        assert!(!free.contains(far) && !free.contains(Point2::new(1e300, 0.0)));
    }
}
