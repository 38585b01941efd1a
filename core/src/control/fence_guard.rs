//! Keeps a robot within a fence: commands are limited to what stops before the border.
//!
//! In: where the robot is in the map of the fence, how it runs, and the command that is wished.
//! Out: the command that keeps it within, [`Command::Stop`] if need be.
//!
//! 1. The robot's disc is to stay within, by a margin and by twice the standard deviation of its
//!    place: the clearance of its middle may not fall below the sum.
//! 2. Its middle is followed along the arc of the wished speeds, those it was commanded, those it
//!    runs, and straight on, for the turn rate takes time to change and the robot is between them.
//!    Where the clearance falls too low the way ends. As the clearance changes by no more than the
//!    way that is gone, a step may be as long as there is clearance to spare.
//! 3. Speed: v t + v²/(2 a) may not exceed that way. Turning on the spot is never limited.
//! 4. A robot that is nearer the border than that already, or outside, may go wherever its
//!    clearance does not get less: so it is driven back.
//! 5. Where its pose is not known it stands.

#[cfg(test)]
mod tests;

use nalgebra::Point2;

use super::safe::{BRAKING, Braking};
use super::{Speeds, within_model};
use crate::bounds::config;
use crate::geom::geofence::Geofence;
use crate::geom::{Pose2, PoseEstimate};
use crate::robot::{Command, RobotModel};

config! {
    /// How cautious the fence is.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct FenceConfig {
        /// Distance kept between the robot's disc and the border, m. Default 0.05: a leg ends as
        /// exactly as its encoders count.
        pub margin: f64 = 0.05,
        /// Time from a pose to an effect, s. Default 0.3, as safe mode has it: two readings of the
        /// odometry, a tick, and the motors.
        pub reaction: f64 = 0.3,
        /// A pose whose place is less sure than that (standard deviation, m) is none. Default 0.5.
        pub sigma: f64 = 0.5,
    }
}

impl FenceConfig {
    /// The clearance that the robot's middle keeps, m: who plans keeps no less than who guards.
    #[must_use]
    pub fn keeps(&self, model: &RobotModel, pose: &PoseEstimate) -> f64 {
        model.radius() + self.margin + 2.0 * sigma_of(pose)
    }
}

/// Steps along a way are no shorter, m.
const STEP: f64 = 0.005;
/// A leg under way is not given up for less, m: poses scatter.
const SCATTER: f64 = 0.03;
/// Less than this part of the wished speed is standing at the border.
const HELD: f64 = 0.1;

/// See the module.
#[derive(Clone, Debug)]
pub struct FenceGuard {
    model: RobotModel,
    config: FenceConfig,
    fence: Geofence,
    /// Where the robot is; none where that is not known.
    pose: Option<PoseEstimate>,
    /// Speeds at which it runs, by odometry.
    runs: Speeds,
    /// What is under way, as it was wished, and as it was let through.
    wish: Command,
    commanded: Command,
    /// What remains of a leg under way, m.
    leg: f64,
}

impl FenceGuard {
    /// Before a pose is known.
    #[must_use]
    pub fn new(model: RobotModel, fence: Geofence, config: FenceConfig) -> Self {
        Self {
            model,
            config,
            fence,
            pose: None,
            runs: (0.0, 0.0),
            wish: Command::Stop,
            commanded: Command::Stop,
            leg: 0.0,
        }
    }

    /// The fence.
    #[must_use]
    pub fn fence(&self) -> &Geofence {
        &self.fence
    }

    /// What is under way, as it was wished.
    #[must_use]
    pub fn wish(&self) -> Command {
        self.wish
    }

    /// Whether it is known, well enough, where the robot is.
    #[must_use]
    pub fn is_placed(&self) -> bool {
        self.pose.is_some()
    }

    /// Whether the robot's middle is outside.
    #[must_use]
    pub fn is_outside(&self) -> bool {
        let at = self.pose.map(|pose| pose.pose.position());
        at.is_some_and(|at| self.fence.clearance(at) < 0.0)
    }

    /// Whether the fence, and nothing else, keeps the robot from going where it is wished to.
    #[must_use]
    pub fn holds_back(&self) -> bool {
        match (self.wish, self.commanded) {
            (Command::Velocity { forward: wish, .. }, Command::Velocity { forward, .. }) => {
                wish != 0.0 && forward.abs() < HELD * wish.abs()
            }
            (Command::Velocity { forward, turn }, Command::Stop) => forward != 0.0 || turn != 0.0,
            (Command::Forward(wish), Command::Forward(by)) => by.abs() < wish.abs(),
            (Command::Forward(_) | Command::Turn(_), Command::Stop) => true,
            _ => false,
        }
    }

    /// Takes where the robot is, and the speeds at which it runs; `None` where that is not known,
    /// or not to be believed. Says what to tell the robot now, where that is no longer what it was.
    pub fn moved(&mut self, pose: Option<PoseEstimate>, runs: Speeds, by: f64) -> Option<Command> {
        let sigma = |pose: &PoseEstimate| sigma_of(pose) <= self.config.sigma;
        self.pose = pose.filter(sigma);
        self.runs = runs;
        self.leg = (self.leg.abs() - by * self.leg.signum())
            .max(0.0)
            .copysign(self.leg);
        self.again()
    }

