//! What every registration method gets as prior, and what it returns.

use nalgebra::{Matrix3, Vector2};

use crate::geom::{Pose2, PoseEstimate};

/// The prior of the pose, before the points are matched.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Prior {
    /// The believed pose.
    pub pose: Pose2,
    /// Inverse of its covariance of (x, y, θ), in the frame of the pose's coordinates.
    pub information: Matrix3<f64>,
}

/// The verdict on a match.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Verdict {
    /// The points fix the pose.
    Converged,
    /// They do not fix the pose along this direction (unit vector in the map frame); there the
    /// prior decides.
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
    /// It converged where the clouds contradict each other: each lies where the other saw through,
    /// or nowhere near it.
    LocalMinimum {
        /// Part of the points that agree, of those that could, 0 to 1: of all, or of the points
        /// that constrain the least known direction.
        agreement: f64,
    },
    /// Another pose is as good, or may well be. The pose found is far from the start while a nearer
    /// one is as good, or while the scans show partly different things; or such scans agree about
    /// as well elsewhere.
    Ambiguous,
}

/// The result of a match.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Registration {
    /// `map_from_points`, with the covariance of points and prior together.
    pub estimate: PoseEstimate,
    /// The information of the points alone, the inverse of their covariance; zero along a
    /// degenerate direction.
    pub information: Matrix3<f64>,
    /// Points that lie on their surface.
    pub inliers: usize,
    /// Inliers as a part of all points.
    pub overlap: f64,
    /// Root of the mean squared residual of the inliers, m.
    pub residual: f64,
    /// Iterations taken.
    pub iterations: usize,
    /// How good it is.
    pub verdict: Verdict,
}
