//! In: beams. Out: the numbers that the sums need of them, in columns, so that four points are
//! processed at a time.
//!
//! The plain form is `Sample::of`: it says what the columns hold for one beam, and the tests
//! compare the columns with it. The columns are faster, at a price:
//!
//! 1. Layout. Four neighbours stand together: four x, then four y and so on. [`Blocks`] returns
//!    those of a range. If the range does not begin or end with a group of four, the lanes outside
//!    of it have `keep` 0; so does a skipped point. The last group is padded with copies of the
//!    last point.
//! 2. The last digit. One division gives both 1/ρ and 1/σ.
//! 3. Memory. Prefix sums, so the line through any range costs a few operations.

use std::ops::Range;

use nalgebra::{Point2, Vector2};

use super::moments::Moments;
use crate::lanes::{Kernel, LANES, Lanes, greatest, least, run};
use crate::points::Beam;

/// Errors of the sensor and the surface that affect every point.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Noise {
    /// Standard deviation of a bearing, rad.
    pub(super) bearing_sigma: f64,
    /// How far from flat a wall may be, one standard deviation, m.
    pub(super) surface_sigma: f64,
}

/// The numbers that the sums need of one beam.
#[cfg(test)]
#[derive(Clone, Copy, Debug)]
pub(super) struct Sample {
    /// Where the beam ends, and its direction there.
    pub(super) end: Vector2<f64>,
    pub(super) along: Vector2<f64>,
    /// 1/σ² of the range.
    pub(super) weight: f64,
    /// Variances of the end along the beam and across it, m².
    pub(super) var_along: f64,
    pub(super) var_across: f64,
    /// Index of the beam in the scan.
    pub(super) number: f64,
}

/// Written as in a textbook.
#[cfg(test)]
pub(super) fn square(x: f64) -> f64 {
    x * x
}

#[cfg(test)]
impl Sample {
    pub(super) fn of(beam: &Beam, bearing_sigma: f64) -> Self {
        Self {
            end: beam.end_in_robot.coords,
            along: (beam.end_in_robot - beam.origin_in_robot) / beam.range,
            weight: 1.0 / (beam.sigma * beam.sigma),
            var_along: beam.sigma * beam.sigma,
            var_across: square(bearing_sigma * beam.range),
            number: beam.beam_idx as f64,
        }
    }

    /// The direction perpendicular to the beam.
    pub(super) fn across(&self) -> Vector2<f64> {
        Vector2::new(-self.along.y, self.along.x)
    }

    /// Variance of the distance from a line with this normal.
    pub(super) fn variance(&self, normal: &Vector2<f64>) -> f64 {
        square(normal.dot(&self.along)) * self.var_along
            + square(normal.dot(&self.across())) * self.var_across
    }
}

/// Beams by columns.
#[derive(Clone, Debug, Default)]
pub(super) struct Columns {
    noise: Noise,
    extremes: Extremes,
    /// The beam of each point.
    sources: Vec<usize>,
    fours: Vec<Four>,
    n_dropped: usize,
    /// Sums over all points before each one, kept or not.
    prefix: Vec<Moments>,
}

/// Shows whether sums can handle the numbers, and bounds their noise.
#[derive(Clone, Copy, Debug)]
struct Extremes {
    /// Largest standard deviation of a range or a bearing, m.
    largest: f64,
    /// Smallest range or standard deviation of one, m.
    smallest: f64,
}

impl Default for Extremes {
    fn default() -> Self {
        Self {
            largest: 0.0,
            smallest: f64::INFINITY,
        }
    }
}

impl Columns {
    /// Fills the columns with the beams of some ranges, all of which must be hits.
    pub(super) fn load(
        &mut self,
        beams: &[Beam],
        ranges: impl IntoIterator<Item = Range<usize>>,
        noise: Noise,
    ) {
        self.noise = noise;
        self.n_dropped = 0;
        self.sources.clear();
        for range in ranges {
            self.sources.extend(range);
        }
        let n_fours = self.sources.len().div_ceil(LANES);
        if self.prefix.len() <= LANES * n_fours {
            self.fours.resize(n_fours, Four::default());
            self.prefix.resize(LANES * n_fours + 1, Moments::default());
        }
        self.extremes = run(Load {
            beams,
            sources: &self.sources,
            bearing_sigma: noise.bearing_sigma,
            fours: &mut self.fours,
            prefix: &mut self.prefix,
        });
    }

