//! Why a simulation cannot begin.

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
    /// The robot's motors cannot be used, or not controlled.
    #[error("robot: {0}")]
    Drive(#[from] DesignError),
    /// The robot cannot be used.
    #[error("robot: {field} is {value}, expected more than 0 and finite")]
    Robot {
        /// The figure.
        field: &'static str,
        /// What stands there.
        value: f64,
    },
}

pub(super) fn check_robot(robot: &RobotModel) -> Result<(), SimError> {
    let figures = [
        ("length", robot.length),
        ("width", robot.width),
        ("track_width", robot.track_width),
        ("metres_per_tick", robot.metres_per_tick),
        ("max_speed", robot.max_speed),
        ("max_turn_rate", robot.max_turn_rate),
        ("max_acceleration", robot.max_acceleration),
        ("max_turn_acceleration", robot.max_turn_acceleration),
    ];
    match figures
        .into_iter()
        .find(|(_, value)| !(*value > 0.0 && value.is_finite()))
    {
        None => Ok(()),
        Some((field, value)) => Err(SimError::Robot { field, value }),
    }
}
