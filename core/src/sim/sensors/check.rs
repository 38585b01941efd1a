//! The figures of sensors and their ranges: one error type for all of them.

use crate::bounds::{Bounds, OutOfBounds, check};

/// Why a sensor cannot be used.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SensorError {
    /// A figure is out of its bounds.
    #[error("{sensor}: {error}")]
    Bounds {
        /// Kind of sensor.
        sensor: &'static str,
        /// The figure, its value and its bounds.
        error: OutOfBounds,
    },
    /// The calibration of the rangers is wrong.
    #[error("rangers: {0}")]
    Calibration(#[from] crate::robot::CharacteristicError),
}

/// Checks the figures of the sensor with this name.
pub(super) fn check_sensor(
    sensor: &'static str,
    figures: &[(&'static str, f64, Bounds)],
) -> Result<(), SensorError> {
    check(figures).map_err(|error| SensorError::Bounds { sensor, error })
}
