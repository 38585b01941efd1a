//! What a session begins with.

use crate::pilot::PilotConfig;
use crate::robot::{OdometryCalibration, RobotModel};
use crate::settings::Settings;
use crate::slam::{Method, SlamConfig};

/// What a session begins with.
#[derive(Clone, Debug)]
pub struct SessionConfig {
    /// The robot's figures.
    pub robot: RobotModel,
    /// Whether its sensor scans only on command, while the robot stands.
    pub scans_on_command: bool,
    /// Whether somebody drives the robot by what is seen; nobody does in a recording, and then
    /// walkers are not searched for.
    pub is_driven: bool,
    /// How the pose is estimated.
    pub method: Method,
    /// Seed of the pilot's random numbers.
    pub seed: u64,
    /// Settings of the estimation.
    pub slam: SlamConfig,
    /// Settings of planning and driving.
    pub pilot: PilotConfig,
    /// What is known of the odometry.
    pub calibration: OdometryCalibration,
}

impl SessionConfig {
    /// A session with these settings: the line filter, on a robot that is driven.
    #[must_use]
    pub fn of(settings: &Settings, robot: RobotModel, scans_on_command: bool) -> Self {
        Self {
            robot,
            scans_on_command,
            is_driven: true,
            method: Method::LineEkf,
            seed: 0,
            slam: settings.slam.clone(),
            pilot: settings.pilot.clone(),
            calibration: settings.odometry.calibration(&robot),
        }
    }
}
