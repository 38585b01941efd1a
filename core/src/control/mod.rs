//! From a path to commands, and from any command to a safe one.

mod curve;
mod follow;
mod safe;
#[cfg(test)]
mod tests;
mod watch;

pub use curve::CurveFollower;
pub use follow::{FollowConfig, Follower, LegFollower, Steering};
pub use safe::{SafeConfig, free_distance, limit_speed, within_model};
pub use watch::ProgressWatch;
