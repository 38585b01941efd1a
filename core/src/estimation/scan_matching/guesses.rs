//! Candidate motions since the last scan.
//!
//! In: what odometry says, if the motion is counted, and the previous scans. Out: guesses, the
//! likeliest first.
//!
//! 1. If there is odometry, its motion comes first. It may be wrong: then the robot stood still, or
//!    went on as before; or odometry came late, so the matches of previous scans already include a
//!    part of it, and it must be counted from one of those scans.
//! 2. Without odometry the robot is assumed to go on as before: a carried sensor keeps its speed
//!    from scan to scan.
//! 3. Odometry that failed is tried after those.
//! 4. In any case the robot may have turned more or less: a fan of headings is tried.
//!
//! Source of step 2: Vizzo et al. (2023), "KISS-ICP: in defense of point-to-point ICP".

use nalgebra::{Matrix3, Vector3};

use super::ScanMatcher;
use super::odometry_watch::Believed;
use crate::geom::{Length, Pose2, PoseEstimate, pose_cov};
use crate::registration::{Prior, RollingPrior};
use crate::robot::Stamp;

/// A motion that may have taken place.
#[derive(Clone, Copy, Debug)]
pub(super) struct Guess {
    /// Where it leads, in the running submap.
    pub(super) pose: Pose2,
    /// Uncertainty of the motion itself.
    pub(super) cov: Matrix3<f64>,
    /// Prior penalty, as a fraction of the scan's points.
    pub(super) penalty: f64,
}

/// A speed and a turn rate that robots in buildings seldom exceed, m/s and rad/s.
const FAST: f64 = 1.5;
const FAST_TURN: f64 = 1.5;
/// Usual changes of speed, m/s² and rad/s².
const ACCELERATION: f64 = 1.0;
const TURN_ACCELERATION: f64 = 3.0;
/// After longer than this, s, nothing is known of a motion that odometry did not count.
pub(super) const LONG_AGO: f64 = 10.0;
/// Penalties for having stopped and for having turned, if odometry did not count the motion.
const STOPPED: f64 = 0.05;
const TURNED: f64 = 0.1;
/// Uncertainty of the last matched pose, m and rad, while the motion from it is corrected: slipping
/// wheels do not slip at an even rate, and the pose at the end of a sweep is no better known than
/// that.
const BEGIN_SHIFT: f64 = 0.015;
const BEGIN_TURN: f64 = 0.02;
/// The fan of headings, rad.
const FAN: [f64; 8] = [0.15, -0.15, 0.35, -0.35, 0.6, -0.6, 0.9, -0.9];

impl ScanMatcher {
    /// The candidate motions, the likeliest first.
    pub(super) fn guesses(&self, moved: &Believed, stamp: Stamp) -> Vec<Guess> {
        let seconds = self.seconds_until(stamp);
        let freely = |pose: Pose2, penalty: f64| Guess {
            pose,
            cov: self.unguided_cov(seconds),
            penalty,
        };
        let here = self.local.pose;
        let speed = self.motion.speed;
        let [as_before, as_fast] = speed.map_or([Pose2::identity(); 2], |(past, motion)| {
            // Stamps may jitter: limit the motion to between half and twice the last one.
            let part = (seconds.max(1e-6) / past.max(1e-6)).clamp(0.5, 2.0);
            [motion, motion.fraction(part)]
        });
        let lead = match moved.counted() {
            Some(moved) => {
                let turned = here.rotation();
                let mut cov = turned * moved.cov * turned.transpose();
                if moved.motion == Pose2::identity() {
                    // If it stops more suddenly than robots do, it may still be moving while
                    // odometry hangs.
                    let went_on = unbraked(&(here * as_before).minus(&here), seconds);
                    cov += went_on * went_on.transpose();
                }
                Guess {
                    pose: here * moved.motion,
                    cov,
                    penalty: 0.0,
                }
            }
            None => freely(here * as_before, 0.0),
        };
        let mut list = vec![lead, freely(here * as_fast, 0.0), freely(here, STOPPED)];
        if let Believed::Failed(Some(moved)) = moved {
            list.push(freely(here * moved.motion, 0.0));
        }
        if moved.counted().is_some() {
            list.push(freely(here * as_before, 0.0));
            list.extend(self.motion.pasts.iter().rev().skip(1).map(|past| {
                let since = past.odom_from_robot.delta_to(&self.motion.odom_from_robot);
                freely(past.submap_from_robot * since, 0.0)
            }));
        }
        let most = FAST_TURN * seconds.clamp(0.1, 1.0);
        let fan = FAN.into_iter().filter(|turn| turn.abs() <= most);
        list.extend(fan.map(|turn| freely(lead.pose * Pose2::new(0.0, 0.0, turn), TURNED)));
        list
    }

