//! What the filter takes in, and why it refuses the rest.

use crate::association::AssociationError;
use crate::features::LineFeature;
use crate::registration::LocateError;
use crate::robot::OdometryError;

/// Why the filter refused an input; the state is untouched.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum EkfError {
    /// Odometry that is no motion.
    #[error(transparent)]
    Odometry(#[from] OdometryError),
    /// A setting of [`super::EkfConfig`] out of range.
    #[error("{field} is {value}; expected {expected}")]
    Setting {
        /// Its name.
        field: &'static str,
        /// Its value.
        value: f64,
        /// What it may be.
        expected: &'static str,
    },
    /// How sightings are to be matched makes no sense.
    #[error(transparent)]
    Association(#[from] AssociationError),
    /// A line with a number that is not finite, or a covariance that is not positive definite.
    #[error("feature {feature}: {what}")]
    Feature {
        /// Index in the scan's list.
        feature: usize,
        /// The part at fault.
        what: &'static str,
    },
}

impl From<LocateError> for EkfError {
    fn from(error: LocateError) -> Self {
        let LocateError {
            field,
            value,
            expected,
        } = error;
        Self::Setting {
            field,
            value,
            expected,
        }
    }
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
