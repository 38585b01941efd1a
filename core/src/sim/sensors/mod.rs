//! Range sensors: from the true world to what the wire would bring.
//!
//! In: where the sensor is and which way it looks at each instant. Out: a [`Scan`] whose σ are those that its noise was
//! drawn with. Faults are part of a sensor: dropouts, outliers, glass that lets most beams through, dark surfaces that
//! are seen from near only.

mod lidar;
mod rangers;
mod view;

pub use lidar::LidarModel;
pub use rangers::RangerModel;

pub(super) use lidar::Lidar;
pub(super) use rangers::Rangers;
pub(super) use view::{Span, View};

use rand::Rng;

use crate::geom::Pose2;
use crate::robot::Scan;

/// The sensors that a world file or a command line can name.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SensorKind {
    /// A lidar that turns all the time.
    #[default]
    Lidar,
    /// Four infra-red rangers on a servo.
    Rangers,
}

impl SensorKind {
    /// The sensor with its default figures.
    #[must_use]
    pub fn model(self) -> SensorModel {
        match self {
            Self::Lidar => SensorModel::lidar(),
            Self::Rangers => SensorModel::rangers(),
        }
    }
}

/// A sensor with all its figures.
#[derive(Clone, Debug, PartialEq)]
pub enum SensorModel {
    /// A lidar that turns all the time.
    Lidar(LidarModel),
    /// Four infra-red rangers on a servo, which look round on [`crate::robot::Command::Scan`] only.
    Rangers(RangerModel),
}

impl SensorModel {
    /// The RPLIDAR A1.
    #[must_use]
    pub fn lidar() -> Self {
        Self::Lidar(LidarModel::default())
    }

    /// Four Sharp rangers of 0.2 to 1.5 m.
    #[must_use]
    pub fn rangers() -> Self {
        Self::Rangers(RangerModel::default())
    }

    /// Which kind it is.
    #[must_use]
    pub fn kind(&self) -> SensorKind {
        match self {
            Self::Lidar(_) => SensorKind::Lidar,
            Self::Rangers(_) => SensorKind::Rangers,
        }
    }

    /// Whether it looks round only on [`crate::robot::Command::Scan`].
    #[must_use]
    pub fn scans_on_command(&self) -> bool {
        matches!(self, Self::Rangers(_))
    }

    /// Where it sits on the robot.
    #[must_use]
    pub fn robot_from_sensor(&self) -> Pose2 {
        match self {
            Self::Lidar(model) => model.robot_from_sensor,
            Self::Rangers(model) => model.robot_from_sensor,
        }
    }

    /// The farthest range it reports, m.
    #[must_use]
    pub fn max_range(&self) -> f64 {
        match self {
            Self::Lidar(model) => model.max_range,
            Self::Rangers(model) => model.max_range,
        }
    }

    /// Checks the figures.
    ///
    /// # Errors    [`SensorError`], naming the first figure outside of its range.
    pub fn validate(&self) -> Result<(), SensorError> {
        match self {
            Self::Lidar(model) => model.validate(),
            Self::Rangers(model) => model.validate(),
        }
    }
}

/// Why a [`SensorModel`] cannot be used.
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
        expected: &'static str,
    },
}

/// A sensor at work.
#[derive(Clone, Debug)]
pub(super) enum Sensor {
    Lidar(Lidar),
    Rangers(Rangers),
}

impl Sensor {
    pub(super) fn new(model: &SensorModel) -> Self {
        match model {
            SensorModel::Lidar(model) => Self::Lidar(Lidar::new(model)),
            SensorModel::Rangers(model) => Self::Rangers(Rangers::new(model)),
        }
    }

    /// Begins a scan at `seconds`: a new revolution, or a sweep of the servo.
    pub(super) fn begin(&mut self, seconds: f64) {
        match self {
            Self::Lidar(lidar) => lidar.begin(seconds),
            Self::Rangers(rangers) => rangers.begin(seconds),
        }
    }

    /// Gives up a sweep under way; a lidar turns on.
    pub(super) fn abort(&mut self) {
        if let Self::Rangers(rangers) = self {
            rangers.abort();
        }
    }

    /// Takes the readings that fall into `span`; gives the scan that became complete.
    pub(super) fn step(&mut self, span: &Span, view: &View, rng: &mut impl Rng) -> Option<Scan> {
        match self {
            Self::Lidar(lidar) => lidar.step(span, view, rng),
            Self::Rangers(rangers) => rangers.step(span, view, rng),
        }
    }
}

/// Checks figures against their ranges, in order.
fn check_figures(
    sensor: &'static str,
    figures: &[(&'static str, f64, bool, &'static str)],
) -> Result<(), SensorError> {
    match figures.iter().find(|(_, _, fits, _)| !fits) {
        None => Ok(()),
        Some(&(field, value, _, expected)) => Err(SensorError::Value {
            sensor,
            field,
            value,
            expected,
        }),
    }
}
