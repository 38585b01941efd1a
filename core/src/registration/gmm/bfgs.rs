//! The minimum of a smooth function of few variables, from a start, by its gradient.
//!
//! 1. A step goes against the gradient, turned and scaled by an estimate of the inverse Hessian.
//!    The estimate begins with what the caller knows, or with the identity, and is updated at each
//!    step.
//! 2. The step is halved until the value falls by a part of what the gradient promises (Armijo).
//! 3. It ends where the gradient is flat, after a short step, or where no step lowers the value.
//!
//! Our own, because the crates that have it ask the machine for random numbers in WebAssembly, or
//! bring in a second linear algebra library.
//!
//! Source: Nocedal & Wright (2006), "Numerical optimization", algorithms 3.1 and 6.1.

use nalgebra::{DMatrix, DVector};

use crate::geom::Length;

/// Part of the decrease promised by the gradient that a step has to bring.
const ARMIJO: f64 = 1e-4;
/// How often a step is halved at most.
const MOST_HALVINGS: usize = 40;
/// The longest first step: the curvature of the function is not known yet.
const FIRST_STEP: f64 = 0.1;

/// When a descent ends.
#[derive(Clone, Copy, Debug)]
pub(super) struct Until {
    /// The largest component of the gradient is below this.
    pub(super) flat: f64,
    /// A step was shorter than this.
    pub(super) short: f64,
    /// This many steps were taken.
    pub(super) iterations: usize,
}

/// Where the descent ended.
pub(super) struct Descended {
    pub(super) at: DVector<f64>,
    pub(super) iterations: usize,
    /// Whether it ended because the gradient is flat, the last step was short, or no step lowers
    /// the value.
    pub(super) is_settled: bool,
}

/// Descends from `start`; `inverse` is that of the Hessian there, if known; `value` gives the
/// function and its gradient; `before_step` is called with the point from which each step is taken.
pub(super) fn descend(
    start: DVector<f64>,
    inverse: Option<DMatrix<f64>>,
    until: &Until,
    value: impl Fn(&DVector<f64>) -> (f64, DVector<f64>),
    mut before_step: impl FnMut(&DVector<f64>),
) -> Descended {
    let size = start.len();
    let is_known = inverse.is_some();
    let mut inverse = inverse.unwrap_or_else(|| DMatrix::identity(size, size));
    let mut at = start;
    let (mut here, mut gradient) = value(&at);
    let mut last_step = f64::INFINITY;
    for iterations in 0..until.iterations {
        if gradient.amax() < until.flat || last_step < until.short {
            return Descended {
                at,
                iterations,
                is_settled: true,
            };
        }
        let mut step = -(&inverse * &gradient);
        if iterations == 0 && !is_known {
            step *= (FIRST_STEP / step.length()).min(1.0);
        }
        let promised = ARMIJO * step.dot(&gradient);
        let mut length = 1.0;
        let fallen = (0..MOST_HALVINGS).find_map(|_| {
            let there = &at + &step * length;
            let (value, gradient) = value(&there);
            let falls = value <= here + length * promised;
            length *= 0.5;
            falls.then_some((there, value, gradient))
        });
        let Some((there, value, after)) = fallen else {
            return Descended {
                at,
                iterations,
                is_settled: true,
            };
        };
        before_step(&at);
        let (moved, turned) = (&there - &at, &after - &gradient);
        let bend = moved.dot(&turned);
        if bend > 1e-12 * moved.length() * turned.length() {
            if iterations == 0 && !is_known {
                inverse *= bend / turned.norm_squared();
            }
            let rho = 1.0 / bend;
            let left = DMatrix::identity(size, size) - &moved * turned.transpose() * rho;
            inverse = &left * inverse * left.transpose() + &moved * moved.transpose() * rho;
        }
        last_step = moved.length();
        (at, here, gradient) = (there, value, after);
    }
    Descended {
        at,
        iterations: until.iterations,
        is_settled: last_step < until.short,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const UNTIL: Until = Until {
        flat: 1e-9,
        short: 0.0,
        iterations: 100,
    };

    /// Rosenbrock's valley, whose least value 0 is at (1, 1).
    fn valley(p: &DVector<f64>) -> (f64, DVector<f64>) {
        let (x, y) = (p[0], p[1]);
        let (a, b) = (1.0 - x, y - x * x);
        let gradient = vec![-2.0 * a - 400.0 * x * b, 200.0 * b];
        (a * a + 100.0 * b * b, DVector::from_vec(gradient))
    }

    #[test]
    fn finds_the_end_of_a_bent_valley() {
        let start = DVector::from_vec(vec![-1.2, 1.0]);
        let found = descend(start.clone(), None, &UNTIL, valley, |_| {});
        assert!(
            found.is_settled && found.iterations < 60,
            "{}",
            found.iterations
        );
        assert!((found.at - DVector::from_element(2, 1.0)).length() < 1e-8);
        let until = Until {
            iterations: 3,
            ..UNTIL
        };
        let cut = descend(start, None, &until, valley, |_| {});
        assert!(!cut.is_settled && cut.iterations == 3);
    }

    /// With the true inverse Hessian the first step is Newton's: in a quadratic bowl it is the last
    /// one.
    #[test]
    fn one_step_is_enough_where_the_curvature_is_known() {
        let bend = DMatrix::from_row_slice(2, 2, &[3.0, 1.0, 1.0, 2.0]);
        let least = DVector::from_vec(vec![4.0, -7.0]);
        let bowl = |p: &DVector<f64>| {
            let off = p - &least;
            let gradient = &bend * &off;
            (0.5 * off.dot(&gradient), gradient)
        };
        let inverse = bend.clone().try_inverse();
        let found = descend(DVector::zeros(2), inverse, &UNTIL, bowl, |_| {});
        assert!(found.is_settled && found.iterations == 1);
        assert!((found.at - &least).length() < 1e-12);
    }

    #[test]
    fn ends_after_a_short_step() {
        let until = Until {
            short: 0.5,
            ..UNTIL
        };
        let start = DVector::from_vec(vec![-1.2, 1.0]);
        // The first step is of 0.1.
        let found = descend(start, None, &until, valley, |_| {});
        assert!(found.is_settled && found.iterations == 1);
    }

    #[test]
    fn stays_where_it_is_flat() {
        let bowl = |p: &DVector<f64>| (p.norm_squared(), p * 2.0);
        let found = descend(DVector::zeros(3), None, &UNTIL, bowl, |_| {});
        assert!(found.is_settled && found.iterations == 0);
    }
}
