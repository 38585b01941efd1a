//! Detection and tracking of moving objects: people who walk about, and the points on them.
//!
//! In: scans, the map, and the robot's pose in it. Out: tracks with position, velocity and
//! covariance, and which beams end on them.
//!
//! ```text
//!   scan ─> beams that end on what is followed ─> the other beams ─> estimation ─> pose, map
//!                     ▲                                                             │
//!                   tracks <── sightings <── clusters <── hits in free space <──────┘
//! ```
//!
//! | file | subject |
//! |---|---|
//! | `moving_objects` | the whole process, scan by scan |
//! | `free_space` | hits where the map is known to be free |
//! | `clusters` | neighbouring hits, and the position of a thing's middle |
//! | `state` | the constant-velocity Kalman filter |
//! | `kalman_tracks`, `gm_phd` | which sighting belongs to which object |
//! | `motion` | what moves, and what only seemed to |
//! | `ospa` | how far tracks are from the truth |
//!
//! [`crate::points::Walkers`] warns of approaching people without map and pose, from one scan to
//! the next, for a robot that has to stop at once; here people are tracked, through halts and
//! occlusions.

mod clusters;
mod config;
mod free_space;
mod gm_phd;
mod kalman_tracks;
mod motion;
mod moving_objects;
mod ospa;
mod state;

pub use config::{TrackAssociation, TrackingConfig};
pub use motion::TrackMotion;
pub use moving_objects::{Matched, MovingObjects, Track};
pub use ospa::ospa;
pub use state::{ObjectState, Sighting};