    /// Where the first candidate motion leads, with the whole uncertainty of the pose there.
    pub(super) fn predicted(&self, moved: &Believed, lead: &Guess) -> PoseEstimate {
        match moved.counted() {
            Some(moved) => moved.after(&self.local),
            None => PoseEstimate {
                pose: lead.pose,
                cov: self.local.cov + lead.cov,
            },
        }
    }

    /// Prior of a motion while it is matched: the pose at the last match defines the map there, and
    /// is not doubted here.
    pub(super) fn prior_of(&self, guess: &Guess) -> Prior {
        let mut cov = guess.cov + self.odometry_floor();
        if self.is_blind {
            cov += self.local.cov;
        }
        // A covariance that odometry spoilt gives no information.
        let information = cov.try_inverse().unwrap_or_else(Matrix3::zeros);
        Prior {
            pose: guess.pose,
            information,
        }
    }

    /// Prior of a motion while points seen along it are matched. `by_odometry` is the pose by
    /// odometry alone.
    pub(super) fn rolling_prior(&self, guess: &Guess, by_odometry: &Pose2) -> RollingPrior {
        let mut at_begin = pose_cov(BEGIN_SHIFT, BEGIN_TURN);
        if self.is_blind {
            at_begin += self.local.cov;
        }
        let inverse = |cov: Matrix3<f64>| cov.try_inverse().unwrap_or_else(Matrix3::zeros);
        RollingPrior {
            by_odometry: Prior {
                pose: *by_odometry,
                information: inverse(at_begin),
            },
            error: guess.pose.minus(by_odometry),
            error_information: inverse(guess.cov + self.odometry_floor()),
        }
    }

    /// Time from the last scan to this one, s.
    pub(super) fn seconds_until(&self, stamp: Stamp) -> f64 {
        self.motion
            .pasts
            .back()
            .map_or(0.0, |p| stamp.since(p.stamp))
    }

    /// How far a fast robot moves and turns within this time, m and rad.
    pub(super) fn fast(seconds: f64) -> [f64; 2] {
        [FAST * seconds, FAST_TURN * seconds]
    }

    /// Uncertainty of a motion of this duration if odometry does not count it.
    fn unguided_cov(&self, seconds: f64) -> Matrix3<f64> {
        let seconds = seconds.clamp(0.0, LONG_AGO);
        let half_square = 0.5 * seconds * seconds;
        let [way, turn] = Self::fast(seconds);
        pose_cov(
            self.config.odometry_sigma + way.min(ACCELERATION * half_square),
            self.config.odometry_turn_sigma + turn.min(TURN_ACCELERATION * half_square),
        )
    }
}

/// What remains of a motion (x, y, θ) from scan to scan after the robot has braked as usual for
/// this many seconds.
fn unbraked(motion: &Vector3<f64>, seconds: f64) -> Vector3<f64> {
    let left = |speed: f64, braking: f64| {
        let by_brake = braking * seconds * seconds;
        (1.0 - by_brake / speed.max(1e-9)).max(0.0)
    };
    let shift = motion.xy() * left(motion.xy().length(), ACCELERATION);
    shift.push(motion.z * left(motion.z.abs(), TURN_ACCELERATION))
}
