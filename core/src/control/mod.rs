//! From a path to commands, and from any command to a safe command.

mod curve;
mod ease;
mod fence_guard;
mod follow;
mod guard;
mod outline;
mod safe;
#[cfg(test)]
mod safe_tests;
mod separation;
mod strip;
#[cfg(test)]
mod tests;
mod watch;
mod window;

pub use curve::CurveFollower;
pub use fence_guard::{FenceConfig, FenceGuard};
pub use follow::{FollowConfig, Follower, LegFollower};
pub use guard::SafeMode;
pub use outline::limit_outline;
pub use safe::{Limits, SafeConfig, Speeds, Underway, limit_speed, within_model};
pub use separation::{leg_is_safe, limit_among_walkers};
pub use strip::free_distance;
pub use watch::ProgressWatch;
pub use window::{Avoidance, People, choose_in_window};
