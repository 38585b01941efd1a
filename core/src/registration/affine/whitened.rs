//! A cloud shifted and scaled to mean 0 and covariance 1.

use nalgebra::{Complex, Matrix2, Point2, Vector2};

use super::super::first_too_far;
use super::AffineError;

/// A cloud whose width is below this part of its length lies on a line.
const THINNEST: f64 = 1e-6;

/// A whitened cloud, and the way back: x = mean + factor · z.
#[derive(Clone, Debug)]
pub(super) struct Whitened {
    /// z = x + iy of each point.
    pub(super) points: Vec<Complex<f64>>,
    pub(super) mean: Vector2<f64>,
    /// L of the covariance L Lᵀ.
    pub(super) factor: Matrix2<f64>,
    pub(super) inverse_factor: Matrix2<f64>,
}

impl Whitened {
    pub(super) fn of(cloud: &[Point2<f64>], name: &'static str) -> Result<Self, AffineError> {
        if cloud.len() < 3 {
            return Err(AffineError::TooFewPoints {
                cloud: name,
                found: cloud.len(),
            });
        }
        if let Some(index) = first_too_far(cloud) {
            return Err(AffineError::NotFinite { cloud: name, index });
        }
        let count = cloud.len() as f64;
        let mean = cloud.iter().map(|p| p.coords).sum::<Vector2<f64>>() / count;
        let off = || cloud.iter().map(|p| p.coords - mean);
        let cov = off().map(|d| d * d.transpose()).sum::<Matrix2<f64>>() / count;
        let on_a_line = AffineError::OnALine { cloud: name };
        // The product of the variances along both axes, compared with the square of their mean.
        let size = 0.5 * cov.trace();
        let is_thin = cov.determinant() <= THINNEST * THINNEST * size * size;
        let cholesky = cov.cholesky().filter(|_| !is_thin).ok_or(on_a_line)?;
        let factor = cholesky.l();
        let inverse_factor = factor.try_inverse().ok_or(on_a_line)?;
        let whiten = |d: Vector2<f64>| {
            let z = inverse_factor * d;
            Complex::new(z.x, z.y)
        };
        Ok(Self {
            points: off().map(whiten).collect(),
            mean,
            factor,
            inverse_factor,
        })
    }
}