    /// Whether sums can handle all numbers: finite, with ranges and sigmas greater than 0.
    pub(super) fn is_usable(&self) -> bool {
        let sum = self.moments(&(0..self.len()));
        let Extremes { largest, smallest } = self.extremes;
        smallest > 0.0 && largest < f64::INFINITY && (sum.xx + sum.yy + sum.w).is_finite()
    }

    /// Number of points.
    pub(super) fn len(&self) -> usize {
        self.sources.len()
    }

    /// No point is less certain than this in any direction, m.
    pub(super) fn largest_sigma(&self) -> f64 {
        self.extremes.largest + self.noise.surface_sigma
    }

    /// No range is more certain than this, m.
    pub(super) fn smallest_sigma(&self) -> f64 {
        self.extremes.smallest
    }

    /// The beam of a point.
    pub(super) fn source(&self, index: usize) -> usize {
        self.sources[index]
    }

    /// Position of a point, robot frame.
    #[inline]
    pub(super) fn point(&self, index: usize) -> Point2<f64> {
        let (four, lane) = self.four(index);
        Point2::new(four.x[lane], four.y[lane])
    }

    /// Direction of a point's beam.
    pub(super) fn direction(&self, index: usize) -> Vector2<f64> {
        let (four, lane) = self.four(index);
        Vector2::new(four.ux[lane], four.uy[lane])
    }

    /// Index of a point's beam in the scan.
    pub(super) fn number(&self, index: usize) -> usize {
        let (four, lane) = self.four(index);
        four.number[lane] as usize
    }

    #[inline]
    pub(super) fn is_kept(&self, index: usize) -> bool {
        let (four, lane) = self.four(index);
        four.keep[lane] > 0.0
    }

    /// From here on, the sums skip a point.
    pub(super) fn drop_point(&mut self, index: usize) {
        if let Some(four) = self.fours.get_mut(index / LANES) {
            four.keep[index % LANES] = 0.0;
            self.n_dropped += 1;
        }
    }

    /// Whether no point is skipped.
    #[inline]
    pub(super) fn all_kept(&self) -> bool {
        self.n_dropped == 0
    }

    /// The points of a range that are not skipped.
    pub(super) fn kept(&self, range: Range<usize>) -> impl DoubleEndedIterator<Item = usize> {
        range.filter(|&index| self.is_kept(index))
    }

    /// What a point adds to the sums.
    pub(super) fn moments_of(&self, index: usize) -> Moments {
        let (four, lane) = self.four(index);
        Moments::of(four.weight[lane], four.x[lane], four.y[lane])
    }

    /// The sums over a range, skipped points included.
    #[inline]
    pub(super) fn moments(&self, range: &Range<usize>) -> Moments {
        self.prefix[range.end].minus(&self.prefix[range.start])
    }

    /// Variance of a point's distance from a line with this normal, including the roughness of the
    /// surface.
    pub(super) fn variance(&self, index: usize, normal: &Vector2<f64>) -> f64 {
        self.spread(index, normal) + self.var_surface()
    }

    /// Variance of g · p for a point p and any vector g, from the noise of its beam.
    pub(super) fn spread(&self, index: usize, g: &Vector2<f64>) -> f64 {
        let (four, lane) = self.four(index);
        let along = self.direction(index);
        let (cos, sin) = (g.dot(&along), g.perp(&along));
        let by_bearing = if self.bearings_are_exact() {
            0.0
        } else {
            sin * sin * four.var_across[lane]
        };
        cos * cos * four.var_along[lane] + by_bearing
    }

    /// The same for a line perpendicular to the beam: variance of the range, including the
    /// roughness of the surface.
    pub(super) fn variance_along(&self, index: usize) -> f64 {
        let (four, lane) = self.four(index);
        four.var_along[lane] + self.var_surface()
    }

