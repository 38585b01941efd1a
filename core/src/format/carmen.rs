//! CARMEN logs (`.log`, `.clf`): recorded laser scans with the odometry at which they were taken.
//!
//! In: bytes, in chunks of any size. Out: a [`CarmenLog`], its scans in the order in which they
//! were taken. And back: scans with their odometry become a log ([`CarmenLog::push`]), and a log
//! becomes text ([`CarmenLog::write`]).
//!
//! 1. Lines are cut from the chunks as they come; only an unfinished line and the numbers
//!    themselves are kept, so a large log is never held as text.
//! 2. `FLASER`, `RLASER` and `ROBOTLASER1` become scans, `PARAM` is kept, `ODOM` is counted (every
//!    laser message carries the odometry of its own moment, interpolated by the recorder), other
//!    messages are skipped.
//! 3. Structure is strict: the number of fields must match the one announced, and every field must
//!    be a number. Spaces, tabs, line ends, empty lines and comments are free. A range that is NaN,
//!    infinite or negative counts as not measured, and a message without a valid pose or time is
//!    left out; both are reported ([`CarmenLog::left_out`]).
//! 4. At the end the scans are put in the order in which they were taken (`order`), and the reading
//!    that means "nothing came back" is determined (see [`CarmenLog::no_return_from`]).
//!
//! The format has no field for the duration of a sweep. It stands in a `PARAM` line of our own,
//! which other programs ignore.
//!
//! Source: CARMEN, Carnegie Mellon robot navigation toolkit, log format (the comment lines at the
//! head of each log). `FLASER n r_1 … r_n x y θ odom_x odom_y odom_θ ipc_timestamp host
//! logger_timestamp`: the first pose is that of the laser, the second that of the robot, and the
//! place of the laser on the robot is their difference.

mod error;
mod fields;
mod order;
mod reader;
#[cfg(test)]
mod tests;
mod writer;

use super::LeftOut;
use crate::geom::Pose2;
use crate::robot::{Scan, Stamp};

/// The name of a `PARAM` line of our own: the duration of each sweep that follows in the file,
/// [`CarmenScan::sweep`].
const SWEEP: &str = "slamlab_sweep";

pub use self::error::CarmenError;
pub use self::reader::CarmenReader;

/// Which laser took a scan.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Laser {
    /// `FLASER`.
    Front,
    /// `RLASER`.
    Rear,
    /// `ROBOTLASER1`.
    Robot1,
}

/// Directions of a scan's beams: beam i points to `first + i * step`, rad, in the frame of the
/// laser.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BeamFan {
    /// Direction of the first beam, rad.
    pub first: f64,
    /// From beam to beam, rad.
    pub step: f64,
}

impl BeamFan {
    /// The fan of `FLASER` and `RLASER`, which do not state it: a half circle, from right to left.
    ///
    /// An even number of beams leaves out the last direction (180 beams: -90° to 89° in steps of
    /// 1°; 360: in steps of 0.5°); an odd number has both ends (181: -90° to 90°).
    #[must_use]
    pub fn half_circle(beams: usize) -> Self {
        let gaps = beams - beams % 2;
        Self {
            first: -std::f64::consts::FRAC_PI_2,
            step: std::f64::consts::PI / gaps.max(1) as f64,
        }
    }
}

/// One laser message without its readings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CarmenScan {
    /// `ipc_timestamp`, s, as it stands in the log.
    pub ipc_seconds: f64,
    /// When it was taken, s: the stamp, corrected where stamps run backwards.
    pub seconds: f64,
    /// Pose of the robot in the frame of the odometry.
    pub odom_from_robot: Pose2,
    /// Where the laser sits.
    pub robot_from_sensor: Pose2,
    /// Directions of the beams.
    pub fan: BeamFan,
    /// Range at which the message itself says that the laser ends, m; infinite where it does not.
    pub max_range: f32,
    /// Duration from the first beam to the last, s; negative where the last beam was taken first, 0
    /// where all were taken at once or the log does not say.
    pub sweep: f64,
    start: usize,
    beams: usize,
}

/// The scans of one laser, in the order of time.
#[derive(Clone, Debug, PartialEq)]
pub struct CarmenLog {
    /// The laser whose scans these are: the one with most messages.
    pub laser: Laser,
    /// The scans, in the order in which they were taken.
    pub scans: Vec<CarmenScan>,
    /// `PARAM` lines: name and value.
    pub params: Vec<(String, String)>,
    /// Readings from here on mean that nothing came back, m: 80, or the log's largest reading if it
    /// is repeated so often that it must be a code.
    pub no_return_from: f32,
    /// What the reader left out.
    pub left_out: LeftOut,
    readings: Vec<f32>,
}

impl CarmenLog {
    /// Reads a log that is all in memory.
    ///
    /// # Errors   [`CarmenError`], with the line and field.
    pub fn parse(bytes: &[u8]) -> Result<Self, CarmenError> {
        let mut reader = CarmenReader::default();
        reader.push(bytes)?;
        reader.finish()
    }

    /// Whether any range was measured.
    pub(crate) fn has_ranges(&self) -> bool {
        self.readings.iter().any(|range| *range > 0.0)
    }

    /// Readings of a scan as recorded, m.
    #[must_use]
    pub fn readings(&self, scan: &CarmenScan) -> &[f32] {
        let readings = self.readings.get(scan.start..scan.start + scan.beams);
        readings.unwrap_or_default()
    }

    /// Seconds from the first scan to the last.
    #[must_use]
    pub fn duration(&self) -> f64 {
        match (self.scans.first(), self.scans.last()) {
            (Some(first), Some(last)) => last.seconds - first.seconds,
            _ => 0.0,
        }
    }

    /// Whether the odometry ever moved: a log of a carried sensor repeats one pose.
    #[must_use]
    pub fn has_odometry(&self) -> bool {
        let poses = self.scans.iter().map(|scan| scan.odom_from_robot);
        poses.clone().zip(poses.skip(1)).any(|(a, b)| a != b)
    }

    /// Stamp of a scan: time since the first.
    #[must_use]
    pub fn stamp(&self, scan: &CarmenScan) -> Stamp {
        let start = self.scans.first().map_or(0.0, |first| first.seconds);
        Stamp::from_seconds(scan.seconds - start)
    }

    /// A scan in the form that the rest of the core takes: beams in the order in which they were
    /// taken, no-returns infinite, readings of 0 invalid, σ 1 cm as for the SICK.
    #[must_use]
    pub fn scan(&self, scan: &CarmenScan) -> Scan {
        let no_return = self.no_return_from.min(scan.max_range);
        let readings = self.readings(scan);
        let range = |range: &f32| match *range {
            range if range >= no_return => f32::INFINITY,
            range if range > 0.0 => range,
            _ => f32::NAN,
        };
        let bearing = |i| scan.fan.first + i as f64 * scan.fan.step;
        let mut bearings: Vec<f64> = (0..readings.len()).map(bearing).collect();
        let mut ranges: Vec<f32> = readings.iter().map(range).collect();
        if scan.sweep < 0.0 {
            bearings.reverse();
            ranges.reverse();
        }
        Scan {
            stamp: self.stamp(scan),
            robot_from_sensor: scan.robot_from_sensor,
            bearings,
            ranges,
            sigmas: vec![0.01; readings.len()],
            bearing_sigma: 0.25 * scan.fan.step.abs(),
            max_range: f64::from(no_return),
            sweep: scan.sweep.abs(),
            qualities: vec![],
        }
    }
}
