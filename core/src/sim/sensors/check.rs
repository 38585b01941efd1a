//! Figures of sensors and what they may be: one piece for all of them.

use crate::bounds::{Bounds, OutOfBounds, check};

/// Why a sensor cannot be used.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SensorError {
    /// A figure outside of its bounds.
    #[error("{sensor}: {error}")]
    Bounds {
        /// Kind of sensor.
        sensor: &'static str,
        /// The figure, what it is and what it may be.
        error: OutOfBounds,
    },
    /// The calibration of the rangers.
    #[error("rangers: {0}")]
    Calibration(#[from] crate::robot::CharacteristicError),
}

/// Checks the figures of the sensor of this name.
pub(super) fn check_sensor(
    sensor: &'static str,
    figures: &[(&'static str, f64, Bounds)],
) -> Result<(), SensorError> {
    check(figures).map_err(|error| SensorError::Bounds { sensor, error })
}
