//! In: two neighbouring beams. Out: whether one surface may carry both.
//!
//! | rule | breaks where the distance of the neighbours exceeds | holds where others fail | fails |
//! |---|---|---|---|
//! | [`BreakRule::Adaptive`] | what a surface at the grazing angle would give, plus noise | a long wall seen at a flat angle | a slit seen head on |
//! | [`BreakRule::MeanRatio`] | ν times the mean distance | a slit seen head on | a long wall seen at a flat angle; a slit beside a deep step |
//! | [`BreakRule::Spacing`] | a multiple of k(ρ) = a ρ + b, the sensor's own spacing | a slit, beside a step too | a long wall seen at a flat angle |
//!
//! The tests check each cell of the table.

use std::ops::Range;

use nalgebra::{Point2, Vector2};

use super::CHUNK;
use crate::geom::Length;
use crate::lanes::{Kernel, LANES, Lanes, run};
use crate::points::{Beam, Points, Run, SpacingModel};

/// The rule by which two neighbouring beams do not lie on one surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum BreakRule {
    /// The adaptive breakpoint detector: `D = ρ sin Δφ / sin(λ - Δφ) + n σ`, what a surface seen at
    /// the grazing angle λ would give, plus noise. ρ is the shorter of the two ranges, so that the
    /// order of the beams does not matter; σ² is the sum of both variances.
    ///
    /// Source: Borges & Aldon (2004), "Line extraction in 2D range images for mobile robotics", eq.
    /// (3).
    Adaptive {
        /// Grazing angle λ below which a surface is not followed, rad. Default 0.17 (10°). Larger:
        /// more breaks on walls seen at a flat angle, fewer walls joined across a depth step.
        grazing_angle: f64,
        /// Noise allowed on top, in standard deviations of the difference of two ranges. Default 3.
        n_sigmas: f64,
    },
    /// Neighbours break if they are farther apart than `ratio` times the mean over neighbours
    /// without a lost beam between them: for doors that a ranger sees with evenly spaced points.
    ///
    /// Source: TDK 2016 §4.2, d > ν d̄ with ν from 4 to 5.
    MeanRatio {
        /// ν. Larger: fewer breaks.
        ratio: f64,
    },
    /// Neighbours break if they are farther apart than `ratio` times the sensor's spacing at the
    /// mean of both ranges.
    ///
    /// Source: Pilch 2016 §3.5.1 with ratio 2.
    Spacing {
        /// k(ρ), fitted per sensor.
        spacing: SpacingModel,
        /// Multiple of k. Larger: fewer breaks, flatter angles at which a wall is still followed.
        ratio: f64,
    },
}

impl BreakRule {
    /// [`Self::Spacing`] with the ratio of its paper.
    #[must_use]
    pub fn spacing(spacing: SpacingModel) -> Self {
        Self::Spacing {
            spacing,
            ratio: 2.0,
        }
    }

    /// All rules with their default values, with their names in settings and their names for
    /// people.
    #[must_use]
    pub fn all() -> [(&'static str, Self, &'static str); 3] {
        let mean = Self::MeanRatio { ratio: 4.5 };
        let spacing = Self::spacing(SpacingModel::even(360.0));
        [
            (
                "adaptive",
                Self::default(),
                "adaptive (Borges & Aldon 2004)",
            ),
            ("mean-ratio", mean, "ν times the mean (TDK 2016)"),
            ("spacing", spacing, "the sensor's spacing (Pilch 2016)"),
        ]
    }
}

impl Default for BreakRule {
    fn default() -> Self {
        Self::Adaptive {
            grazing_angle: 0.17,
            n_sigmas: 3.0,
        }
    }
}

/// The test of two neighbouring hits.
pub(super) trait Joins {
    fn joins(&self, a: &Ray, b: &Ray) -> bool;

    /// Sets `surely` to 1 for each beam of a range that clearly joins the one before it; for a 0,
    /// [`Self::joins`] has to decide.
    fn join_surely(&self, _beams: &[Beam], _range: Range<usize>, surely: &mut [f64; CHUNK]) {
        surely.fill(0.0);
    }
}

