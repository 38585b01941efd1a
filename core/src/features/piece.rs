//! Neighbouring points that may be one line, and the point that separates two lines.

use std::ops::Range;

use nalgebra::Vector2;

use super::columns::Columns;
use super::moments::Moments;
use crate::geom::Length;
use crate::lanes::{Kernel, Lanes, greatest, run};

/// Neighbouring points, and the sums over those that are not skipped.
#[derive(Clone, Copy, Debug)]
pub(super) struct Piece {
    pub(super) start: usize,
    pub(super) end: usize,
    pub(super) moments: Moments,
}

impl Piece {
    /// All points of a range, none of which may have been skipped.
    pub(super) fn whole(columns: &Columns, range: Range<usize>) -> Self {
        Self {
            start: range.start,
            end: range.end,
            moments: columns.moments(&range),
        }
    }

    pub(super) fn range(&self) -> Range<usize> {
        self.start..self.end
    }

    pub(super) fn n_points(&self) -> usize {
        self.end - self.start
    }

    /// The first point that is not skipped.
    pub(super) fn first(&self, columns: &Columns) -> Option<usize> {
        columns.kept(self.range()).next()
    }

    /// The last point that is not skipped.
    pub(super) fn last(&self, columns: &Columns) -> Option<usize> {
        columns.kept(self.range()).next_back()
    }

    /// From here on, skips one of the points.
    pub(super) fn drop_point(&mut self, columns: &mut Columns, index: usize) {
        if columns.is_kept(index) {
            columns.drop_point(index);
            self.moments = self.moments.minus(&columns.moments_of(index));
        }
    }

    /// Both parts of the piece; the second begins after `corner`.
    pub(super) fn split_after(&self, columns: &Columns, corner: usize) -> [Self; 2] {
        [
            Self::kept_of(columns, self.start..corner + 1),
            Self::kept_of(columns, corner + 1..self.end),
        ]
    }

    /// The points of a range that are not skipped.
    pub(super) fn kept_of(columns: &Columns, range: Range<usize>) -> Self {
        let mut part = Self::whole(columns, range.clone());
        if columns.all_kept() {
            return part;
        }
        for index in range.filter(|&index| !columns.is_kept(index)) {
            part.moments = part.moments.minus(&columns.moments_of(index));
        }
        part
    }

    /// The kept point, neither the first nor the last, that is farthest from the line through those
    /// two, and its distance, m.
    pub(super) fn farthest_from_chord(&self, columns: &Columns) -> Option<(usize, f64)> {
        let (first, last) = (self.first(columns)?, self.last(columns)?);
        if last < first + 2 {
            return None;
        }
        let (a, b) = (columns.point(first), columns.point(last));
        let chord = b - a;
        let length = chord.length();
        let normal = if length > 0.0 {
            Vector2::new(-chord.y, chord.x) / length
        } else {
            // The ends coincide: any direction is as good.
            Vector2::x()
        };
        let offset = normal.dot(&a.coords);
        let inner = first + 1..last;
        let index = run(Farthest {
            columns,
            range: &inner,
            normal: &normal,
            r: offset,
        })?;
        let distance = (normal.dot(&columns.point(index).coords) - offset).abs();
        Some((index, distance))
    }
}

/// The first of the kept points that are farthest from a line.
struct Farthest<'a> {
    columns: &'a Columns,
    range: &'a Range<usize>,
    normal: &'a Vector2<f64>,
    r: f64,
}

impl Kernel for Farthest<'_> {
    type Output = Option<usize>;

    #[inline(always)]
    fn run<L: Lanes>(self, machine: L::Machine) -> Option<usize> {
        let splat = |value| L::splat(machine, value);
        let (nx, ny, r) = (splat(self.normal.x), splat(self.normal.y), splat(self.r));
        let one = splat(1.0);
        // Each lane has its own farthest point and the block that contains it.
        let (mut best, mut best_block) = (splat(-1.0), splat(-1.0));
        let blocks = self.columns.blocks(self.range);
        for block in 0..blocks.len() {
            let b = blocks.at(machine, block);
            // A skipped point counts as -1 m: behind all others.
            let found = ((nx * b.x + ny * b.y - r).abs() + one) * b.keep - one;
            best_block = found.where_greater(best, splat(block as f64), best_block);
            best = found.where_greater(best, found, best);
        }
        let most = greatest(best);
        let lanes = best.to_array().into_iter().zip(best_block.to_array());
        let indices = lanes.enumerate().filter_map(|(lane, (distance, block))| {
            let is_best = distance >= most && block >= 0.0;
            is_best.then(|| blocks.index(block as usize, lane))
        });
        indices.min()
    }
}

/// The greatest distance of a kept point from a line, m.
pub(super) struct LargestDistance<'a> {
    pub(super) columns: &'a Columns,
    pub(super) range: Range<usize>,
    pub(super) normal: &'a Vector2<f64>,
    pub(super) r: f64,
}

impl Kernel for LargestDistance<'_> {
    type Output = f64;

    #[inline(always)]
    fn run<L: Lanes>(self, machine: L::Machine) -> f64 {
        let splat = |value| L::splat(machine, value);
        let (nx, ny, r) = (splat(self.normal.x), splat(self.normal.y), splat(self.r));
        let mut most = splat(0.0);
        let blocks = self.columns.blocks(&self.range);
        for block in 0..blocks.len() {
            let b = blocks.at(machine, block);
            most = most.or_greater((nx * b.x + ny * b.y - r).abs() * b.keep);
        }
        greatest(most)
    }
}
