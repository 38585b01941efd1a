//! What robot and sensors report, as on the wire, and its conversion from and to the core's own
//! types.

use nalgebra::Matrix3;
use serde::{Deserialize, Serialize};

use super::names::named;
use super::number;
use crate::geom::Pose2;
use crate::robot::{Odometry, OdometryError, RobotModel, Scan, ScanError, Stamp};

/// Motion between two stamps of the robot, in the robot frame at the first.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct OdometryBody {
    /// Number of the source.
    pub source: u8,
    /// Start of the motion, µs of the robot's clock.
    pub from: u64,
    /// End of the motion, µs of the robot's clock.
    pub to: u64,
    /// x, y (m), heading (rad).
    pub motion: [f64; 3],
    /// xx, xy, xθ, yy, yθ, θθ.
    pub cov: [f64; 6],
}

impl OdometryBody {
    /// To the wire.
    #[must_use]
    pub fn new(source: u8, odometry: &Odometry) -> Self {
        let (m, c) = (&odometry.motion, &odometry.cov);
        let (xx, xy, xt) = (c[(0, 0)], c[(0, 1)], c[(0, 2)]);
        let (yy, yt, tt) = (c[(1, 1)], c[(1, 2)], c[(2, 2)]);
        Self {
            source,
            from: odometry.from.0,
            to: odometry.to.0,
            motion: [m.x(), m.y(), m.heading()],
            cov: [xx, xy, xt, yy, yt, tt],
        }
    }

    /// From the wire.
    ///
    /// # Errors    [`OdometryError`] if a number is not finite or a variance negative.
    pub fn odometry(&self) -> Result<Odometry, OdometryError> {
        let [x, y, heading] = self.motion;
        let [xx, xy, xt, yy, yt, tt] = self.cov;
        let odometry = Odometry {
            from: Stamp(self.from),
            to: Stamp(self.to),
            motion: Pose2::new(x, y, heading),
            cov: Matrix3::new(xx, xy, xt, xy, yy, yt, xt, yt, tt),
        };
        odometry.validate().map(|()| odometry)
    }
}

/// A [`Scan`] with the number of its source; units and order are the same.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ScanBody {
    /// Number of the source.
    pub source: u8,
    /// When the last beam was taken, µs of the robot's clock.
    pub stamp: u64,
    /// Pose of the sensor on the robot: x, y (m), heading (rad).
    pub mount: [f64; 3],
    /// rad.
    pub bearings: Vec<f64>,
    /// m; infinite if nothing came back, NaN if invalid.
    #[serde(with = "number")]
    pub ranges: Vec<f32>,
    /// m.
    #[serde(with = "number")]
    pub sigmas: Vec<f32>,
    /// rad.
    pub bearing_sigma: f64,
    /// m.
    pub max_range: f64,
    /// s.
    pub sweep: f64,
    /// Strength of each echo in the sensor's own unit; empty if it gives none.
    pub qualities: Vec<u8>,
}

impl ScanBody {
    /// To the wire.
    #[must_use]
    pub fn new(source: u8, scan: &Scan) -> Self {
        let mount = &scan.robot_from_sensor;
        Self {
            source,
            stamp: scan.stamp.0,
            mount: [mount.x(), mount.y(), mount.heading()],
            bearings: scan.bearings.clone(),
            ranges: scan.ranges.clone(),
            sigmas: scan.sigmas.clone(),
            bearing_sigma: scan.bearing_sigma,
            max_range: scan.max_range,
            sweep: scan.sweep,
            qualities: scan.qualities.clone(),
        }
    }

    /// From the wire.
    ///
    /// # Errors    [`ScanError`], naming the first beam and column at fault.
    pub fn scan(self) -> Result<Scan, ScanError> {
        let [x, y, heading] = self.mount;
        let scan = Scan {
            stamp: Stamp(self.stamp),
            robot_from_sensor: Pose2::new(x, y, heading),
            bearings: self.bearings,
            ranges: self.ranges,
            sigmas: self.sigmas,
            bearing_sigma: self.bearing_sigma,
            max_range: self.max_range,
            sweep: self.sweep,
            qualities: self.qualities,
        };
        scan.validate().map(|()| scan)
    }
}

/// Single readings of rangers, before they become a scan.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RangersBody {
    /// Number of the source.
    pub source: u8,
    /// µs of the robot's clock.
    pub stamp: u64,
    /// One for each ranger that was read.
    pub readings: Vec<RangerReading>,
}

/// One reading of one ranger.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct RangerReading {
    /// Number of the ranger, from 0.
    pub index: u8,
    /// Angle of the servo, rad, counter-clockwise.
    pub servo: f32,
    /// Counts of the converter.
    pub raw: u16,
}

/// State of the bumpers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct BumpersBody {
    /// Number of the source.
    pub source: u8,
    /// µs of the robot's clock.
    pub stamp: u64,
    /// Pressed at the left.
    pub left: bool,
    /// Pressed at the right.
    pub right: bool,
}

