//! How the errors of pose and walls hang together, as data for a picture.
//!
//! Source: TDK 2016 fig. 3.4-3.5.

use super::{EkfSlam, LandmarkId};

/// The matrix of correlation coefficients of the state (x, y, θ, …, α₁, r₁, α₂, r₂, …).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Correlations {
    /// Number of rows, as many as columns.
    pub n: usize,
    /// The row of the first landmark's α; those before it belong to the robot.
    pub first_landmark: usize,
    /// The landmarks in the order of their rows, two each: α, then r.
    pub landmarks: Vec<LandmarkId>,
    /// `n` rows of `n` coefficients, -1 to 1; 0 where one of the two is known exactly, the diagonal then too.
    pub coefficients: Vec<f32>,
}

impl EkfSlam {
    /// The correlation coefficients of the whole state at the last scan. O(n²).
    #[must_use]
    pub fn correlations(&self) -> Correlations {
        let n = self.cov.n();
        let cell = |i: usize| self.covariance().correlation(i / n, i % n) as f32;
        Correlations {
            n,
            first_landmark: super::ROBOT,
            landmarks: self.landmarks.iter().map(|entry| entry.id).collect(),
            coefficients: (0..n * n).map(cell).collect(),
        }
    }
}
