//! Sums of Gaussians: G(t) = Σ q exp(-|t - s|² / 2σ²) over all sources s, at all targets t.
//!
//! In: sources with one weight in each of K columns, targets, σ, and the error allowed, in parts of
//! Σ|q|. Out: the sums of each column at each target.
//!
//! There are three ways; the one that takes the least work is used unless one is named:
//!
//! - `direct`: every pair.
//! - `grid`: only pairs nearer than R = σ √(2 ln 1/ε); each of the others contributes less than ε.
//!   This is best while σ is small. Both of these use single precision if the error allowed is
//!   larger than what that adds.
//! - `chebyshev`: the fast Gauss transform. Boxes of sources are summed into polynomials, which are
//!   translated to boxes of targets and evaluated there: O(M + N) while σ is large. Greengard &
//!   Strain use Hermite and Taylor series, whose bound needs twice as many terms in each direction.
//!   Instead, the kernel is interpolated at Chebyshev nodes (Fong & Darve 2009), with a bound that
//!   follows from its derivatives.
//!
//! Source: Greengard & Strain (1991), "The fast Gauss transform"; Fong & Darve (2009), "The
//! black-box fast multipole method"; Pilch (2016), eqs. (1.54) and (1.55).

mod cells;
mod chebyshev;
mod direct;
mod exp;
mod single;
#[cfg(test)]
mod tests;

pub(super) use cells::Cells;
pub(super) use exp::exp2_of_minus;
pub(super) use single::COST as SINGLE_COST;

use nalgebra::Point2;

use self::single::Single;
use crate::lanes;

/// A way to compute the sums.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TransformMethod {
    /// Every pair.
    Direct,
    /// Pairs that are near.
    Grid,
    /// By interpolation in boxes.
    Chebyshev,
}

impl TransformMethod {
    /// All ways, with their names.
    pub const ALL: [(&'static str, Self); 3] = [
        ("direct", Self::Direct),
        ("grid", Self::Grid),
        ("chebyshev", Self::Chebyshev),
    ];
}

/// Smallest and largest error that can be asked for, in parts of Σ|q|.
pub const TRANSFORM_ERROR: crate::bounds::Bounds = [1e-12, 0.1];

/// The sums at each target.
///
/// `sigma` is in m; `error` is clamped to [`TRANSFORM_ERROR`]. Without a `method`, the one that
/// takes the least work is used.
#[must_use]
pub fn gauss_transform<const K: usize>(
    sources: &[Point2<f64>],
    weights: &[[f64; K]],
    targets: &[Point2<f64>],
    sigma: f64,
    error: f64,
    method: Option<TransformMethod>,
) -> Vec<[f64; K]> {
    let error = error.clamp(TRANSFORM_ERROR[0], TRANSFORM_ERROR[1]);
    let scale = 1.0 / (2.0 * sigma * sigma);
    let count = sources.len().min(weights.len());
    let (Some(sources), Some(weights)) = (sources.get(..count), weights.get(..count)) else {
        return vec![];
    };
    if sources.is_empty() || !scale.is_finite() {
        return vec![[0.0; K]; targets.len()];
    }
    let single = Single::of(sources, weights, targets, scale, error);
    let plan = match method {
        None => {
            let pair = if single.is_some() { SINGLE_COST } else { 1.0 };
            Plan::of(sources, targets, sigma, error, pair)
        }
        Some(TransformMethod::Direct) => Plan::Direct,
        Some(TransformMethod::Grid) => Plan::Grid(Cells::of(sources, near_reach(scale, error))),
        Some(TransformMethod::Chebyshev) => {
            Plan::Chebyshev(chebyshev::Plan::of(sources, targets, sigma, error))
        }
    };
    let all = || sources.iter().copied().zip(weights.iter().copied());
    match (plan, single) {
        (Plan::Direct, Some(single)) => lanes::run(single::Pairs::of(all(), targets, single, None)),
        (Plan::Grid(cells), Some(single)) => {
            let sorted = cells.sorted(sources, weights);
            lanes::run(single::Pairs::of(sorted, targets, single, Some(&cells)))
        }
        (Plan::Direct, None) => direct::all(sources, weights, targets, scale),
        (Plan::Grid(cells), None) => direct::near(sources, weights, targets, scale, &cells),
        (Plan::Chebyshev(plan), _) => chebyshev::transform(sources, weights, targets, sigma, &plan),
    }
}

/// The radius beyond which a pair contributes less than `error`, m.
pub(super) fn reach(scale: f64, error: f64) -> f64 {
    (-libm::log(error) / scale).sqrt()
}

/// The radius of the pairs that are summed: it leaves room for the error of single precision.
fn near_reach(scale: f64, error: f64) -> f64 {
    reach(scale, (1.0 - single::SHARE) * error)
}

/// The way that takes the least work, with what was computed to find that out.
pub(super) enum Plan {
    Direct,
    Grid(Cells),
    Chebyshev(chebyshev::Plan),
}

impl Plan {
    /// In multiples of the cost of a pair in double precision; `pair` is its cost here.
    pub(super) fn of(
        sources: &[Point2<f64>],
        targets: &[Point2<f64>],
        sigma: f64,
        error: f64,
        pair: f64,
    ) -> Self {
        /// Cost of sorting one point into cells.
        const SORTED: f64 = 8.0;
        let all = pair * sources.len() as f64 * targets.len() as f64;
        let boxes = chebyshev::Plan::of(sources, targets, sigma, error);
        let fewer = boxes.work.min(all);
        let sorting = SORTED * (sources.len() + targets.len()) as f64;
        if sorting < fewer {
            let cells = Cells::of(sources, near_reach(0.5 / (sigma * sigma), error));
            if pair * cells.pairs(targets) + sorting < fewer {
                return Self::Grid(cells);
            }
        }
        if boxes.work < all {
            Self::Chebyshev(boxes)
        } else {
            Self::Direct
        }
    }
}
