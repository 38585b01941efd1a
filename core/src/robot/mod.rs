//! What crosses the border between a robot (real, simulated or recorded) and the rest: stamps,
//! scans, odometry, commands, the figures of the robot itself, and the conversion of a ranger's
//! volts to a range.

mod adc;
mod bumpers;
mod characteristic;
mod command;
pub mod controller;
mod even;
mod lost_readings;
mod model;
mod motor;
mod odometry;
mod ranger;
mod scan;
mod sharp;
mod stamp;
mod wear;

pub use adc::Adc;
pub use bumpers::Bumpers;
pub use characteristic::{
    CalibrationPair, Characteristic, CharacteristicError, Fit, LEAST_PAIRS, Variable,
};
pub use command::Command;
pub use even::EvenBeams;
pub use lost_readings::{Place, places_of_revolution};
pub use model::{BodyShape, OdometryBias, OdometryNoise, RobotModel};
pub use motor::{DriveTrain, MotorError, MotorModel};
pub use odometry::{Odometry, OdometryError, TrackNoise, TrackOdometry, Tracks};
pub use ranger::{RangerInverse, RangerModel};
pub use scan::{Scan, ScanError};
pub use sharp::Sharp;
pub use stamp::Stamp;
pub use wear::{OdometryCalibration, TrackWear};
