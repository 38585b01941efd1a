//! The figures of a robot as a C header, so that its firmware has the very numbers of the model.
//!
//! In: a [`RobotModel`]. Out: `gains.h`: the geometry, the limits, and the controller's gains in integers.
//!
//! Units of the firmware: counts and periods; `Q16` in a name means 16 bits behind the point.

use std::fmt::Write as _;

use crate::robot::RobotModel;
use crate::robot::controller::fixed::{
    FEEDBACK_BITS, FixedError, FixedGains, FixedMotor, INTEGRAL_UNIT, OBSERVER_BITS,
};
use crate::robot::controller::{ControllerConfig, DesignError, Gains};

/// Period of the firmware's controller, ms.
pub const PERIOD_MILLIS: u32 = 10;

/// Why there is no header for a robot.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum HeaderError {
    /// No controller.
    #[error(transparent)]
    Design(#[from] DesignError),
    /// A gain that 16 bits do not hold.
    #[error(transparent)]
    Fixed(#[from] FixedError),
}

/// The text of `gains.h`.
///
/// # Errors    [`HeaderError`]: the motors cannot be controlled, or a gain does not fit.
pub fn write(model: &RobotModel, config: &ControllerConfig) -> Result<String, HeaderError> {
    let period = f64::from(PERIOD_MILLIS) * 1e-3;
    let per_count = model.radians_per_count();
    let gains = Gains::design(&model.drive, period, per_count, config)?;
    let fixed = FixedGains::new(&model.drive, &gains, per_count)?;
    let mut text = String::from(
        "/* Made from the robot's model: cargo run -p slamlab-core --example firmware_gains > \
         bridge/firmware/gains.h\n * A test holds that it is current; do not edit it. */\n\
         #ifndef GAINS_H\n#define GAINS_H\n\n#include <stdint.h>\n\n",
    );
    for (name, value, comment) in constants(model, period) {
        let _ = writeln!(text, "#define {name} {value} /* {comment} */");
    }
    text += &arrays(&fixed);
    text += "\n#endif\n";
    Ok(text)
}

fn constants(model: &RobotModel, period: f64) -> Vec<(&'static str, i64, &'static str)> {
    let count = model.metres_per_tick;
    let half = 0.5 * model.track_width;
    let q16 = |value: f64| (value * 65_536.0).round() as i64;
    let counts = |metres: f64| metres / count;
    vec![
        (
            "PERIOD_MS",
            PERIOD_MILLIS.into(),
            "period of the controller",
        ),
        ("LENGTH_MM", q(model.length, 1e3), "of the board"),
        ("WIDTH_MM", q(model.width, 1e3), "of the board"),
        (
            "TRACK_WIDTH_MM",
            q(model.track_width, 1e3),
            "effective, when turning",
        ),
        ("COUNT_NM", q(count, 1e9), "way of a track for one count"),
        ("MAX_SPEED_MM_S", q(model.max_speed, 1e3), "of the body"),
        (
            "MAX_SPEED_Q16",
            q16(counts(model.max_speed * period)),
            "of a track, counts in a period",
        ),
        (
            "MAX_TURN_Q16",
            q16(counts(half * model.max_turn_rate * period)),
            "of a track, turning on the spot",
        ),
        (
            "ACCELERATION_Q16",
            q16(counts(model.max_acceleration * period * period)),
            "counts in a period, in a period",
        ),
        (
            "TURN_ACCELERATION_Q16",
            q16(counts(half * model.max_turn_acceleration * period * period)),
            "of a track, turning on the spot",
        ),
        (
            "SPEED_Q16_PER_MM_S_Q8",
            q(counts(1e-3 * period) * 65_536.0, 256.0),
            "times mm/s, less 8 bits: a track's speed",
        ),
        (
            "TURN_Q16_PER_MRAD_S_Q8",
            q(counts(1e-3 * half * period) * 65_536.0, 256.0),
            "times mrad/s, less 8 bits",
        ),
        (
            "WAY_Q12_PER_UM_Q16",
            q16(counts(1e-6) * 4_096.0),
            "times um, less 16 bits: counts with 12 bits",
        ),
        (
            "TURN_Q12_PER_URAD_Q16",
            q16(counts(1e-6 * half) * 4_096.0),
            "times urad, less 16 bits",
        ),
        (
            "BATTERY_MV",
            q(model.drive.battery, 1e3),
            "the voltage of full duty",
        ),
        ("OBSERVER_BITS", OBSERVER_BITS.into(), "behind the point"),
        ("FEEDBACK_BITS", FEEDBACK_BITS.into(), "behind the point"),
        ("INTEGRAL_UNIT", INTEGRAL_UNIT as i64, "counts x periods"),
    ]
}

fn q(value: f64, scale: f64) -> i64 {
    (value * scale).round() as i64
}

/// Initialisers for both motors, and the feedback.
fn arrays(fixed: &FixedGains) -> String {
    let mut text = String::from(
        "\n/* Of the left and of the right motor. Rows: angle, speed, current; columns: speed, current, load. */\n",
    );
    let mut array = |declaration: &str, rows: Vec<String>| {
        let _ = writeln!(
            text,
            "static const int16_t {declaration} = {{\n    {},\n}};",
            rows.join(",\n    ")
        );
    };
    let of_motors = |row: fn(&FixedMotor) -> String| fixed.motors.iter().map(row).collect();
    array(
        "TRANSITION[2][3][3]",
        of_motors(|m| {
            let rows: Vec<String> = m.transition.iter().map(|row| braced(row)).collect();
            format!("{{{}}}", rows.join(", "))
        }),
    );
    array("INPUT[2][3]", of_motors(|m| braced(&m.input)));
    array("OBSERVER_GAIN[2][4]", of_motors(|m| braced(&m.gain)));
    array(
        "HOLDING_CURRENT[2][2]",
        of_motors(|m| braced(&m.holding_current)),
    );
    array(
        "HOLDING_VOLTAGE[2][2]",
        of_motors(|m| braced(&m.holding_voltage)),
    );
    array(
        "FEEDBACK[2][7]",
        fixed.feedback.iter().map(|row| braced(row)).collect(),
    );
    text
}

fn braced(numbers: &[i16]) -> String {
    let numbers: Vec<String> = numbers.iter().map(i16::to_string).collect();
    format!("{{{}}}", numbers.join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_firmwares_header_is_current() {
        let committed = include_str!("../../../bridge/firmware/gains.h");
        let fresh = write(&RobotModel::rp6(), &ControllerConfig::default()).unwrap();
        assert_eq!(
            committed, fresh,
            "make it anew: cargo run -p slamlab-core --example firmware_gains > bridge/firmware/gains.h"
        );
    }

    #[test]
    fn a_robot_that_cannot_be_has_no_header() {
        let mut model = RobotModel::rp6();
        model.drive.left.inertia = 0.0;
        let error = write(&model, &ControllerConfig::default()).unwrap_err();
        assert!(error.to_string().contains("left motor"), "{error}");
    }
}
