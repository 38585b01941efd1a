//! Lines of a scan drawn into bits, before they go to the blocks of the grid.
//!
//! In: lines in slices. Out: for each block the cells on any line, as 64 words.
//!
//! `cells` is the plain form: every cell of every slice of every line. The tests compare the canvas
//! with it, cell for cell. The canvas is faster because it draws slices as words, and needs more
//! memory: a sheet as large as all lines together.
//!
//! 1. Lines along x are drawn row by row; lines along y into a second, transposed sheet. So slices
//!    are few and long in any direction, and every slice of up to 56 cells is one change of one
//!    word.
//! 2. A row is a string of bytes, and a word begins at any of them: no slice has to be split where
//!    blocks meet.
//! 3. The words are read back block by block, those of the second sheet transposed.

use pulp::NullaryFnOnce;

use super::{BLOCK, BLOCK_BITS, BLOCK_CELLS, BlockIndex};
use crate::lanes::widened;
use crate::map::CellIndex;
use crate::map::line::{CellLine, FRACTION};

/// Bytes of a row of a block.
const ROW_BYTES: usize = BLOCK_CELLS / 8;
/// Lines that reach farther than this many cells from the beginning of the first one do not fit a
/// canvas.
const REACH: u32 = 2048;
/// Length of a slice that begins at any bit of a byte and still fits a word.
const WORD_SLICE: i64 = 55;

/// Rows of one block, a bit for each cell.
pub(crate) type Bits = [u64; BLOCK_CELLS];

/// Lines that are drawn together, and memory that is kept between scans.
#[derive(Clone, Debug, Default)]
pub(crate) struct Canvas {
    /// Where the first line begins.
    first: Option<CellIndex>,
    flat: Sheet,
    steep: Sheet,
}

impl Canvas {
    /// Takes a line, to be drawn with the others; returns it if it is too far away from the first
    /// one.
    pub(crate) fn take(&mut self, line: CellLine) -> Option<CellLine> {
        let ends = line.ends();
        let first = self.first.unwrap_or(ends[0]);
        let is_near = |at: i32, first: i32| at.abs_diff(first) < REACH;
        let is_inside =
            |end: &CellIndex| is_near(end.col, first.col) && is_near(end.row, first.row);
        if !ends.iter().all(is_inside) {
            return Some(line);
        }
        self.first = Some(first);
        let sheet = if line.is_flat {
            &mut self.flat
        } else {
            &mut self.steep
        };
        sheet.lines.push(line);
        None
    }

    /// Draws all lines, and passes on the bits of each block.
    pub(crate) fn draw(&mut self, mut visit: impl FnMut(BlockIndex, Bits)) {
        let Self { first, flat, steep } = self;
        flat.draw();
        steep.draw();
        flat.for_blocks(|[col, row], bits| visit(BlockIndex { col, row }, *bits));
        steep.for_blocks(|[row, col], bits| {
            widened(Turn(bits));
            visit(BlockIndex { col, row }, *bits);
        });
        *first = None;
    }
}

/// Rows of bits (or columns, in the sheet for lines along y).
#[derive(Clone, Debug, Default)]
struct Sheet {
    /// The lines of this sheet's direction, to be drawn.
    lines: Vec<CellLine>,
    /// The lowest block in each of the two directions, along and across.
    low: [i32; 2],
    /// Bytes of a row: those of its blocks, plus room for a word that sticks out.
    row_bytes: usize,
    bytes: Vec<u8>,
}

impl Sheet {
    /// Clears the sheet, makes it as large as its lines need, and draws them.
    fn draw(&mut self) {
        self.bytes.clear();
        let mut low = [i32::MAX; 2];
        let mut high = [i32::MIN; 2];
        for line in &self.lines {
            let (across, last) = (line.across, line.last_across());
            low = [low[0].min(line.from), low[1].min(across.min(last))];
            high = [high[0].max(line.to), high[1].max(across.max(last))];
        }
        if self.lines.is_empty() {
            return;
        }
        let [[left, low], [right, high]] = [low, high].map(|at| at.map(|cell| cell >> BLOCK_BITS));
        self.low = [left, low];
        self.row_bytes = (right - left + 2) as usize * ROW_BYTES;
        let rows = (high - low + 1) as usize * BLOCK_CELLS;
        self.bytes.resize(rows * self.row_bytes, 0);
        widened(DrawLines(self));
    }

