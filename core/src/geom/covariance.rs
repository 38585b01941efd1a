//! Covariances, and the estimate that carries one.

use nalgebra::{Matrix3, SMatrix, Vector3};

use super::Pose2;

/// 99 % quantile of χ² with 2 degrees of freedom.
pub const CHI2_2DOF_99: f64 = 9.210_340_371_976_18;

/// A pose and how well it is known: covariance of (x, y, θ) in the frame of the pose's coordinates,
/// m², m·rad, rad².
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PoseEstimate {
    /// The estimated pose.
    pub pose: Pose2,
    /// Covariance of (x, y, θ).
    pub cov: Matrix3<f64>,
}

impl PoseEstimate {
    /// A pose known exactly.
    #[must_use]
    pub fn exact(pose: Pose2) -> Self {
        Self {
            pose,
            cov: Matrix3::zeros(),
        }
    }

    /// Normalised estimation error squared against the true pose; χ² with 3 degrees of freedom if
    /// the covariance is honest. `None` while the covariance is singular, as it is before the first
    /// motion.
    ///
    /// Source: Bar-Shalom, Li & Kirubarajan (2001), eq. (5.4.2-1).
    #[must_use]
    pub fn nees(&self, truth: &Pose2) -> Option<f64> {
        let error = self.pose.minus(truth);
        let solved = self.cov.cholesky()?.solve(&error);
        Some(error.dot(&solved))
    }
}

/// Covariance of (x, y, θ) with independent standard deviations of `way` m and `turn` rad.
#[must_use]
pub fn pose_cov(way: f64, turn: f64) -> Matrix3<f64> {
    Matrix3::from_diagonal(&Vector3::new(way * way, way * way, turn * turn))
}

/// Makes a matrix symmetric to the bit by averaging it with its transpose.
pub fn symmetrize<const N: usize>(matrix: &mut SMatrix<f64, N, N>) {
    for row in 0..N {
        for column in 0..row {
            let mean = 0.5 * (matrix[(row, column)] + matrix[(column, row)]);
            matrix[(row, column)] = mean;
            matrix[(column, row)] = mean;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nees_of_one_sigma_along_one_axis_is_one() {
        let estimate = PoseEstimate {
            pose: Pose2::new(0.1, 0.0, 0.0),
            cov: Matrix3::from_diagonal(&nalgebra::Vector3::new(0.01, 0.02, 0.03)),
        };
        let nees = estimate.nees(&Pose2::identity()).unwrap();
        assert!((nees - 1.0).abs() < 1e-12);
        assert!(
            PoseEstimate::exact(Pose2::identity())
                .nees(&Pose2::identity())
                .is_none()
        );
    }

    #[test]
    fn chi2_quantile_is_that_of_the_closed_form() {
        // With 2 degrees of freedom the distribution function is 1 - exp(-x/2).
        assert!((CHI2_2DOF_99 + 2.0 * libm::log(0.01)).abs() < 1e-9);
    }
}
