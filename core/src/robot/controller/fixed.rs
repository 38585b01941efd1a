//! The gains in integers, for a processor without floating point.
//!
//! In: the motors and the [`Gains`] designed for them. Out: the same numbers, scaled and rounded.
//!
//! 1. Units that keep every number near one: counts for angles, counts per period for speeds,
//!    amperes for currents, volts for voltages. A load is the current that holds it; the integral
//!    of ΔΨ is in units of 64 counts x periods.
//! 2. States have 16 fractional bits, so small corrections add up instead of being lost.
//! 3. Coefficients are 16-bit numbers, with [`OBSERVER_BITS`] fractional bits in the observers and
//!    [`FEEDBACK_BITS`] where the result is a voltage. One that does not fit is an error: on the
//!    processor it would overflow silently.
//!
//! The observers of the firmware follow the angle relative to the last count, so their angle never
//! grows. The first column of the transition (1, 0, 0, 0) and the last row (0, 0, 0, 1) need no
//! numbers.

use super::Gains;
use crate::robot::{DriveTrain, MotorModel};

/// Fractional bits of the observers' coefficients.
pub const OBSERVER_BITS: u32 = 14;
/// Fractional bits of coefficients whose product is a voltage.
pub const FEEDBACK_BITS: u32 = 11;
/// Unit of the integral of ΔΨ, counts x periods.
pub const INTEGRAL_UNIT: f64 = 64.0;

/// The controller's numbers.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FixedGains {
    /// Of the left and of the right motor.
    pub motors: [FixedMotor; 2],
    /// K, a row for each voltage: (ΔΨ, Ψ'_L, i_L, Ψ'_R, i_R, z_ΔΨ, z_Ψ'); [`FEEDBACK_BITS`].
    pub feedback: [[i16; 7]; 2],
}

/// The numbers of one motor; rows are (Ψ, Ψ', i) and, for the gain, the load.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FixedMotor {
    /// Φ without its trivial parts: columns (Ψ', i, load); [`OBSERVER_BITS`].
    pub transition: [[i16; 3]; 3],
    /// Γ: what a volt adds; [`OBSERVER_BITS`].
    pub input: [i16; 3],
    /// What a count of innovation adds; [`OBSERVER_BITS`].
    pub gain: [i16; 4],
    /// Current that holds a speed, and an acceleration; [`OBSERVER_BITS`].
    pub holding_current: [i16; 2],
    /// Voltage that holds a current, and a speed; [`FEEDBACK_BITS`].
    pub holding_voltage: [i16; 2],
}

/// Why gains do not fit.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("gains in integers: {of} is {value:.4}, expected less than {most} in size")]
pub struct FixedError {
    /// Which coefficient.
    pub of: &'static str,
    /// Its value in the units above.
    pub value: f64,
    /// The largest value that 16 bits hold.
    pub most: f64,
}

/// Units of (Ψ, Ψ', i, load), SI.
type Units = [f64; 4];

impl FixedGains {
    /// Scales and rounds the gains of these motors.
    ///
    /// # Units    `radians_per_count` of a shaft, as the gains were designed for.
    /// # Errors    [`FixedError`] for a coefficient that does not fit in 16 bits.
    pub fn new(
        train: &DriveTrain,
        gains: &Gains,
        radians_per_count: f64,
    ) -> Result<Self, FixedError> {
        let h = gains.period;
        let motor = |motor: &MotorModel, side: usize| {
            let speed = radians_per_count / h;
            let units = [radians_per_count, speed, 1.0, motor.torque_constant];
            FixedMotor::new(motor, gains, side, &units)
        };
        let units = [
            radians_per_count,
            radians_per_count / h,
            1.0,
            radians_per_count / h,
            1.0,
            INTEGRAL_UNIT * radians_per_count * h,
            radians_per_count,
        ];
        let mut feedback = [[0; 7]; 2];
        for (side, row) in feedback.iter_mut().enumerate() {
            for (column, (to, unit)) in row.iter_mut().zip(units).enumerate() {
                let value = gains.feedback[(side, column)] * unit;
                *to = rounded("feedback", value, FEEDBACK_BITS)?;
            }
        }
        Ok(Self {
            motors: [motor(&train.left, 0)?, motor(&train.right, 1)?],
            feedback,
        })
    }
}

impl FixedMotor {
    fn new(
        motor: &MotorModel,
        gains: &Gains,
        side: usize,
        units: &Units,
    ) -> Result<Self, FixedError> {
        let observer = &gains.observers[side];
        let [angle, speed, ..] = *units;
        let mut fixed = Self {
            transition: [[0; 3]; 3],
            input: [0; 3],
            gain: [0; 4],
            holding_current: [0; 2],
            holding_voltage: [0; 2],
        };
        for row in 0..3 {
            for column in 0..3 {
                let value = observer.transition[(row, column + 1)] * units[column + 1] / units[row];
                fixed.transition[row][column] = rounded("transition", value, OBSERVER_BITS)?;
            }
            let value = observer.input[row] / units[row];
            fixed.input[row] = rounded("input", value, OBSERVER_BITS)?;
        }
        for (row, unit) in units.iter().enumerate() {
            let value = observer.gain[row] * angle / unit;
            fixed.gain[row] = rounded("observer gain", value, OBSERVER_BITS)?;
        }
        let (of_speed, _) = motor.to_hold(speed, 0.0, 0.0);
        let (of_acceleration, _) = motor.to_hold(0.0, speed / gains.period, 0.0);
        fixed.holding_current = [
            rounded("current of a speed", of_speed, OBSERVER_BITS)?,
            rounded("current of an acceleration", of_acceleration, OBSERVER_BITS)?,
        ];
        fixed.holding_voltage = [
            rounded("resistance", motor.resistance, FEEDBACK_BITS)?,
            rounded(
                "speed constant",
                motor.speed_constant * speed,
                FEEDBACK_BITS,
            )?,
        ];
        Ok(fixed)
    }
}