/// The data of a beam that the rules use.
#[derive(Clone, Copy)]
pub(super) struct Ray {
    end: Point2<f64>,
    from_sensor: Vector2<f64>,
    range: f64,
    sigma: f64,
}

impl Ray {
    #[inline(always)]
    pub(super) fn of(beam: &Beam) -> Self {
        Self {
            end: beam.end_in_robot,
            from_sensor: beam.end_in_robot - beam.origin_in_robot,
            range: beam.range,
            sigma: beam.sigma,
        }
    }
}

/// Two beams: |sin Δφ| and cos Δφ, both multiplied by the product of the ranges.
#[derive(Clone, Copy)]
struct Pair {
    sin: f64,
    cos: f64,
    product: f64,
    distance_squared: f64,
}

impl Pair {
    #[inline(always)]
    fn of(a: &Ray, b: &Ray) -> Self {
        Self {
            sin: a.from_sensor.perp(&b.from_sensor).abs(),
            cos: a.from_sensor.dot(&b.from_sensor),
            product: a.range * b.range,
            distance_squared: (b.end - a.end).norm_squared(),
        }
    }
}

/// The largest step in bearing, which applies to every rule.
pub(super) struct Step {
    sin_max: f64,
}

impl Step {
    pub(super) fn new(max_step: f64) -> Self {
        Self {
            sin_max: libm::sin(max_step),
        }
    }

    #[inline(always)]
    fn allows(&self, pair: &Pair) -> bool {
        pair.cos > 0.0 && pair.sin <= self.sin_max * pair.product
    }
}

impl Joins for Step {
    fn joins(&self, a: &Ray, b: &Ray) -> bool {
        self.allows(&Pair::of(a, b))
    }
}

/// The constants of [`BreakRule::Adaptive`].
pub(super) struct Adaptive {
    step: Step,
    sin_grazing: f64,
    cos_grazing: f64,
    n_sigmas: f64,
}

impl Adaptive {
    pub(super) fn new(grazing_angle: f64, n_sigmas: f64, max_step: f64) -> Self {
        Self {
            step: Step::new(max_step),
            sin_grazing: libm::sin(grazing_angle),
            cos_grazing: libm::cos(grazing_angle),
            n_sigmas,
        }
    }

    /// `shorter`: the shorter range. `variance`: of the difference of the ranges. Passed by value:
    /// references would keep every beam on the stack.
    #[inline(never)]
    fn limit(&self, shorter: f64, variance: f64, pair: Pair) -> f64 {
        let scale = 1.0 / pair.product;
        let (sin_step, cos_step) = (pair.sin * scale, pair.cos * scale);
        // sin(λ - Δφ). A coarse sensor's Δφ may come near λ, where the rule would let everything
        // through.
        let sin_rest =
            (self.sin_grazing * cos_step - self.cos_grazing * sin_step).max(0.5 * self.sin_grazing);
        shorter * sin_step / sin_rest + self.n_sigmas * variance.sqrt()
    }
}

impl Joins for Adaptive {
    fn joins(&self, a: &Ray, b: &Ray) -> bool {
        let pair = Pair::of(a, b);
        if !self.step.allows(&pair) {
            return false;
        }
        let variance = a.sigma * a.sigma + b.sigma * b.sigma;
        let limit = self.limit(a.range.min(b.range), variance, pair);
        pair.distance_squared <= limit * limit
    }

    /// sin(λ - Δφ) ≤ sin λ and the noise only adds to the limit: most neighbours pass here, without
    /// a division or a root.
    fn join_surely(&self, beams: &[Beam], range: Range<usize>, surely: &mut [f64; CHUNK]) {
        run(SureJoins {
            rule: self,
            beams,
            range,
            surely,
        });
    }
}

/// The neighbours that [`Adaptive`] joins regardless of their noise.
struct SureJoins<'a> {
    rule: &'a Adaptive,
    beams: &'a [Beam],
    range: Range<usize>,
    surely: &'a mut [f64; CHUNK],
}

