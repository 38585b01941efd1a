//! The geofence of a bridge that maps: where the robot is in the map, and what that allows.
//!
//! In: the poses that the mapper finds, odometry, and commands. Out: commands that stay within, and
//! how the robot stands to its fence.
//!
//! A pose counts while it is localised and not older than [`LONGEST`]; in between the odometry
//! carries it on. A mapper that is busy for longer lets the robot stand until it is done.

use std::time::Duration;

use crate::control::{FenceConfig, FenceGuard};
use crate::geom::geofence::Geofence;
use crate::robot::{Command, Odometry, RobotModel};
use crate::wire::CarriedPose;
use crate::wire::message::{FenceState, PoseBody, PoseState};

/// An older pose is none, s.
const LONGEST: f64 = 2.0;
/// Speeds are averaged over so long, s.
const RUNS: f64 = 0.1;
/// A robot that was held back is told to be so for so long at least: at a border it is, and is not,
/// many times a second.
const HELD_FOR: Duration = Duration::from_secs(1);

/// See the module.
#[derive(Clone, Debug)]
pub(super) struct Fence {
    guard: FenceGuard,
    model: RobotModel,
    pose: CarriedPose,
    held: Option<Duration>,
}

impl Fence {
    /// Of a robot that may go everywhere.
    pub(super) fn new(model: RobotModel) -> Self {
        Self {
            guard: FenceGuard::new(model, Geofence::default(), FenceConfig::default()),
            model,
            pose: CarriedPose::default(),
            held: None,
        }
    }

    pub(super) fn fence(&self) -> &Geofence {
        self.guard.fence()
    }

    /// Another fence; what is under way is looked at with the next odometry.
    pub(super) fn set(&mut self, fence: Geofence) {
        let under_way = self.guard.wish();
        self.guard = FenceGuard::new(self.model, fence, FenceConfig::default());
        self.guard.limit(under_way);
        self.held = None;
        self.look(0.0);
    }

    /// Takes where the mapper found the robot.
    pub(super) fn pose(&mut self, body: &PoseBody) -> Option<Command> {
        let state = match body.state {
            PoseState::Localised => PoseState::Localised,
            _ => PoseState::Lost,
        };
        self.pose.tell(&PoseBody { state, ..*body });
        self.look(0.0)
    }

    /// Takes a motion; says what to tell the robot now, where that is no longer what it was.
    pub(super) fn odometry(&mut self, odometry: &Odometry) -> Option<Command> {
        self.pose.odometry(odometry);
        self.look(odometry.motion.x())
    }

    fn look(&mut self, by: f64) -> Option<Command> {
        let (pose, runs) = (self.pose.fresh(LONGEST), self.pose.speeds(RUNS));
        self.guard.moved(pose, runs, by)
    }

    pub(super) fn limit(&mut self, wish: Command) -> Command {
        self.guard.limit(wish)
    }

    pub(super) fn bounded(&self, wish: Command) -> Command {
        self.guard.bounded(wish)
    }

    pub(super) fn stopped(&mut self) {
        self.guard.stopped();
    }

    /// Whether it keeps a robot from being armed: it is not known where that is.
    pub(super) fn is_lost(&self) -> bool {
        !self.fence().is_empty() && !self.guard.is_placed()
    }

    /// How the robot stands to it.
    pub(super) fn state(&mut self, now: Duration) -> FenceState {
        let holds_back = self.guard.holds_back();
        if holds_back {
            self.held = Some(now);
        }
        let is_held = |at: Duration| now.saturating_sub(at) < HELD_FOR;
        match () {
            () if self.fence().is_empty() => FenceState::Off,
            () if !self.guard.is_placed() => FenceState::NoPose,
            () if self.guard.is_outside() => FenceState::Outside,
            () if self.held.is_some_and(is_held) => FenceState::Held,
            () => FenceState::Within,
        }
    }
}
