//! Turn-and-go: following straight legs with velocities.
//!
//! In: the path, and the pose estimate at every tick. Out: forward speed and turn rate, until the
//! last leg ends.
//!
//! 1. Turn on the spot until the robot faces along the leg.
//! 2. Drive. The robot aims at a point a little ahead on the leg, so it returns to the line when it
//!    has drifted off (pure pursuit, Coulter 1992); the speed falls with the heading error.
//! 3. Both speeds end in a braking curve, v = √(2 a d) at a fraction of the robot's acceleration,
//!    linear close to the end: a robot that obeys its model arrives without overshoot.
//! 4. The robot does not stop at a corner that is nearly straight.

use nalgebra::Point2;

use super::curve::CurveFollower;
use super::safe::Speeds;
use crate::bounds::config;
use crate::geom::{Pose2, Segment, wrap};
use crate::plan::{Path, Piece};
use crate::robot::RobotModel;

/// Fraction of the robot's acceleration that is used for braking; more is faster and overshoots
/// sooner.
pub(super) const BRAKING: f64 = 0.6;
/// Driving begins below this heading error, rad.
const ALIGNED: f64 = 0.05;
/// Above this heading error the robot stops driving and turns on the spot, rad.
pub(super) const ASTRAY: f64 = 0.6;
/// Turn rate for a radian of heading error, 1/s.
const TURN_GAIN: f64 = 2.5;
/// Corners that turn less than this are taken without a stop, rad.
const SOFT_CORNER: f64 = 0.35;

config! {
    /// How a path is followed.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct FollowConfig {
        /// Part of the robot's highest speeds that is used. Default 1.
        pub pace: f64 = 1.0,
        /// A leg ends this near to its end, m. Default 0.02.
        pub tolerance: f64 = 0.02,
        /// How far ahead on the leg to aim, m. Default 0.25; shorter returns to the line sooner and
        /// swings sooner.
        pub look_ahead: f64 = 0.25,
    }
}

/// Follows one path.
#[derive(Clone, Debug)]
pub enum Follower {
    /// Leg by leg, turning on the spot at the corners.
    Legs(LegFollower),
    /// Over rounded corners, without a stop, by pure pursuit (Coulter 1992).
    Curve(CurveFollower),
}

impl Follower {
    /// A follower for a path of straight legs; legs without length are skipped.
    #[must_use]
    pub fn new(path: &Path) -> Self {
        Self::Legs(LegFollower::new(path))
    }

    /// A follower for a rounded path.
    #[must_use]
    pub fn rounded(pieces: &[Piece]) -> Self {
        Self::Curve(CurveFollower::new(pieces))
    }

    /// The path that is still to be driven, from where the robot is.
    #[must_use]
    pub fn remaining(&self, position: Point2<f64>) -> Path {
        match self {
            Self::Legs(legs) => legs.remaining(position),
            Self::Curve(curve) => curve.remaining(),
        }
    }

    /// The speeds for this tick, m/s and rad/s; `None` when the path has been driven.
    pub fn steer(
        &mut self,
        pose: &Pose2,
        model: &RobotModel,
        config: &FollowConfig,
    ) -> Option<Speeds> {
        match self {
            Self::Legs(legs) => legs.steer(pose, model, config),
            Self::Curve(curve) => curve.steer(pose, model, config),
        }
    }
}

/// Follows straight legs.
#[derive(Clone, Debug)]
pub struct LegFollower {
    legs: Vec<Segment>,
    current: usize,
    is_turning: bool,
}

impl LegFollower {
    /// A follower for a path; legs without length are skipped.
    #[must_use]
    pub fn new(path: &Path) -> Self {
        Self {
            legs: path.legs().filter(|leg| leg.length() > 1e-6).collect(),
            current: 0,
            is_turning: true,
        }
    }