fn rounded(of: &'static str, value: f64, bits: u32) -> Result<i16, FixedError> {
    let one = f64::from(1_u32 << bits);
    let scaled = (value * one).round();
    match scaled.abs() <= f64::from(i16::MAX) {
        true => Ok(scaled as i16),
        false => Err(FixedError {
            of,
            value,
            most: f64::from(i16::MAX) / one,
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Fractional bits of states and voltages.
    const STATE_BITS: u32 = 16;
    use crate::robot::RobotModel;
    use crate::robot::controller::Observer;

    const PERIOD: f64 = 0.01;

    fn designed() -> (RobotModel, Gains, FixedGains) {
        let model = RobotModel::rp6();
        let per_count = model.radians_per_count();
        let gains = Gains::design(&model.drive, PERIOD, per_count).unwrap();
        let fixed = FixedGains::new(&model.drive, &gains, per_count).unwrap();
        (model, gains, fixed)
    }

    /// Steps with the integers, as the firmware does, next to the observer in floating point.
    #[test]
    fn the_integer_observer_follows_the_one_in_floating_point() {
        let (model, gains, fixed) = designed();
        let per_count = model.radians_per_count();
        let mut float = Observer::new(gains.observers[0]);
        let motor = &fixed.motors[0];
        let times =
            |coefficient: i16, state: i64| (state * i64::from(coefficient)) >> OBSERVER_BITS;
        let one = f64::from(1_u32 << STATE_BITS);
        // (Ψ minus the last count, Ψ', i, load).
        let (mut state, mut last) = ([0_i64; 4], 0_i64);
        for step in 0..500_i64 {
            // An oscillating speed, counted.
            let angle = 40.0 * libm::sin(0.02 * step as f64) + 3.0 * step as f64;
            let (count, voltage) = (angle.floor() as i64, 3.0 * libm::cos(0.05 * step as f64));
            let volts = (voltage * one).round() as i64;
            float.update(voltage, count as f64 * per_count);

            let row = |r: usize| {
                let of_state: i64 = (0..3)
                    .map(|c| times(motor.transition[r][c], state[c + 1]))
                    .sum();
                of_state + times(motor.input[r], volts)
            };
            let predicted = [
                state[0] + row(0) - ((count - last) << STATE_BITS),
                row(1),
                row(2),
                state[3],
            ];
            last = count;
            for (to, (gain, from)) in state.iter_mut().zip(motor.gain.iter().zip(predicted)) {
                *to = from + times(*gain, -predicted[0]);
            }
            let speed = state[1] as f64 / one * per_count / PERIOD;
            let load = state[3] as f64 / one * model.drive.left.torque_constant;
            assert!(
                (speed - float.speed()).abs() < 0.02,
                "{step}: {speed} {}",
                float.speed()
            );
            assert!(
                (load - float.load()).abs() < 2e-3,
                "{step}: {load} {}",
                float.load()
            );
            assert!((state[2] as f64 / one - float.current()).abs() < 0.01);
            let ahead = state[0] as f64 / one;
            assert!((ahead - (float.angle() / per_count - count as f64)).abs() < 0.05);
        }
    }

    #[test]
    fn rounding_takes_little_from_any_gain_and_none_away() {
        let (model, gains, fixed) = designed();
        let per_count = model.radians_per_count();
        let volts = |row: usize, column: usize| {
            f64::from(fixed.feedback[row][column]) / f64::from(1_u32 << FEEDBACK_BITS)
        };
        for row in 0..2 {
            for (column, unit) in [(0, per_count), (1, per_count / PERIOD), (6, per_count)] {
                let exact = gains.feedback[(row, column)] * unit;
                assert!((volts(row, column) - exact).abs() <= 0.5 / 2048.0 + 1e-12);
            }
            let integral = gains.feedback[(row, 5)] * 64.0 * per_count * PERIOD;
            assert!((volts(row, 5) / integral - 1.0).abs() < 0.02, "{integral}");
        }
    }

    #[test]
    fn what_does_not_fit_is_named() {
        let (model, mut gains, _) = designed();
        gains.feedback[(1, 1)] = 1e4;
        let error = FixedGains::new(&model.drive, &gains, model.radians_per_count()).unwrap_err();
        assert_eq!((error.of, error.most), ("feedback", 32767.0 / 2048.0));
    }
}