    #[inline(always)]
    fn draw_line(&mut self, line: &CellLine) {
        let low = self.low.map(|block| block * BLOCK);
        let row = |slice: u32| (line.across + line.step * slice as i32 - low[1]) as usize;
        let (from, to) = ((line.from - low[0]) as usize, (line.to - low[0]) as usize);
        if line.more == 0 {
            self.draw_slice(row(0), from, to);
            return;
        }
        let mut place = line.border + ((from as i64) << FRACTION);
        self.draw_slice(row(0), from, cell(place));
        if line.slope >> FRACTION >= WORD_SLICE {
            for slice in 1..line.more {
                let next = place + line.slope;
                self.draw_slice(row(slice), cell(place) + line.gap, cell(next));
                place = next;
            }
        } else if line.more > 1 {
            let (first, last) = (row(1), row(line.more - 1));
            let bytes = first.min(last) * self.row_bytes..(first.max(last) + 1) * self.row_bytes;
            let rows = self.bytes.get_mut(bytes).unwrap_or_default();
            let rows = rows.chunks_exact_mut(self.row_bytes);
            place = if line.step > 0 {
                draw_short_slices(rows, line, place)
            } else {
                draw_short_slices(rows.rev(), line, place)
            };
        }
        self.draw_slice(row(line.more), cell(place) + line.gap, to);
    }

    /// A slice of any length.
    #[inline(always)]
    fn draw_slice(&mut self, row: usize, from: usize, to: usize) {
        let bytes = row * self.row_bytes..(row + 1) * self.row_bytes;
        let row = self.bytes.get_mut(bytes).unwrap_or_default();
        let mut at = from;
        while at <= to {
            let more = (to - at).min(WORD_SLICE as usize);
            draw_word(row, at, (2 << more) - 1);
            at += more + 1;
        }
    }

    /// Passes on the blocks that contain something, along and across.
    fn for_blocks(&self, mut visit: impl FnMut([i32; 2], &mut Bits)) {
        if self.bytes.is_empty() {
            return;
        }
        let bands = self.bytes.chunks_exact(BLOCK_CELLS * self.row_bytes);
        for (band, across) in bands.zip(self.low[1]..) {
            let mut any = vec![0; self.row_bytes];
            for row in band.chunks_exact(self.row_bytes) {
                any.iter_mut().zip(row).for_each(|(any, byte)| *any |= byte);
            }
            let blocks = any.as_chunks::<ROW_BYTES>().0.iter().enumerate();
            for (at, _) in blocks.filter(|(_, any)| **any != [0; ROW_BYTES]) {
                let mut bits = [0; BLOCK_CELLS];
                let rows = band.chunks_exact(self.row_bytes);
                for (word, row) in bits.iter_mut().zip(rows) {
                    let bytes = row.as_chunks().0.get(at);
                    *word = bytes.map_or(0, |bytes| u64::from_le_bytes(*bytes));
                }
                visit([self.low[0] + at as i32, across], &mut bits);
            }
        }
    }
}

/// Draws a slice in each row, each of which fits a word; the first begins at `place`. Returns where
/// the next one would begin.
#[inline(always)]
fn draw_short_slices<'a>(
    rows: impl Iterator<Item = &'a mut [u8]>,
    line: &CellLine,
    mut place: i64,
) -> i64 {
    for row in rows {
        let next = place + line.slope;
        let from = cell(place) + (line.gap & 1);
        draw_word(row, from, (2 << (cell(next) - from)) - 1);
        place = next;
    }
    place
}

