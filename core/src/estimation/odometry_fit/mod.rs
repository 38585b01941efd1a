//! The systematic and random odometry errors of a robot, from a drive whose poses are known
//! otherwise.
//!
//! In: a [`Drive`] (what the tracks counted) and the pose at each of its scans, by SLAM or from the
//! truth. Out: an [`OdometryFit`]: how much farther each track runs than is counted, the effective
//! track width, the three coefficients of [`OdometryNoise`], and how far the poses themselves are
//! off, each with its standard error.
//!
//! 1. Scans are combined into legs of some decimetres or a fraction of a radian: there are fewer of
//!    them, and their motion is large compared with the pose errors (`drive`).
//! 2. The error of each pose as seen from the odometry is a random walk, observed with white noise.
//!    A Kalman filter over it gives the likelihood of all poses; the systematic errors of the
//!    tracks enter linearly, and follow by least squares (`likelihood`).
//! 3. The logarithms of the noise coefficients follow by Newton's method; then motions are counted
//!    again with the result, because the width enters by its reciprocal, until nothing changes
//!    (`maximum`).
//! 4. Legs that the model cannot explain (a push, tracks that spun against a wall) are left out,
//!    and counted.
//! 5. A weak prior ([`PRIOR`] for each part) covers what the drive does not show. A parameter about
//!    which the drive says less than twice as much is reported as unknown, with the reason.
//!
//! Source: Censi, Franchi, Marchionni & Oriolo (2013), "Simultaneous calibration of odometry and
//! sensor parameters for mobile robots", for the parameters and their likelihood (we know the place
//! of the sensor, and estimate the noise too); Borenstein & Feng (1996) for which errors matter;
//! Schweppe (1965), "Evaluation of likelihood functions for Gaussian signals", for the likelihood
//! by innovations. Paired increments alone would count the error of each pose twice, with opposite
//! signs.

mod drive;
mod likelihood;
mod maximum;
#[cfg(test)]
mod tests;
mod words;

use nalgebra::Matrix3;

use crate::geom::Pose2;
use crate::robot::{OdometryNoise, RobotModel, TrackWear};

pub use drive::{Drive, DriveExtent};
pub use words::FittedParameter;

/// The prior of each track and of the width: its relative standard deviation.
pub(super) const PRIOR: f64 = 0.1;

/// The odometry errors of a robot.
#[derive(Clone, Debug, PartialEq)]
pub struct OdometryFit {
    /// The robot's nominal model.
    pub model: RobotModel,
    /// How the tracks differ from the model.
    pub wear: TrackWear,
    /// Covariance of its left, right and track width.
    pub wear_cov: Matrix3<f64>,
    /// The random errors of the odometry.
    pub noise: OdometryNoise,
    /// Standard errors of the logarithms of its coefficients, in their order.
    pub noise_log_sigmas: [f64; 3],
    /// Standard deviations of the errors of the poses: position along each axis, m, and heading,
    /// rad.
    pub pose_sigmas: [f64; 2],
    /// What was driven.
    pub extent: DriveExtent,
    /// Legs that were used.
    pub legs: usize,
    /// Legs that the model could not explain.
    pub left_out: usize,
}

/// Why no fit is possible.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum OdometryFitError {
    /// The number of poses differs from that of scans.
    #[error("{poses} poses for {scans} scans of the drive")]
    Poses {
        /// Poses given.
        poses: usize,
        /// Scans of the drive.
        scans: usize,
    },
    /// A pose that is not finite.
    #[error("pose {scan} of the drive is not finite")]
    NotFinite {
        /// Number of the scan, from 0.
        scan: usize,
    },
    /// Too little was driven.
    #[error(
        "the robot drove {way:.1} m and turned {turn:.1} rad: that makes {legs} legs, expected at least {least}"
    )]
    TooShort {
        /// m.
        way: f64,
        /// rad.
        turn: f64,
        /// Legs that there are.
        legs: usize,
        /// Legs that are enough.
        least: usize,
    },
    /// No maximum of the likelihood was found.
    #[error("the poses and the odometry do not fit together: they are not of one drive")]
    NoMaximum,
}

/// The least number of legs from which noise can be estimated.
const LEAST_LEGS: usize = 20;

impl OdometryFit {
    /// Fits `drive` of a robot of this model to the poses at its scans, in any one frame.
    ///
    /// # Errors    [`OdometryFitError`].
    pub fn new(
        drive: &Drive,
        poses: &[Pose2],
        model: &RobotModel,
    ) -> Result<Self, OdometryFitError> {
        let legs = drive.legs(poses)?;
        let extent = drive.extent();
        let count = legs.iter().flatten().count();
        if count < LEAST_LEGS {
            return Err(OdometryFitError::TooShort {
                way: extent.way,
                turn: extent.turned(),
                legs: count,
                least: LEAST_LEGS,
            });
        }
        let found = maximum::find(&legs, model).ok_or(OdometryFitError::NoMaximum)?;
        Ok(Self {
            model: *model,
            wear: found.wear,
            wear_cov: found.wear_cov,
            noise: found.chance.noise(),
            noise_log_sigmas: found.noise_log_sigmas,
            pose_sigmas: found.chance.pose_sigmas(),
            extent,
            legs: count - found.left_out,
            left_out: found.left_out,
        })
    }

    /// Standard errors of left, right and track width.
    #[must_use]
    pub fn wear_sigmas(&self) -> [f64; 3] {
        [0, 1, 2].map(|i: usize| self.wear_cov[(i, i)].max(0.0).sqrt())
    }
}
