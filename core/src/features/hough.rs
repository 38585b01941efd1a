//! Lines by the Hough transform: each point votes for all lines through it; lines with many votes
//! are there.
//!
//! 1. Over a run, an accumulator of (α, r): α in [0, π), r signed and about the middle of the run,
//!    so it needs no more cells than the run is wide. Each point adds one to the cell of r = x cos
//!    α + y sin α in each column.
//! 2. The cell with the most votes is a guess, refined by the weighted fit ([`super::consensus`]).
//! 3. Suppression: the votes of the points on the line are taken back in all columns, and with them
//!    the flanks of its peak. If a peak leads to no line, it and its neighbours are cleared.
//! 4. Repeat from step 2 until no cell has enough votes for a line.
//!
//! Source: Duda & Hart (1972), "Use of the Hough transformation to detect lines and curves in
//! pictures"; Pilch 2016 §1.2.1, eq. (1.8). Taking back votes comes from the progressive transform
//! (Matas, Galambos & Kittler 2000, "Robust detection of lines using the progressive probabilistic
//! Hough transform"): suppressing a window around a peak would also hide a parallel wall beside it.

use std::f64::consts::PI;
use std::ops::Range;

use nalgebra::{Point2, Vector2};

use super::columns::Columns;
use super::consensus::{is_near, refined, settle_borders};
use super::piece::Piece;
use crate::bounds::config;
use crate::geom::{Length, unit_vector};

/// Most cells of a column; if a run is wider, cells are larger.
const MOST_ROWS: f64 = 4096.0;
/// Most peaks of a run that are checked.
const MOST_PEAKS: usize = 200;

config! {
    /// How lines are looked for by votes.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct Hough {
        /// Step of α, rad. Default 0.026 (1.5°). Larger: faster; long walls are torn.
        pub alpha_step: f64 = 0.026,
        /// Step of r, m. Default 0.05. Larger: walls that are closer than that are one at first.
        pub r_step: f64 = 0.05,
        /// A point is on a line within so many standard deviations. Default 3. Larger: shallow
        /// corners stay undetected.
        pub inlier_sigmas: f64 = 3.0,
    }
}

/// Votes, with buffers kept between scans.
#[derive(Clone, Debug, Default)]
pub(super) struct Accumulator {
    votes: Vec<u32>,
    /// Normal of each column.
    normals: Vec<Vector2<f64>>,
    n_rows: usize,
    r_step: f64,
    middle: Vector2<f64>,
    /// Whether a point of the run is on no line yet.
    free: Vec<bool>,
}

impl Hough {
    /// Splits a run of points; `pieces` receives its lines in order, each of at least `few` points.
    pub(super) fn split(
        &self,
        columns: &mut Columns,
        run: Range<usize>,
        few: usize,
        room: &mut Accumulator,
        pieces: &mut Vec<Piece>,
    ) {
        let first = pieces.len();
        room.begin(self, columns, &run);
        for _ in 0..MOST_PEAKS {
            let Some((cell, votes)) = room.highest() else {
                break;
            };
            if (votes as usize) < few {
                break;
            }
            let (normal, r) = room.line(cell);
            let near = |index| {
                is_near(
                    columns,
                    index,
                    (&normal, r),
                    self.inlier_sigmas,
                    room.r_step,
                )
            };
            let is_free = |index: usize| room.is_free(index - run.start);
            let limits = (self.inlier_sigmas, few);
            match refined(columns, &run, limits, is_free, near) {
                Some(found) => {
                    room.take_back(columns, &run, found.stretch.range.clone());
                    pieces.push(found.take(columns, self.inlier_sigmas));
                }
                None => room.clear_around(cell),
            }
        }
        let own = pieces.get_mut(first..).unwrap_or_default();
        own.sort_by_key(|piece| piece.start);
        settle_borders(columns, own, few);
    }
}

impl Accumulator {
    /// Step 1.
    fn begin(&mut self, config: &Hough, columns: &Columns, run: &Range<usize>) {
        let n_columns = (PI / config.alpha_step).ceil().max(1.0);
        self.normals.clear();
        let column = |i: u32| unit_vector(PI * f64::from(i) / n_columns);
        self.normals.extend((0..n_columns as u32).map(column));
        let (mut low, mut high) = (Point2::from([f64::MAX; 2]), Point2::from([f64::MIN; 2]));
        for p in run.clone().map(|index| columns.point(index)) {
            (low, high) = (low.inf(&p), high.sup(&p));
        }
        self.middle = nalgebra::center(&low, &high).coords;
        let width = (high - low).length();
        self.r_step = config.r_step.max(width / MOST_ROWS);
        self.n_rows = (width / self.r_step) as usize + 2;
        self.votes.clear();
        self.votes.resize(self.normals.len() * self.n_rows, 0);
        self.free.clear();
        self.free.resize(run.len(), true);
        for index in run.clone() {
            self.vote(columns, index, u32::wrapping_add);
        }
    }

    /// Adds or removes the votes of a point.
    fn vote(&mut self, columns: &Columns, index: usize, count: fn(u32, u32) -> u32) {
        let p = columns.point(index).coords - self.middle;
        let half = 0.5 * self.n_rows as f64;
        let cells = self.votes.chunks_exact_mut(self.n_rows);
        for (normal, rows) in self.normals.iter().zip(cells) {
            let row = normal.dot(&p) / self.r_step + half;
            if let Some(votes) = rows.get_mut(row as usize) {
                *votes = count(*votes, 1);
            }
        }
    }

    /// The first of the cells with the most votes, and their number.
    fn highest(&self) -> Option<(usize, u32)> {
        let most = *self.votes.iter().max()?;
        let cell = self.votes.iter().position(|&votes| votes == most)?;
        Some((cell, most))
    }

    /// Normal and signed distance of the line in the middle of a cell.
    fn line(&self, cell: usize) -> (Vector2<f64>, f64) {
        let (column, row) = (cell / self.n_rows, cell % self.n_rows);
        let normal = self.normals.get(column).copied().unwrap_or_default();
        let r = (row as f64 + 0.5 - 0.5 * self.n_rows as f64) * self.r_step;
        (normal, r + normal.dot(&self.middle))
    }

    fn is_free(&self, place: usize) -> bool {
        self.free.get(place).is_some_and(|free| *free)
    }

    /// Step 3, for the points of a line.
    fn take_back(&mut self, columns: &Columns, run: &Range<usize>, taken: Range<usize>) {
        for index in taken {
            let free = self.free.get_mut(index - run.start);
            if free.is_some_and(std::mem::take) {
                self.vote(columns, index, u32::saturating_sub);
            }
        }
    }

    /// Step 3, for a peak that led to no line. Columns form a ring: after the last comes the first,
    /// with the sign of r reversed.
    fn clear_around(&mut self, cell: usize) {
        let (n_columns, n_rows) = (self.normals.len(), self.n_rows);
        let (column, row) = (cell / n_rows, cell % n_rows);
        for step in [n_columns - 1, 0, 1] {
            let beside = (column + step) % n_columns;
            let is_turned =
                step == 1 && beside < column || step == n_columns - 1 && beside > column;
            let row = if is_turned { n_rows - 1 - row } else { row };
            for row in row.saturating_sub(1)..(row + 2).min(n_rows) {
                if let Some(votes) = self.votes.get_mut(beside * n_rows + row) {
                    *votes = 0;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests;
