//! One measured motion: its error, and the derivatives of the error.
//!
//! In: the poses at both ends. Out: the error (x, y, θ) with its Jacobians.

use nalgebra::{Matrix3, Vector3};

use crate::geom::{Pose2, symmetrize};

/// A measured motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Edge {
    /// The pose it starts from.
    pub from: usize,
    /// The pose it leads to.
    pub to: usize,
    /// `from_from_to`, as measured.
    pub motion: Pose2,
    /// Inverse of the covariance of the error, in the frame of the measured `to`.
    pub information: Matrix3<f64>,
    /// Scale of the Cauchy kernel that reduces the weight of large errors, in units of χ, the
    /// normalised error; `None` gives all errors full weight.
    pub cauchy: Option<f64>,
}

impl Edge {
    pub(super) fn error(&self, from: &Pose2, to: &Pose2) -> Vector3<f64> {
        let off = self.motion.delta_to(&from.delta_to(to));
        Vector3::new(off.x(), off.y(), off.heading())
    }

    /// Derivatives of the error with respect to (x, y, θ) of the start and of the end.
    pub(super) fn jacobians(&self, from: &Pose2, to: &Pose2) -> (Matrix3<f64>, Matrix3<f64>) {
        // Rzᵀ Rᵢᵀ is a rotation by minus both headings.
        let (cos, sin) = (*from * self.motion).cos_sin();
        let (dx, dy) = (to.x() - from.x(), to.y() - from.y());
        let by_to = Matrix3::new(cos, sin, 0.0, -sin, cos, 0.0, 0.0, 0.0, 1.0);
        let mut by_from = -by_to;
        by_from[(0, 2)] = -sin * dx + cos * dy;
        by_from[(1, 2)] = -cos * dx - sin * dy;
        (by_from, by_to)
    }
}

/// Converts the information of an error of (x, y, θ) of the motion itself to that of an error in
/// the frame of the measured `to`.
#[must_use]
pub fn information_at_end(motion: &Pose2, information: &Matrix3<f64>) -> Matrix3<f64> {
    let turn = motion.rotation();
    let mut turned = turn.transpose() * information * turn;
    symmetrize(&mut turned);
    turned
}
