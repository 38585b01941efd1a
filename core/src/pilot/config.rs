//! The pilot's figures.

use crate::control::{Avoidance, FollowConfig, SafeConfig};
use crate::plan::{FrontierConfig, RouteConfig};

/// How the pilot plans, drives and gives up.
#[derive(Clone, Debug, PartialEq)]
pub struct PilotConfig {
    /// Planning. The middle margin grows with the uncertainty of the pose.
    pub route: RouteConfig,
    /// Following.
    pub follow: FollowConfig,
    /// Safe mode.
    pub safe: SafeConfig,
    /// What it does about people in its way. Default [`Avoidance::KeepsToWay`].
    pub avoidance: Avoidance,
    /// Exploration.
    pub frontier: FrontierConfig,
    /// Whether it goes back to where it began when all is explored. Default false.
    pub return_home: bool,
    /// Without progress for this long the robot backs off, s. Default 3.
    pub patience: f64,
    /// How many scans of one frontier may show nothing new (less than a tenth of what it promised)
    /// before it is given up. Default 4.
    pub scans_per_frontier: usize,
    /// Longest leg between two scans of a sensor that scans on command, m. Default 0.7.
    pub longest_leg: f64,
    /// How uncertain odometry may make the heading between two scans of a sensor that scans on
    /// command, rad. Default 0.05, 3°. Larger: fewer scans, more walls that are not recognised: of
    /// 40 errands of the rp6 in `arena` 38 arrive at 0.06, and 11 of 20 at 0.12.
    pub leg_heading_sigma: f64,
    /// Whether a leg goes on until the estimate says that the heading is so uncertain, and a turn
    /// is followed by a scan only then; else both are judged beforehand by the model alone. Default
    /// false. With rangers true saves a sixth of the time in `arena` and `doors` (20 of 20 each
    /// without contact), but a robot among people (`crowd`, seed 1) drove into one in an hour, and
    /// into none with false.
    pub legs_by_estimate: bool,
}

impl Default for PilotConfig {
    fn default() -> Self {
        Self {
            route: RouteConfig::default(),
            follow: FollowConfig::default(),
            safe: SafeConfig::default(),
            avoidance: Avoidance::default(),
            frontier: FrontierConfig::default(),
            return_home: false,
            patience: 3.0,
            scans_per_frontier: 4,
            longest_leg: 0.7,
            leg_heading_sigma: 0.05,
            legs_by_estimate: false,
        }
    }
}

impl PilotConfig {
    /// For a sensor that scans on command and sees little: frontiers creep on by decimetres, so
    /// that one place is the goal more often before it is known, and the border of what is known is
    /// scanned in pieces of a metre. Its ranges err by centimetres, so it keeps that much more from
    /// what it saw.
    #[must_use]
    pub fn short_range() -> Self {
        let default = Self::default();
        Self {
            scans_per_frontier: 8,
            frontier: FrontierConfig {
                longest: 1.0,
                ..default.frontier
            },
            safe: SafeConfig {
                gap: 0.05,
                ..default.safe
            },
            ..default
        }
    }
}
