//! Walkers that came since the last scan, from partial scans: a sensor that sweeps only while the
//! robot stands sees nothing else of people.
//!
//! 1. A reading in space that the last scan saw to be free, by more than the possible error of
//!    both, belongs to somebody who came.
//! 2. They stay where they were seen for [`KEPT_FOR`], or until the next scan.
//!
//! One reading is enough: a false one costs only a sweep, and by the next partial scan a walker has
//! moved half a metre.

use nalgebra::Point2;

use super::{BEHIND, Beam, Points, Walkers};
use crate::geom::Pose2;
use crate::robot::Stamp;

/// How long somebody counts without being seen again, s: a turn and the beginning of a leg.
const KEPT_FOR: f64 = 3.0;
/// Number of standard deviations by which a reading may err.
const SIGMAS: f64 = 3.0;
/// Possible error of odometry in a turn, as [`super::TURN_DRIFT`]; it grows with the root of the
/// turn. Two standard deviations for tracks that slip by 2e-3 rad²/rad, as those of the small
/// robots that carry such sensors.
const TURN_DRIFT: f64 = 0.09;

/// Somebody who came, robot frame of the last scan.
#[derive(Clone, Copy, Debug)]
pub(super) struct Newcomer {
    pub(super) at: Point2<f64>,
    seen: Stamp,
}

impl Walkers {
    /// Takes readings on the move; `robot_at_scan_from_robot` is the motion since the last scan.
    /// Afterwards [`Self::points`] are those who came. Returns those whom these readings saw, robot
    /// frame of the last scan, m.
    pub fn partial_scan(
        &mut self,
        readings: &Points,
        robot_at_scan_from_robot: &Pose2,
    ) -> Vec<Point2<f64>> {
        self.newcomers
            .retain(|other| readings.stamp.since(other.seen) <= KEPT_FOR);
        let Some(mut past) = self.past.back().cloned() else {
            return vec![];
        };
        // For these readings only: the next scan brings the whole motion.
        past.now_from_then = robot_at_scan_from_robot.inverse();
        let has_come = |beam: &&Beam| {
            let behind = BEHIND + SIGMAS * beam.sigma;
            past.looked_past(beam.end_in_robot, behind, TURN_DRIFT)
        };
        let in_scan = |beam: &Beam| *robot_at_scan_from_robot * beam.end_in_robot;
        let came: Vec<_> = readings.hits().filter(has_come).map(in_scan).collect();
        let seen = readings.stamp;
        self.newcomers
            .extend(came.iter().map(|&at| Newcomer { at, seen }));
        self.points = self.newcomers.iter().map(|other| other.at).collect();
        came
    }
}
