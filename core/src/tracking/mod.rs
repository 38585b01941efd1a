//! Detection and tracking of moving objects: people who walk about, and the points that are theirs.
//!
//! In: scans, the map, and where the robot is in it. Out: tracks with position, velocity and
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
//! | `moving_objects` | the whole, scan by scan |
//! | `free_space` | hits where the map is known to be free |
//! | `clusters` | neighbouring hits, and where the middle of a thing is |
//! | `state` | the constant-velocity Kalman filter |
//! | `kalman_tracks`, `gm_phd` | which sighting is of which object |
//! | `motion` | what moves, and what only seemed to |
//! | `ospa` | how far tracks are from the truth |
//!
//! [`crate::points::Walkers`] warns of who comes near without map and pose, from one scan to the
//! next, for a robot that has to stop at once; here people are followed, through halts and behind
//! each other.

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
