//! In: points near a circle. Out: the circle through them, with covariance.
//!
//! 1. Weighted least squares of dᵢ = |pᵢ - c| - R by Gauss-Newton, w = 1 / (σᵢ² max(cos²βᵢ, ¼)), β
//!    the angle between beam and radius. Noise acts along the beam, so it moves a point off the
//!    circle by cos β of it. Where a beam grazes the circle that is zero to first order, but the
//!    remainder is unknown, so the weight of such points is at most four times as large.
//! 2. These weights are not the inverse variances, so the covariance is (JᵀWJ)⁻¹ (JᵀW V W J)
//!    (JᵀWJ)⁻¹ with the variances V of the beams across the circle.
//!
//! Source: Gander, Golub & Strebel (1994), "Least-squares fitting of circles and ellipses" (the
//! geometric fit); the covariance as for any estimate by given weights.

use nalgebra::{Matrix3, Vector2, Vector3};

use super::Circle;
use crate::features::columns::Columns;
use crate::features::moments::Moments;
use crate::geom::Length;

/// A circle and its uncertainty.
#[derive(Clone, Copy, Debug)]
pub(super) struct CircleFit {
    pub(super) circle: Circle,
    /// Covariance of (x, y, R), m².
    pub(super) cov: Matrix3<f64>,
    /// Σ d² / var(d), with n - 3 degrees of freedom on something round.
    pub(super) chi2: f64,
}

const MOST_STEPS: usize = 30;
/// A step shorter than this ends the search, m.
const SMALL_STEP: f64 = 1e-9;
/// Smallest cos² β, for weights and for χ².
const LEAST_COS2: f64 = 0.25;

/// The circle through `points`, from a guess; `None` if there is none: too few points, points in a
/// row, or a search that diverges.
pub(super) fn fit(columns: &Columns, points: &[usize], guess: Circle) -> Option<CircleFit> {
    let mut circle = guess;
    for _ in 0..MOST_STEPS {
        let (mut h, mut g) = (Matrix3::zeros(), Vector3::zeros());
        for &index in points {
            let Some((out, d)) = off(columns, index, &circle) else {
                continue;
            };
            let (j, w) = (jacobian(&out), weight(columns, index, &out));
            h += j * j.transpose() * w;
            g += j * (w * d);
        }
        let step = h.cholesky()?.solve(&-g);
        circle.middle += Vector2::new(step.x, step.y);
        circle.radius += step.z;
        if step.length() < SMALL_STEP {
            return judged(columns, points, circle);
        }
    }
    None
}

impl CircleFit {
    /// Whether a point is on the circle, within n σ of its range and of the circle at that place.
    pub(super) fn has(&self, columns: &Columns, index: usize, sigmas: f64) -> bool {
        off(columns, index, &self.circle).is_some_and(|(out, d)| {
            let j = jacobian(&out);
            let var = columns.variance_along(index) + j.dot(&(self.cov * j));
            d * d <= sigmas * sigmas * var
        })
    }
}

/// The direction from the centre to a point, and how far the point is outside of the circle, m.
fn off(columns: &Columns, index: usize, circle: &Circle) -> Option<(Vector2<f64>, f64)> {
    let out = columns.point(index) - circle.middle;
    let length = out.length();
    (length > 0.0).then(|| (out / length, length - circle.radius))
}

/// ∂d by (x, y, R).
fn jacobian(out: &Vector2<f64>) -> Vector3<f64> {
    Vector3::new(-out.x, -out.y, -1.0)
}

fn weight(columns: &Columns, index: usize, out: &Vector2<f64>) -> f64 {
    1.0 / columns
        .spread(index, out)
        .max(LEAST_COS2 * columns.variance_along(index))
}

/// χ² of the same points as two lines, one through the points before the best border, the other
/// through the rest; counted like that of the circle.
pub(super) fn chi2_of_bend(columns: &Columns, points: &[usize]) -> f64 {
    let line = |points: &[usize]| {
        let sum = points.iter().fold(Moments::default(), |sum, &index| {
            sum.plus(&columns.moments_of(index))
        });
        let (normal, r) = sum.line();
        let square = |&index: &usize| {
            let off = normal.dot(&columns.point(index).coords) - r;
            weight(columns, index, &normal) * off * off
        };
        points.iter().map(square).sum::<f64>()
    };
    let borders = 2..points.len().saturating_sub(1);
    let chi2 = borders.map(|border| {
        let (before, after) = points.split_at(border);
        line(before) + line(after)
    });
    chi2.fold(f64::INFINITY, f64::min)
}

/// Step 2.
fn judged(columns: &Columns, points: &[usize], circle: Circle) -> Option<CircleFit> {
    let (mut h, mut v, mut chi2) = (Matrix3::zeros(), Matrix3::zeros(), 0.0);
    for &index in points {
        let (out, d) = off(columns, index, &circle)?;
        let (j, w) = (jacobian(&out), weight(columns, index, &out));
        let outer = j * j.transpose();
        h += outer * w;
        v += outer * (w * w * columns.variance(index, &out));
        chi2 += w * d * d;
    }
    let inverse = h.cholesky()?.inverse();
    let cov = inverse * v * inverse;
    let is_usable = circle.radius > 0.0 && cov.iter().all(|v| v.is_finite());
    is_usable.then_some(CircleFit { circle, cov, chi2 })
}