/// Battery voltage.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct BatteryBody {
    /// Number of the source.
    pub source: u8,
    /// µs of the robot's clock.
    pub stamp: u64,
    /// V.
    pub volts: f32,
}

/// Motor currents.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct CurrentsBody {
    /// Number of the source.
    pub source: u8,
    /// µs of the robot's clock.
    pub stamp: u64,
    /// Left, A.
    pub left: f32,
    /// Right, A.
    pub right: f32,
}

/// State of the wire to a device.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct LinkBody {
    /// Number of the source.
    pub source: u8,
    /// Whether data can flow.
    pub state: LinkState,
    /// From a command to its acknowledgement, s; none if the device acknowledges nothing.
    pub round_trip: Option<f32>,
    /// Damaged frames since the start.
    pub damaged: u64,
    /// Bytes that belonged to no frame since the start.
    pub skipped: u64,
}

impl LinkBody {
    /// A wire without counts yet.
    #[must_use]
    pub fn new(state: LinkState) -> Self {
        Self {
            state,
            ..Self::default()
        }
    }
}

named! {
    /// Whether data can flow.
    #[derive(Default)]
    pub enum LinkState {
        /// Closed, or gone.
        #[default]
        Down = "down",
        /// Open, and nothing was understood yet.
        Opening = "opening",
        /// At work.
        Up = "up",
        /// The robot must be reset by hand.
        ResetNeeded = "reset-needed",
    }
}

/// A robot or a sensor, for the list that a person sees.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Device {
    /// Number of the source.
    pub source: u8,
    /// As it was named on the command line: `rplidar:/dev/ttyUSB0`.
    pub name: String,
    /// Its description of itself: `RPLIDAR A1, firmware 1.29`; empty until it has sent one.
    pub model: String,
    /// Its state.
    pub state: DeviceState,
    /// For a fault: cause and cure, in a sentence.
    pub detail: String,
}

named! {
    /// How a device does.
    ///
    /// Source: Pilch 2016 §3.6, states 0 to 4.
    #[derive(Default)]
    pub enum DeviceState {
        /// Not there yet.
        #[default]
        Waiting = "waiting",
        /// There.
        Connected = "connected",
        /// Measuring.
        Measuring = "measuring",
        /// Measuring, and its data are passed on.
        Sending = "sending",
        /// Something is wrong with it.
        Fault = "fault",
    }
}

/// The figures of the robot that a program needs to steer it; see [`RobotModel`] for their units.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RobotFigures {
    /// Name of the preset that the rest is taken from: `rp6`.
    pub preset: String,
    /// Length, width, track width, metres per tick.
    pub size: [f64; 4],
    /// Highest speed, turn rate, acceleration, turn acceleration.
    pub limits: [f64; 4],
    /// Odometry noise: per metre, lateral per metre, heading per radian.
    pub noise: [f64; 3],
    /// Whether it scans only on command, while standing.
    pub scans_on_command: bool,
}

impl RobotFigures {
    /// To the wire.
    #[must_use]
    pub fn new(model: &RobotModel, scans_on_command: bool) -> Self {
        let mut model = *model;
        let (size, limits, noise) = figures(&mut model);
        Self {
            size: size.map(|figure| *figure),
            limits: limits.map(|figure| *figure),
            noise: noise.map(|figure| *figure),
            preset: model.name.to_owned(),
            scans_on_command,
        }
    }

    /// From the wire: the preset with these figures; `None` if the preset is unknown.
    #[must_use]
    pub fn model(&self) -> Option<RobotModel> {
        let presets = [RobotModel::rp6(), RobotModel::pioneer()];
        let mut model = presets.into_iter().find(|m| m.name == self.preset)?;
        let (size, limits, noise) = figures(&mut model);
        let size = size.into_iter().zip(self.size);
        let limits = limits.into_iter().zip(self.limits);
        let noise = noise.into_iter().zip(self.noise);
        for (figure, said) in size.chain(limits).chain(noise) {
            *figure = said;
        }
        Some(model)
    }
}

/// The figures of a model in the order on the wire: size, limits, noise.
fn figures(model: &mut RobotModel) -> ([&mut f64; 4], [&mut f64; 4], [&mut f64; 3]) {
    let size = [
        &mut model.length,
        &mut model.width,
        &mut model.track_width,
        &mut model.metres_per_tick,
    ];
    let limits = [
        &mut model.max_speed,
        &mut model.max_turn_rate,
        &mut model.max_acceleration,
        &mut model.max_turn_acceleration,
    ];
    let noise = &mut model.odometry_noise;
    let noise = [
        &mut noise.per_metre,
        &mut noise.lateral_per_metre,
        &mut noise.heading_per_radian,
    ];
    (size, limits, noise)
}
