//! Every setting of a run in one table: name, meaning, range, unit, what it belongs to, and how to
//! read and write it.
//!
//! In: a key and a number. Out: the changed [`Settings`], or a sentence on why not. Page and
//! command line read this table, so nothing is typed twice. Defaults, and the ranges that are
//! checked, come from the configurations themselves.
//!
//! | file | subject |
//! |---|---|
//! | `table/` | the settings, one row each |
//! | `setting` | the content of a row |
//! | `applies` | which rows have an effect on a run |
//! | `field` | how the number of a row is stored in a configuration |
//! | `presets` | named sets of settings |

mod applies;
mod field;
mod presets;
mod setting;
mod table;
#[cfg(test)]
mod tests;

pub use applies::{Idle, Scope};
pub use presets::{PRESETS, Preset};
pub use setting::{Acts, Kind, Named, Needs, Setting, Source, Unit};
pub use table::table;

use crate::bounds::config;
use crate::map::EvidenceConfig;
use crate::pilot::PilotConfig;
use crate::robot::{
    BodyShape, OdometryCalibration, OdometryNoise, RobotModel, TrackNoise, TrackWear,
};
use crate::sim::SensorModel;
use crate::sim::sensors::SonarModel;
use crate::slam::SlamConfig;

/// All settings of a run, apart from world, robot, seed and method.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// The sensor's figures.
    pub sensor: SensorModel,
    /// Sonars beside the sensor, if any.
    pub sonars_beside: Option<SonarModel>,
    /// A simulated robot's body.
    pub body: SimulatedBody,
    /// How a simulated robot's tracks differ from the model.
    pub wear: SimulatedWear,
    /// What is assumed of the errors of the odometry.
    pub odometry: OdometrySettings,
    /// What a recorded log does not say about itself.
    pub log: LogSettings,
    /// Estimation.
    pub slam: SlamConfig,
    /// Planning and driving.
    pub pilot: PilotConfig,
}

/// Which part of a simulated robot's body touches walls, and its size.
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
    /// Whether the wear is as given here; otherwise the seed draws it.
    pub is_given: bool,
    /// The wear, if given.
    pub given: TrackWear,
}

impl SimulatedWear {
    /// The given wear, if any.
    #[must_use]
    pub fn used(&self) -> Option<TrackWear> {
        self.is_given.then_some(self.given)
    }
}

/// What is assumed of the errors of the odometry: how the tracks differ from the model, and which
/// of two noise models is used.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OdometrySettings {
    /// How the tracks are known to differ from the model.
    pub wear: TrackWear,
    /// Whether the constant Q of the paper is used.
    pub is_constant: bool,
    /// Variance of a track's travel in each reading by the constant model, m².
    pub constant: f64,
    /// Variances that grow with the distance travelled.
    pub proportional: OdometryNoise,
}

impl OdometrySettings {
    /// For this robot; the constant Q is what the other model gives at full speed, 100 readings a
    /// second.
    #[must_use]
    pub fn of(robot: &RobotModel) -> Self {
        Self {
            wear: TrackWear::default(),
            is_constant: false,
            constant: robot.odometry_noise.per_metre * robot.max_speed * 0.01,
            proportional: robot.odometry_noise,
        }
    }

    /// The calibration of this robot: its own noise figures apply unless a setting differs from the
    /// defaults of its model.
    #[must_use]
    pub fn calibration(&self, robot: &RobotModel) -> OdometryCalibration {
        let noise = |of: &Self| (of.is_constant, of.constant, of.proportional);
        OdometryCalibration {
            wear: self.wear,
            noise: (noise(self) != noise(&Self::of(robot))).then(|| self.used()),
        }
    }

    /// The noise model that is used.
    #[must_use]
    pub fn used(&self) -> TrackNoise {
        if self.is_constant {
            TrackNoise::Constant(self.constant)
        } else {
            TrackNoise::Proportional(self.proportional)
        }
    }
}

config! {
    /// What a recorded log does not say of itself. Encoders and wheels are those of rovers' logs
    /// (`format::rover_log`), the reach is that of rangers' (`format::ranger_log`), the rate that
    /// of logs of revolutions (`format::revolution_log`).
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct LogSettings {
        /// Whether the log's odometry is used; without it, the sensor might have been carried.
        pub uses_odometry: bool = true,
        /// Counts of an encoder in a revolution of its wheel. Larger: ways are shorter.
        pub counts_per_revolution: f64 = 333.3,
        /// Diameter of the wheels, m. Larger: ways are longer.
        pub wheel_diameter: f64 = 0.0582,
        /// From the left wheels to the right ones, m. Larger: turns are smaller.
        pub track_width: f64 = 0.190,
        /// Readings of rangers from here on, m, say that nothing came back from nearer.
        pub ranger_reach: f64 = 2.0,
        /// Revolutions of the lidar a second, Hz. Larger: the log is over sooner, and what moves is
        /// faster.
        pub revolution_rate: f64 = crate::format::revolution_log::NOMINAL_RATE,
    }
}

/// Why a setting cannot be set.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SettingError {
    /// There is no setting of that key.
    #[error("there is no setting `{0}`")]
    Unknown(String),
    /// The value is outside its range.
    #[error("{name} is {value}{unit}, expected {expected}")]
    Range {
        /// Name for people.
        name: &'static str,
        /// What was asked for.
        value: f64,
        /// Unit with a space in front, or nothing.
        unit: String,
        /// What is allowed.
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
            log: LogSettings::default(),
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

    /// The settings that differ from `defaults`, with their numbers.
    #[must_use]
    pub fn changes_from(&self, defaults: &Self) -> Vec<(String, f64)> {
        let changed = table().filter_map(|setting| {
            let number = self.get(setting)?;
            (defaults.get(setting) != Some(number)).then(|| (setting.key.to_owned(), number))
        });
        changed.collect()
    }

    /// The number of a setting; `None` if this sensor or rule does not have it.
    #[must_use]
    pub fn get(&self, setting: &Setting) -> Option<f64> {
        (setting.field.get)(self)
    }
}

/// The row of a setting.
///
/// # Errors    [`SettingError::Unknown`].
pub(crate) fn find(key: &str) -> Result<&'static Setting, SettingError> {
    let found = table().find(|setting| setting.key == key);
    found.ok_or_else(|| SettingError::Unknown(key.to_owned()))
}

/// The defaults of estimation and driving for a sensor.
///
/// A sensor that scans only on command sees each cell a few times at most and little of each wall,
/// with long drives by odometry between scans: it takes Celej's quicker grid, and the `short_range`
/// figures of lines, filter and pilot.
fn estimation_and_driving(sensor: &SensorModel) -> (SlamConfig, PilotConfig) {
    let mut slam = SlamConfig::default();
    match sensor {
        SensorModel::Rangers(_) => return (SlamConfig::short_range(), PilotConfig::short_range()),
        SensorModel::Sonar(sonar) => slam.evidence = EvidenceConfig::cones(sonar.half_angle),
        SensorModel::Lidar(_) => {}
    }
    (slam, PilotConfig::default())
}