    /// The command as far as it stays within.
    pub fn limit(&mut self, wish: Command) -> Command {
        self.wish = wish;
        self.commanded = self.bounded(wish);
        self.leg = match self.commanded {
            Command::Forward(by) => by,
            _ => 0.0,
        };
        self.commanded
    }

    /// The same of a command that others made of one that was limited.
    #[must_use]
    pub fn bounded(&self, wish: Command) -> Command {
        if self.fence.is_empty() {
            return wish;
        }
        let Some(pose) = &self.pose else {
            return match wish {
                // Standing still is no motion.
                Command::Scan => wish,
                _ => Command::Stop,
            };
        };
        match wish {
            Command::Velocity { forward, turn } => {
                let (forward, turn) = within_model((forward, turn), &self.model);
                let forward = self.speed(pose, forward, turn);
                Command::Velocity { forward, turn }
            }
            Command::Forward(by) => {
                let free = self.free_on(pose, (by.signum(), 0.0), by.abs());
                match free > STEP {
                    true => Command::Forward(free.copysign(by)),
                    false => Command::Stop,
                }
            }
            Command::Stop | Command::Turn(_) | Command::Scan => wish,
        }
    }

    /// Forgets what is under way: the robot was stopped.
    pub fn stopped(&mut self) {
        (self.wish, self.commanded, self.leg) = (Command::Stop, Command::Stop, 0.0);
    }

    fn again(&mut self) -> Option<Command> {
        match self.wish {
            Command::Velocity { .. } => {
                let before = self.commanded;
                let now = self.limit(self.wish);
                (now != before).then_some(now)
            }
            Command::Forward(_) | Command::Turn(_) if self.commanded != Command::Stop => {
                let is_within = match &self.pose {
                    None => self.fence.is_empty(),
                    Some(pose) => self.leg == 0.0 || self.is_safe_leg(pose),
                };
                (!is_within).then(|| {
                    // What it was wished to do stays, for `holds_back`.
                    (self.commanded, self.leg) = (Command::Stop, 0.0);
                    Command::Stop
                })
            }
            _ => None,
        }
    }

    /// A leg slows down by itself where it ends.
    fn is_safe_leg(&self, pose: &PoseEstimate) -> bool {
        let braking = self.braking().way(self.model.max_speed);
        let needs = braking.min(self.leg.abs());
        self.free_on(pose, (self.leg.signum(), 0.0), needs) + SCATTER >= needs
    }

    /// The forward speed, at a turn rate, from which it stops within.
    fn speed(&self, pose: &PoseEstimate, forward: f64, turn: f64) -> f64 {
        let braking = self.braking();
        let commanded = match self.commanded {
            Command::Velocity { turn, .. } => turn,
            _ => 0.0,
        };
        let mut speed = forward;
        // A slower robot that turns as fast runs on a narrower arc.
        for _ in 0..2 {
            if speed == 0.0 {
                break;
            }
            let longest = braking.way(speed);
            let turns = [turn, commanded, self.runs.1, 0.0].map(|turn| (speed, turn));
            let runs = (self.runs.0 * speed > 0.0).then_some(self.runs);
            let free = (turns.into_iter().chain(runs))
                .map(|arc| self.free_on(pose, arc, longest))
                .fold(longest, f64::min);
            speed = braking.speed_within(free, speed, longest).copysign(speed);
        }
        speed
    }

    /// How far the robot may go on the arc of these speeds, at most `longest`, m.
    fn free_on(&self, pose: &PoseEstimate, arc: Speeds, longest: f64) -> f64 {
        let (forward, turn) = arc;
        let start = self.fence.clearance(pose.pose.position());
        let keep = self.keeps(pose).min(start);
        let mut gone = 0.0;
        while gone < longest {
            let spare = self
                .fence
                .clearance(self.at(&pose.pose, gone, forward, turn))
                - keep;
            if spare < 0.0 {
                // The step before was the last that is known to be within.
                return (gone - STEP).max(0.0);
            }
            gone += spare.max(STEP);
        }
        let last = self
            .fence
            .clearance(self.at(&pose.pose, longest, forward, turn))
            - keep;
        match last < 0.0 {
            true => (longest - STEP).max(0.0),
            false => longest,
        }
    }

    /// Where the robot's middle is after so many metres of an arc.
    fn at(&self, pose: &Pose2, gone: f64, forward: f64, turn: f64) -> Point2<f64> {
        let way = gone.copysign(forward);
        let turned = turn / forward.abs() * gone;
        let half = Pose2::new(0.0, 0.0, 0.5 * turned);
        // The chord of the arc: sin(x) / x of its length.
        let x = 0.5 * turned;
        let chord = match x.abs() < 1e-6 {
            true => way,
            false => way * libm::sin(x) / x,
        };
        (*pose * half * Pose2::new(chord, 0.0, 0.0)).position()
    }

    /// The clearance that the robot's middle keeps, m.
    fn keeps(&self, pose: &PoseEstimate) -> f64 {
        self.config.keeps(&self.model, pose)
    }

    fn braking(&self) -> Braking {
        Braking {
            deceleration: BRAKING * self.model.max_acceleration,
            reaction: self.config.reaction,
        }
    }
}

/// Standard deviation of the place, in its worse direction along an axis, m; no number where the
/// covariance is none.
fn sigma_of(pose: &PoseEstimate) -> f64 {
    pose.cov[(0, 0)].max(pose.cov[(1, 1)]).sqrt()
}
