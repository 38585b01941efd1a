//! In: lines of a scan. Out: the points where they cross, as landmarks with covariance: corners of rooms above all.
//!
//! 1. p solves (cos αᵢ, sin αᵢ) · p = rᵢ for both lines, that is M p = r.
//! 2. ∂p = M⁻¹ (∂rᵢ - tᵢ ∂αᵢ) with tᵢ where p lies along line i, from the foot of the origin: what counts of a line is how well its
//!    distance is known at p, vᵢ = tᵢ² σ_α² - 2 tᵢ σ_αr + σ_r², and the covariance is M⁻¹ diag(v₁, v₂) M⁻ᵀ.
//! 3. A crossing of lines that hardly differ in direction, or far beyond the seen parts of both, is refused.
//!
//! Source: Pilch 2016 §3.5.1 keeps the crossings of all lines as important points; the covariance is ours.

use nalgebra::{Matrix2, Point2, Vector2};

use super::feature::LineFeature;
use crate::geom::{Segment, symmetrize};

/// Where two lines of a scan cross.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Intersection {
    /// Position, robot frame.
    pub position: Point2<f64>,
    /// Covariance of (x, y), m².
    pub cov: Matrix2<f64>,
    /// Angle between the lines, rad in (0, π/2].
    pub angle: f64,
    /// Distance from the seen part of the lines, m; 0 where both reach the point. Growing: rather a guess than a corner.
    pub extension: f64,
}

/// Which crossings are kept.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct IntersectionConfig {
    /// Least angle between the lines, rad. Default 0.35 (20°). Growing: fewer, better known points.
    pub min_angle: f64,
    /// Farthest from the seen part of either line, m. Default 0.5; infinite keeps all, as the source does.
    pub max_extension: f64,
}

impl Default for IntersectionConfig {
    fn default() -> Self {
        Self {
            min_angle: 0.35,
            max_extension: 0.5,
        }
    }
}

/// Why two lines have no usable crossing.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum IntersectionError {
    /// The lines hardly differ in direction.
    #[error("the lines differ by {angle:.3} rad in direction; expected at least {min_angle} rad")]
    Parallel {
        /// Angle between them, rad.
        angle: f64,
        /// The least angle asked for, rad.
        min_angle: f64,
    },
    /// The crossing lies where neither, or only one, was seen.
    #[error(
        "the lines cross {extension:.2} m beyond what was seen; expected at most {max_extension} m"
    )]
    Beyond {
        /// How far beyond, m.
        extension: f64,
        /// The farthest asked for, m.
        max_extension: f64,
    },
}

/// Where two lines cross.
///
/// # Errors    [`IntersectionError`]: lines too parallel, or not seen near the crossing.
pub fn intersect(
    a: &LineFeature,
    b: &LineFeature,
    config: &IntersectionConfig,
) -> Result<Intersection, IntersectionError> {
    let (na, nb) = (a.line.normal(), b.line.normal());
    let determinant = na.perp(&nb);
    let angle = libm::atan2(determinant.abs(), na.dot(&nb).abs());
    // 1e-9 keeps the inverse finite whatever is asked for.
    if angle.is_nan() || angle < config.min_angle.max(1e-9) {
        return Err(IntersectionError::Parallel {
            angle,
            min_angle: config.min_angle,
        });
    }
    let inverse = Matrix2::new(nb.y, -na.y, -nb.x, na.x) / determinant;
    let position = Point2::from(inverse * Vector2::new(a.line.r(), b.line.r()));
    let beyond = |f: &LineFeature| Segment::new(f.ends[0], f.ends[1]).distance(position);
    let extension = beyond(a).max(beyond(b));
    if extension.is_nan() || extension > config.max_extension {
        return Err(IntersectionError::Beyond {
            extension,
            max_extension: config.max_extension,
        });
    }
    let known = Matrix2::from_diagonal(&Vector2::new(
        variance_at(a, position),
        variance_at(b, position),
    ));
    let mut cov = inverse * known * inverse.transpose();
    symmetrize(&mut cov);
    Ok(Intersection {
        position,
        cov,
        angle,
        extension,
    })
}

/// The crossings of all pairs of `lines`, written to `found` (cleared first) with the numbers of both lines.
pub fn intersections(
    lines: &[LineFeature],
    config: &IntersectionConfig,
    found: &mut Vec<([usize; 2], Intersection)>,
) {
    found.clear();
    for (i, a) in lines.iter().enumerate() {
        for (j, b) in lines.iter().enumerate().skip(i + 1) {
            found.extend(intersect(a, b, config).ok().map(|point| ([i, j], point)));
        }
    }
}

/// Variance of the line's distance from a point near it, m².
fn variance_at(feature: &LineFeature, point: Point2<f64>) -> f64 {
    let t = feature.line.normal().perp(&point.coords);
    let cov = &feature.cov;
    t * t * cov[(0, 0)] - t * (cov[(0, 1)] + cov[(1, 0)]) + cov[(1, 1)]
}

#[cfg(test)]
mod tests;
