//! In: beams on one wall. Out: the wall's line (α, r) in the robot frame, with covariance.
//!
//! 1. Weighted total least squares with w = 1/σ²: α = ½ atan2(-2 Cxy, Cyy - Cxx), r = x̄ cos α + ȳ
//!    sin α, then r ≥ 0 (TDK 2016 §4.1, with the erratum of the specification on the arctangent;
//!    Siegwart & Nourbakhsh 2004, §4.3.1).
//! 2. C is the weighted scatter minus what noise alone contributes to it, Σ wᵢ (1 - wᵢ/W) Rᵢ with
//!    Rᵢ the covariance of point i. Noise acts along the beam, not around the point, so without
//!    this α is biased towards the side seen at the flatter angle. A bias does not average out over
//!    hundreds of scans, and a filter that trusts σ_α assumes that it does.
//! 3. Covariance F C_X Fᵀ of range and bearing noise (Arras & Siegwart 1997, "Feature extraction
//!    and scene interpretation for map-based navigation and map building"), with F in closed form.
//!    In the frame of the line (t along it, n across it) ∂α = -w (t ∂n + n ∂t) / (Ctt - Cnn) and
//!    ∂r = w/W ∂n + t̄ ∂α. The paper's numeric F is the test.
//! 4. With (uₙ, uₜ) the beam in that frame, the range moves a point by (uₙ, uₜ), the bearing by
//!    (-uₜ, uₙ), and p = t uₙ + n uₜ, q = n uₙ - t uₜ are their effects on α. So three sums over
//!    the points give the whole covariance: A = Σ w p² + w² σ⊥² q², B = Σ w p uₙ - w² σ⊥² q uₜ, C =
//!    Σ w uₙ² + w² σ⊥² uₜ².

mod residuals;
mod sums;

use std::iter;

use nalgebra::{Matrix2, Point2, Vector2};

use super::columns::{Columns, Noise};
use super::feature::LineFeature;
use super::piece::Piece;
use crate::geom::Line;
use crate::points::Beam;
use residuals::Residuals;
use sums::{Faded, Frame, Scatter, Sums};

/// A beam whose numbers cannot be used.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error(
    "beam {beam_idx}: ends at ({x}, {y}) m, range {range} m, sigma {sigma} m; expected finite numbers, range and sigma greater than 0"
)]
pub struct BadBeam {
    /// Index of the beam in the scan.
    pub beam_idx: usize,
    /// Where it ends, m.
    pub x: f64,
    /// Where it ends, m.
    pub y: f64,
    /// Its range, m.
    pub range: f64,
    /// Its standard deviation, m.
    pub sigma: f64,
}

/// Fits one line to `beams`. `None` if no line goes through them: there are fewer than two, no
/// direction stands out, or they run along the line, so that their ranges do not measure its
/// position.
///
/// # Units    `bearing_sigma`: rad, not negative.
/// # Source   TDK 2016 §4.1; Arras & Siegwart (1997). The scatter of the noise is removed, see the
/// module.
/// # Example
/// ```
/// use nalgebra::{Point2, Vector2};
/// use slamlab_core::features::fit_line;
/// use slamlab_core::geom::Length;
/// use slamlab_core::points::Beam;
/// let on_x_2 = |y: f64| Beam {
///     beam_idx: 0,
///     origin_in_robot: Point2::origin(),
///     end_in_robot: Point2::new(2.0, y),
///     range: Vector2::new(2.0, y).length(),
///     sigma: 0.01,
///     is_hit: true,
///     quality: None,
///     age: 0.0,
/// };
/// let wall = fit_line(&[on_x_2(-1.0), on_x_2(0.0), on_x_2(1.0)], 0.0).unwrap();
/// assert!(wall.line.alpha().abs() < 1e-9 && (wall.line.r() - 2.0).abs() < 1e-9);
/// ```
#[must_use]
pub fn fit_line(beams: &[Beam], bearing_sigma: f64) -> Option<LineFeature> {
    let mut columns = Columns::default();
    let noise = Noise {
        bearing_sigma,
        surface_sigma: 0.0,
    };
    columns.load(beams, iter::once(0..beams.len()), noise);
    let fit = fit_columns(&columns, &Piece::whole(&columns, 0..columns.len()))?;
    let chi2 = fit.residuals(&columns, false).chi2;
    Some(fit.feature(&columns, chi2, beams.first()?.origin_in_robot))
}

/// Refuses the first beam with unusable numbers.
pub(super) fn check_beams<'a>(beams: impl IntoIterator<Item = &'a Beam>) -> Result<(), BadBeam> {
    match beams.into_iter().find(|beam| !is_usable(beam)) {
        Some(beam) => Err(BadBeam {
            beam_idx: beam.beam_idx,
            x: beam.end_in_robot.x,
            y: beam.end_in_robot.y,
            range: beam.range,
            sigma: beam.sigma,
        }),
        None => Ok(()),
    }
}

/// Whether the sums can handle a beam.
pub(super) fn is_usable(beam: &Beam) -> bool {
    let numbers = [
        beam.end_in_robot.x,
        beam.end_in_robot.y,
        beam.origin_in_robot.x,
        beam.origin_in_robot.y,
        beam.range,
        beam.sigma,
    ];
    numbers.iter().all(|v| v.is_finite()) && beam.range > 0.0 && beam.sigma > 0.0
}

/// A line through the kept points of a range.
#[derive(Clone, Copy, Debug)]
pub(super) struct Fit {
    pub(super) line: Line,
    pub(super) cov: Matrix2<f64>,
    /// Feet of the first and the last point.
    pub(super) ends: [Point2<f64>; 2],
    pub(super) n_points: usize,
    frame: Frame,
    by_heading: [Vector2<f64>; 2],
    /// Index of the first point.
    pub(super) first: usize,
    /// Index of the last point.
    pub(super) last: usize,
}

impl Fit {
    /// The points' distances from the line, relative to their known noise.
    pub(super) fn residuals(&self, columns: &Columns, with_bend: bool) -> Residuals {
        Residuals::of(columns, self.first..self.last + 1, &self.frame, with_bend)
    }

    /// With χ² of the residuals, and the sensor's position at the first beam.
    pub(super) fn feature(&self, columns: &Columns, chi2: f64, origin: Point2<f64>) -> LineFeature {
        LineFeature {
            line: self.line,
            cov: self.cov,
            ends: self.ends,
            seen_from_origin_side: self.frame.normal.dot(&origin.coords) <= self.line.r(),
            first_beam: columns.number(self.first),
            last_beam: columns.number(self.last),
            n_points: self.n_points,
            chi2,
            by_heading: self.by_heading,
        }
    }
}

/// [`fit_line`] for the points of a piece that are not skipped.
pub(super) fn fit_columns(columns: &Columns, piece: &Piece) -> Option<Fit> {
    let (first, last) = (piece.first(columns)?, piece.last(columns)?);
    let scatter = Scatter::of(columns, piece);
    if scatter.n_points < 2 {
        return None;
    }
    let frame = scatter.frame()?;
    let faded = Faded::between(columns.number(first), columns.number(last));
    let sums = Sums::of(columns, first..last + 1, &frame, &faded);
    let foot = |index: usize| {
        let p = columns.point(index);
        p - frame.normal * (frame.normal.dot(&p.coords) - frame.line.r())
    };
    Some(Fit {
        line: frame.line,
        cov: sums.covariance(&scatter, &frame)?,
        ends: [foot(first), foot(last)],
        n_points: scatter.n_points,
        frame,
        by_heading: sums.by_heading(&scatter, &frame),
        first,
        last,
    })
}

#[cfg(test)]
mod tests;
