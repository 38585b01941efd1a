//! Every setting of a run in one table: name, unit, range, meaning, and how to read and write it.
//!
//! In: a key and a number. Out: other [`Settings`], or a sentence on why not. Whoever shows settings to people (page, command
//! line) reads the table and types nothing twice; defaults are those of the configurations themselves.
//!
//! | file | subject |
//! |---|---|
//! | `table/` | the settings, one entry each |
//! | `presets` | named sets of them |

mod presets;
mod table;
#[cfg(test)]
mod tests;

pub use presets::{PRESETS, Preset};
pub use table::table;

use crate::map::EvidenceConfig;
use crate::pilot::PilotConfig;
use crate::robot::{
    BodyShape, OdometryCalibration, OdometryNoise, RobotModel, TrackNoise, TrackWear,
};
use crate::sim::SensorModel;
use crate::sim::sensors::SonarModel;
use crate::slam::SlamConfig;

/// All that can be set of a run, beside world, robot, seed and method.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// The sensor's figures.
    pub sensor: SensorModel,
    /// Sonars beside it, if any.
    pub sonars_beside: Option<SonarModel>,
    /// A simulated robot's body.
    pub body: SimulatedBody,
    /// How a simulated robot's tracks differ from the model.
    pub wear: SimulatedWear,
    /// What the odometry says of its own errors.
    pub odometry: OdometrySettings,
    /// Estimation.
    pub slam: SlamConfig,
    /// Planning and driving.
    pub pilot: PilotConfig,
}

/// What of a simulated robot's body touches walls, and its size.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SimulatedBody {
    /// Its shape.
    pub shape: BodyShape,
    /// Length of a rectangle, m; 0: as the robot's model says.
    pub length: f64,
    /// Its width, m; 0: as the robot's model says.
    pub width: f64,
}

impl SimulatedBody {
    /// The robot with this body.
    #[must_use]
    pub fn on(&self, robot: RobotModel) -> RobotModel {
        let mut robot = RobotModel {
            shape: self.shape,
            ..robot
        };
        if self.shape == BodyShape::Rectangle {
            let given = |given: f64, own: f64| if given > 0.0 { given } else { own };
            robot.length = given(self.length, robot.length);
            robot.width = given(self.width, robot.width);
        }
        robot
    }
}

/// How a simulated robot's tracks differ from the model.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SimulatedWear {
    /// Whether as given here; otherwise as the seed draws it.
    pub is_given: bool,
    /// So, where it is given.
    pub given: TrackWear,
}

impl SimulatedWear {
    /// As given, if it is.
    #[must_use]
    pub fn used(&self) -> Option<TrackWear> {
        self.is_given.then_some(self.given)
    }
}

/// Both models of odometry noise, and which one is used; and what is known of the tracks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OdometrySettings {
    /// How the tracks are known to differ from the model.
    pub wear: TrackWear,
    /// Whether the source's constant Q is used.
    pub is_constant: bool,
    /// Its variance of a track's way in each reading, m².
    pub constant: f64,
    /// The variances that grow with the way.
    pub proportional: OdometryNoise,
}

impl OdometrySettings {
    /// Of this robot; the constant Q is what the other model gives at full speed, 100 readings a second.
    #[must_use]
    pub fn of(robot: &RobotModel) -> Self {
        Self {
            wear: TrackWear::default(),
            is_constant: false,
            constant: robot.odometry_noise.per_metre * robot.max_speed * 0.01,
            proportional: robot.odometry_noise,
        }
    }

    /// The calibration of this robot: its own word on noise stands where nothing else was set than the defaults of its model.
    #[must_use]
    pub fn calibration(&self, robot: &RobotModel) -> OdometryCalibration {
        let noise = |of: &Self| (of.is_constant, of.constant, of.proportional);
        OdometryCalibration {
            wear: self.wear,
            noise: (noise(self) != noise(&Self::of(robot))).then(|| self.used()),
        }
    }

    /// The one that is used.
    #[must_use]
    pub fn used(&self) -> TrackNoise {
        if self.is_constant {
            TrackNoise::Constant(self.constant)
        } else {
            TrackNoise::Proportional(self.proportional)
        }
    }
}

/// One setting.
#[derive(Clone, Copy, Debug)]
pub struct Setting {
    /// Its name in links and messages, unique.
    pub key: &'static str,
    /// Where it belongs.
    pub group: &'static str,
    /// Its name for people.
    pub name: &'static str,
    /// Its unit; empty for a pure number.
    pub unit: &'static str,
    /// Smallest and largest number that is accepted.
    pub range: [f64; 2],
    /// What the number is.
    pub kind: Kind,
    /// When a change acts.
    pub acts: Acts,
    /// What it is for, in one line, and what happens when it grows.
    pub meaning: &'static str,
    get: fn(&Settings) -> Option<f64>,
    set: fn(&mut Settings, f64),
}

/// What the number of a setting is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Any number within the range.
    Real,
    /// A whole number.
    Whole,
    /// 0 or 1.
    Switch,
    /// The place of one of these.
    Choice(&'static [&'static str]),
}

