//! The cells between the beams of a scan: steps 1 to 3 of the area rule in [`super::free_cells`].

use std::f64::consts::TAU;

use nalgebra::Point2;

use super::free_cells::Way;
use super::{BLOCK, BLOCK_BITS, BLOCK_CELLS, BlockIndex, Grid};
use crate::geom::{Length, sides_of};
use crate::points::WIDEST_GAP;

/// The ways, and working memory that is kept between scans.
#[derive(Clone, Debug, Default)]
pub(super) struct Area {
    pub(super) ways: Vec<Way>,
    outline: Vec<Point2<f64>>,
    /// A bit for each cell: block after block of the rectangle, row by row in each. All zero
    /// between two polygons.
    flags: Vec<[u64; BLOCK_CELLS]>,
}

impl Area {
    /// Marks the cells between the ways: step 1.
    pub(super) fn mark(&mut self, grid: &mut Grid) {
        let ways = std::mem::take(&mut self.ways);
        let turns: Vec<f64> = ways.windows(2).map(|w| turn(&w[0], &w[1])).collect();
        let is_joined = |turn: f64| turn > 0.0 && turn < WIDEST_GAP;
        // Not across a range of bearings where nothing was seen: the other way round may be the
        // shorter one.
        let small = turns.iter().filter(|turn| is_joined(turn.abs()));
        let direction = small.sum::<f64>().signum();
        let (mut first, mut turned) = (0, 0.0);
        for (at, turn) in turns.iter().map(|turn| turn * direction).enumerate() {
            turned += turn;
            if is_joined(turn) && turned < TAU {
                continue;
            }
            self.fill(&ways[first..=at], grid);
            // A fan that goes all the way round would overlap itself: the next fan begins with its
            // last way.
            (first, turned) = if is_joined(turn) {
                (at, turn)
            } else {
                (at + 1, 0.0)
            };
        }
        if let Some(rest) = ways.get(first..) {
            self.fill(rest, grid);
        }
        if let [begin, .., end] = ways[..]
            && is_joined(direction * turn(&end, &begin))
        {
            self.fill(&[end, begin], grid);
        }
        self.ways = ways;
    }

    /// Marks the cells of a fan.
    fn fill(&mut self, fan: &[Way], grid: &mut Grid) {
        if let [way] = fan {
            grid.cross(*way);
            return;
        }
        let starts = fan.iter().rev().map(|[start, _]| *start);
        self.outline.clear();
        self.outline.extend(fan.iter().map(end_of).chain(starts));
        self.outline.dedup();
        if let Some(rect) = BlockRect::around(&self.outline) {
            self.flag(&rect);
            self.mark_inside(&rect, grid);
        }
    }

    /// Step 2.
    fn flag(&mut self, rect: &BlockRect) {
        self.flags
            .resize(rect.count().max(self.flags.len()), [0; BLOCK_CELLS]);
        for (a, b) in sides_of(&self.outline) {
            let (low, high) = if a.y < b.y { (a, b) } else { (b, a) };
            let slope = (high.x - low.x) / (high.y - low.y);
            let rows = first_centre_from(low.y)..first_centre_from(high.y);
            for row in rows {
                let x = low.x + (f64::from(row) + 0.5 - low.y) * slope;
                if let Some((block, row, bit)) = rect.place(first_centre_from(x), row) {
                    self.flags[block][row] ^= bit;
                }
            }
        }
    }

    /// Step 3.
    fn mark_inside(&mut self, rect: &BlockRect, grid: &mut Grid) {
        let blocks = self.flags.chunks_mut(rect.cols as usize);
        for (band, row) in blocks.zip(rect.rows.clone()) {
            // One word for each row of the band: all ones if the word before ended inside.
            let mut inside = [0; BLOCK_CELLS];
            for (flags, col) in band.iter_mut().zip(rect.col..) {
                if flags.iter().chain(&inside).all(|word| *word == 0) {
                    continue;
                }
                let marks = grid.marks_of(BlockIndex { col, row });
                let mut cells = std::mem::replace(flags, [0; BLOCK_CELLS]);
                for (word, inside) in cells.iter_mut().zip(&mut inside) {
                    *word = parity_up_to_each_bit(*word) ^ *inside;
                    *inside = (*word as i64 >> 63) as u64;
                }
                if let Some(marks) = marks {
                    let marks = &mut grid.marks[marks];
                    for (misses, cells) in marks.misses.iter_mut().zip(cells) {
                        *misses |= cells;
                    }
                }
            }
        }
    }
}

/// Blocks around a polygon.
struct BlockRect {
    col: i32,
    cols: i32,
    rows: std::ops::Range<i32>,
}

impl BlockRect {
    /// `None` without points.
    fn around(outline: &[Point2<f64>]) -> Option<Self> {
        let first = *outline.first()?;
        let (low, high) = outline
            .iter()
            .fold((first, first), |(low, high), p| (low.inf(p), high.sup(p)));
        let block = |at: f64| at.floor() as i32 >> BLOCK_BITS;
        Some(Self {
            col: block(low.x),
            cols: block(high.x) - block(low.x) + 1,
            rows: block(low.y)..block(high.y) + 1,
        })
    }

    fn count(&self) -> usize {
        self.cols as usize * self.rows.len()
    }

    /// Block, row in it and bit of a cell; `None` right of the rectangle, where no cell has to be
    /// toggled.
    #[inline]
    fn place(&self, col: i32, row: i32) -> Option<(usize, usize, u64)> {
        let across = (col >> BLOCK_BITS) - self.col;
        let up = (row >> BLOCK_BITS) - self.rows.start;
        let block = (up * self.cols + across) as usize;
        let bit = 1 << (col & (BLOCK - 1));
        (across < self.cols).then_some((block, (row & (BLOCK - 1)) as usize, bit))
    }
}

/// The first row (or column) whose centre is not below (or left of) `at`.
#[inline]
fn first_centre_from(at: f64) -> i32 {
    // By hand, because `ceil` is a function call if the machine has no instruction for it.
    let whole = (at - 0.5) as i32;
    whole + i32::from(at - 0.5 > f64::from(whole))
}

/// Each bit becomes the exclusive or of itself and all lower ones.
#[inline]
fn parity_up_to_each_bit(mut word: u64) -> u64 {
    for shift in [1, 2, 4, 8, 16, 32] {
        word ^= word << shift;
    }
    word
}

/// The end of a way, moved back from the surface by a cell.
fn end_of([start, end]: &Way) -> Point2<f64> {
    let way = end - start;
    let cells = way.length();
    if cells > 1.0 {
        end - way / cells
    } else {
        *start
    }
}

/// By how much the next way turns to the left: the tangent of the angle, which equals the angle
/// when it is small; 0 from a right angle on, and if a way has no direction.
fn turn(way: &Way, next: &Way) -> f64 {
    let (way, next) = (way[1] - way[0], next[1] - next[0]);
    let along = way.dot(&next);
    if along > 0.0 {
        way.perp(&next) / along
    } else {
        0.0
    }
}
