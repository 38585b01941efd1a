//! Why a simulation cannot begin.

use crate::bounds::{OutOfBounds, POSITIVE, check};
use crate::robot::RobotModel;
use crate::robot::controller::DesignError;
use crate::sim::WorldError;
use crate::sim::sensors::SensorError;

/// Why a simulation cannot begin.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SimError {
    /// The world cannot be used.
    #[error("world {name:?}: {source}")]
    World {
        /// Name of the world.
        name: String,
        /// What is wrong with it.
        source: WorldError,
    },
    /// The sensor cannot be used.
    #[error(transparent)]
    Sensor(#[from] SensorError),
    /// The robot's motors cannot be used, or cannot be controlled.
    #[error("robot: {0}")]
    Drive(#[from] DesignError),
    /// A figure of the robot is out of its bounds.
    #[error("robot: {0}")]
    Robot(#[from] OutOfBounds),
}

pub(super) fn check_robot(robot: &RobotModel) -> Result<(), SimError> {
    let turn_acceleration = robot.max_turn_acceleration;
    Ok(check(&[
        ("length", robot.length, POSITIVE),
        ("width", robot.width, POSITIVE),
        ("track_width", robot.track_width, POSITIVE),
        ("metres_per_tick", robot.metres_per_tick, POSITIVE),
        ("max_speed", robot.max_speed, POSITIVE),
        ("max_turn_rate", robot.max_turn_rate, POSITIVE),
        ("max_acceleration", robot.max_acceleration, POSITIVE),
        ("max_turn_acceleration", turn_acceleration, POSITIVE),
    ])?)
}
