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
    n_dropped: usize,
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
    /// σ² of the bearing times range²; anything where bearings are exact.
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
        self.n_dropped = 0;
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

    /// Appends beams on which something came back, for which [`Self::reset`] has made room.
    pub(super) fn extend(&mut self, beams: &[Beam]) {
        let n_blocks = beams.len().div_ceil(LANES);
        let rows = |column| rows_mut(column, self.len, n_blocks);
        let (x, y, ux, uy) = (
            rows(&mut self.x),
            rows(&mut self.y),
            rows(&mut self.ux),
            rows(&mut self.uy),
        );
        let (weight, number, keep) = (
            rows(&mut self.weight),
            rows(&mut self.number),
            rows(&mut self.keep),
        );
        let (var_along, var_across) = (rows(&mut self.var_along), rows(&mut self.var_across));
        let (mut largest, mut smallest) = (self.largest, self.smallest);
        let bearing_sigma = f64x4::splat(self.noise.bearing_sigma);
        for (i, beams) in beams.chunks(LANES).enumerate() {
            // Lanes past the last beam repeat one; the next block writes over them.
            let four = match beams {
                [a, b, c, d] => [a, b, c, d],
                [a, b, c] => [a, b, c, c],
                [a, b] => [a, b, b, b],
                [a, ..] => [a; LANES],
                [] => break,
            };
            let lane = |read: fn(&Beam) -> f64| f64x4::new(four.map(read));
            let end = (lane(|b| b.end_in_robot.x), lane(|b| b.end_in_robot.y));
            let origin = (lane(|b| b.origin_in_robot.x), lane(|b| b.origin_in_robot.y));
            let (range, sigma) = (lane(|b| b.range), lane(|b| b.sigma));
            // One division gives both 1/ρ and 1/σ.
            let inverse = f64x4::ONE / (range * sigma);
            let (per_range, per_sigma) = (inverse * sigma, inverse * range);
            let across = range * bearing_sigma;
            x[i] = end.0.to_array();
            y[i] = end.1.to_array();
            ux[i] = ((end.0 - origin.0) * per_range).to_array();
            uy[i] = ((end.1 - origin.1) * per_range).to_array();
            weight[i] = (per_sigma * per_sigma).to_array();
            var_along[i] = (sigma * sigma).to_array();
            var_across[i] = (across * across).to_array();
            number[i] = four.map(|b| b.beam_idx as f64);
            keep[i] = [1.0; LANES];
            largest = largest.fast_max(sigma.fast_max(across));
            smallest = smallest.fast_min(sigma.fast_min(range));
        }
        (self.largest, self.smallest) = (largest, smallest);
        self.extend_sums(n_blocks);
        self.len += beams.len();
    }

    /// Sums past the last point are written over by the next beams.
    fn extend_sums(&mut self, n_blocks: usize) {
        let at = self.len;
        let [x, y, weight] =
            [&self.x, &self.y, &self.weight].map(|column| rows(column, at, n_blocks));
        let Some((first, after)) = self.prefix[at..].split_first_mut() else {
            return;
        };
        let after = &mut after.as_chunks_mut::<LANES>().0[..n_blocks];
        let mut sum = *first;
        for i in 0..n_blocks {
            let [w, px, py] = [weight[i], x[i], y[i]].map(f64x4::new);
            let (wx, wy) = (w * px, w * py);
            let [w, wx, wy, xx, xy, yy] =
                [w, wx, wy, wx * px, wx * py, wy * py].map(f64x4::to_array);
            for lane in 0..LANES {
                sum = sum.plus(&Moments {
                    w: w[lane],
                    x: wx[lane],
                    y: wy[lane],
                    xx: xx[lane],
                    xy: xy[lane],
                    yy: yy[lane],
                });
                after[i][lane] = sum;
            }
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
            self.n_dropped += 1;
        }
    }

    /// Whether no point at all was left out.
    #[inline]
    pub(super) fn all_kept(&self) -> bool {
        self.n_dropped == 0
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
        let by_bearing = if self.bearings_are_exact() {
            0.0
        } else {
            sin * sin * self.var_across[index]
        };
        cos * cos * self.var_along[index] + by_bearing + self.var_surface()
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
    pub(super) fn blocks(&self, range: Range<usize>) -> Blocks<'_> {
        let n_blocks = range.len().div_ceil(LANES);
        let rows = |column| rows(column, range.start, n_blocks);
        Blocks {
            n_blocks,
            x: rows(&self.x),
            y: rows(&self.y),
            ux: rows(&self.ux),
            uy: rows(&self.uy),
            weight: rows(&self.weight),
            var_along: rows(&self.var_along),
            var_across: rows(&self.var_across),
            number: rows(&self.number),
            keep: rows(&self.keep),
            last: WITHIN[(LANES * n_blocks - range.len()).min(LANES - 1)],
        }
    }
}

/// A range of the columns. Loops count and call [`Self::at`]: an iterator over [`Block`]s would not be inlined, and copy all nine.
pub(super) struct Blocks<'a> {
    n_blocks: usize,
    x: &'a [[f64; LANES]],
    y: &'a [[f64; LANES]],
    ux: &'a [[f64; LANES]],
    uy: &'a [[f64; LANES]],
    weight: &'a [[f64; LANES]],
    var_along: &'a [[f64; LANES]],
    var_across: &'a [[f64; LANES]],
    number: &'a [[f64; LANES]],
    keep: &'a [[f64; LANES]],
    /// Which lanes of the last block lie within the range.
    last: [f64; LANES],
}

impl Blocks<'_> {
    #[inline(always)]
    pub(super) fn len(&self) -> usize {
        self.n_blocks
    }

    #[inline(always)]
    pub(super) fn at(&self, i: usize) -> Block {
        let keep = f64x4::new(self.keep[i]);
        Block {
            x: f64x4::new(self.x[i]),
            y: f64x4::new(self.y[i]),
            ux: f64x4::new(self.ux[i]),
            uy: f64x4::new(self.uy[i]),
            weight: f64x4::new(self.weight[i]),
            var_along: f64x4::new(self.var_along[i]),
            var_across: f64x4::new(self.var_across[i]),
            number: f64x4::new(self.number[i]),
            keep: if i + 1 < self.n_blocks {
                keep
            } else {
                keep * f64x4::new(self.last)
            },
        }
    }
}

impl Block {
    /// Variances of the distances from a line with normal (`nx`, `ny`), without what the bearings add.
    #[inline(always)]
    pub(super) fn variance_by_range(&self, nx: f64x4, ny: f64x4) -> f64x4 {
        let cos = nx * self.ux + ny * self.uy;
        cos * cos * self.var_along
    }

    /// What the bearings add.
    #[inline(always)]
    pub(super) fn variance_by_bearing(&self, nx: f64x4, ny: f64x4) -> f64x4 {
        let sin = nx * self.uy - ny * self.ux;
        sin * sin * self.var_across
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

/// [`rows`], to write to.
#[inline(always)]
fn rows_mut(column: &mut [f64], start: usize, n_blocks: usize) -> &mut [[f64; LANES]] {
    &mut column[start..].as_chunks_mut::<LANES>().0[..n_blocks]
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
    // `f64::max` also looks for NaN, of which there is none.
    let greater = |a: f64, b: f64| if a > b { a } else { b };
    greater(greater(a, b), greater(c, d))
}
