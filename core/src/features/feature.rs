//! A wall as one scan shows it.

use nalgebra::{Matrix2, Point2, Vector2};

use crate::geom::{Length, Line};

/// A wall as one scan shows it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LineFeature {
    /// The line in the robot frame.
    pub line: Line,
    /// Covariance of (α, r), rad², rad·m, m².
    pub cov: Matrix2<f64>,
    /// Where the seen part begins and ends, on the line, in the order of the beams, robot frame.
    pub ends: [Point2<f64>; 2],
    /// Whether the sensor looked from the robot origin's side of the line. False only if the line
    /// passes between the two.
    pub seen_from_origin_side: bool,
    /// Index of the first beam on it in the scan; may be greater than `last_beam` if the line goes
    /// past the end of the scan.
    pub first_beam: usize,
    /// Index of the last beam on it.
    pub last_beam: usize,
    /// How many beams the fit used.
    pub n_points: usize,
    /// Σ d²/σ_d² of the residuals: χ² with `n_points - 2` degrees of freedom on a flat wall.
    pub chi2: f64,
    /// How (α, r) change if the heading was off by 1 rad at the first beam, and at the last, fading
    /// to zero at the middle one: what slipping tracks do to a wall while a turning lidar sweeps
    /// over it. rad/rad, m/rad.
    pub by_heading: [Vector2<f64>; 2],
}

impl LineFeature {
    /// Length of the seen part, m.
    #[must_use]
    pub fn length(&self) -> f64 {
        let [a, b] = self.ends;
        (b - a).length()
    }
}
