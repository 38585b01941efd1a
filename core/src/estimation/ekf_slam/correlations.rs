//! How the errors of pose and walls are correlated, as data for a plot.
//!
//! Source: TDK 2016 fig. 3.4-3.5.

use super::{LandmarkId, ROBOT};
use crate::estimation::SymmetricMatrix;

/// The matrix of correlation coefficients of the state (x, y, θ, …, α₁, r₁, α₂, r₂, …).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Correlations {
    /// Number of rows, as many as columns.
    pub n: usize,
    /// The row of the first landmark's α; those before it belong to the robot.
    pub first_landmark: usize,
    /// The landmarks in the order of their rows, two each: α, then r; for a point x, then y.
    pub landmarks: Vec<LandmarkId>,
    /// `n` rows of `n` coefficients, -1 to 1; 0 where one of the two is known exactly, also on the
    /// diagonal.
    pub coefficients: Vec<f32>,
}

impl Correlations {
    /// The correlation coefficients of the whole state, which holds these landmarks. O(n²).
    #[must_use]
    pub fn of(covariance: &SymmetricMatrix, landmarks: impl Iterator<Item = LandmarkId>) -> Self {
        let n = covariance.n();
        // Names are assigned, and rows appended, in the order of first sightings.
        let mut landmarks: Vec<_> = landmarks.collect();
        landmarks.sort_unstable();
        let cell = |i: usize| covariance.correlation(i / n, i % n) as f32;
        Self {
            n,
            first_landmark: ROBOT,
            landmarks,
            coefficients: (0..n * n).map(cell).collect(),
        }
    }
}
