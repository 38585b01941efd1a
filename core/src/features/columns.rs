//! In: beams. Out: what the sums need of them, column by column, so that four points are worked on at a time.
//!
//! 1. One column for each number; a block loads four neighbours of each. Operations on blocks are those of IEEE 754, lane by
//!    lane, and lanes are added in one fixed order: same bits on every machine.
//! 2. Prefix sums, so that the line through any range costs a few operations.
//! 3. A point left out keeps its place with `keep` 0. Columns go on for [`LANES`] harmless rows past the last point.

use std::ops::Range;

use nalgebra::{Point2, Vector2};
use wide::f64x4;

use super::moments::Moments;
use crate::points::Beam;

/// Points worked on at a time.
pub(super) const LANES: usize = 4;

/// What the sensor and the surface add to every point.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Noise {
    /// Standard deviation of a bearing, rad.
    pub(super) bearing_sigma: f64,
    /// How far from flat a wall may be, m.
    pub(super) surface_sigma: f64,
}

/// Beams by columns; unit vectors (`ux`, `uy`) run along the beams.
#[derive(Clone, Debug, Default)]
pub(super) struct Columns {
    len: usize,
    noise: Noise,
    /// Largest standard deviation of a range or a bearing, m.
    largest: f64x4,
    /// Smallest range or standard deviation of one, m.
    smallest: f64x4,
    x: Vec<f64>,
    y: Vec<f64>,
    ux: Vec<f64>,
    uy: Vec<f64>,
    weight: Vec<f64>,
    var_along: Vec<f64>,
    var_across: Vec<f64>,
    number: Vec<f64>,
    keep: Vec<f64>,
    /// Sums over all points before each one, kept or not.
    prefix: Vec<Moments>,
}

/// Four neighbours. Lanes past the end of the range have `keep` 0.
#[derive(Clone, Copy)]
pub(super) struct Block {
    pub(super) x: f64x4,
    pub(super) y: f64x4,
    pub(super) ux: f64x4,
    pub(super) uy: f64x4,
    /// 1/σ² of the range.
    pub(super) weight: f64x4,
    /// σ² of the range.
    pub(super) var_along: f64x4,
    /// σ² of the bearing times range².
    pub(super) var_across: f64x4,
    /// Number of the beam in the scan.
    pub(super) number: f64x4,
    /// 1, or 0 where the point was left out.
    pub(super) keep: f64x4,
}

impl Columns {
    /// Empties the columns and makes room for `n_points`.
    pub(super) fn reset(&mut self, n_points: usize, noise: Noise) {
        self.len = 0;
        self.noise = noise;
        self.largest = f64x4::ZERO;
        self.smallest = f64x4::splat(f64::INFINITY);
        let n_rows = n_points + LANES;
        for column in [
            &mut self.x,
            &mut self.y,
            &mut self.ux,
            &mut self.uy,
            &mut self.weight,
            &mut self.var_along,
            &mut self.var_across,
            &mut self.number,
            &mut self.keep,
        ] {
            if column.len() < n_rows {
                column.resize(n_rows, 1.0);
            }
        }
        if self.prefix.len() < n_rows + 1 {
            self.prefix.resize(n_rows + 1, Moments::default());
        }
        self.prefix[0] = Moments::default();
    }

    /// Appends beams on which something came back, as long as there is room.
    pub(super) fn extend(&mut self, beams: &[Beam]) {
        for four in beams.chunks(LANES) {
            self.push_block(four);
        }
    }

