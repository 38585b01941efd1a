//! What defines a run.

use crate::pilot::{Mode, PilotConfig};
use crate::robot::{OdometryCalibration, RobotModel, TrackWear};
use crate::settings::Settings;
use crate::sim::sensors::SonarModel;
use crate::sim::{SensorModel, World};
use crate::slam::{Method, PriorMap, SlamConfig};

/// What defines a run; the same configuration gives the same run.
#[derive(Clone, Debug)]
pub struct ExperimentConfig {
    /// The world that the robot is in.
    pub world: World,
    /// The robot.
    pub robot: RobotModel,
    /// Its sensor.
    pub sensor: SensorModel,
    /// Sonars in addition, which draw a map of their own. Default none.
    pub sonars_beside: Option<SonarModel>,
    /// Seed of all noise.
    pub seed: u64,
    /// How the pose is estimated.
    pub method: Method,
    /// The mode at the beginning.
    pub mode: Mode,
    /// Whether the robot drives by the cycle of TDK 2016 §6.3 (scan standing, plan, one turn, one
    /// leg), even with a sensor that scans all the time. Default false.
    pub cycle: bool,
    /// How the robot's tracks differ from its model; `None`: as drawn from the seed.
    pub wear: Option<TrackWear>,
    /// What is known of the odometry; its true errors belong to the robot.
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
            // Its body is as in the model: no setting has changed it.
            robot,
            ..Self::of(&settings, world, robot, seed)
        }
    }

    /// The same with these settings.
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

    /// The settings of estimation. A prior map that is required but not given is made from the
    /// walls of the world.
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
