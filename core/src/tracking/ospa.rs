//! Distance between a set of tracks and the true set of objects: optimal subpattern assignment
//! (OSPA).
//!
//! In: the positions of both. Out: one distance, which covers errors of position and of number.
//!
//! With m objects and n ≥ m tracks it is ((Σ min(d, c)^p + c^p (n - m)) / n)^(1/p) over the best
//! assignment: each one too many or too few costs as much as one with an error of the cutoff c.
//!
//! Source: Schuhmacher, Vo & Vo (2008), "A consistent metric for performance evaluation of
//! multi-object filters", eq. (3).

use nalgebra::Point2;

use crate::association::assign;
use crate::geom::Length;

/// The distance of order 2, m, with the cutoff (m); 0 for two empty sets.
#[must_use]
pub fn ospa(a: &[Point2<f64>], b: &[Point2<f64>], cutoff: f64) -> f64 {
    let (few, many) = if a.len() <= b.len() { (a, b) } else { (b, a) };
    if many.is_empty() {
        return 0.0;
    }
    let cost = |p: &Point2<f64>, q: &Point2<f64>| {
        let d = (p - q).length().min(cutoff);
        d * d
    };
    let costs: Vec<Vec<f64>> = few
        .iter()
        .map(|p| many.iter().map(|q| cost(p, q)).collect())
        .collect();
    let chosen = assign(&costs);
    let apart = costs
        .iter()
        .zip(chosen)
        .filter_map(|(row, col)| row.get(col?).copied());
    let missing = (many.len() - few.len()) as f64 * cutoff * cutoff;
    ((apart.sum::<f64>() + missing) / many.len() as f64).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn points(xs: &[f64]) -> Vec<Point2<f64>> {
        xs.iter().map(|&x| Point2::new(x, -0.5 * x)).collect()
    }

    #[test]
    fn by_hand() {
        let check = |a: &[f64], b: &[f64], expect: f64| {
            let along =
                |xs: &[f64]| -> Vec<_> { xs.iter().map(|&x| Point2::new(x, 0.0)).collect() };
            let found = ospa(&along(a), &along(b), 1.0);
            assert!(
                (found - expect).abs() < 1e-12,
                "{found} instead of {expect}"
            );
        };
        check(&[], &[], 0.0);
        check(&[1.0], &[], 1.0);
        check(&[0.0], &[0.3], 0.3);
        // One has an error of the cutoff.
        check(&[0.0], &[7.0], 1.0);
        // One of two is missing, the other has an error of 0.6: √((0.36 + 1) / 2).
        check(&[0.6, 9.0], &[0.0], 0.68_f64.sqrt());
        // The crossed assignment would be farther.
        check(&[0.0, 0.5], &[0.5, 0.0], 0.0);
    }

    proptest! {
        /// It is a metric: symmetric, and never longer than by way of a third set.
        #[test]
        fn it_is_a_metric(
            a in proptest::collection::vec(-2.0..2.0_f64, 0..5), b in proptest::collection::vec(-2.0..2.0_f64, 0..5),
            c in proptest::collection::vec(-2.0..2.0_f64, 0..5),
        ) {
            let d = |p: &[f64], q: &[f64]| ospa(&points(p), &points(q), 1.0);
            prop_assert!((d(&a, &b) - d(&b, &a)).abs() < 1e-12);
            prop_assert!(d(&a, &a) < 1e-12);
            prop_assert!(d(&a, &c) <= d(&a, &b) + d(&b, &c) + 1e-9);
        }
    }
}
