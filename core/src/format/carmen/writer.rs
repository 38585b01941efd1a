//! From scans to a log, and from a log to text.
//!
//! 1. A log has one direction of the first beam and one step: beams are put at equal angles
//!    ([`EvenBeams`]), and a direction without a beam has no reading (0).
//! 2. A message has no time within a sweep: a `PARAM` line before it says how long the sweep took,
//!    and which end came first. For beams that were not taken in order of direction it says
//!    nothing.
//! 3. Numbers are written with as many digits as are needed to read them back to the bit.

use std::fmt::Write as _;

use super::{BeamFan, CarmenLog, CarmenScan, Laser, SWEEP};
use crate::format::LeftOut;
use crate::geom::Pose2;
use crate::robot::{EvenBeams, Scan};

impl CarmenLog {
    /// A log without scans, of a laser whose messages state their fan.
    #[must_use]
    pub fn empty() -> Self {
        Self {
            laser: Laser::Robot1,
            scans: vec![],
            params: vec![],
            no_return_from: f32::INFINITY,
            left_out: LeftOut::default(),
            readings: vec![],
        }
    }

    /// Readings of all scans together.
    #[must_use]
    pub fn len(&self) -> usize {
        self.readings.len()
    }

    /// Whether there is no reading.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.readings.is_empty()
    }

    /// Adds a scan that is later than those before, taken at `seconds`, where odometry alone put
    /// the robot at `odom_from_robot`.
    pub fn push(&mut self, seconds: f64, odom_from_robot: &Pose2, scan: &Scan) {
        let max_range = scan.max_range as f32;
        let reading = |range: f32| match range {
            r if r.is_nan() => 0.0,
            r => r.min(max_range),
        };
        let even = EvenBeams::of(&scan.bearings, &scan.ranges);
        let start = self.readings.len();
        let ranges = even.pick(&scan.ranges, f32::NAN);
        self.readings.extend(ranges.into_iter().map(reading));
        self.scans.push(CarmenScan {
            ipc_seconds: seconds,
            seconds,
            odom_from_robot: *odom_from_robot,
            robot_from_sensor: scan.robot_from_sensor,
            fan: BeamFan {
                first: even.first,
                step: even.step,
            },
            max_range,
            sweep: sweep_of(&even, scan.sweep),
            start,
            beams: self.readings.len() - start,
        });
    }

    /// The text of the file: `PARAM` lines, then a laser message for each scan, preceded by a
    /// `PARAM` line wherever the duration of the sweep changes.
    #[must_use]
    pub fn write(&self) -> String {
        let mut text = String::from("# CARMEN log, written by slamlab\n");
        for (name, value) in &self.params {
            // Writing to a string does not fail, here and below.
            let _ = writeln!(text, "PARAM {name} {value} 0 slamlab 0");
        }
        let mut sweep = 0.0;
        for scan in &self.scans {
            if scan.sweep != sweep {
                sweep = scan.sweep;
                let _ = writeln!(text, "PARAM {SWEEP} {sweep} 0 slamlab 0");
            }
            self.write_scan(&mut text, scan);
        }
        text
    }

    fn write_scan(&self, text: &mut String, scan: &CarmenScan) {
        let readings = self.readings(scan);
        let name = match self.laser {
            Laser::Front => "FLASER",
            Laser::Rear => "RLASER",
            Laser::Robot1 => "ROBOTLASER1",
        };
        let _ = write!(text, "{name}");
        if self.laser == Laser::Robot1 {
            let BeamFan { first, step } = scan.fan;
            let view = step * readings.len().saturating_sub(1) as f64;
            // A limit of 0 means no limit.
            let limit = Some(scan.max_range).filter(|m| m.is_finite());
            let limit = limit.unwrap_or_default();
            let _ = write!(text, " 0 {first} {view} {step} {limit} 0.01 0");
        }
        let _ = write!(text, " {}", readings.len());
        for reading in readings {
            let _ = write!(text, " {reading}");
        }
        if self.laser == Laser::Robot1 {
            let _ = write!(text, " 0");
        }
        let odom_from_robot = &scan.odom_from_robot;
        let odom_from_sensor = *odom_from_robot * scan.robot_from_sensor;
        for pose in [&odom_from_sensor, odom_from_robot] {
            let _ = write!(text, " {} {} {}", pose.x(), pose.y(), pose.heading());
        }
        if self.laser == Laser::Robot1 {
            let _ = write!(text, " 0 0 0 0 0");
        }
        let seconds = scan.ipc_seconds;
        let _ = writeln!(text, " {seconds} slamlab {seconds}");
    }
}

/// The duration of a sweep in the sense of [`CarmenScan::sweep`], for beams that were put at equal
/// angles.
fn sweep_of(even: &EvenBeams, seconds: f64) -> f64 {
    let taken: Vec<usize> = even.beams.iter().copied().flatten().collect();
    if taken.is_sorted() {
        seconds
    } else if taken.iter().rev().is_sorted() {
        -seconds
    } else {
        0.0
    }
}
