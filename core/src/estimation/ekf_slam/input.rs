//! What the filter takes in, and why it refuses the rest.

use crate::features::LineFeature;
use crate::robot::Odometry;

/// Why the filter refused an input; the state is untouched.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum EkfError {
    /// Odometry with a number that is not finite, or with a negative variance.
    #[error(
        "odometry from {from:.3} s to {to:.3} s: {what}; expected finite numbers and variances of at least 0"
    )]
    Odometry {
        /// Start of the motion, s.
        from: f64,
        /// End of the motion, s.
        to: f64,
        /// The part at fault.
        what: &'static str,
    },
    /// A line with a number that is not finite, or a covariance that is not positive definite.
    #[error("feature {feature}: {what}")]
    Feature {
        /// Index in the scan's list.
        feature: usize,
        /// The part at fault.
        what: &'static str,
    },
}

pub(in crate::estimation) fn check_odometry(odometry: &Odometry) -> Result<(), EkfError> {
    let error = |what| {
        Err(EkfError::Odometry {
            from: odometry.from.seconds(),
            to: odometry.to.seconds(),
            what,
        })
    };
    let motion = &odometry.motion;
    if !(motion.x() + motion.y() + motion.heading()).is_finite() {
        return error("the motion is not finite");
    }
    if !odometry.cov.iter().all(|v| v.is_finite()) {
        return error("the covariance is not finite");
    }
    if odometry.cov.diagonal().iter().any(|&v| v < 0.0) {
        return error("a variance is negative");
    }
    Ok(())
}

pub(in crate::estimation) fn check_feature(
    index: usize,
    feature: &LineFeature,
) -> Result<(), EkfError> {
    let error = |what| {
        Err(EkfError::Feature {
            feature: index,
            what,
        })
    };
    let numbers = [feature.line.alpha(), feature.line.r()];
    let ends = feature.ends.iter().flat_map(|end| end.iter().copied());
    if !numbers.into_iter().chain(ends).all(f64::is_finite) {
        return error("alpha, r or an end is not finite");
    }
    let c = &feature.cov;
    let determinant = c[(0, 0)] * c[(1, 1)] - c[(0, 1)] * c[(1, 0)];
    if !(c[(0, 0)] > 0.0 && determinant > 0.0 && determinant.is_finite()) {
        return error("the covariance of (alpha, r) is not finite and positive definite");
    }
    Ok(())
}
