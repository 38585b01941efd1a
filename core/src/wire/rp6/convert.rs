//! Converts units: millimetres, milliradians and counts on the wire; metres, radians and poses
//! inside.
//!
//! In: commands of the core, telemetry. Out: commands of the wire, odometry with covariance.
//!
//! 1. A command that the wire cannot hold is refused and named; nothing is silently clamped.
//! 2. The counts wrap after 2³¹ and the robot's clock after 49 days. Differences are taken modulo
//!    2³², so both continue correctly.
//! 3. Counts become metres by the [`RobotModel`], whose figures the robot's [`Hello`] can replace.

use super::{Command, Hello, Ranger, Telemetry};
use crate::robot::{self, Adc, Odometry, RobotModel, Stamp, TrackOdometry};

/// The converter of the battery voltage: 10 bits over 5 V, behind a divider by two.
///
/// Source: the RP6's own display of its battery, counts / 102.4.
pub const BATTERY_ADC: Adc = Adc {
    bits: 10,
    reference: 10.0,
};

/// Why a command does not fit on the wire.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("RP6 command: {field} is {value}, expected {least} to {most}")]
pub struct CommandError {
    /// The figure.
    pub field: &'static str,
    /// Its value, SI.
    pub value: f64,
    /// The least that fits.
    pub least: f64,
    /// The most that fits.
    pub most: f64,
}

impl TryFrom<&robot::Command> for Command {
    type Error = CommandError;

    /// `Scan` becomes a sweep of the servo over a quarter turn in steps of 2°, which four rangers
    /// make a whole turn.
    fn try_from(command: &robot::Command) -> Result<Self, CommandError> {
        Ok(match *command {
            robot::Command::Stop => Self::Stop,
            robot::Command::Velocity { forward, turn } => Self::Velocity {
                forward_mm_s: small("forward speed, m/s", forward)?,
                turn_mrad_s: small("turn rate, rad/s", turn)?,
            },
            robot::Command::Forward(way) => Self::Forward {
                way_um: large("way, m", way)?,
            },
            robot::Command::Turn(angle) => Self::Turn {
                angle_urad: large("angle, rad", angle)?,
            },
            robot::Command::Scan => Self::Sweep {
                from_mrad: -785,
                to_mrad: 751,
                step_mrad: 35,
            },
        })
    }
}

/// Thousandths in 16 bits.
fn small(field: &'static str, value: f64) -> Result<i16, CommandError> {
    within(field, value, 1e3, f64::from(i16::MAX)).map(|scaled| scaled as i16)
}

/// Millionths in 32 bits.
fn large(field: &'static str, value: f64) -> Result<i32, CommandError> {
    within(field, value, 1e6, f64::from(i32::MAX)).map(|scaled| scaled as i32)
}

fn within(field: &'static str, value: f64, scale: f64, most: f64) -> Result<f64, CommandError> {
    let scaled = (value * scale).round();
    // NaN fails this comparison.
    match scaled.abs() <= most {
        true => Ok(scaled),
        false => Err(CommandError {
            field,
            value,
            least: -most / scale,
            most: most / scale,
        }),
    }
}

impl Hello {
    /// The RP6's model with the geometry that this robot reports; a figure of 0 is unknown to it.
    #[must_use]
    pub fn model(&self) -> RobotModel {
        let mut model = RobotModel::rp6();
        let set = |figure: &mut f64, value: f64| {
            if value > 0.0 {
                *figure = value;
            }
        };
        set(&mut model.length, 1e-3 * f64::from(self.length_mm));
        set(&mut model.width, 1e-3 * f64::from(self.width_mm));
        set(
            &mut model.track_width,
            1e-3 * f64::from(self.track_width_mm),
        );
        set(&mut model.metres_per_tick, 1e-9 * f64::from(self.count_nm));
        set(&mut model.max_speed, 1e-3 * f64::from(self.max_speed_mm_s));
        model
    }
}

impl Telemetry {
    /// Battery voltage, V.
    #[must_use]
    pub fn battery_volts(&self) -> f64 {
        BATTERY_ADC.volts(self.battery_adc.into())
    }
}

impl Ranger {
    /// Voltage of the ranger, V.
    #[must_use]
    pub fn volts(&self) -> f64 {
        Adc::rp6().volts(self.adc.into())
    }

    /// Angle of the servo, rad, counter-clockwise from straight ahead.
    #[must_use]
    pub fn servo_angle(&self) -> f64 {
        1e-3 * f64::from(self.servo_mrad)
    }
}

/// Computes odometry from telemetry.
#[derive(Clone, Debug)]
pub struct Odometer {
    tracks: TrackOdometry,
    last: Option<Telemetry>,
    stamp: Stamp,
    counts: [i64; 2],
}

impl Odometer {
    /// For a robot with these figures.
    #[must_use]
    pub fn new(model: &RobotModel) -> Self {
        Self {
            tracks: TrackOdometry::new(model),
            last: None,
            stamp: Stamp(0),
            counts: [0; 2],
        }
    }

    /// The motion since the last telemetry, in the robot's own time, continued where its clock
    /// wraps; the first one is zero. `None` for telemetry that is not later than the last: it came
    /// twice, or the robot restarted, which needs a new odometer.
    pub fn update(&mut self, telemetry: &Telemetry) -> Option<Odometry> {
        let Some(last) = self.last else {
            self.stamp = Stamp(1_000 * u64::from(telemetry.time_ms));
            self.counts = telemetry.counts.map(i64::from);
            self.last = Some(*telemetry);
            return Some(self.tracks.update(self.stamp, self.counts));
        };
        let elapsed = telemetry.time_ms.wrapping_sub(last.time_ms);
        // More than half the range ahead means that it lies behind.
        if elapsed == 0 || elapsed > u32::MAX / 2 {
            return None;
        }
        self.stamp = Stamp(self.stamp.0 + 1_000 * u64::from(elapsed));
        for (total, (now, then)) in self
            .counts
            .iter_mut()
            .zip(telemetry.counts.into_iter().zip(last.counts))
        {
            *total += i64::from(now.wrapping_sub(then));
        }
        self.last = Some(*telemetry);
        Some(self.tracks.update(self.stamp, self.counts))
    }
}
