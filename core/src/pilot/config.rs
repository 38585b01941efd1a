//! The pilot's settings.

use crate::bounds::config;
use crate::control::{Avoidance, FollowConfig, SafeConfig};
use crate::plan::{FrontierConfig, RouteConfig};

config! {
    /// How the pilot plans, drives and gives up.
    #[derive(Clone, Debug, PartialEq)]
    pub struct PilotConfig {
        /// Planning. The middle margin grows with the uncertainty of the pose.
        pub route: RouteConfig = RouteConfig::default(),
        /// Following.
        pub follow: FollowConfig = FollowConfig::default(),
        /// Safe mode.
        pub safe: SafeConfig = SafeConfig::default(),
        /// What it does about people in its way. Default [`Avoidance::KeepsToWay`].
        pub avoidance: Avoidance = Avoidance::default(),
        /// Exploration.
        pub frontier: FrontierConfig = FrontierConfig::default(),
        /// Whether it drives through the gap of each open loop when all is explored, as far as the
        /// map is made by a pose graph. Default true.
        pub close_loops: bool = true,
        /// Whether it goes back to where it began when all is explored. Default false.
        pub return_home: bool = false,
        /// Without progress for this long the robot backs off, s. Default 3.
        pub patience: f64 = 3.0,
        /// A robot whose place in the map around it is less sure than that (standard deviation in
        /// the worse direction, m) is lost. Default 1: twice that to either side is a room, so that
        /// the map does not even say in which one it is. Rangers that see 0.7 m far come to 0.6 in
        /// `doors` and find their walls again; sonars at smooth walls come to many metres. Larger:
        /// it drives on by a map that it cannot find its way in.
        pub lost_sigma: f64 = 1.0,
        /// But only once that has lasted so long, s: a loop that closes mends it. Default 20.
        pub lost_after: f64 = 20.0,
        /// How many scans of one frontier may show nothing new (less than a tenth of what it
        /// promised) before it is given up. Default 4.
        pub scans_per_frontier: usize = 4,
        /// Longest leg between two scans of a sensor that scans on command, m. Default 0.7.
        pub longest_leg: f64 = 0.7,
        /// How uncertain odometry may make the heading between two scans of a sensor that scans on
        /// command, rad. Default 0.05, 3°. Larger: fewer scans, more walls that are not recognised:
        /// of 40 errands of the rp6 in `arena` 38 arrive at 0.06, and 11 of 20 at 0.12.
        pub leg_heading_sigma: f64 = 0.05,
        /// Whether a leg goes on until the estimate says that the heading is so uncertain, and a
        /// turn is followed by a scan only then; else both are judged beforehand by the model
        /// alone. Default false. With rangers true saves a sixth of the time in `arena` and `doors`
        /// (20 of 20 each without contact), but a robot among people (`crowd`, seed 1) drove into
        /// one in an hour, and into none with false.
        pub legs_by_estimate: bool = false,
    }
}

impl PilotConfig {
    /// For a sensor that scans on command and has a short range: frontiers move by decimetres, so
    /// one place is the goal more often before it is known, and the border of the known area is
    /// scanned in pieces of a metre. Its ranges err by centimetres, so it keeps that much more
    /// distance from what it saw.
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
