//! The geofence of a bridge that maps: where the robot is in the map, and what that allows.
//!
//! In: the poses that the mapper finds, odometry, and commands. Out: commands that stay within the
//! fence, and its state.
//!
//! A pose counts while it is localised and not older than [`LONGEST`]; until the next one, odometry
//! carries it on. If the mapper is busy for longer, the robot stands until it is done.

use std::time::Duration;

use crate::control::{FenceConfig, FenceGuard};
use crate::geom::geofence::Geofence;
use crate::robot::{Command, Odometry, RobotModel};
use crate::wire::CarriedPose;
use crate::wire::message::{FenceState, PoseBody, PoseState};

/// A pose older than this does not count, s.
const LONGEST: f64 = 2.0;
/// Speeds are averaged over this time, s.
const RUNS: f64 = 0.1;
/// Least time for which a robot that was held back is reported as such: at a border, being held and
/// not being held alternate many times a second.
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
    /// An empty fence: the robot may go everywhere.
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

    /// Replaces the fence; the command under way is checked at the next odometry.
    pub(super) fn set(&mut self, fence: Geofence) {
        let under_way = self.guard.wish();
        self.guard = FenceGuard::new(self.model, fence, FenceConfig::default());
        self.guard.limit(under_way);
        self.held = None;
        self.look(0.0);
    }

    /// Takes the pose at which the mapper found the robot.
    pub(super) fn pose(&mut self, body: &PoseBody) -> Option<Command> {
        let state = match body.state {
            PoseState::Localised => PoseState::Localised,
            _ => PoseState::Lost,
        };
        self.pose.tell(&PoseBody { state, ..*body });
        self.look(0.0)
    }

    /// Takes a motion; returns the command that the robot must get now, if it has changed.
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

    /// Whether it keeps the robot from being armed: there is a fence, and the pose is unknown.
    pub(super) fn is_lost(&self) -> bool {
        !self.fence().is_empty() && !self.guard.is_placed()
    }

    /// Where the robot is relative to it, and whether it holds the robot back.
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
