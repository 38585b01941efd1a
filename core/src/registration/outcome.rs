//! What every registration method is given of the pose beforehand, and what it answers.

use nalgebra::{Matrix3, Vector2};

use crate::geom::{Pose2, PoseEstimate};

/// What is believed of the pose before the points are asked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Prior {
    /// The believed pose.
    pub pose: Pose2,
    /// Inverse of its covariance of (x, y, θ), in the frame of the pose's coordinates.
    pub information: Matrix3<f64>,
}

/// What a match is worth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Verdict {
    /// The points fix the pose.
    Converged,
    /// They do not say how far along this direction (unit vector in the map frame); there the prior
    /// stands.
    Degenerate {
        /// The direction.
        direction: Vector2<f64>,
    },
    /// Too few points lie on a surface.
    TooFewPoints {
        /// How many did.
        found: usize,
    },
    /// The last step was still large.
    NotConverged,
    /// It came to rest where the clouds contradict each other: each lies where the other saw
    /// through, or nowhere near it.
    LocalMinimum {
        /// Part of the points that could agree and do, 0 to 1: of all, or of those that tell of the
        /// way of which least is told.
        agreement: f64,
    },
    /// Another pose is as good, or may well be: it lies far from the start while one nearer to it
    /// is as good, or while the scans show partly different things; or of such scans about as much
    /// agrees elsewhere.
    Ambiguous,
}

/// The result of a match.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Registration {
    /// `map_from_points`, with the covariance of points and prior together.
    pub estimate: PoseEstimate,
    /// What the points alone say: the inverse of their covariance; nothing along a degenerate
    /// direction.
    pub information: Matrix3<f64>,
    /// Points that lie on their surface.
    pub inliers: usize,
    /// Inliers as a part of all points.
    pub overlap: f64,
    /// Root of the mean squared residual of the inliers, m.
    pub residual: f64,
    /// Iterations taken.
    pub iterations: usize,
    /// What it is worth.
    pub verdict: Verdict,
}
