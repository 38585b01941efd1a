//! Keeps a robot within a fence: commands are limited so that the robot can stop before the border.
//!
//! In: the robot's pose in the map of the fence, its speeds, and the requested command. Out: the
//! command that keeps it within, [`Command::Stop`] if need be.
//!
//! 1. The robot's disc must stay within, by a margin and by twice the standard deviation of its
//!    position: the clearance of its centre may not fall below the sum.
//! 2. Its centre is followed along the arc of the requested speeds, of the commanded speeds and of
//!    the actual speeds, and straight on, because the turn rate takes time to change and the true
//!    motion is between them. The free distance ends where the clearance falls too low. The
//!    clearance changes by no more than the distance moved, so a step may be as long as the spare
//!    clearance.
//! 3. Speed: v t + v²/(2 a) may not exceed that distance. Turning on the spot is never limited.
//! 4. A robot that is already nearer to the border than that, or outside, may go wherever its
//!    clearance does not decrease, so it can be driven back.
//! 5. If its pose is not known it stands.

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
    /// The clearance that the robot's centre keeps, m: the planner must keep no less than the
    /// guard.
    #[must_use]
    pub fn keeps(&self, model: &RobotModel, pose: &PoseEstimate) -> f64 {
        model.radius() + self.margin + 2.0 * sigma_of(pose)
    }
}

/// Shortest step along an arc, m.
const STEP: f64 = 0.005;
/// A leg under way is not stopped for less than this, m: poses scatter.
const SCATTER: f64 = 0.03;
/// Below this fraction of the requested speed the robot counts as held at the border.
const HELD: f64 = 0.1;

/// See the module.
#[derive(Clone, Debug)]
pub struct FenceGuard {
    model: RobotModel,
    config: FenceConfig,
    fence: Geofence,
    /// Where the robot is; `None` if that is not known.
    pose: Option<PoseEstimate>,
    /// The robot's actual speeds, by odometry.
    runs: Speeds,
    /// The command under way, as requested and as let through.
    wish: Command,
    commanded: Command,
    /// What remains of a leg under way, m.
    leg: f64,
}

impl FenceGuard {
    /// A guard that does not know the pose yet.
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

    /// The command under way, as it was requested.
    #[must_use]
    pub fn wish(&self) -> Command {
        self.wish
    }

    /// Whether the robot's pose is known well enough.
    #[must_use]
    pub fn is_placed(&self) -> bool {
        self.pose.is_some()
    }

    /// Whether the robot's centre is outside.
    #[must_use]
    pub fn is_outside(&self) -> bool {
        let at = self.pose.map(|pose| pose.pose.position());
        at.is_some_and(|at| self.fence.clearance(at) < 0.0)
    }

    /// Whether the fence, and nothing else, keeps the robot from doing what was requested.
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

    /// Takes the robot's pose and speeds; `None` if the pose is not known, or not to be trusted.
    /// Returns what to tell the robot now, if that has changed.
    pub fn moved(&mut self, pose: Option<PoseEstimate>, runs: Speeds, by: f64) -> Option<Command> {
        let sigma = |pose: &PoseEstimate| sigma_of(pose) <= self.config.sigma;
        self.pose = pose.filter(sigma);
        self.runs = runs;
        self.leg = (self.leg.abs() - by * self.leg.signum())
            .max(0.0)
            .copysign(self.leg);
        self.again()
    }

    /// The command, limited to what stays within the fence.
    pub fn limit(&mut self, wish: Command) -> Command {
        self.wish = wish;
        self.commanded = self.bounded(wish);
        self.leg = match self.commanded {
            Command::Forward(by) => by,
            _ => 0.0,
        };
        self.commanded
    }

    /// The same limit for a command that others derived from a limited one.
    #[must_use]
    pub fn bounded(&self, wish: Command) -> Command {
        if self.fence.is_empty() {
            return wish;
        }
        let Some(pose) = &self.pose else {
            return match wish {
                // A scan involves no motion.
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

    /// Forgets the command under way: the robot was stopped.
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
                    // The request is kept, for `holds_back`.
                    (self.commanded, self.leg) = (Command::Stop, 0.0);
                    Command::Stop
                })
            }
            _ => None,
        }
    }

    /// Whether a leg may go on. A leg slows down by itself at its end.
    fn is_safe_leg(&self, pose: &PoseEstimate) -> bool {
        let braking = self.braking().way(self.model.max_speed);
        let needs = braking.min(self.leg.abs());
        self.free_on(pose, (self.leg.signum(), 0.0), needs) + SCATTER >= needs
    }

    /// The forward speed, at a turn rate, from which the robot stops within the fence.
    fn speed(&self, pose: &PoseEstimate, forward: f64, turn: f64) -> f64 {
        let braking = self.braking();
        let commanded = match self.commanded {
            Command::Velocity { turn, .. } => turn,
            _ => 0.0,
        };
        let mut speed = forward;
        // At the same turn rate, a slower robot runs on a narrower arc.
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
                // The step before was the last known to be within.
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

    /// Position of the robot's centre after a distance along an arc, m.
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

    /// The clearance that the robot's centre keeps, m.
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

/// Standard deviation of the position along its worse axis, m; NaN if the covariance is not valid.
fn sigma_of(pose: &PoseEstimate) -> f64 {
    pose.cov[(0, 0)].max(pose.cov[(1, 1)]).sqrt()
}
