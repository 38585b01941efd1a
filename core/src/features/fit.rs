//! In: beams on one wall. Out: the wall's line (α, r) in the robot frame, with covariance.
//!
//! 1. Weighted total least squares with w = 1/σ²: α = ½ atan2(-2 Cxy, Cyy - Cxx), r = x̄ cos α + ȳ sin α, then r ≥ 0
//!    (TDK 2016 §4.1, with the erratum of the specification on the arctangent; Siegwart & Nourbakhsh 2004, §4.3.1).
//! 2. C is the weighted scatter less what the noise alone contributes to it, Σ wᵢ (1 - wᵢ/W) Rᵢ with Rᵢ the covariance of
//!    point i. Noise runs along the beam, not around the point, so without this α is biased towards the side seen
//!    at the flatter angle; a bias does not average out over hundreds of scans, and a filter that believes σ_α would.
//! 3. Covariance F C_X Fᵀ of range and bearing noise (Arras & Siegwart 1997, "Feature extraction and scene
//!    interpretation for map-based navigation and map building"), with F in closed form. In the frame of the line
//!    (t along it, n across it) ∂α = -w (t ∂n + n ∂t) / (Ctt - Cnn) and ∂r = w/W ∂n + t̄ ∂α. The source's numeric F is
//!    the test.

use nalgebra::{Matrix2, Point2, Vector2};

use crate::geom::{Line, sin_cos};
use crate::points::Beam;

/// A wall as one scan shows it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LineFeature {
    /// The line in the robot frame.
    pub line: Line,
    /// Covariance of (α, r), rad², rad·m, m².
    pub cov: Matrix2<f64>,
    /// Where the seen part begins and ends, on the line, in the order of the beams, robot frame.
    pub ends: [Point2<f64>; 2],
    /// Whether the sensor looked from the robot origin's side of the line. False only where the line passes
    /// between the two.
    pub seen_from_origin_side: bool,
    /// Number of the first beam on it, as in the scan; may be greater than `last_beam` where the line goes past the
    /// end of the scan.
    pub first_beam: usize,
    /// Number of the last beam on it.
    pub last_beam: usize,
    /// How many beams the fit used.
    pub n_points: usize,
    /// Σ d²/σ_d² of the residuals: χ² with `n_points - 2` degrees of freedom on a flat wall.
    pub chi2: f64,
    /// How (α, r) change when the heading was off by 1 rad at the first beam, and at the last, fading to none at the middle
    /// one: what slipping tracks do to a wall while a turning lidar sweeps over it. rad/rad, m/rad.
    pub by_heading: [Vector2<f64>; 2],
}

impl LineFeature {
    /// Length of the seen part, m.
    #[must_use]
    pub fn length(&self) -> f64 {
        let [a, b] = self.ends;
        (b - a).norm()
    }
}

/// Why no line goes through some beams.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FitError {
    /// A line needs two points.
    #[error("{n_points} points; a line needs at least 2")]
    TooFew {
        /// How many there are.
        n_points: usize,
    },
    /// The points are not longer than they are wide.
    #[error(
        "points spread {along:.3} along the line and {across:.3} across it (weighted, noise removed); no direction stands out"
    )]
    Degenerate {
        /// Weighted scatter along the line.
        along: f64,
        /// Weighted scatter across the line.
        across: f64,
    },
    /// A beam whose numbers cannot be used.
    #[error(
        "beam {beam_idx}: range {range} m with sigma {sigma} m; expected finite numbers greater than 0"
    )]
    Value {
        /// Number of the beam in the scan.
        beam_idx: usize,
        /// Its range, m.
        range: f64,
        /// Its standard deviation, m.
        sigma: f64,
    },
}

/// Fits one line to `beams`.
///
/// # Units    `bearing_sigma`: rad. `surface_sigma`: how far from flat a wall may be, m; it enters the χ² only.
/// # Errors   [`FitError`]: fewer than 2 beams, no direction that stands out, numbers that are not finite.
/// # Source   TDK 2016 §4.1; Arras & Siegwart (1997). The noise's own scatter is removed, see the module.
/// # Example
/// ```
/// use nalgebra::{Point2, Vector2};
/// use slamlab_core::features::fit_line;
/// use slamlab_core::points::Beam;
/// let on_x_2 = |y: f64| Beam {
///     beam_idx: 0,
///     origin_in_robot: Point2::origin(),
///     end_in_robot: Point2::new(2.0, y),
///     range: Vector2::new(2.0, y).norm(),
///     sigma: 0.01,
///     is_hit: true,
/// };
/// let wall = fit_line(&[on_x_2(-1.0), on_x_2(0.0), on_x_2(1.0)], 0.0, 0.0).unwrap();
/// assert!(wall.line.alpha().abs() < 1e-9 && (wall.line.r() - 2.0).abs() < 1e-9);
/// ```
pub fn fit_line(
    beams: &[Beam],
    bearing_sigma: f64,
    surface_sigma: f64,
) -> Result<LineFeature, FitError> {
    let samples: Vec<_> = beams
        .iter()
        .map(|beam| Sample::new(beam, bearing_sigma, surface_sigma))
        .collect();
    fit_samples(&samples)
}

/// A beam made ready for sums.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sample {
    /// Where it ends, robot frame.
    pub(super) point: Point2<f64>,
    /// Unit vector along the beam.
    pub(super) along: Vector2<f64>,
    /// 1/σ² of the range.
    pub(super) weight: f64,
    /// σ² of the range, and of the bearing times range².
    var_along: f64,
    var_across: f64,
    var_surface: f64,
    origin: Point2<f64>,
    range: f64,
    pub(super) beam_idx: usize,
    /// Set where the extraction found that this beam does not belong to the line around it.
    pub(super) dropped: bool,
}

