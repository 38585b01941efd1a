//! The turns that make one power sum of two whitened clouds agree.
//!
//! With z = x + iy, turning a cloud by α multiplies its Σ zⁿ by e^{inα}. For whitened clouds Σ zⁿ
//! is zero for n = 1 and n = 2. The least n ≥ 3 for which it is not zero leaves n turns to try, and
//! n more with a reflection.
//!
//! Source: Ho et al. (2009), "Affine registration with symmetric polynomials": power sums are the
//! symmetric polynomials that they use.

use std::f64::consts::TAU;

use nalgebra::Complex;

use super::Turn;
use super::signature::power;

/// Power sums that are tried. A cloud whose sums are all zero up to here is as good as round.
const ORDERS: std::ops::RangeInclusive<usize> = 3..=12;
/// A power sum that is smaller than this part of its largest possible value counts as zero.
const NOTHING: f64 = 1e-3;

/// All candidate turns; none if all power sums are zero.
pub(super) fn turns(from: &[Complex<f64>], to: &[Complex<f64>]) -> Vec<Turn> {
    let found = ORDERS.into_iter().find_map(|n| {
        let (a, b) = (power_sum(from, n)?, power_sum(to, n)?);
        Some((n, a, b))
    });
    let Some((n, a, b)) = found else {
        return vec![];
    };
    let angle = |z: Complex<f64>| libm::atan2(z.im, z.re);
    let turns = |is_reflected: bool| {
        let first = if is_reflected { a.conj() } else { a };
        let between = angle(b) - angle(first);
        (0..n).map(move |root| Turn {
            angle: (between + TAU * root as f64) / n as f64,
            is_reflected,
        })
    };
    [false, true].into_iter().flat_map(turns).collect()
}

/// Σ zⁿ, if it is not zero.
fn power_sum(points: &[Complex<f64>], n: usize) -> Option<Complex<f64>> {
    let powers = || points.iter().map(|z| power(*z, n));
    let sum: Complex<f64> = powers().sum();
    let most: f64 = powers().map(|z| z.norm_sqr().sqrt()).sum();
    (sum.norm_sqr().sqrt() > NOTHING * most).then_some(sum)
}