    /// The legs that are still to be driven, the current one from where the robot is.
    #[must_use]
    pub fn remaining(&self, position: Point2<f64>) -> Path {
        let legs = self.legs.get(self.current..).unwrap_or_default();
        let here = legs.first().map(|leg| leg.closest_point(position));
        Path {
            points: here
                .into_iter()
                .chain(legs.iter().map(|leg| leg.b))
                .collect(),
        }
    }

    /// The speeds for this tick, m/s and rad/s; `None` when the path has been driven.
    pub fn steer(
        &mut self,
        pose: &Pose2,
        model: &RobotModel,
        config: &FollowConfig,
    ) -> Option<Speeds> {
        while let Some(&leg) = self.legs.get(self.current) {
            if !has_ended(&leg, pose.position(), config) {
                return self.along(&leg, pose, model, config);
            }
            self.current += 1;
            self.is_turning |= self.corner() > SOFT_CORNER;
        }
        None
    }

    fn along(
        &mut self,
        leg: &Segment,
        pose: &Pose2,
        model: &RobotModel,
        config: &FollowConfig,
    ) -> Option<Speeds> {
        let length = leg.length();
        let direction = leg.vector() / length;
        let done = (pose.position() - leg.a).dot(&direction);
        let left = length - done;
        // Aiming beyond the end keeps the heading steady when the end is near.
        let aim = leg.a + direction * (done.max(0.0) + config.look_ahead);
        let to_aim = aim - pose.position();
        let error = wrap(libm::atan2(to_aim.y, to_aim.x) - pose.heading());
        self.is_turning = turns_on_spot(self.is_turning, error);
        let turn = turn_rate(error, model, config);
        if self.is_turning {
            return Some((0.0, turn));
        }
        let brake = BRAKING * model.max_acceleration;
        let next = self.legs.get(self.current + 1);
        let at_end = match next {
            // A soft corner is taken at a speed for which the turn is fast enough.
            Some(next) if turn_between(leg, next) <= SOFT_CORNER => 0.4 * model.max_speed,
            _ => 0.0,
        };
        let left = left.max(0.0);
        let by_braking = (at_end * at_end + 2.0 * brake * left).sqrt();
        // The last centimetres: proportional, no faster than the braking curve.
        let by_distance = at_end + 2.0 * left + 0.01;
        let by_heading = model.max_speed * (1.0 - error.abs() / ASTRAY).max(0.0);
        let by_pace = config.pace * model.max_speed;
        let forward = by_pace.min(by_braking).min(by_distance).min(by_heading);
        Some((forward, turn))
    }

    /// Angle between the leg before the current one and the current one; π if there is none before.
    fn corner(&self) -> f64 {
        let before = self.current.checked_sub(1).and_then(|i| self.legs.get(i));
        match (before, self.legs.get(self.current)) {
            (Some(before), Some(leg)) => turn_between(before, leg),
            _ => std::f64::consts::PI,
        }
    }
}

/// Whether the robot turns on the spot: it starts at a large error, and goes on until the error is
/// small.
pub(super) fn turns_on_spot(is_turning: bool, error: f64) -> bool {
    if error.abs() > ASTRAY {
        true
    } else if error.abs() < ALIGNED {
        false
    } else {
        is_turning
    }
}

/// Turn rate for a heading error: proportional near zero, a braking curve farther out, the model's
/// limit beyond.
pub(super) fn turn_rate(error: f64, model: &RobotModel, config: &FollowConfig) -> f64 {
    let by_braking = (2.0 * BRAKING * model.max_turn_acceleration * error.abs()).sqrt();
    let rate = (TURN_GAIN * error.abs())
        .min(by_braking)
        .min(config.pace * model.max_turn_rate);
    rate.copysign(error)
}

fn has_ended(leg: &Segment, position: Point2<f64>, config: &FollowConfig) -> bool {
    let direction = leg.vector() / leg.length();
    (leg.b - position).dot(&direction) <= config.tolerance
}

fn turn_between(a: &Segment, b: &Segment) -> f64 {
    let (a, b) = (a.vector(), b.vector());
    libm::atan2(a.perp(&b), a.dot(&b)).abs()
}
