//! Figures of sensors and the ranges that they may have: one piece for all of them.

/// Why a sensor cannot be used.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SensorError {
    /// A figure outside of its range.
    #[error("{sensor}: {field} is {value}, expected {expected}")]
    Value {
        /// Kind of sensor.
        sensor: &'static str,
        /// The figure.
        field: &'static str,
        /// What stands there.
        value: f64,
        /// What may stand there.
        expected: String,
    },
    /// The calibration of the rangers.
    #[error("rangers: {0}")]
    Calibration(#[from] crate::robot::CharacteristicError),
}

/// Checks the figures of the sensor of this name.
pub(super) struct Check(pub(super) &'static str);

impl Check {
    pub(super) fn within(
        &self,
        field: &'static str,
        value: f64,
        [low, high]: [f64; 2],
    ) -> Result<(), SensorError> {
        let fits = (low..=high).contains(&value);
        self.that(fits, field, value, || format!("{low} to {high}"))
    }

    /// More than 0 and finite.
    pub(super) fn positive(&self, field: &'static str, value: f64) -> Result<(), SensorError> {
        let fits = value > 0.0 && value.is_finite();
        self.that(fits, field, value, || "more than 0 and finite".to_owned())
    }

    /// At least 0 and finite.
    pub(super) fn size(&self, field: &'static str, value: f64) -> Result<(), SensorError> {
        let fits = value >= 0.0 && value.is_finite();
        self.that(fits, field, value, || "at least 0 and finite".to_owned())
    }

    /// A part of the readings.
    pub(super) fn part(&self, field: &'static str, value: f64) -> Result<(), SensorError> {
        self.within(field, value, [0.0, 1.0])
    }

    /// `min_range` and `max_range`.
    pub(super) fn ranges(&self, min: f64, max: f64, most: f64) -> Result<(), SensorError> {
        self.size("min_range", min)?;
        let expected = || format!("more than min_range and at most {most} m");
        self.that(max > min && max <= most, "max_range", max, expected)
    }

    pub(super) fn that(
        &self,
        fits: bool,
        field: &'static str,
        value: f64,
        expected: impl FnOnce() -> String,
    ) -> Result<(), SensorError> {
        if fits {
            return Ok(());
        }
        Err(SensorError::Value {
            sensor: self.0,
            field,
            value,
            expected: expected(),
        })
    }
}
