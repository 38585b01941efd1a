//! Range sensors: from the true world to the readings on the wire.
//!
//! In: the pose of the sensor at each instant. Out: a [`Scan`] whose σ are those with which its
//! noise was drawn. Every sensor has both directions: forward from the world to the output of its
//! electronics, and inverse to a range. Faults are part of a sensor: dropouts, outliers, glass that
//! lets most beams through, dark surfaces that are seen only from near.

mod check;
mod lidar;
mod rangers;
mod sonar;
mod view;

pub use check::SensorError;
pub use lidar::LidarModel;
pub use sonar::SonarModel;

pub(super) use lidar::Lidar;
pub(super) use rangers::Rangers;
pub(super) use sonar::Sonar;
pub(super) use view::{Span, View};

use std::str::FromStr;

use rand::Rng;

use crate::robot::{RangerModel, Scan};

/// The sensors that a world file or a command line can name.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SensorKind {
    /// A lidar that turns all the time: RPLIDAR A1.
    #[default]
    Lidar,
    /// A lidar that sees half of the horizon, fast and far: SICK LMS 200.
    Sick,
    /// Four infra-red rangers on a servo.
    Rangers,
    /// A ring of sixteen sonars.
    Sonar,
}

impl SensorKind {
    /// All sensors, with their names in files, commands and pages, and for people.
    pub const ALL: [(&'static str, Self, &'static str); 4] = [
        ("lidar", Self::Lidar, "Lidar, 360°"),
        ("sick", Self::Sick, "SICK lidar, 180°"),
        ("rangers", Self::Rangers, "4 IR rangers"),
        ("sonar", Self::Sonar, "Ring of 16 sonars"),
    ];

    /// Its name.
    #[must_use]
    pub fn name(self) -> &'static str {
        let entry = Self::ALL.iter().find(|(_, kind, _)| *kind == self);
        entry.map_or("", |(name, _, _)| name)
    }

    /// The sensor with its default figures.
    #[must_use]
    pub fn model(self) -> SensorModel {
        match self {
            Self::Lidar => SensorModel::lidar(),
            Self::Sick => SensorModel::Lidar(LidarModel::sick()),
            Self::Rangers => SensorModel::rangers(),
            Self::Sonar => SensorModel::Sonar(SonarModel::default()),
        }
    }
}

/// There is no sensor with that name.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("there is no sensor `{0}`; expected one of {names}", names = SensorKind::ALL.map(|(name, ..)| name).join(", "))]
pub struct UnknownSensor(String);

impl FromStr for SensorKind {
    type Err = UnknownSensor;

    fn from_str(name: &str) -> Result<Self, UnknownSensor> {
        let found = Self::ALL.iter().find(|(known, ..)| *known == name);
        let kind = found.map(|(_, kind, _)| *kind);
        kind.ok_or_else(|| UnknownSensor(name.to_owned()))
    }
}

/// A sensor with all its figures.
#[derive(Clone, Debug, PartialEq)]
pub enum SensorModel {
    /// A lidar that turns all the time.
    Lidar(LidarModel),
    /// Four infra-red rangers on a servo, which sweep only on [`crate::robot::Command::Scan`].
    Rangers(RangerModel),
    /// A ring of sonars.
    Sonar(SonarModel),
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

    /// Whether it sweeps only on [`crate::robot::Command::Scan`].
    #[must_use]
    pub fn scans_on_command(&self) -> bool {
        matches!(self, Self::Rangers(_))
    }

    /// Checks the figures.
    ///
    /// # Errors    [`SensorError`], naming the first figure outside of its range.
    pub fn validate(&self) -> Result<(), SensorError> {
        match self {
            Self::Lidar(model) => model.validate(),
            Self::Rangers(model) => model.validate(),
            Self::Sonar(model) => model.validate(),
        }
    }
}

/// A sensor in operation.
#[derive(Clone, Debug)]
pub(super) enum Sensor {
    Lidar(Lidar),
    Rangers(Box<Rangers>),
    Sonar(Sonar),
}

impl Sensor {
    /// # Errors    [`SensorError`]: the first figure outside of its range.
    pub(super) fn new(model: &SensorModel) -> Result<Self, SensorError> {
        model.validate()?;
        Ok(match model {
            SensorModel::Lidar(model) => Self::Lidar(Lidar::new(model)),
            SensorModel::Rangers(model) => Self::Rangers(Box::new(Rangers::new(model)?)),
            SensorModel::Sonar(model) => Self::Sonar(Sonar::new(model)),
        })
    }

    /// Begins a scan at `seconds`: a new revolution, or a sweep of the servo.
    pub(super) fn begin(&mut self, seconds: f64) {
        match self {
            Self::Lidar(lidar) => lidar.begin(seconds),
            Self::Rangers(rangers) => rangers.begin(seconds),
            Self::Sonar(sonar) => sonar.begin(seconds),
        }
    }

    /// Gives up a sweep in progress; a lidar keeps turning.
    pub(super) fn abort(&mut self) {
        if let Self::Rangers(rangers) = self {
            rangers.abort();
        }
    }

    /// Takes the readings that fall into `span`; returns a scan when it is complete.
    pub(super) fn step(&mut self, span: &Span, view: &View, rng: &mut impl Rng) -> Option<Scan> {
        match self {
            Self::Lidar(lidar) => lidar.step(span, view, rng),
            Self::Rangers(rangers) => rangers.step(span, view, rng),
            Self::Sonar(sonar) => sonar.step(span, view, rng),
        }
    }

    /// Whether the robot moves: meanwhile rangers on a servo sweep to and fro; other sensors ignore
    /// this.
    pub(super) fn moves(&mut self, moves: bool, seconds: f64) {
        match self {
            Self::Rangers(rangers) if moves => rangers.start_partial_scans(seconds),
            Self::Rangers(rangers) => rangers.stop_partial_scans(),
            Self::Lidar(_) | Self::Sonar(_) => (),
        }
    }

    /// A few readings of a moving robot, by a sensor that can sweep only while the robot stands.
    pub(super) fn partial_scan(
        &mut self,
        span: &Span,
        view: &View,
        rng: &mut impl Rng,
    ) -> Option<Scan> {
        match self {
            Self::Rangers(rangers) => rangers.partial_scan(span, view, rng),
            Self::Lidar(_) | Self::Sonar(_) => None,
        }
    }
}
