//! The simulated robot in a simulated building: takes [`crate::robot::Command`], returns encoder
//! ticks and [`crate::robot::Scan`], exactly as a real one does, and also knows the truth.
//!
//! | file | subject |
//! |---|---|
//! | `world` | what the building contains, where the robot starts |
//! | `worlds/` | the built-in worlds, one file each |
//! | `cast` | rays, fans of rays and distances to walls through a grid |
//! | `drive` | from commands to track motion: desired speeds within limits, the controller, the motors |
//! | `motor` | a running motor: inertia, current, dry friction |
//! | `response` | how motors and controller respond to a step or a load, as time series |
//! | `body` | from track motion to true motion: slip, collision, contacts, bumpers |
//! | `contact` | contacts, counted by what was touched and who moved |
//! | `battery` | voltage that sags with the load and falls with time |
//! | `doors` | doors that open and shut, by schedule and on command |
//! | `movers` | discs that walk along way-points |
//! | `sensors/` | lidars, infra-red rangers on a servo, sonars |
//! | `scan_pair` | two scans and the motion between them, for testing registration |
//! | `reachable` | what can be explored: the denominator of "explored fraction" |
//!
//! One seed, one world and one list of commands give the same bits everywhere. Motion and sensors
//! draw from separate streams of ChaCha8, so changing the sensor does not change how the tracks
//! slip.

mod battery;
mod body;
mod cast;
mod contact;
mod doors;
mod drive;
mod motor;
mod movers;
mod noise;
mod reachable;
pub mod response;
pub mod scan_pair;
pub mod sensors;
mod simulation;
mod things;
mod world;
pub mod worlds;

pub use battery::BatteryModel;
pub use cast::{Caster, Fan, Hit};
pub use contact::Contacts;
pub use doors::NoDoor;
pub use motor::Motor;
pub use reachable::{ReachableArea, reachable_area};
pub use sensors::{SensorKind, SensorModel, UnknownSensor};
pub use simulation::{Blocked, SimError, Simulation, TIME_STEP};
pub use things::{Thing, Things};
pub use world::{Disc, Door, Material, Mover, Obstacle, RobotKind, Shape, Wall, World, WorldError};
