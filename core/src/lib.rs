//! slamlab's core: a small robot maps a building it has never seen, finds itself in it, plans and
//! drives.
//!
//! The modules stand in the order in which data flows. Each imports only from those above it,
//! except the sources that close the loop ([`experiment`], [`replay`], [`live`]); a test checks
//! this. There is no I/O, no clock, no thread, no global state and no operating-system randomness
//! here: time is an argument, and randomness is a seeded generator that the caller passes in.
//!
//! # Conventions, everywhere
//!
//! | what | how |
//! |---|---|
//! | units | metres, radians, seconds; `f64` (`f32` only in [`robot::Scan`], grids and buffers) |
//! | frames | right-handed, x forward, y left, angles counter-clockwise (+90° takes the x axis to the y axis) |
//! | angles | wrapped to (-π, π] by [`geom::wrap`] |
//! | transforms | `a_from_b * p_in_b = p_in_a`, read right to left: `map_from_scan = map_from_robot * robot_from_scan` |
//! | frame names | `map`, `odom`, `robot` (ROS `base_link`), `sensor`, as in ROS REP-103 and REP-105 |
//! | a line | `(alpha, r)`: x cos α + y sin α = r with r ≥ 0 |
//! | same bits | transcendental functions come from `libm`, so native and browser runs are equal to the bit |

// Vocabulary.
pub mod geom;

pub mod hash;

pub mod bounds;

mod lanes;

// What crosses the border to a robot.
pub mod robot;

// State as bytes.
pub mod snapshot;

// The stages, in the order of the data.
pub mod points;

pub mod features;

pub mod map;

pub mod association;

pub mod registration;

pub mod estimation;

pub mod tracking;

pub mod plan;

pub mod control;

// The stories: estimate and map; decide and drive.
pub mod slam;

pub mod pilot;

// Simulator, files and messages: no stage imports them.
pub mod sim;

pub mod format;

pub mod wire;

// The whole loop on one robot, and every setting of it.
pub mod settings;

pub mod twin;

pub mod session;

// Its sources: a simulation, a recording, a robot behind a bridge.
pub mod experiment;

pub mod lesson;

pub mod replay;

pub mod live;

// Both ends of a serial line, and the rules that keep a robot safe.
pub mod device;
