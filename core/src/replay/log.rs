//! A recorded log of any kind.

use std::f64::consts::PI;

use crate::format::carmen::CarmenLog;
use crate::format::ranger_log::RangerLog;
use crate::format::revolution_log::RevolutionLog;
use crate::format::rover_log::RoverLog;
use crate::format::{FieldError, LeftOut};
use crate::robot::RobotModel;
use crate::settings::{LogSettings, Settings};
use crate::slam::Method;
use crate::wire::message::RobotFigures;
use crate::wire::recording::{Damage, Recording};

use super::posed_log::PosedLog;

/// A recorded log.
#[derive(Clone, Debug)]
pub enum Log {
    /// From a CARMEN logger.
    Carmen(CarmenLog),
    /// From the bridge.
    Recording(Recording),
    /// From a rover with an RPLIDAR.
    Rover(RoverLog),
    /// From a robot with four rangers.
    Rangers(RangerLog),
    /// From an RPLIDAR alone, one revolution per line.
    Revolutions(RevolutionLog),
    /// Any other log, with the poses of another file as its odometry.
    Posed(PosedLog),
}

impl From<CarmenLog> for Log {
    fn from(log: CarmenLog) -> Self {
        Self::Carmen(log)
    }
}

impl From<Recording> for Log {
    fn from(recording: Recording) -> Self {
        Self::Recording(recording)
    }
}

impl From<RoverLog> for Log {
    fn from(log: RoverLog) -> Self {
        Self::Rover(log)
    }
}

impl From<RangerLog> for Log {
    fn from(log: RangerLog) -> Self {
        Self::Rangers(log)
    }
}

impl From<PosedLog> for Log {
    fn from(log: PosedLog) -> Self {
        Self::Posed(log)
    }
}

impl From<RevolutionLog> for Log {
    fn from(log: RevolutionLog) -> Self {
        Self::Revolutions(log)
    }
}

impl Log {
    /// Number of scans.
    #[must_use]
    pub fn scans(&self) -> usize {
        match self {
            Self::Carmen(log) => log.scans.len(),
            Self::Recording(recording) => recording.scans(),
            Self::Rover(log) => log.scans.len(),
            Self::Rangers(log) => log.scans.len(),
            Self::Revolutions(log) => log.len(),
            Self::Posed(posed) => posed.log().scans(),
        }
    }

    /// Seconds from its beginning to its end; `figures` give what the log does not contain.
    #[must_use]
    pub fn duration(&self, figures: &LogSettings) -> f64 {
        match self {
            Self::Carmen(log) => log.duration(),
            Self::Recording(recording) => recording.duration(),
            Self::Rover(log) => log.duration(),
            Self::Rangers(log) => log.duration(),
            Self::Revolutions(log) => log.duration(figures.revolution_rate),
            Self::Posed(posed) => posed.log().duration(figures),
        }
    }

    /// The robot that it was recorded with: for a rover's log, one with tracks and these figures; a
    /// Pioneer if the log does not say.
    #[must_use]
    pub fn robot(&self, figures: &LogSettings) -> RobotModel {
        match self {
            Self::Rover(_) => return rover(figures),
            Self::Posed(posed) => return posed.log().robot(figures),
            _ => {}
        }
        let model = self.figures().and_then(|figures| figures.model());
        model.unwrap_or_else(RobotModel::pioneer)
    }

    /// Whether its robot stood for each scan, as one with rangers on a servo does.
    #[must_use]
    pub fn scans_on_command(&self) -> bool {
        let figures = self.figures();
        figures.is_some_and(|figures| figures.scans_on_command)
    }

    /// The default settings for its robot.
    #[must_use]
    pub fn settings(&self) -> Settings {
        let robot = self.robot(&LogSettings::default());
        Settings::of_robot(&robot, self.scans_on_command())
    }

    /// The method by which it can be mapped if `asked` was requested: without odometry, only scan
    /// matching works.
    #[must_use]
    pub fn method(&self, asked: Method) -> Method {
        let fallback = Method::ScanMatching;
        if self.has_odometry() { asked } else { fallback }
    }

    /// Whether a robot reported its motion; otherwise a sensor was carried.
    #[must_use]
    pub fn has_odometry(&self) -> bool {
        match self {
            Self::Carmen(log) => log.has_odometry(),
            Self::Recording(recording) => recording.has_odometry(),
            Self::Rover(log) => log.has_odometry(),
            Self::Rangers(log) => log.has_odometry(),
            Self::Revolutions(_) => false,
            Self::Posed(_) => true,
        }
    }

    /// What is wrong with its file, if the rest can be used.
    #[must_use]
    pub fn damage(&self) -> &[Damage] {
        match self {
            Self::Recording(recording) => recording.damage(),
            Self::Posed(posed) => posed.log().damage(),
            Self::Carmen(_) | Self::Rover(_) | Self::Rangers(_) | Self::Revolutions(_) => &[],
        }
    }

    /// What its reader left out of a text: ranges and lines that cannot be measurements.
    #[must_use]
    pub fn left_out(&self) -> Option<&LeftOut> {
        match self {
            Self::Carmen(log) => Some(&log.left_out),
            Self::Rover(log) => Some(&log.left_out),
            Self::Rangers(log) => Some(&log.left_out),
            Self::Revolutions(log) => Some(&log.left_out),
            Self::Posed(posed) => posed.log().left_out(),
            Self::Recording(_) => None,
        }
    }

    /// What was wrong with the first range of a text in which no range is valid.
    pub(super) fn without_ranges(&self) -> Option<&FieldError> {
        let has_ranges = match self {
            Self::Carmen(log) => log.has_ranges(),
            Self::Rover(log) => log.has_ranges(),
            Self::Rangers(log) => log.has_ranges(),
            Self::Revolutions(log) => log.has_ranges(),
            Self::Posed(_) | Self::Recording(_) => true,
        };
        let first = self.left_out()?.ranges.first.as_ref();
        first.filter(|_| !has_ranges)
    }

    fn figures(&self) -> Option<RobotFigures> {
        match self {
            Self::Recording(recording) => recording.robot(),
            Self::Posed(posed) => posed.log().figures(),
            Self::Carmen(_) | Self::Rover(_) | Self::Rangers(_) | Self::Revolutions(_) => None,
        }
    }
}

/// A small rover with tracks, which slips like an RP6.
fn rover(figures: &LogSettings) -> RobotModel {
    RobotModel {
        name: "rover",
        metres_per_tick: PI * figures.wheel_diameter / figures.counts_per_revolution,
        track_width: figures.track_width,
        ruled_width: figures.track_width,
        ..RobotModel::rp6()
    }
}