#[inline(always)]
fn cell(place: i64) -> usize {
    // Unsigned, so that the compiler knows its range.
    (place as u64 >> FRACTION) as usize
}

/// Sets in the row the bits of `cells`, the lowest of which is the row's cell `from`.
#[inline(always)]
fn draw_word(row: &mut [u8], from: usize, cells: u64) {
    let word = row.get_mut(from / 8..from / 8 + 8);
    if let Some(bytes) = word.and_then(<[u8]>::first_chunk_mut) {
        *bytes = (u64::from_le_bytes(*bytes) | cells << (from % 8)).to_le_bytes();
    }
}

/// Draws the lines of a sheet and removes them.
struct DrawLines<'a>(&'a mut Sheet);

impl NullaryFnOnce for DrawLines<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let mut lines = std::mem::take(&mut self.0.lines);
        for line in &lines {
            self.0.draw_line(line);
        }
        lines.clear();
        self.0.lines = lines;
    }
}

/// Transposes the bits: blocks of half the size change places, then those inside them, down to
/// single bits.
///
/// Source: Warren (2012), "Hacker's Delight", §7-3.
struct Turn<'a>(&'a mut Bits);

impl NullaryFnOnce for Turn<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let mut low_halves = u64::MAX >> (BLOCK_CELLS / 2);
        let mut half = BLOCK_CELLS / 2;
        while half > 0 {
            for pair in self.0.chunks_exact_mut(2 * half) {
                let (lower, upper) = pair.split_at_mut(half);
                for (lower, upper) in lower.iter_mut().zip(upper) {
                    let changed = (*lower >> half ^ *upper) & low_halves;
                    *upper ^= changed;
                    *lower ^= changed << half;
                }
            }
            half /= 2;
            low_halves ^= low_halves << half;
        }
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use nalgebra::Point2;
    use proptest::prelude::*;

    use super::*;

    /// All cells of the lines.
    fn cells(lines: &[CellLine]) -> std::collections::BTreeSet<(i32, i32)> {
        let cells = lines.iter().flat_map(|line| line.cells());
        cells.map(|cell| (cell.col, cell.row)).collect()
    }

    proptest! {
        #[test]
        fn a_canvas_has_the_cells_of_its_lines_and_no_others(
            ways in prop::collection::vec(
                ([-90.0..90.0_f64, -90.0..90.0_f64], [-400.0..400.0_f64, -400.0..400.0_f64], any::<bool>()),
                1..20,
            ),
        ) {
            let line = |&([x, y], [dx, dy], is_crossed): &([f64; 2], [f64; 2], bool)| {
                let (start, end) = (Point2::new(x, y), Point2::new(x + dx, y + dy));
                if is_crossed { CellLine::crossed(start, end) } else { CellLine::bresenham(start, end) }
            };
            let lines: Vec<CellLine> = ways.iter().filter_map(line).collect();
            let mut canvas = Canvas::default();
            for line in &lines {
                prop_assert!(canvas.take(*line).is_none());
            }
            let mut drawn = BTreeSet::new();
            canvas.draw(|block, bits| {
                for (row, word) in bits.iter().enumerate() {
                    let set = (0..BLOCK_CELLS).filter(|col| word >> col & 1 == 1);
                    drawn.extend(set.map(|col| {
                        (block.col * BLOCK + col as i32, block.row * BLOCK + row as i32)
                    }));
                }
            });
            prop_assert_eq!(drawn, cells(&lines));
        }
    }

    #[test]
    fn turning_makes_rows_of_columns() {
        let mut state = 1_u64;
        let bits: Bits = std::array::from_fn(|_| {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1);
            state ^ state >> 31
        });
        let mut turned = bits;
        widened(Turn(&mut turned));
        for (row, turned) in turned.iter().enumerate() {
            for (col, own) in bits.iter().enumerate() {
                assert_eq!(turned >> col & 1, own >> row & 1, "{row} {col}");
            }
        }
    }
}