/// When a change acts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Acts {
    /// From the next scan or tick on.
    AtOnce,
    /// When the run begins anew.
    OnRestart,
}

/// Why a setting cannot be set.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SettingError {
    /// No setting of that key.
    #[error("there is no setting `{0}`")]
    Unknown(String),
    /// It belongs to another sensor or method.
    #[error("{name} is no setting of this run: it belongs to another sensor or rule")]
    Absent {
        /// Name for people.
        name: &'static str,
    },
    /// Outside of its range.
    #[error("{name} is {value}{unit}, expected {expected}")]
    Range {
        /// Name for people.
        name: &'static str,
        /// What was asked for.
        value: f64,
        /// Unit with a blank in front, or nothing.
        unit: String,
        /// What may stand there.
        expected: String,
    },
}

impl Settings {
    /// The defaults for a sensor on a robot.
    #[must_use]
    pub fn of(sensor: SensorModel, robot: &RobotModel) -> Self {
        let (slam, pilot) = estimation_and_driving(&sensor);
        Self {
            sensor,
            sonars_beside: None,
            body: SimulatedBody::default(),
            wear: SimulatedWear::default(),
            odometry: OdometrySettings::of(robot),
            slam,
            pilot,
        }
    }

    /// The defaults for a real or a recorded robot, whose sensor is not simulated.
    #[must_use]
    pub fn of_robot(robot: &RobotModel, scans_on_command: bool) -> Self {
        let sensor = match scans_on_command {
            true => SensorModel::rangers(),
            false => SensorModel::lidar(),
        };
        Self::of(sensor, robot)
    }

    /// The number of a setting; `None` where this sensor or rule has none such.
    #[must_use]
    pub fn get(&self, setting: &Setting) -> Option<f64> {
        (setting.get)(self)
    }

    /// Sets a number.
    ///
    /// # Errors    [`SettingError`]; then nothing has changed.
    pub fn set(&mut self, key: &str, value: f64) -> Result<(), SettingError> {
        let found = table().find(|setting| setting.key == key);
        let setting = found.ok_or_else(|| SettingError::Unknown(key.to_owned()))?;
        setting.check(value)?;
        if self.get(setting).is_none() {
            let name = setting.name;
            return Err(SettingError::Absent { name });
        }
        (setting.set)(self, value);
        Ok(())
    }

    /// Sets all of them, choices before the settings that come with them: in the order of the table.
    ///
    /// # Errors    [`SettingError`] for the first that cannot be; those before it are set.
    pub fn set_all<'a>(
        &mut self,
        changes: impl IntoIterator<Item = (&'a str, f64)>,
    ) -> Result<(), SettingError> {
        in_order(changes).try_for_each(|(key, value)| self.set(key, value))
    }

    /// The same for settings that may have been made for another sensor: those that this one does not have are left out.
    ///
    /// # Errors    [`SettingError`] for the first that no sensor has, or that is out of range; those before it are set.
    pub fn set_present<'a>(
        &mut self,
        changes: impl IntoIterator<Item = (&'a str, f64)>,
    ) -> Result<(), SettingError> {
        in_order(changes).try_for_each(|(key, value)| match self.set(key, value) {
            Err(SettingError::Absent { .. }) => Ok(()),
            done => done,
        })
    }
}

/// Changes in the order of the table: choices before the settings that come with them.
fn in_order<'a>(
    changes: impl IntoIterator<Item = (&'a str, f64)>,
) -> impl Iterator<Item = (&'a str, f64)> {
    let mut changes: Vec<_> = changes.into_iter().collect();
    changes.sort_by_key(|(key, _)| table().position(|setting| setting.key == *key));
    changes.into_iter()
}

/// The defaults of estimation and driving for a sensor.
///
/// A sensor that scans only on command sees each cell a few times at most, little of each wall, and from afar in terms
/// of odometry: it takes Celej's quicker grid, and the `short_range` figures of lines, filter and pilot.
fn estimation_and_driving(sensor: &SensorModel) -> (SlamConfig, PilotConfig) {
    if let SensorModel::Sonar(sonar) = sensor {
        let slam = SlamConfig {
            evidence: EvidenceConfig::cones(sonar.half_angle),
            ..SlamConfig::default()
        };
        return (slam, PilotConfig::default());
    }
    if !sensor.scans_on_command() {
        return (SlamConfig::default(), PilotConfig::default());
    }
    (SlamConfig::short_range(), PilotConfig::short_range())
}

impl Setting {
    fn check(&self, value: f64) -> Result<(), SettingError> {
        let [low, high] = self.range;
        let is_whole = self.kind == Kind::Real || value.fract() == 0.0;
        if (low..=high).contains(&value) && is_whole {
            return Ok(());
        }
        let unit = match self.unit {
            "" => String::new(),
            unit => format!(" {unit}"),
        };
        let whole = match self.kind {
            Kind::Real => "",
            _ => "a whole number from ",
        };
        let expected = format!("{whole}{low} to {high}{unit}");
        Err(SettingError::Range {
            name: self.name,
            value,
            unit,
            expected,
        })
    }
}
