//! What makes a run.

use crate::map::EvidenceConfig;
use crate::pilot::{Mode, PilotConfig};
use crate::robot::{RobotModel, TrackNoise, TrackWear};
use crate::sim::sensors::SonarModel;
use crate::sim::{SensorModel, World};
use crate::slam::{Method, SlamConfig};

/// What makes a run; the same configuration makes the same run.
#[derive(Clone, Debug)]
pub struct ExperimentConfig {
    /// Where the robot is.
    pub world: World,
    /// What it is.
    pub robot: RobotModel,
    /// What it sees with.
    pub sensor: SensorModel,
    /// Sonars beside it, which draw a map of their own. Default none.
    pub sonars_beside: Option<SonarModel>,
    /// Of all noise.
    pub seed: u64,
    /// How it estimates.
    pub method: Method,
    /// What it does at first.
    pub mode: Mode,
    /// Whether it drives by the cycle of TDK 2016 §6.3 (scan standing, plan, one turn, one leg) also with a sensor that looks
    /// round all the time. Default false.
    pub cycle: bool,
    /// How the robot's tracks differ from its model; none: as the seed draws it.
    pub wear: Option<TrackWear>,
    /// How the odometry takes them to differ.
    pub told_wear: TrackWear,
    /// What the odometry says of its own errors; how it errs is the robot's.
    pub odometry: TrackNoise,
    /// Settings of the estimation.
    pub slam: SlamConfig,
    /// Settings of planning and driving.
    pub pilot: PilotConfig,
}

impl ExperimentConfig {
    /// The settings for the given world, robot, sensor and seed: the line filter explores.
    ///
    /// A sensor that scans only on command sees each cell a few times at most, little of each wall, and from afar in terms
    /// of odometry: it takes Celej's quicker grid, and the `short_range` figures of lines, filter and pilot.
    #[must_use]
    pub fn new(world: World, robot: RobotModel, sensor: SensorModel, seed: u64) -> Self {
        let (slam, pilot) = Self::settings_for(&sensor);
        Self {
            world,
            robot,
            sensor,
            sonars_beside: None,
            seed,
            method: Method::LineEkf,
            mode: Mode::Explore,
            cycle: false,
            wear: None,
            told_wear: TrackWear::default(),
            odometry: TrackNoise::Proportional(robot.odometry_noise),
            slam,
            pilot,
        }
    }

    /// The settings of estimation and driving for a sensor.
    pub(crate) fn settings_for(sensor: &SensorModel) -> (SlamConfig, PilotConfig) {
        if let SensorModel::Sonar(sonar) = sensor {
            let evidence = EvidenceConfig::cones(sonar.half_angle);
            let slam = SlamConfig {
                evidence,
                ..SlamConfig::default()
            };
            return (slam, PilotConfig::default());
        }
        if !sensor.scans_on_command() {
            return (SlamConfig::default(), PilotConfig::default());
        }
        (SlamConfig::short_range(), PilotConfig::short_range())
    }
}
