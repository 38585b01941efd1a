//! From continuous to discrete time, exactly.
//!
//! In: A of x' = A x + B u and a time step. Out: Φ = exp(A h) and S = ∫₀ʰ exp(A s) ds, so that x⁺ =
//! Φ x + S B u for an input that is held during the step. A need not be invertible.
//!
//! 1. The step is halved until ‖A h‖ is at most 1/2; then the series of S converges to the last bit
//!    within 16 terms.
//! 2. Φ = I + A S, and the step is doubled again: S(2h) = S(h) + Φ(h) S(h).
//!
//! Source: scaling and squaring as in Van Loan (1978), "Computing integrals involving the matrix
//! exponential", which computes both from one larger exponential; doubling S keeps to the size of
//! A.

use nalgebra::SMatrix;

use crate::geom::Length;

/// Terms of the series: 0.5¹⁷/17! is 2e-20.
const TERMS: u32 = 16;

/// Φ = exp(A h) and S = ∫₀ʰ exp(A s) ds.
///
/// # Units    `step` h in s, `a` in 1/s.
#[must_use]
pub fn discretize<const N: usize>(
    a: &SMatrix<f64, N, N>,
    step: f64,
) -> (SMatrix<f64, N, N>, SMatrix<f64, N, N>) {
    let mut h = step;
    let mut halvings = 0;
    while a.length() * h.abs() > 0.5 && halvings < 64 {
        h *= 0.5;
        halvings += 1;
    }
    let identity = SMatrix::<f64, N, N>::identity();
    // S = h (I + A h/2! + (A h)²/3! + …), from the innermost bracket outwards.
    let ah = a * h;
    let mut sum = identity;
    for k in (2..=TERMS + 1).rev() {
        sum = identity + ah * sum / f64::from(k);
    }
    let mut s = sum * h;
    for _ in 0..halvings {
        let phi = identity + a * s;
        s += phi * s;
    }
    (identity + a * s, s)
}

#[cfg(test)]
mod tests {
    use nalgebra::{Matrix3, SMatrix};

    use super::*;
    use crate::robot::{DriveTrain, MotorModel};

    #[test]
    fn first_order_lag_and_double_integrator_have_their_closed_forms() {
        let h = 0.3;
        let (phi, s) = discretize(&SMatrix::<f64, 1, 1>::new(-7.0), h);
        let decay = libm::exp(-7.0 * h);
        assert!((phi.x - decay).abs() < 1e-15 && (s.x - (1.0 - decay) / 7.0).abs() < 1e-15);
        let (phi, s) = discretize(&SMatrix::<f64, 2, 2>::new(0.0, 1.0, 0.0, 0.0), h);
        assert!((phi - SMatrix::<f64, 2, 2>::new(1.0, h, 0.0, 1.0)).length() < 1e-15);
        assert!((s - SMatrix::<f64, 2, 2>::new(h, 0.5 * h * h, 0.0, h)).length() < 1e-15);
    }

    #[test]
    fn agrees_with_the_padé_exponential_of_van_loans_matrix() {
        for (motor, h) in [
            (MotorModel::rp6(), 1e-3),
            (MotorModel::rp6(), 0.01),
            (MotorModel::pioneer(), 5e-3),
        ] {
            let (a, b, _) = motor.matrices();
            let (phi, s) = discretize(&a, h);
            let mut both = SMatrix::<f64, 4, 4>::zeros();
            both.fixed_view_mut::<3, 3>(0, 0).copy_from(&a);
            both.fixed_view_mut::<3, 1>(0, 3).copy_from(&b);
            let exp = (both * h).exp();
            let expect = exp.fixed_view::<3, 3>(0, 0);
            assert!(
                (phi - expect).length() < 1e-10 * expect.length(),
                "{phi} {expect}"
            );
            assert!((s * b - exp.fixed_view::<3, 1>(0, 3)).length() < 1e-10 * (s * b).length());
        }
    }

    #[test]
    fn two_steps_are_one_of_twice_the_time() {
        let (a, _) = DriveTrain::rp6().matrices();
        let ((one, s_one), (two, s_two)) = (discretize(&a, 1e-3), discretize(&a, 2e-3));
        assert!((one * one - two).length() < 1e-12);
        assert!((s_one + one * s_one - s_two).length() < 1e-12);
        assert_eq!(
            discretize(&Matrix3::<f64>::zeros(), 1.0).0,
            Matrix3::identity()
        );
    }
}