    fn push_block(&mut self, beams: &[Beam]) {
        let four = match beams {
            [a, b, c, d] => [a, b, c, d],
            [a, b, c] => [a, b, c, c],
            [a, b] => [a, b, b, b],
            [a] => [a; LANES],
            _ => return,
        };
        let lane = |read: fn(&Beam) -> f64| f64x4::new(four.map(read));
        let (x, y) = (lane(|b| b.end_in_robot.x), lane(|b| b.end_in_robot.y));
        let (range, sigma) = (lane(|b| b.range), lane(|b| b.sigma));
        let (origin_x, origin_y) = (lane(|b| b.origin_in_robot.x), lane(|b| b.origin_in_robot.y));
        // One division gives both 1/ρ and 1/σ.
        let inverse = f64x4::ONE / (range * sigma);
        let (per_range, per_sigma) = (inverse * sigma, inverse * range);
        let weight = per_sigma * per_sigma;
        let across = range * self.noise.bearing_sigma;
        let at = self.len;
        store(&mut self.x, at, x);
        store(&mut self.y, at, y);
        store(&mut self.ux, at, (x - origin_x) * per_range);
        store(&mut self.uy, at, (y - origin_y) * per_range);
        store(&mut self.weight, at, weight);
        store(&mut self.var_along, at, sigma * sigma);
        store(&mut self.var_across, at, across * across);
        store(&mut self.number, at, lane(|b| b.beam_idx as f64));
        store(&mut self.keep, at, f64x4::ONE);
        self.largest = self.largest.fast_max(sigma.fast_max(across));
        self.smallest = self.smallest.fast_min(sigma.fast_min(range));
        self.push_sums(weight, x, y);
        self.len += beams.len();
    }

    /// Sums past the last point are written over by the next block.
    #[inline(always)]
    fn push_sums(&mut self, weight: f64x4, x: f64x4, y: f64x4) {
        let (wx, wy) = (weight * x, weight * y);
        let [w, wx, wy, xx, xy, yy] = [weight, wx, wy, wx * x, wx * y, wy * y].map(f64x4::to_array);
        let room = self.prefix.get_mut(self.len..);
        let Some([before, after @ ..]) = room.and_then(|r| r.first_chunk_mut::<{ LANES + 1 }>())
        else {
            return;
        };
        let mut sum = *before;
        for (i, after) in after.iter_mut().enumerate() {
            sum = sum.plus(&Moments {
                w: w[i],
                x: wx[i],
                y: wy[i],
                xx: xx[i],
                xy: xy[i],
                yy: yy[i],
            });
            *after = sum;
        }
    }

    /// Whether all numbers are such as sums can take: finite, ranges and sigmas greater than 0.
    pub(super) fn is_usable(&self) -> bool {
        let sum = self.prefix[self.len];
        let [least, most] = [self.smallest, self.largest].map(f64x4::to_array);
        least.iter().all(|&v| v > 0.0)
            && most.iter().all(|&v| v < f64::INFINITY)
            && (sum.xx + sum.yy + sum.w).is_finite()
    }

    /// Number of points.
    pub(super) fn len(&self) -> usize {
        self.len
    }

    /// No point is less certain than this in any direction, m.
    pub(super) fn largest_sigma(&self) -> f64 {
        greatest(self.largest) + self.noise.surface_sigma
    }

    /// Position of a point, robot frame.
    #[inline]
    pub(super) fn point(&self, index: usize) -> Point2<f64> {
        Point2::new(self.x[index], self.y[index])
    }

    /// Number of a point's beam in the scan.
    pub(super) fn number(&self, index: usize) -> usize {
        self.number[index] as usize
    }

    /// Whether a point was not left out.
    #[inline]
    pub(super) fn is_kept(&self, index: usize) -> bool {
        self.keep.get(index).is_some_and(|&keep| keep > 0.0)
    }

    /// Leaves a point out.
    pub(super) fn drop_point(&mut self, index: usize) {
        if let Some(keep) = self.keep.get_mut(index) {
            *keep = 0.0;
        }
    }

    /// The points of a range that were not left out.
    pub(super) fn kept(&self, range: Range<usize>) -> impl DoubleEndedIterator<Item = usize> {
        range.filter(|&index| self.is_kept(index))
    }

    /// What a point adds to the sums.
    pub(super) fn moments_of(&self, index: usize) -> Moments {
        Moments::of(self.weight[index], self.x[index], self.y[index])
    }