impl Kernel for SureJoins<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, machine: L::Machine) {
        let splat = |value| L::splat(machine, value);
        let (zero, one) = (splat(0.0), splat(1.0));
        let sin_max = splat(self.rule.step.sin_max);
        let sin_grazing = splat(self.rule.sin_grazing);
        let Some(last) = self.beams.len().checked_sub(1) else {
            return;
        };
        let four = |first: usize| {
            let beam = |lane: usize| &self.beams[(first + lane).min(last)];
            Rays::<L>::of(machine, [beam(0), beam(1), beam(2), beam(3)])
        };
        let mut before = four(self.range.start.saturating_sub(LANES));
        let firsts = self.range.step_by(LANES);
        for (first, surely) in firsts.zip(self.surely.as_chunks_mut::<LANES>().0) {
            let b = four(first);
            let a = b.after(&before);
            before = b;
            let sin = (a.from_x * b.from_y - a.from_y * b.from_x).abs();
            let cos = a.from_x * b.from_x + a.from_y * b.from_y;
            let (dx, dy) = (b.x - a.x, b.y - a.y);
            let bound = sin_grazing * a.range.or_greater(b.range);
            let reach = (dx * dx + dy * dy) * bound * bound;
            // Comparisons with NaN are false.
            let ahead = cos.where_greater(zero, one, zero);
            let near = (sin_max * a.range * b.range).where_greater(sin, ahead, zero);
            *surely = (sin * sin).where_greater(reach, near, zero).to_array();
        }
    }
}

/// The data of four beams that the rule uses.
#[derive(Clone, Copy)]
struct Rays<L> {
    x: L,
    y: L,
    from_x: L,
    from_y: L,
    range: L,
}

impl<L: Lanes> Rays<L> {
    /// The neighbour before each ray.
    #[inline(always)]
    fn after(&self, before: &Self) -> Self {
        Self {
            x: self.x.after(before.x),
            y: self.y.after(before.y),
            from_x: self.from_x.after(before.from_x),
            from_y: self.from_y.after(before.from_y),
            range: self.range.after(before.range),
        }
    }

    #[inline(always)]
    fn of(machine: L::Machine, [a, b, c, d]: [&Beam; LANES]) -> Self {
        let lane = |read: fn(&Beam) -> f64| L::load(machine, &[read(a), read(b), read(c), read(d)]);
        let (x, y) = (lane(|b| b.end_in_robot.x), lane(|b| b.end_in_robot.y));
        Self {
            x,
            y,
            from_x: x - lane(|b| b.origin_in_robot.x),
            from_y: y - lane(|b| b.origin_in_robot.y),
            range: lane(|b| b.range),
        }
    }
}

/// The constants of [`BreakRule::Spacing`].
pub(super) struct Spaced {
    step: Step,
    spacing: SpacingModel,
    ratio: f64,
}

impl Spaced {
    pub(super) fn new(spacing: SpacingModel, ratio: f64, max_step: f64) -> Self {
        Self {
            step: Step::new(max_step),
            spacing,
            ratio,
        }
    }
}

impl Joins for Spaced {
    fn joins(&self, a: &Ray, b: &Ray) -> bool {
        let pair = Pair::of(a, b);
        let limit = self.ratio * self.spacing.between(a.range, b.range);
        self.step.allows(&pair) && limit > 0.0 && pair.distance_squared <= limit * limit
    }
}

/// [`BreakRule::MeanRatio`] on runs that [`Step`] has made.
pub(super) fn break_by_mean(points: &Points, ratio: f64, runs: &mut Vec<Run>) {
    let n_beams = points.beams.len();
    let whole = std::mem::take(runs);
    for run in whole {
        let steps = || {
            run.beams(points)
                .zip(run.beams(points).skip(1))
                .map(|(a, b)| (b.end_in_robot - a.end_in_robot).length())
        };
        let mean = steps().sum::<f64>() / (run.len.max(2) - 1) as f64;
        let mut part = Run {
            first: run.first,
            len: 1,
        };
        for (index, step) in steps().enumerate() {
            if step > ratio * mean {
                runs.push(part);
                part = Run {
                    first: (run.first + index + 1) % n_beams,
                    len: 0,
                };
            }
            part.len += 1;
        }
        runs.push(part);
    }
}
