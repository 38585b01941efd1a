//! Which cells a scan leaves free.
//!
//! In: the straight ways that are free, in the order of their bearings. Out: marks in the blocks.
//!
//! | sweep | a cell is free if | cost |
//! |---|---|---|
//! | [`Sweep::Crossed`] | a way enters it | cells on the ways, by runs |
//! | [`Sweep::Bresenham`] | it is on the line of a way | the same, fewer of them |
//! | [`Sweep::Area`] | its centre lies between the ways | outline of the area, a word for 64 cells |
//!
//! The area:
//! 1. Neighbouring ways less than 0.1 rad apart make a fan, the polygon of their ends closed over their starts. Ends stand back by
//!    a cell, for that of the surface is not free. A way by itself is crossed.
//! 2. Each side of the polygon changes, in each row whose centre line it meets, one bit: that of the first cell whose centre lies
//!    right of it. A cell is inside if an odd number of bits left of it and its own is set.
//! 3. In the rectangle of blocks around the polygon, row by row, each word becomes the exclusive or of all bits up to each of its own
//!    (six shifts), turned round where the word before it ended inside.
//!
//! Sources: Celej §4, `BresenhamLine` and `myownAlgorithm`, which sweeps the rectangle between robot and obstacle; there it pays
//! least where the beam is horizontal or vertical and the rectangle a line. Here one rectangle holds all beams. Step 2: Ackland & Weste
//! (1981), "The edge flag algorithm: a fill method for raster scan displays".

use nalgebra::Point2;

use super::{BLOCK, BLOCK_BITS, BlockIndex, Grid};
use crate::map::line::runs_on_line;
use crate::map::ray::{Run, runs_on_ray};

/// How the cells that a scan leaves free are found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Sweep {
    /// Every cell that a beam enters (Amanatides & Woo 1987).
    #[default]
    Crossed,
    /// The cells of each beam's Bresenham line, which leaves out cells that the beam only nicks.
    Bresenham,
    /// Every cell whose centre lies in the area between the beams, also where they are farther apart than cells.
    Area,
}

impl Sweep {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Crossed, Self::Bresenham, Self::Area];
}

/// A way from a sensor to where it is no longer free, in cells.
pub(super) type Way = [Point2<f64>; 2];

/// Ways that reach farther than this many cells in x or y have no area.
const REACH: f64 = 16_384.0;

/// The block in which the last run was, and its marks.
type Known = Option<(BlockIndex, Option<usize>)>;

impl Grid {
    /// Marks what the ways leave free.
    pub(super) fn sweep(&mut self, ways: impl Iterator<Item = Way>) {
        match self.config.sweep {
            Sweep::Crossed => ways.for_each(|way| self.cross(way)),
            Sweep::Bresenham => {
                for [start, end] in ways {
                    let mut known = None;
                    runs_on_line(start, end, |run| self.mark(run, &mut known));
                }
            }
            Sweep::Area => {
                let mut area = std::mem::take(&mut self.area);
                area.ways.extend(ways.filter(is_in_reach));
                area.mark(self);
                area.ways.clear();
                self.area = area;
            }
        }
    }

    pub(super) fn cross(&mut self, [start, end]: Way) {
        let mut known = None;
        runs_on_ray(start, end, |run| self.mark(run, &mut known));
    }

    /// Neighbouring runs of a ray nearly always lie in one block: it is looked up only where it changes.
    #[inline(always)]
    fn mark(&mut self, run: Run, known: &mut Known) {
        for (index, offset, cells) in run_by_block(run) {
            let marks = match *known {
                Some((last, marks)) if last == index => marks,
                _ => {
                    let marks = self.marks_of(index);
                    *known = Some((index, marks));
                    marks
                }
            };
            if let Some(marks) = marks {
                self.marks[marks].misses[offset] |= cells;
            }
        }
    }
}

/// Parts a run where it crosses into the next block, in its own direction: block, row in it, and the cells as bits.
#[inline]
fn run_by_block(run: Run) -> impl Iterator<Item = (BlockIndex, usize, u64)> {
    let (low, high) = (run.from.min(run.to), run.from.max(run.to));
    let (first, last) = (run.from >> BLOCK_BITS, run.to >> BLOCK_BITS);
    let step = if first <= last { 1 } else { -1 };
    (0..=(last - first).abs()).map(move |n| {
        let col = first + n * step;
        let from = low.max(col << BLOCK_BITS) & (BLOCK - 1);
        let to = high.min((col << BLOCK_BITS) | (BLOCK - 1)) & (BLOCK - 1);
        let cells = (u64::MAX >> (BLOCK - 1 - (to - from))) << from;
        let index = BlockIndex {
            col,
            row: run.row >> BLOCK_BITS,
        };
        (index, (run.row & (BLOCK - 1)) as usize, cells)
    })
}

fn is_in_reach([start, end]: &Way) -> bool {
    start.coords.amax() < 1e9 && (end - start).amax() < REACH
}