    /// σ² of the roughness, m².
    #[inline]
    pub(super) fn var_surface(&self) -> f64 {
        self.noise.surface_sigma * self.noise.surface_sigma
    }

    /// Whether bearings are exact: then half of the sums are zero.
    #[inline]
    pub(super) fn bearings_are_exact(&self) -> bool {
        self.noise.bearing_sigma <= 0.0
    }

    /// The points of a range, four at a time.
    #[inline(always)]
    pub(super) fn blocks(&self, range: &Range<usize>) -> Blocks<'_> {
        let first = range.start / LANES;
        let end = range.end.div_ceil(LANES);
        Blocks {
            first,
            fours: &self.fours[first..end],
            head: WITHIN[LANES + range.start % LANES],
            tail: WITHIN[LANES + range.end - LANES * end],
        }
    }

    #[inline]
    fn four(&self, index: usize) -> (&Four, usize) {
        (&self.fours[index / LANES], index % LANES)
    }
}

/// A range of the columns. Loops count and call [`Self::at`]: an iterator over [`Block`]s would not
/// be inlined, and would copy all nine.
pub(super) struct Blocks<'a> {
    /// Index of the first group of four.
    first: usize,
    fours: &'a [Four],
    /// Which lanes of the first group lie within the range.
    head: [f64; LANES],
    /// Which lanes of the last group do.
    tail: [f64; LANES],
}

/// Four neighbours, as they are stored.
type Four = Block<[f64; LANES]>;

/// Four neighbours; unit vectors (`ux`, `uy`) run along the beams. Lanes outside the range being
/// processed have `keep` 0.
#[derive(Clone, Copy, Debug, Default)]
#[repr(align(32))]
pub(super) struct Block<L> {
    pub(super) x: L,
    pub(super) y: L,
    pub(super) ux: L,
    pub(super) uy: L,
    /// 1/σ² of the range.
    pub(super) weight: L,
    /// σ² of the range.
    pub(super) var_along: L,
    /// σ² of the bearing times range²; undefined if bearings are exact.
    pub(super) var_across: L,
    /// Index of the beam in the scan.
    pub(super) number: L,
    /// 1, or 0 if the point is skipped.
    pub(super) keep: L,
}

impl Blocks<'_> {
    #[inline(always)]
    pub(super) fn len(&self) -> usize {
        self.fours.len()
    }

    /// Index of a point of block `i`.
    #[inline(always)]
    pub(super) fn index(&self, i: usize, lane: usize) -> usize {
        LANES * (self.first + i) + lane
    }

    #[inline(always)]
    pub(super) fn at<L: Lanes>(&self, machine: L::Machine, i: usize) -> Block<L> {
        let four = &self.fours[i];
        let load = |values: &[f64; LANES]| L::load(machine, values);
        let mut keep = load(&four.keep);
        if i == 0 {
            keep = keep * load(&self.head);
        }
        if i + 1 == self.fours.len() {
            keep = keep * load(&self.tail);
        }
        Block {
            x: load(&four.x),
            y: load(&four.y),
            ux: load(&four.ux),
            uy: load(&four.uy),
            weight: load(&four.weight),
            var_along: load(&four.var_along),
            var_across: load(&four.var_across),
            number: load(&four.number),
            keep,
        }
    }
}

impl<L: Lanes> Block<L> {
    /// Variances of the distances from a line with normal (`nx`, `ny`), without the part of the
    /// bearings.
    #[inline(always)]
    pub(super) fn variance_by_range(&self, nx: L, ny: L) -> L {
        let cos = nx * self.ux + ny * self.uy;
        cos * cos * self.var_along
    }

    /// The part of the bearings.
    #[inline(always)]
    pub(super) fn variance_by_bearing(&self, nx: L, ny: L) -> L {
        let sin = nx * self.uy - ny * self.ux;
        sin * sin * self.var_across
    }
}

