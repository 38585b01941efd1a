//! Covariances, and the estimate that carries one.

use nalgebra::{Matrix2, Matrix3, Point2, SMatrix};

use super::{Pose2, wrap};

/// 95 % quantile of χ² with 2 degrees of freedom.
pub const CHI2_2DOF_95: f64 = 5.991_464_547_107_979;
/// 99 % quantile of χ² with 2 degrees of freedom.
pub const CHI2_2DOF_99: f64 = 9.210_340_371_976_18;

/// A pose and how well it is known: covariance of (x, y, θ) in the frame of the pose's coordinates, m², m·rad, rad².
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

    /// Normalised estimation error squared against the true pose; χ² with 3 degrees of freedom if the covariance is
    /// honest. `None` while the covariance is singular, as it is before the first motion.
    ///
    /// Source: Bar-Shalom, Li & Kirubarajan (2001), eq. (5.4.2-1).
    #[must_use]
    pub fn nees(&self, truth: &Pose2) -> Option<f64> {
        let error = nalgebra::Vector3::new(
            self.pose.x() - truth.x(),
            self.pose.y() - truth.y(),
            wrap(self.pose.heading() - truth.heading()),
        );
        let solved = self.cov.cholesky()?.solve(&error);
        Some(error.dot(&solved))
    }

    /// The 95 % confidence ellipse of the position.
    #[must_use]
    pub fn ellipse95(&self) -> Ellipse {
        let cov = self.cov.fixed_view::<2, 2>(0, 0).into_owned();
        Ellipse::of_covariance(self.pose.position(), &cov, CHI2_2DOF_95)
    }
}

/// An ellipse: centre, semi-axes (m, the longer first), direction of the longer one (rad).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ellipse {
    /// Centre.
    pub centre: Point2<f64>,
    /// Longer semi-axis, m.
    pub major: f64,
    /// Shorter semi-axis, m.
    pub minor: f64,
    /// Direction of the longer axis, rad in (-π/2, π/2].
    pub angle: f64,
}

impl Ellipse {
    /// The ellipse (p - c)ᵀ C⁻¹ (p - c) = `chi2`. Semi-axes are √(chi2 λ): the factor 2 of the source makes full axes
    /// (erratum to TDK 2016, see the specification).
    #[must_use]
    pub fn of_covariance(centre: Point2<f64>, cov: &Matrix2<f64>, chi2: f64) -> Self {
        let mean = 0.5 * (cov[(0, 0)] + cov[(1, 1)]);
        let half = 0.5 * (cov[(0, 0)] - cov[(1, 1)]);
        let off = 0.5 * (cov[(0, 1)] + cov[(1, 0)]);
        let spread = libm::hypot(half, off);
        Self {
            centre,
            major: (chi2 * (mean + spread).max(0.0)).sqrt(),
            minor: (chi2 * (mean - spread).max(0.0)).sqrt(),
            angle: 0.5 * libm::atan2(off, half),
        }
    }
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
    fn ellipse_of_a_diagonal_covariance_has_its_standard_deviations_as_axes() {
        let e = Ellipse::of_covariance(Point2::origin(), &Matrix2::new(1.0, 0.0, 0.0, 4.0), 1.0);
        assert!((e.major - 2.0).abs() < 1e-12 && (e.minor - 1.0).abs() < 1e-12);
        assert!((e.angle.abs() - std::f64::consts::FRAC_PI_2).abs() < 1e-12);
    }

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
    fn chi2_quantiles_are_those_of_the_closed_form() {
        // With 2 degrees of freedom the distribution function is 1 - exp(-x/2).
        assert!((CHI2_2DOF_95 + 2.0 * libm::log(0.05)).abs() < 1e-9);
        assert!((CHI2_2DOF_99 + 2.0 * libm::log(0.01)).abs() < 1e-9);
    }
}
