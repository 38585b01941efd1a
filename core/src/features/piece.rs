//! Neighbouring points that may be one line, and the point at which they are two.

use std::ops::Range;

use nalgebra::Vector2;
use wide::f64x4;

use super::columns::{Columns, LANES, greatest};
use super::moments::Moments;

/// Neighbouring points, and the sums over those not left out.
#[derive(Clone, Copy, Debug)]
pub(super) struct Piece {
    pub(super) start: usize,
    pub(super) end: usize,
    pub(super) moments: Moments,
}

impl Piece {
    /// All points of a range, of which none may have been left out.
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

    /// The first point that was not left out.
    pub(super) fn first(&self, columns: &Columns) -> Option<usize> {
        columns.kept(self.range()).next()
    }

    /// The last point that was not left out.
    pub(super) fn last(&self, columns: &Columns) -> Option<usize> {
        columns.kept(self.range()).next_back()
    }

    /// Leaves out one of the points.
    pub(super) fn drop_point(&mut self, columns: &mut Columns, index: usize) {
        if columns.is_kept(index) {
            columns.drop_point(index);
            self.moments = self.moments.minus(&columns.moments_of(index));
        }
    }

    /// Both parts of the piece, the second beginning after `corner`.
    pub(super) fn split_after(&self, columns: &Columns, corner: usize) -> [Self; 2] {
        [
            Self::kept_of(columns, self.start..corner + 1),
            Self::kept_of(columns, corner + 1..self.end),
        ]
    }

    /// The points of a range that were not left out.
    fn kept_of(columns: &Columns, range: Range<usize>) -> Self {
        let mut part = Self::whole(columns, range.clone());
        if columns.all_kept() {
            return part;
        }
        for index in range.filter(|&index| !columns.is_kept(index)) {
            part.moments = part.moments.minus(&columns.moments_of(index));
        }
        part
    }

    /// The kept point, neither the first nor the last, that is farthest from the line through these two, and how far, m.
    pub(super) fn farthest_from_chord(&self, columns: &Columns) -> Option<(usize, f64)> {
        let (first, last) = (self.first(columns)?, self.last(columns)?);
        if last < first + 2 {
            return None;
        }
        let (a, b) = (columns.point(first), columns.point(last));
        let chord = b - a;
        let length = chord.norm();
        let normal = if length > 0.0 {
            Vector2::new(-chord.y, chord.x) / length
        } else {
            // The ends are one point: any direction is as good.
            Vector2::x()
        };
        let offset = normal.dot(&a.coords);
        let inner = first + 1..last;
        let index = farthest(columns, inner, &normal, offset)?;
        let distance = (normal.dot(&columns.point(index).coords) - offset).abs();
        Some((index, distance))
    }
}

/// The first of the kept points that are farthest from a line.
fn farthest(
    columns: &Columns,
    range: Range<usize>,
    normal: &Vector2<f64>,
    r: f64,
) -> Option<usize> {
    let [nx, ny, r] = [normal.x, normal.y, r].map(f64x4::splat);
    // A point left out counts as -1 m: behind all others.
    let distances = |x: f64x4, y: f64x4, keep: f64x4| {
        ((nx * x + ny * y - r).abs() + f64x4::ONE) * keep - f64x4::ONE
    };
    // Each lane has its own farthest point and the block in which it stands.
    let (mut best, mut best_block) = (f64x4::splat(-1.0), f64x4::splat(-1.0));
    let start = range.start;
    let blocks = columns.blocks(range);
    for block in 0..blocks.len() {
        let b = blocks.at(block);
        let found = distances(b.x, b.y, b.keep);
        let is_farther = found.simd_gt(best);
        best = is_farther.select(found, best);
        best_block = is_farther.select(f64x4::splat(block as f64), best_block);
    }
    let most = greatest(best);
    let lanes = best.to_array().into_iter().zip(best_block.to_array());
    let indices = lanes.enumerate().filter_map(|(lane, (distance, block))| {
        let is_best = distance >= most && block >= 0.0;
        is_best.then(|| start + LANES * block as usize + lane)
    });
    indices.min()
}

/// The greatest distance of a kept point from a line, m.
pub(super) fn largest_distance(
    columns: &Columns,
    range: Range<usize>,
    normal: &Vector2<f64>,
    r: f64,
) -> f64 {
    let [nx, ny, r] = [normal.x, normal.y, r].map(f64x4::splat);
    let mut most = f64x4::ZERO;
    let blocks = columns.blocks(range);
    for block in 0..blocks.len() {
        let b = blocks.at(block);
        most = most.fast_max((nx * b.x + ny * b.y - r).abs() * b.keep);
    }
    greatest(most)
}
