//! The discrete algebraic Riccati equation, and the gains computed from it: of feedback and of
//! filters.
//!
//! In: A, B and the weights Q and R. Out: the X of X = AᵀXA - AᵀXB (R + BᵀXB)⁻¹ BᵀXA + Q, and the
//! gains that follow from it.
//!
//! 1. Doubling: with G = B R⁻¹ Bᵀ, H = Q and W = (I + G H)⁻¹,
//!    A ← A W A, G ← G + A W G Aᵀ, H ← H + Aᵀ H W A. After k rounds, H is what the fixed-point
//!    iteration of the equation has after 2ᵏ: it converges in about ten rounds where that takes
//!    thousands at 1 kHz.
//! 2. The result is put back into the equation; if it does not satisfy it, that is an error, not a
//!    gain.
//!
//! Source: Anderson (1978), "Second-order convergent algorithms for the steady-state Riccati
//! equation"; Chu, Fan, Lin & Wang (2004), "Structure-preserving algorithms for periodic
//! discrete-time algebraic Riccati equations".

use nalgebra::{SMatrix, SVector};

use crate::geom::Length;

/// Rounds after which a solution that has not converged never will: 2⁵⁰ steps.
const MOST_ROUNDS: usize = 50;
/// The change of X in a round, and the residual of the equation, that are accepted, as a part of X.
const SETTLED: f64 = 1e-12;
const RESIDUAL: f64 = 1e-6;

/// Why there is no gain.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RiccatiError {
    /// The iteration diverges, or converges to something that is not a solution.
    #[error(
        "the Riccati equation does not converge: after {rounds} doublings it is missed by {residual:e} of its solution"
    )]
    NotConverged {
        /// Rounds of doubling.
        rounds: usize,
        /// Relative residual; NaN if the numbers overflowed.
        residual: f64,
    },
    /// R, or R + BᵀXB, has no inverse.
    #[error("the weight of the inputs is singular")]
    SingularWeight,
}

/// The stabilising solution X of the equation, symmetric.
///
/// # Errors    [`RiccatiError`]: R is singular; or no convergence, because (A, B) cannot be
/// stabilised or a mode on the unit circle is not weighted by Q.
pub fn riccati<const N: usize, const M: usize>(
    a: &SMatrix<f64, N, N>,
    b: &SMatrix<f64, N, M>,
    q: &SMatrix<f64, N, N>,
    r: &SMatrix<f64, M, M>,
) -> Result<SMatrix<f64, N, N>, RiccatiError> {
    let r_inverse = r.try_inverse().ok_or(RiccatiError::SingularWeight)?;
    let (mut f, mut g, mut h) = (*a, b * r_inverse * b.transpose(), *q);
    let mut rounds = 0;
    let mut has_settled = false;
    while rounds < MOST_ROUNDS && !has_settled {
        rounds += 1;
        let residual = f64::NAN;
        let failed = RiccatiError::NotConverged { rounds, residual };
        let w = (SMatrix::identity() + g * h).try_inverse().ok_or(failed)?;
        let change = f.transpose() * h * w * f;
        g += f * w * g * f.transpose();
        f = f * w * f;
        h += change;
        h = (h + h.transpose()) * 0.5;
        g = (g + g.transpose()) * 0.5;
        if !h.iter().all(|x| x.is_finite()) {
            return Err(failed);
        }
        has_settled = change.length() <= SETTLED * h.length();
    }
    let residual = residual(a, b, q, r, &h).ok_or(RiccatiError::SingularWeight)?;
    match has_settled && residual <= RESIDUAL {
        true => Ok(h),
        false => Err(RiccatiError::NotConverged { rounds, residual }),
    }
}

/// The feedback u = -K x that minimises Σ xᵀQx + uᵀRu: K = (R + BᵀXB)⁻¹ BᵀXA.
///
/// # Errors    [`RiccatiError`], as [`riccati`].
pub fn regulator_gain<const N: usize, const M: usize>(
    a: &SMatrix<f64, N, N>,
    b: &SMatrix<f64, N, M>,
    q: &SMatrix<f64, N, N>,
    r: &SMatrix<f64, M, M>,
) -> Result<SMatrix<f64, M, N>, RiccatiError> {
    let x = riccati(a, b, q, r)?;
    let weight = (r + b.transpose() * x * b).try_inverse();
    Ok(weight.ok_or(RiccatiError::SingularWeight)? * b.transpose() * x * a)
}

