//! From a path to commands, and from any command to a safe one.

mod follow;
mod safe;
#[cfg(test)]
mod tests;
mod watch;

pub use follow::{FollowConfig, Follower, Steering};
pub use safe::{SafeConfig, free_distance, limit_speed, within_model};
pub use watch::ProgressWatch;
