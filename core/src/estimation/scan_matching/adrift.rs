//! A robot at an unknown place: scans are missing, and what it sees now was not seen before.
//!
//! In: the motion since the last scan by odometry, and how much of the new scan lies on the running
//! submap. Out: the uncertainty of the pose beyond that of odometry.
//!
//! 1. If such a scan were drawn into the running submap, only odometry would tie it to what was
//!    there before, and the next submap would take over both: loops closed over the old part would
//!    seem to prove the new one. It therefore begins a submap of its own.
//! 2. Odometry between two scans gives only the net motion. During a gap of a minute the robot kept
//!    its usual pace, out and back again, and odometry erred on all of that: its covariance grows
//!    with the distance driven. The heading error made on the way rotates everything after it.

use nalgebra::Matrix3;

use super::super::agreement::Agreement;
use super::super::submap::Doubt;
use super::ScanMatcher;
use super::guesses::{Guess, LONG_AGO};
use super::seen::Seen;
use super::tracking::{OTHER_OVERLAP, is_quiet};
use crate::geom::{Length, Pose2, pose_cov};
use crate::robot::Stamp;

/// A motion with more uncertainty than this, m and rad, must be confirmed by what is seen.
const ADRIFT_SHIFT: f64 = 0.2;
const ADRIFT_TURN: f64 = 0.25;
/// The largest uncertainty, m and rad: the robot may be anywhere.
const ANYWHERE: [f64; 2] = [50.0, 3.0];

impl ScanMatcher {
    /// The uncertainty of the pose beyond the covariance of odometry, if a scan of many points
    /// follows a poorly known motion and little of it lies on the submap.
    pub(super) fn adrift(
        &self,
        seen: &Seen,
        lead: &Guess,
        agreement: &Agreement,
        stamp: Stamp,
    ) -> Option<Matrix3<f64>> {
        // After a few seconds odometry is more credible than a new place; after a minute it is not.
        let is_silence = self.seconds_until(stamp) >= LONG_AGO;
        let is_unverified = match is_silence {
            true => agreement.overlap() < OTHER_OVERLAP,
            false => is_quiet(agreement),
        };
        if !is_unverified || !self.has_much_to_show(seen) {
            return None;
        }
        let mut cov = lead.cov;
        if self.is_blind {
            cov += self.local.cov;
        }
        let unseen = self.unseen(lead, stamp);
        cov += unseen;
        let doubt = Doubt::of(&cov);
        let is_unknown = doubt.shift > ADRIFT_SHIFT || doubt.turn > ADRIFT_TURN;
        is_unknown.then_some(unseen)
    }

    /// The uncertainty of the motion to `lead` beyond the covariance of the net motion, if it took
    /// long.
    fn unseen(&self, lead: &Guess, stamp: Stamp) -> Matrix3<f64> {
        let seconds = self.seconds_until(stamp);
        let net = self.local.pose.delta_to(&lead.pose);
        if seconds < LONG_AGO || net == Pose2::identity() {
            return Matrix3::zeros();
        }
        let [pace, turning] = self.usual_pace();
        let [way, turn] = [pace * seconds, turning * seconds];
        let [net_way, net_turn] = [net.position().coords.length(), net.heading().abs()];
        let longer = |whole: f64, net: f64| {
            if net > 0.0 {
                (whole / net).max(1.0)
            } else {
                1.0
            }
        };
        let times = longer(way, net_way).max(longer(turn, net_turn));
        let more = |variance: f64| (variance * (times - 1.0)).max(0.0);
        let turn = more(lead.cov[(2, 2)]).sqrt().min(ANYWHERE[1]);
        let shift = more(lead.cov[(0, 0)] + lead.cov[(1, 1)]).sqrt();
        let shift = libm::hypot(shift, 0.5 * way * turn).min(ANYWHERE[0]);
        pose_cov(shift, turn)
    }

    /// Average speed and turn rate of the robot, m/s and rad/s.
    fn usual_pace(&self) -> [f64; 2] {
        let (mut way, mut turn, mut seconds) = (0.0, 0.0, 0.0);
        for pair in self.trajectory.windows(2) {
            let passed = pair[1].stamp.since(pair[0].stamp);
            if pair[0].submap == pair[1].submap && passed < LONG_AGO {
                let motion = pair[0]
                    .submap_from_robot
                    .delta_to(&pair[1].submap_from_robot);
                way += motion.position().coords.length();
                turn += motion.heading().abs();
                seconds += passed;
            }
        }
        [way, turn].map(|sum| if seconds > 0.0 { sum / seconds } else { 0.0 })
    }
}
