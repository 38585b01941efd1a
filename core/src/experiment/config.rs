//! What makes a run.

use crate::pilot::{Mode, PilotConfig};
use crate::robot::{OdometryCalibration, RobotModel, TrackWear};
use crate::settings::Settings;
use crate::sim::sensors::SonarModel;
use crate::sim::{SensorModel, World};
use crate::slam::{Method, PriorMap, SlamConfig};

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
    /// Whether it drives by the cycle of TDK 2016 §6.3 (scan standing, plan, one turn, one leg)
    /// also with a sensor that looks round all the time. Default false.
    pub cycle: bool,
    /// How the robot's tracks differ from its model; none: as the seed draws it.
    pub wear: Option<TrackWear>,
    /// What is known of the odometry; how it errs is the robot's.
    pub calibration: OdometryCalibration,
    /// Settings of the estimation.
    pub slam: SlamConfig,
    /// Settings of planning and driving.
    pub pilot: PilotConfig,
}

impl ExperimentConfig {
    /// The defaults for the given world, robot, sensor and seed: the line filter explores.
    #[must_use]
    pub fn new(world: World, robot: RobotModel, sensor: SensorModel, seed: u64) -> Self {
        let settings = Settings::of(sensor, &robot);
        Self {
            // Its body is the model's: no setting has changed it.
            robot,
            ..Self::of(&settings, world, robot, seed)
        }
    }

    /// The same with other settings.
    #[must_use]
    pub fn of(settings: &Settings, world: World, robot: RobotModel, seed: u64) -> Self {
        Self {
            world,
            robot: settings.body.on(robot),
            sensor: settings.sensor.clone(),
            sonars_beside: settings.sonars_beside.clone(),
            seed,
            method: Method::LineEkf,
            mode: Mode::Explore,
            cycle: false,
            wear: settings.wear.used(),
            calibration: settings.odometry.calibration(&robot),
            slam: settings.slam.clone(),
            pilot: settings.pilot.clone(),
        }
    }

    /// The settings of estimation; for a prior map without one of its own, the walls of the world.
    pub(super) fn slam_with_walls(&self) -> SlamConfig {
        let mut slam = self.slam.clone();
        if self.method.needs_prior_map() && slam.prior_map.faces.is_empty() {
            let walls = self.world.walls();
            let walls = walls.iter().map(|wall| wall.segment);
            slam.prior_map.faces = PriorMap::of_walls(walls, &self.world.start).faces;
        }
        slam
    }
}
