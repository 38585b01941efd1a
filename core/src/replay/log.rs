//! A recorded log of either kind.

use crate::format::carmen::CarmenLog;
use crate::robot::RobotModel;
use crate::settings::Settings;
use crate::slam::Method;
use crate::wire::message::RobotFigures;
use crate::wire::recording::{Damage, Recording};

/// A recorded log.
#[derive(Clone, Debug)]
pub enum Log {
    /// Of a CARMEN logger.
    Carmen(CarmenLog),
    /// Of the bridge.
    Recording(Recording),
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

impl Log {
    /// Scans in it.
    #[must_use]
    pub fn scans(&self) -> usize {
        match self {
            Self::Carmen(log) => log.scans.len(),
            Self::Recording(recording) => recording.scans(),
        }
    }

    /// Seconds from its beginning to its end.
    #[must_use]
    pub fn duration(&self) -> f64 {
        match self {
            Self::Carmen(log) => log.duration(),
            Self::Recording(recording) => recording.duration(),
        }
    }

    /// The robot that it was recorded with; a Pioneer where the log does not tell.
    #[must_use]
    pub fn robot(&self) -> RobotModel {
        let model = self.figures().and_then(|figures| figures.model());
        model.unwrap_or_else(RobotModel::pioneer)
    }

    /// Whether its robot stood for each scan, as one with rangers on a servo does.
    #[must_use]
    pub fn scans_on_command(&self) -> bool {
        let figures = self.figures();
        figures.is_some_and(|figures| figures.scans_on_command)
    }

    /// The default settings of its robot.
    #[must_use]
    pub fn settings(&self) -> Settings {
        Settings::of_robot(&self.robot(), self.scans_on_command())
    }

    /// The method by which it can be mapped where `asked` was asked for: without odometry there is
    /// only scan matching.
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
        }
    }

    /// What is wrong with its file, where the rest can be used.
    #[must_use]
    pub fn damage(&self) -> &[Damage] {
        match self {
            Self::Carmen(_) => &[],
            Self::Recording(recording) => recording.damage(),
        }
    }

    fn figures(&self) -> Option<RobotFigures> {
        match self {
            Self::Carmen(_) => None,
            Self::Recording(recording) => recording.robot(),
        }
    }
}