impl Sample {
    #[inline]
    pub(super) fn new(beam: &Beam, bearing_sigma: f64, surface_sigma: f64) -> Self {
        let across = beam.range * bearing_sigma;
        let var_along = beam.sigma * beam.sigma;
        Self {
            point: beam.end_in_robot,
            along: (beam.end_in_robot - beam.origin_in_robot) / beam.range,
            weight: 1.0 / var_along,
            var_along,
            var_across: across * across,
            var_surface: surface_sigma * surface_sigma,
            origin: beam.origin_in_robot,
            range: beam.range,
            beam_idx: beam.beam_idx,
            dropped: false,
        }
    }

    /// Variance of the point's distance from a line with this normal; with the roughness of the surface.
    #[inline]
    pub(super) fn variance_across(&self, normal: &Vector2<f64>) -> f64 {
        let (cos, sin) = (normal.dot(&self.along), normal.perp(&self.along));
        cos * cos * self.var_along + sin * sin * self.var_across + self.var_surface
    }
}

/// Fits one line to the samples that are not dropped.
pub(super) fn fit_samples(samples: &[Sample]) -> Result<LineFeature, FitError> {
    let kept = || samples.iter().filter(|s| !s.dropped);
    let (mut total, mut mean, mut n_points) = (0.0, Vector2::zeros(), 0);
    for s in kept() {
        if !(s.weight > 0.0 && s.weight.is_finite() && s.point.coords.norm_squared().is_finite()) {
            return Err(FitError::Value {
                beam_idx: s.beam_idx,
                range: s.range,
                sigma: s.var_along.sqrt(),
            });
        }
        total += s.weight;
        mean += s.point.coords * s.weight;
        n_points += 1;
    }
    let (Some(first), Some(last), 2..) = (kept().next(), kept().next_back(), n_points) else {
        return Err(FitError::TooFew { n_points });
    };
    mean /= total;

    // The scatter, less what noise contributes.
    let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
    for s in kept() {
        let d = s.point.coords - mean;
        let (u, v) = (s.along, s.var_across);
        let share = 1.0 - s.weight / total;
        let (along, across) = (s.var_along * share, v * share);
        xx += s.weight * (d.x * d.x - along * u.x * u.x - across * u.y * u.y);
        xy += s.weight * (d.x * d.y - (along - across) * u.x * u.y);
        yy += s.weight * (d.y * d.y - along * u.y * u.y - across * u.x * u.x);
    }
    let alpha = 0.5 * libm::atan2(-2.0 * xy, yy - xx);
    let (sin, cos) = sin_cos(alpha);
    let r = mean.x * cos + mean.y * sin;
    // Eigenvalues of the scatter: the line runs along the greater.
    let half_gap = 0.5 * libm::hypot(yy - xx, 2.0 * xy);
    let (along, across) = (0.5 * (xx + yy) + half_gap, 0.5 * (xx + yy) - half_gap);
    // A spread along the line of a few standard deviations of one point is no direction.
    let spread = 2.0 * half_gap;
    if !(spread > 4.0 && spread.is_finite()) {
        return Err(FitError::Degenerate { along, across });
    }

    let line = Line::new(alpha, r);
    let sign = if r < 0.0 { -1.0 } else { 1.0 };
    let (normal, tangent) = (
        Vector2::new(cos, sin) * sign,
        Vector2::new(-sin, cos) * sign,
    );
    let (mean_t, r) = (tangent.dot(&mean), line.r());
    let (mut aa, mut ar, mut rr, mut chi2) = (0.0, 0.0, 0.0, 0.0);
    let mut by_heading = [Vector2::zeros(); 2];
    let middle = 0.5 * (first.beam_idx + last.beam_idx) as f64;
    let half = (last.beam_idx as f64 - middle).abs().max(0.5);
    let effect = |s: &Sample, n: f64, t: f64, dn: f64, dt: f64| {
        let by_alpha = -s.weight * (t * dn + n * dt) / spread;
        Vector2::new(by_alpha, s.weight / total * dn + mean_t * by_alpha)
    };
    for s in kept() {
        let n = normal.dot(&s.point.coords) - r;
        let t = tangent.dot(&s.point.coords) - mean_t;
        let (un, ut) = (normal.dot(&s.along), tangent.dot(&s.along));
        // The range moves the point along u, the bearing across it: (n, t) by (un, ut) and by (-ut, un).
        for (dn, dt, variance) in [(un, ut, s.var_along), (-ut, un, s.var_across)] {
            let by = effect(s, n, t, dn, dt);
            let (by_alpha, by_r) = (by.x, by.y);
            aa += by_alpha * by_alpha * variance;
            ar += by_alpha * by_r * variance;
            rr += by_r * by_r * variance;
        }
        // A turn about the robot moves the point by its distance, at right angles.
        let from_middle = ((s.beam_idx as f64 - middle) / half).clamp(-1.0, 1.0);
        by_heading[usize::from(from_middle > 0.0)] +=
            effect(s, n, t, -(t + mean_t), r + n) * from_middle.abs();
        chi2 += n * n / s.variance_across(&normal);
    }
    Ok(LineFeature {
        line,
        cov: Matrix2::new(aa, ar, ar, rr),
        ends: [line.project(first.point), line.project(last.point)],
        seen_from_origin_side: line.signed_distance(first.origin) <= 0.0,
        first_beam: first.beam_idx,
        last_beam: last.beam_idx,
        n_points,
        chi2,
        by_heading,
    })
}

#[cfg(test)]
mod tests;