/// The gain of the stationary Kalman filter for one measured number y = c x, by the dual equation:
/// what the filter adds to its prediction for each unit of innovation.
///
/// # Errors    [`RiccatiError`], as [`riccati`].
pub fn filter_gain<const N: usize>(
    a: &SMatrix<f64, N, N>,
    c: &SVector<f64, N>,
    process: &SMatrix<f64, N, N>,
    measurement: f64,
) -> Result<SVector<f64, N>, RiccatiError> {
    let r = SMatrix::<f64, 1, 1>::new(measurement);
    let predicted = riccati(&a.transpose(), c, process, &r)?;
    let innovation = (c.transpose() * predicted * c).x + measurement;
    Ok(predicted * c / innovation)
}

/// The residual of X in the equation, as a part of X.
pub(super) fn residual<const N: usize, const M: usize>(
    a: &SMatrix<f64, N, N>,
    b: &SMatrix<f64, N, M>,
    q: &SMatrix<f64, N, N>,
    r: &SMatrix<f64, M, M>,
    x: &SMatrix<f64, N, N>,
) -> Option<f64> {
    let weight = (r + b.transpose() * x * b).try_inverse()?;
    let axb = a.transpose() * x * b;
    let right = a.transpose() * x * a - axb * weight * axb.transpose() + q;
    Some((right - x).length() / x.length().max(f64::MIN_POSITIVE))
}

#[cfg(test)]
mod tests {
    use nalgebra::{Matrix1, Matrix2, Vector2};
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn scalar_equation_has_the_root_of_its_quadratic(a in -2.0..2.0_f64, b in 0.1..2.0_f64, q in 0.01..10.0_f64, r in 0.01..10.0_f64) {
            let x = riccati(&Matrix1::new(a), &Matrix1::new(b), &Matrix1::new(q), &Matrix1::new(r)).unwrap().x;
            // b² x² + (r - a² r - q b²) x - q r = 0
            let half = 0.5 * (r - a * a * r - q * b * b);
            let root = (-half + (half * half + b * b * q * r).sqrt()) / (b * b);
            prop_assert!((x - root).abs() < 1e-9 * root, "{x} {root}");
        }

        #[test]
        fn doubling_ends_where_the_plain_iteration_does(
            entries in proptest::collection::vec(-1.5..1.5_f64, 9), inputs in proptest::collection::vec(-1.0..1.0_f64, 3), r in 0.1..5.0_f64,
        ) {
            let a = SMatrix::<f64, 3, 3>::from_column_slice(&entries);
            let b = SMatrix::<f64, 3, 1>::from_column_slice(&inputs);
            let (q, r) = (SMatrix::<f64, 3, 3>::identity(), Matrix1::new(r));
            let controllability = SMatrix::<f64, 3, 3>::from_columns(&[b, a * b, a * a * b]);
            prop_assume!(controllability.determinant().abs() > 0.05);
            let x = riccati(&a, &b, &q, &r).unwrap();
            let mut plain = q;
            for _ in 0..2_000 {
                let weight = (r + b.transpose() * plain * b).try_inverse().unwrap();
                let axb = a.transpose() * plain * b;
                plain = a.transpose() * plain * a - axb * weight * axb.transpose() + q;
                plain = (plain + plain.transpose()) * 0.5;
            }
            prop_assert!((x - plain).length() < 1e-6 * x.length(), "{x} {plain}");
            let k = regulator_gain(&a, &b, &q, &r).unwrap();
            prop_assert!((a - b * k).complex_eigenvalues().iter().all(|z| z.norm() < 1.0));
        }
    }

    #[test]
    fn filter_gain_is_that_of_the_covariance_recursion() {
        // A position that drifts, with a speed that drifts.
        let (a, c) = (Matrix2::new(1.0, 0.1, 0.0, 1.0), Vector2::new(1.0, 0.0));
        let (process, measurement) = (Matrix2::new(1e-4, 0.0, 0.0, 1e-2), 0.5);
        let gain = filter_gain(&a, &c, &process, measurement).unwrap();
        let mut p = Matrix2::identity();
        let mut expect = Vector2::zeros();
        for _ in 0..10_000 {
            let predicted = a * p * a.transpose() + process;
            expect = predicted * c / ((c.transpose() * predicted * c).x + measurement);
            p = predicted - expect * c.transpose() * predicted;
        }
        assert!((gain - expect).length() < 1e-9);
    }

    #[test]
    fn what_cannot_be_stabilised_does_not_converge_and_says_so() {
        // The second state grows and no input moves it.
        let a = Matrix2::new(0.5, 0.0, 0.0, 1.1);
        let b = Vector2::new(1.0, 0.0);
        let error = riccati(&a, &b, &Matrix2::identity(), &Matrix1::new(1.0)).unwrap_err();
        assert!(error.to_string().contains("does not converge"), "{error}");
        let singular = riccati(&a, &b, &Matrix2::identity(), &Matrix1::new(0.0));
        assert_eq!(singular, Err(RiccatiError::SingularWeight));
    }
}