/// [`WITHIN`]`[k]` keeps the first k lanes, [`WITHIN`]`[4 + k]` all but those.
const WITHIN: [[f64; LANES]; 2 * LANES] = [
    [0.0, 0.0, 0.0, 0.0],
    [1.0, 0.0, 0.0, 0.0],
    [1.0, 1.0, 0.0, 0.0],
    [1.0, 1.0, 1.0, 0.0],
    [1.0, 1.0, 1.0, 1.0],
    [0.0, 1.0, 1.0, 1.0],
    [0.0, 0.0, 1.0, 1.0],
    [0.0, 0.0, 0.0, 1.0],
];

/// Fills columns and prefix sums.
struct Load<'a> {
    beams: &'a [Beam],
    sources: &'a [usize],
    bearing_sigma: f64,
    fours: &'a mut [Four],
    prefix: &'a mut [Moments],
}

impl Kernel for Load<'_> {
    type Output = Extremes;

    #[inline(always)]
    fn run<L: Lanes>(self, machine: L::Machine) -> Extremes {
        let splat = |value| L::splat(machine, value);
        let (one, bearing_sigma) = (splat(1.0), splat(self.bearing_sigma));
        let (mut largest, mut smallest) = (splat(0.0), splat(f64::INFINITY));
        let mut sum = Moments::default();
        let Some((zero, after)) = self.prefix.split_first_mut() else {
            return Extremes::default();
        };
        *zero = sum;
        let after = after.as_chunks_mut::<LANES>().0;
        let places = self.fours.iter_mut().zip(after);
        for (sources, (four, after)) in self.sources.chunks(LANES).zip(places) {
            // Lanes after the last beam repeat one.
            let [a, b, c, d] = match *sources {
                [a, b, c, d] => [a, b, c, d],
                [a, b, c] => [a, b, c, c],
                [a, b] => [a, b, b, b],
                [a] => [a; LANES],
                _ => break,
            };
            let (a, b, c, d) = (
                &self.beams[a],
                &self.beams[b],
                &self.beams[c],
                &self.beams[d],
            );
            let lane =
                |read: fn(&Beam) -> f64| L::load(machine, &[read(a), read(b), read(c), read(d)]);
            let (x, y) = (lane(|b| b.end_in_robot.x), lane(|b| b.end_in_robot.y));
            let origin = (lane(|b| b.origin_in_robot.x), lane(|b| b.origin_in_robot.y));
            let (range, sigma) = (lane(|b| b.range), lane(|b| b.sigma));
            // One division gives both 1/ρ and 1/σ.
            let inverse = one / (range * sigma);
            let (per_range, per_sigma) = (inverse * sigma, inverse * range);
            let (across, weight) = (range * bearing_sigma, per_sigma * per_sigma);
            *four = Four {
                x: x.to_array(),
                y: y.to_array(),
                ux: ((x - origin.0) * per_range).to_array(),
                uy: ((y - origin.1) * per_range).to_array(),
                weight: weight.to_array(),
                var_along: (sigma * sigma).to_array(),
                var_across: (across * across).to_array(),
                // Signed: one instruction, whereas unsigned takes six.
                number: lane(|b| b.beam_idx as i64 as f64).to_array(),
                keep: [1.0; LANES],
            };
            largest = largest.or_greater(sigma.or_greater(across));
            smallest = smallest.or_lesser(sigma.or_lesser(range));
            let (wx, wy) = (weight * x, weight * y);
            let (xx, xy, yy) = (
                (wx * x).to_array(),
                (wx * y).to_array(),
                (wy * y).to_array(),
            );
            let (w, wx, wy) = (weight.to_array(), wx.to_array(), wy.to_array());
            for (lane, after) in after.iter_mut().enumerate() {
                sum = sum.plus(&Moments {
                    w: w[lane],
                    x: wx[lane],
                    y: wy[lane],
                    xx: xx[lane],
                    xy: xy[lane],
                    yy: yy[lane],
                });
                *after = sum;
            }
        }
        Extremes {
            largest: greatest(largest),
            smallest: least(smallest),
        }
    }
}

#[cfg(test)]
pub(in crate::features) mod tests;
