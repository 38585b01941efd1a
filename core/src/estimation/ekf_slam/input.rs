//! What the filter accepts as input, and why it refuses the rest.

use nalgebra::Matrix2;

use crate::bounds::OutOfBounds;
use crate::features::{LineFeature, PointFeature, PointKind};
use crate::robot::OdometryError;

/// Why the filter refused an input; the state is untouched.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum EkfError {
    /// Odometry that is not a valid motion.
    #[error(transparent)]
    Odometry(#[from] OdometryError),
    /// A prior map whose walls are too long, or too far away, to be held in pieces.
    #[error(
        "{what} is {value}; expected at most {most}; with known.by = 0 the robot is found by lines, however large the map"
    )]
    PriorMap {
        /// The figure that is wrong.
        what: &'static str,
        /// Its value.
        value: f64,
        /// The most it may be.
        most: f64,
    },
    /// A prior map with more poses than a histogram may hold.
    #[error(
        "the prior map is too large for a histogram: {poses:.0} poses, at most {most:.0}; \
         particle-localisation finds the robot in larger ones"
    )]
    TooManyPoses {
        /// Cells of poses that the map spans.
        poses: f64,
        /// The most that there may be.
        most: f64,
    },
    /// A value of a configuration, a start or a prior that is out of its bounds.
    #[error(transparent)]
    Bounds(#[from] OutOfBounds),
    /// A point with a number that is not finite, or a covariance that is not positive definite.
    #[error("point {point}: {what}")]
    Point {
        /// Index in the scan's list of points.
        point: usize,
        /// The part that is wrong.
        what: &'static str,
    },
    /// A line with a number that is not finite, or a covariance that is not positive definite.
    #[error("feature {feature}: {what}")]
    Feature {
        /// Index in the scan's list.
        feature: usize,
        /// The part that is wrong.
        what: &'static str,
    },
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
    if !is_covariance(&feature.cov) {
        return error("the covariance of (alpha, r) is not finite and positive definite");
    }
    Ok(())
}

pub(super) fn check_point(index: usize, point: &PointFeature) -> Result<(), EkfError> {
    let error = |what| Err(EkfError::Point { point: index, what });
    let of_kind = match point.kind {
        PointKind::Circle { radius, var_radius } => [radius, var_radius],
        _ => [0.0; 2],
    };
    let numbers = point.position.iter().chain(&of_kind);
    if !numbers.copied().all(f64::is_finite) {
        return error("the position or the radius is not finite");
    }
    if of_kind[1] < 0.0 {
        return error("the variance of the radius is negative");
    }
    if !is_covariance(&point.cov) {
        return error("the covariance of the position is not finite and positive definite");
    }
    Ok(())
}

fn is_covariance(c: &Matrix2<f64>) -> bool {
    let determinant = c[(0, 0)] * c[(1, 1)] - c[(0, 1)] * c[(1, 0)];
    c[(0, 0)] > 0.0 && determinant > 0.0 && determinant.is_finite()
}