    /// The sums over a range, points left out included.
    #[inline]
    pub(super) fn moments(&self, range: &Range<usize>) -> Moments {
        self.prefix[range.end].minus(&self.prefix[range.start])
    }

    /// Variance of a point's distance from a line with this normal; with the roughness of the surface.
    pub(super) fn variance(&self, index: usize, normal: &Vector2<f64>) -> f64 {
        let along = Vector2::new(self.ux[index], self.uy[index]);
        let (cos, sin) = (normal.dot(&along), normal.perp(&along));
        cos * cos * self.var_along[index] + sin * sin * self.var_across[index] + self.var_surface()
    }

    /// σ² of the roughness, m².
    #[inline]
    pub(super) fn var_surface(&self) -> f64 {
        self.noise.surface_sigma * self.noise.surface_sigma
    }

    /// Whether bearings are exact: then half of the sums are none.
    #[inline]
    pub(super) fn bearings_are_exact(&self) -> bool {
        self.noise.bearing_sigma <= 0.0
    }

    /// The points of a range, four at a time.
    #[inline(always)]
    pub(super) fn blocks(&self, range: Range<usize>) -> impl Iterator<Item = Block> {
        let n_blocks = range.len().div_ceil(LANES);
        let rows = |column| rows(column, range.start, n_blocks);
        let (x, y, ux, uy) = (rows(&self.x), rows(&self.y), rows(&self.ux), rows(&self.uy));
        let (weight, number, keep) = (rows(&self.weight), rows(&self.number), rows(&self.keep));
        let (var_along, var_across) = (rows(&self.var_along), rows(&self.var_across));
        let last = WITHIN[(LANES * n_blocks - range.len()).min(LANES - 1)];
        (0..n_blocks).map(move |i| {
            let keep = f64x4::new(keep[i]);
            Block {
                x: f64x4::new(x[i]),
                y: f64x4::new(y[i]),
                ux: f64x4::new(ux[i]),
                uy: f64x4::new(uy[i]),
                weight: f64x4::new(weight[i]),
                var_along: f64x4::new(var_along[i]),
                var_across: f64x4::new(var_across[i]),
                number: f64x4::new(number[i]),
                keep: if i + 1 < n_blocks {
                    keep
                } else {
                    keep * f64x4::new(last)
                },
            }
        })
    }
}

impl Block {
    /// Variances of the distances from a line with normal (`nx`, `ny`).
    #[inline(always)]
    pub(super) fn variance(&self, nx: f64x4, ny: f64x4, var_surface: f64x4) -> f64x4 {
        let cos = nx * self.ux + ny * self.uy;
        let sin = nx * self.uy - ny * self.ux;
        cos * cos * self.var_along + sin * sin * self.var_across + var_surface
    }
}

/// Which lanes of the last block lie within the range, by the number that do not.
const WITHIN: [[f64; LANES]; LANES] = [
    [1.0, 1.0, 1.0, 1.0],
    [1.0, 1.0, 1.0, 0.0],
    [1.0, 1.0, 0.0, 0.0],
    [1.0, 0.0, 0.0, 0.0],
];

/// `n_blocks` times four neighbours of a column, from `start` on.
#[inline(always)]
fn rows(column: &[f64], start: usize, n_blocks: usize) -> &[[f64; LANES]] {
    &column[start..].as_chunks::<LANES>().0[..n_blocks]
}

#[inline(always)]
fn store(column: &mut [f64], at: usize, values: f64x4) {
    let room = column
        .get_mut(at..)
        .and_then(|c| c.first_chunk_mut::<LANES>());
    if let Some(four) = room {
        *four = values.to_array();
    }
}

/// The sum of the lanes, in one order for every machine.
#[inline(always)]
pub(super) fn total(lanes: f64x4) -> f64 {
    let [a, b, c, d] = lanes.to_array();
    (a + b) + (c + d)
}

/// The greatest of the lanes.
#[inline(always)]
pub(super) fn greatest(lanes: f64x4) -> f64 {
    let [a, b, c, d] = lanes.to_array();
    a.max(b).max(c.max(d))
}
