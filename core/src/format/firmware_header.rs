//! The figures of a robot as a C header, which gives its firmware exactly the numbers of the model.
//!
//! In: a [`RobotModel`]. Out: `gains.h`: the geometry, the limits, and the controller's gains in
//! integers.
//!
//! Units of the firmware: counts and periods; `Q16` in a name means 16 fractional bits.

use std::fmt::Write as _;

use crate::robot::RobotModel;
use crate::robot::controller::fixed::{
    FEEDBACK_BITS, FixedError, FixedGains, FixedMotor, INTEGRAL_UNIT, OBSERVER_BITS,
};
use crate::robot::controller::{DesignError, Gains};

/// Period of the firmware's controller, ms.
pub const PERIOD_MILLIS: u32 = 10;

/// Why no header can be written for a robot.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum HeaderError {
    /// The controller cannot be designed.
    #[error(transparent)]
    Design(#[from] DesignError),
    /// A gain that does not fit in 16 bits.
    #[error(transparent)]
    Fixed(#[from] FixedError),
}

/// The text of `gains.h`.
///
/// # Errors    [`HeaderError`]: the motors cannot be controlled, or a gain does not fit.
pub fn write(model: &RobotModel) -> Result<String, HeaderError> {
    let period = f64::from(PERIOD_MILLIS) * 1e-3;
    let per_count = model.radians_per_count();
    let gains = Gains::design(&model.drive, period, per_count)?;
    let fixed = FixedGains::new(&model.drive, &gains, per_count)?;
    let mut text = String::from(
        "/* Made from the robot's model; do not edit it: a test holds that it is current.\n \
         * cargo run -p slamlab-core --example firmware_gains > bridge/firmware/gains.h */\n\
         #ifndef GAINS_H\n#define GAINS_H\n\n#include <stdint.h>\n\n",
    );
    text += &constants(model, period);
    text += &arrays(&fixed);
    text += "\n#endif\n";
    Ok(text)
}

fn constants(model: &RobotModel, period: f64) -> String {
    let half = 0.5 * model.track_width;
    let counts = |metres: f64| metres / model.metres_per_tick;
    let whole = |value: f64| value.round() as i64;
    let thousandths = |value: f64| whole(value * 1e3);
    let q16 = |value: f64| whole(value * 65_536.0);
    let (length, width) = (thousandths(model.length), thousandths(model.width));
    let track_width = thousandths(model.track_width);
    let count = whole(model.metres_per_tick * 1e9);
    let max_speed = thousandths(model.max_speed);
    let battery = thousandths(model.drive.battery);
    let speed = q16(counts(model.max_speed * period));
    let turn = q16(counts(half * model.max_turn_rate * period));
    let acceleration = q16(counts(model.max_acceleration * period * period));
    let turn_acceleration = q16(counts(half * model.max_turn_acceleration * period * period));
    let by_speed = whole(counts(1e-3 * period) * 65_536.0 * 256.0);
    let by_turn = whole(counts(1e-3 * half * period) * 65_536.0 * 256.0);
    let by_way = q16(counts(1e-6) * 4_096.0);
    let by_angle = q16(counts(1e-6 * half) * 4_096.0);
    format!(
        "#define PERIOD_MS {PERIOD_MILLIS} /* period of the controller */
#define LENGTH_MM {length} /* of the board */
#define WIDTH_MM {width} /* of the board */
#define TRACK_WIDTH_MM {track_width} /* effective, when turning */
#define COUNT_NM {count} /* way of a track for one count */
#define MAX_SPEED_MM_S {max_speed} /* of the body */
#define MAX_SPEED_Q16 {speed} /* of a track, counts in a period */
#define MAX_TURN_Q16 {turn} /* of a track, turning on the spot */
#define ACCELERATION_Q16 {acceleration} /* counts in a period, in a period */
#define TURN_ACCELERATION_Q16 {turn_acceleration} /* of a track, turning on the spot */
#define SPEED_Q16_PER_MM_S_Q8 {by_speed} /* times mm/s, less 8 bits: a track's speed */
#define TURN_Q16_PER_MRAD_S_Q8 {by_turn} /* times mrad/s, less 8 bits */
#define WAY_Q12_PER_UM_Q16 {by_way} /* times um, less 16 bits: counts with 12 bits */
#define TURN_Q12_PER_URAD_Q16 {by_angle} /* times urad, less 16 bits */
#define BATTERY_MV {battery} /* the voltage of full duty */
#define OBSERVER_BITS {OBSERVER_BITS} /* behind the point */
#define FEEDBACK_BITS {FEEDBACK_BITS} /* behind the point */
#define INTEGRAL_UNIT {INTEGRAL_UNIT} /* counts x periods */
"
    )
}

/// Initialisers for both motors, and the feedback.
fn arrays(fixed: &FixedGains) -> String {
    let mut text = String::from(
        "\n/* Of the left and the right motor. Rows: angle, speed, current; columns: speed, current, load. */\n",
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
    let (current, voltage) = ("HOLDING_CURRENT[2][2]", "HOLDING_VOLTAGE[2][2]");
    array(current, of_motors(|m| braced(&m.holding_current)));
    array(voltage, of_motors(|m| braced(&m.holding_voltage)));
    array(
        "FEEDBACK[2][7]",
        fixed.feedback.map(|row| braced(&row)).to_vec(),
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
        let fresh = write(&RobotModel::rp6()).unwrap();
        assert_eq!(
            committed, fresh,
            "make it again: cargo run -p slamlab-core --example firmware_gains > bridge/firmware/gains.h"
        );
    }

    #[test]
    fn a_robot_that_cannot_be_has_no_header() {
        let mut model = RobotModel::rp6();
        model.drive.left.inertia = 0.0;
        let error = write(&model).unwrap_err();
        assert!(error.to_string().contains("left motor"), "{error}");
    }
}
