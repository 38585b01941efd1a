//! The least value of a smooth function of few variables, from a start, by its gradient.
//!
//! 1. A step goes against the gradient, turned and scaled by an estimate of the inverse Hessian,
//!    which begins as the identity and learns from each step.
//! 2. Its length is halved until the value falls by a part of what the gradient promises (Armijo).
//! 3. It ends where the gradient is flat, or no length makes it fall.
//!
//! Our own, because the crates that have it ask the machine for random numbers in WebAssembly, or
//! bring a second linear algebra.
//!
//! Source: Nocedal & Wright (2006), "Numerical optimization", algorithms 3.1 and 6.1.

use nalgebra::{DMatrix, DVector};

use crate::geom::Length;

/// Part of what the gradient promises that a step has to bring.
const ARMIJO: f64 = 1e-4;
/// How often a step is halved at most.
const MOST_HALVINGS: usize = 40;
/// The longest first step: nothing is known yet of how the function bends.
const FIRST_STEP: f64 = 0.1;

/// Where the descent came to.
pub(super) struct Descended {
    pub(super) at: DVector<f64>,
    pub(super) iterations: usize,
    /// Whether it ended because the gradient is flat, or because nothing near is less.
    pub(super) is_settled: bool,
}

/// Descends from `start` until the largest part of the gradient is below `flat`; `value` gives the
/// function and its gradient; `before_step` is told from where each step is taken.
pub(super) fn descend(
    start: DVector<f64>,
    flat: f64,
    most_iterations: usize,
    value: impl Fn(&DVector<f64>) -> (f64, DVector<f64>),
    mut before_step: impl FnMut(&DVector<f64>),
) -> Descended {
    let size = start.len();
    let (mut at, mut inverse) = (start, DMatrix::identity(size, size));
    let (mut here, mut gradient) = value(&at);
    for iterations in 0..most_iterations {
        if gradient.amax() < flat {
            return Descended {
                at,
                iterations,
                is_settled: true,
            };
        }
        let mut step = -(&inverse * &gradient);
        if iterations == 0 {
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
            if iterations == 0 {
                inverse *= bend / turned.norm_squared();
            }
            let rho = 1.0 / bend;
            let left = DMatrix::identity(size, size) - &moved * turned.transpose() * rho;
            inverse = &left * inverse * left.transpose() + &moved * moved.transpose() * rho;
        }
        (at, here, gradient) = (there, value, after);
    }
    Descended {
        at,
        iterations: most_iterations,
        is_settled: false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rosenbrock's valley, whose least value 0 is at (1, 1).
    #[test]
    fn finds_the_end_of_a_bent_valley() {
        let valley = |p: &DVector<f64>| {
            let (x, y) = (p[0], p[1]);
            let (a, b) = (1.0 - x, y - x * x);
            let gradient = vec![-2.0 * a - 400.0 * x * b, 200.0 * b];
            (a * a + 100.0 * b * b, DVector::from_vec(gradient))
        };
        let start = DVector::from_vec(vec![-1.2, 1.0]);
        let found = descend(start.clone(), 1e-9, 100, valley, |_| {});
        assert!(
            found.is_settled && found.iterations < 60,
            "{}",
            found.iterations
        );
        assert!((found.at - DVector::from_element(2, 1.0)).length() < 1e-8);
        let cut = descend(start, 1e-9, 3, valley, |_| {});
        assert!(!cut.is_settled && cut.iterations == 3);
    }

    #[test]
    fn stays_where_it_is_flat() {
        let bowl = |p: &DVector<f64>| (p.norm_squared(), p * 2.0);
        let found = descend(DVector::zeros(3), 1e-9, 10, bowl, |_| {});
        assert!(found.is_settled && found.iterations == 0);
    }
}
