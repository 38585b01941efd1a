//! Which cells a scan leaves free.
//!
//! In: the straight lines of sight that are free ("ways"), in the order of their bearings. Out:
//! marks in the blocks.
//!
//! | rule | a cell is free if | cost |
//! |---|---|---|
//! | [`FreeCells::Crossed`] | a way enters it | a word for each slice of a way, row or column by which is fewer |
//! | [`FreeCells::Bresenham`] | it is on the line of a way | the same |
//! | [`FreeCells::Area`] | its centre lies between the ways | outline of the area, a word for 64 cells |
//!
//! The area:
//! 1. Neighbouring ways less than 0.1 rad apart make a fan, the polygon of their ends closed over
//!    their starts. Ends are moved back by a cell, because the cell of the surface is not free. A
//!    way by itself is treated as crossed.
//! 2. Each side of the polygon changes, in each row whose centre line it meets, one bit: that of
//!    the first cell whose centre lies right of it. A cell is inside if an odd number of bits left
//!    of it and its own is set.
//! 3. In the rectangle of blocks around the polygon, row by row, each word becomes the exclusive or
//!    of all bits up to each of its own (six shifts), inverted if the word before it ended inside.
//!
//! Sources: Celej §4, `BresenhamLine` and `myownAlgorithm`, which sweeps the rectangle between
//! robot and obstacle; there it gains least when the beam is horizontal or vertical and the
//! rectangle is a line. Here one rectangle holds all beams. Step 2: Ackland & Weste (1981), "The
//! edge flag algorithm: a fill method for raster scan displays".

use nalgebra::Point2;

use super::{BLOCK_CELLS, BlockIndex, Grid, split};
use crate::map::line::CellLine;

/// How the cells that a scan leaves free are found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FreeCells {
    /// Every cell that a beam enters (Amanatides & Woo 1987).
    #[default]
    Crossed,
    /// The cells of each beam's Bresenham line, which skips cells that the beam only nicks.
    Bresenham,
    /// Every cell whose centre lies in the area between the beams, even if they are farther apart
    /// than cells.
    Area,
}

impl FreeCells {
    /// All variants, with their names in settings and their names for people.
    pub const ALL: [(&'static str, Self, &'static str); 3] = [
        ("crossed", Self::Crossed, "that a beam enters"),
        ("bresenham", Self::Bresenham, "on its Bresenham line"),
        ("area", Self::Area, "between the beams"),
    ];
}

/// A way from a sensor to where it is no longer free, in cells.
pub(super) type Way = [Point2<f64>; 2];

/// Ways that reach farther than this many cells in x or y have no area.
const REACH: f64 = 16_384.0;

/// The block of the last cell, and its marks.
type LastBlock = Option<(BlockIndex, Option<usize>)>;

impl Grid {
    /// Marks the cells that the ways leave free.
    pub(super) fn mark_free(&mut self, ways: impl Iterator<Item = Way>) {
        match self.config.free_cells {
            FreeCells::Crossed => {
                self.draw_lines(ways.map(|[start, end]| CellLine::crossed(start, end)))
            }
            FreeCells::Bresenham => {
                self.draw_lines(ways.map(|[start, end]| CellLine::bresenham(start, end)));
            }
            FreeCells::Area => {
                let mut area = std::mem::take(&mut self.area);
                area.ways.extend(ways.filter(is_in_reach));
                area.mark(self);
                area.ways.clear();
                self.area = area;
            }
        }
    }

    pub(super) fn cross(&mut self, [start, end]: Way) {
        if let Some(line) = CellLine::crossed(start, end) {
            self.mark_line(line);
        }
    }

    /// Marks lines, nearly all of them by a canvas.
    fn draw_lines(&mut self, lines: impl Iterator<Item = Option<CellLine>>) {
        let mut canvas = std::mem::take(&mut self.canvas);
        for line in lines.flatten() {
            if let Some(far) = canvas.take(line) {
                self.mark_line(far);
            }
        }
        canvas.draw(|block, cells| {
            if let Some(marks) = self.marks_of(block) {
                let misses = &mut self.marks[marks].misses;
                misses.iter_mut().zip(cells).for_each(|(m, c)| *m |= c);
            }
        });
        self.canvas = canvas;
    }

    /// Marks a line cell by cell.
    fn mark_line(&mut self, line: CellLine) {
        let mut last: LastBlock = None;
        for cell in line.cells() {
            let (index, offset) = split(cell);
            let marks = match last {
                Some((block, marks)) if block == index => marks,
                _ => self.marks_of(index),
            };
            last = Some((index, marks));
            if let Some(marks) = marks {
                self.marks[marks].misses[offset / BLOCK_CELLS] |= 1 << (offset % BLOCK_CELLS);
            }
        }
    }
}

fn is_in_reach([start, end]: &Way) -> bool {
    start.coords.amax() < 1e9 && (end - start).amax() < REACH
}
