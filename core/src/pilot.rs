//! Decisions: from a map and a pose to commands.
//!
//! In: a [`Situation`] at every tick. Out: a [`Command`], or `None` if the robot should carry on
//! with the last one.
//!
//! 1. By hand: the requested speeds, made safe.
//! 2. Otherwise a goal: the one that was given, or the frontier that promises most for the length
//!    of the way to it.
//! 3. A way to it: straight, by trees, or over cells; shortened to straight legs. On the way to a
//!    given goal, a robot that is not a disc may also take a way through which only its outline
//!    fits; it is then kept safe by the outline. Everything else uses the disc around the robot.
//! 4. Continuous sensors: follow the legs by turn-and-go, or go around people by the dynamic
//!    window, every speed made safe. The way is checked against the map twice a second, and planned
//!    again when something blocks it or the frontier has vanished. Sensors on a servo: scan, plan,
//!    one turn and one leg over what has been seen, then again.
//! 5. A robot that makes no progress, or whose bumpers report an obstacle that no scan shows, backs
//!    off, tries again, and in the end reports that it is stuck.
//! 6. While a continuous sensor is silent the robot stands and reports it; it goes on with the next
//!    scan.
//! 7. A robot whose position has become so uncertain that the map cannot guide it stands, and
//!    reports that it is lost.
//! 8. Ways and frontiers lie within the geofence, if there is one.
//!
//! Planning happens on these events only, never at the rate of the ticks.

mod around;
mod blocked;
mod closing;
mod config;
mod cycle;
mod errand;
mod explorer;
mod lost;
mod stages;
mod status;
#[cfg(test)]
mod tests;

use nalgebra::{Matrix3, Point2};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use crate::control::{
    SafeConfig, Speeds, Underway, limit_among_walkers, limit_outline, limit_speed, within_model,
};
use crate::estimation::PoseGraph;
use crate::geom::geofence::Geofence;
use crate::geom::{Pose2, PoseEstimate, Segment};
use crate::map::Grid;
use crate::plan::{Frontier, Route};
use crate::points::Points;
use crate::robot::{Bumpers, Command, RobotModel, Stamp};
use around::people_are_near;
pub use config::PilotConfig;
pub use stages::{Cut, Stage, StageRecord, StageReport};
pub use status::{Failure, Finish, Homecoming, Mode, Status};

/// What the pilot knows at a tick.
#[derive(Clone, Copy, Debug)]
pub struct Situation<'a> {
    /// Now.
    pub stamp: Stamp,
    /// Where the robot is, map frame.
    pub estimate: &'a PoseEstimate,
    /// Covariance of the pose in the map around it ([`crate::slam::Slam::known_in_map`]).
    pub known_in_map: Matrix3<f64>,
    /// The map.
    pub grid: &'a Grid,
    /// The pose graph of a map that is made by one, map frame.
    pub graph: Option<&'a PoseGraph>,
    /// What stands around the robot, robot frame at the stamp of the last scan: its points, and
    /// what is too near to be seen ([`crate::slam::Slam::obstacles`]).
    pub points: Option<&'a Points>,
    /// Those of the points that belong to walkers ([`crate::slam::Slam::walkers`]).
    pub walkers: &'a [Point2<f64>],
    /// `robot_at_scan_from_robot`: the motion since the last scan, by odometry.
    pub motion_since_scan: Pose2,
    /// Whether the robot drives on however uncertain its pose is: either the method itself searches
    /// for a lost robot, and finds it as it drives; or it is odometry alone, which is there to show
    /// its drift.
    pub drives_unsure: bool,
    /// How uncertain the heading has become since the last scan, rad
    /// ([`crate::slam::Slam::heading_drift`]).
    pub heading_drift: f64,
    /// The robot's speeds by its odometry, m/s and rad/s ([`crate::slam::Slam::speeds`]).
    pub speeds: Speeds,
    /// Which bumpers are pressed.
    pub bumpers: Bumpers,
    /// Whether the robot is still executing the last command (a turn, a leg, a sweep).
    pub robot_is_busy: bool,
    /// Whether the sensor scans only on command, the robot standing.
    pub scans_on_command: bool,
}

/// Drives one robot.
#[derive(Clone, Debug)]
pub struct Pilot {
    model: RobotModel,
    config: PilotConfig,
    rng: ChaCha8Rng,
    mode: Mode,
    status: Status,
    wish: Speeds,
    /// Speeds of the last command.
    commanded: Speeds,
    errand: errand::Errand,
    phase: cycle::Phase,
    stages: StageRecord,
    hand_scan: cycle::HandScan,
    /// Whether bumpers were pressed at the last tick.
    was_bumped: bool,
    /// Where it may plan to, map frame.
    fence: Geofence,
    doubt: lost::Doubt,
}

/// What safe mode leaves of the requested speeds.
#[derive(Clone, Copy, Debug)]
struct Limited {
    /// With regard to everything around, people included.
    among_things: Speeds,
    /// And also because people may walk on.
    among_people: Speeds,
}

impl Pilot {
    /// A pilot that stands in [`Mode::Manual`].
    #[must_use]
    pub fn new(model: RobotModel, config: PilotConfig, seed: u64) -> Self {
        Self {
            model,
            config,
            rng: ChaCha8Rng::seed_from_u64(seed),
            mode: Mode::Manual,
            status: Status::Idle,
            wish: (0.0, 0.0),
            commanded: (0.0, 0.0),
            errand: errand::Errand::default(),
            phase: cycle::Phase::default(),
            stages: StageRecord::default(),
            hand_scan: cycle::HandScan::default(),
            was_bumped: false,
            fence: Geofence::default(),
            doubt: lost::Doubt::default(),
        }
    }

    /// Begins a new errand and forgets the old one.
    pub fn set_mode(&mut self, mode: Mode) {
        self.mode = mode;
        self.status = Status::Idle;
        self.wish = (0.0, 0.0);
        self.errand = errand::Errand::default();
        self.phase = cycle::Phase::default();
        self.stages = StageRecord::default();
    }

    /// Ways and frontiers lie within this fence from the next plan on; a way that leaves it is
    /// given up at the next review. The pilot does not enforce the fence while driving: the code
    /// that moves the motors must.
    pub fn set_fence(&mut self, fence: Geofence) {
        self.fence = fence;
    }

    /// Other settings from the next tick on.
    pub fn reconfigure(&mut self, config: PilotConfig) {
        self.config = config;
    }

    /// By hand: drive with these speeds (m/s, rad/s) until the next command. Takes over from any
    /// errand.
    pub fn drive(&mut self, forward: f64, turn: f64) {
        if self.mode != Mode::Manual {
            self.set_mode(Mode::Manual);
        }
        self.wish = (forward, turn);
    }

    /// Stand still and forget the errand.
    pub fn stop(&mut self) {
        self.set_mode(Mode::Manual);
    }

    /// What to tell the robot now; `None`: nothing new, it carries on.
    pub fn steer(&mut self, now: &Situation) -> Option<Command> {
        let has_bumped = now.bumpers.any() && !self.was_bumped;
        self.was_bumped = now.bumpers.any();
        self.doubt_pose(now);
        match self.mode {
            Mode::Manual => self.by_hand(now),
            _ if self.status.is_over() => Some(Command::Stop),
            _ if now.robot_is_busy => self.under_way(has_bumped, now),
            _ if now.scans_on_command => self.in_cycle(now),
            _ => Some(self.continuously(has_bumped, now)),
        }
    }

    /// What the stages of the cycle gave; empty for continuous driving.
    #[must_use]
    pub fn stages(&self) -> &StageRecord {
        &self.stages
    }

    /// The same, for the code that does the stages of the scan, or steps through the record.
    pub(crate) fn stages_mut(&mut self) -> &mut StageRecord {
        &mut self.stages
    }

    fn by_hand(&mut self, now: &Situation) -> Option<Command> {
        if self.wish != (0.0, 0.0) {
            self.status = Status::Driving;
            return Some(self.safely(self.wish, now, self.config.safe.by_hand()));
        }
        let was_driving = std::mem::replace(&mut self.status, Status::Idle) == Status::Driving;
        if was_driving || !now.scans_on_command {
            return Some(Command::Stop);
        }
        let is_due = !now.robot_is_busy && self.hand_scan.is_due(now);
        is_due.then_some(Command::Scan)
    }

    fn continuously(&mut self, has_bumped: bool, now: &Situation) -> Command {
        if self.is_blind(now) {
            return self.wait_for_scan();
        }
        if matches!(self.status, Status::Waiting(_)) {
            self.status = Status::Scanning;
        }
        if has_bumped {
            self.get_unstuck(now);
        }
        if let Some(until) = self.errand.backing_until {
            if now.stamp < until {
                return self.safely((-0.3 * self.model.max_speed, 0.0), now, self.config.safe);
            }
            self.errand.backing_until = None;
        }
        if now.points.is_none() || !self.has_way(now) {
            return Command::Stop;
        }
        if self.errand.watch.idle_for(now.stamp, &now.estimate.pose) > self.config.patience {
            // People go away, or become things that the next plan goes around: no reason to give up
            // a goal. A frontier can be given up, since there are others.
            if self.has_one_goal() && people_are_near(now) {
                self.errand.stuck = 0;
            }
            self.get_unstuck(now);
            return Command::Stop;
        }
        let pose = &now.estimate.pose;
        let Some(follower) = &mut self.errand.follower else {
            return Command::Stop;
        };
        let Some(wish) = follower.steer(pose, &self.model, &self.config.follow) else {
            self.arrive(now);
            return Command::Stop;
        };
        let wish = self.around_people(wish, now);
        self.safely(wish, now, self.config.safe)
    }

    /// Whether there is no other goal to turn to.
    fn has_one_goal(&self) -> bool {
        !matches!(self.mode, Mode::Manual) && !self.goes_for_frontiers()
    }

    /// Whether it drives to frontiers.
    fn goes_for_frontiers(&self) -> bool {
        self.mode == Mode::Explore && !self.is_homeward() && !self.is_closing_loop()
    }

    /// Whether everything is explored and the robot is on its way back to where it began.
    #[must_use]
    pub fn is_homeward(&self) -> bool {
        self.errand.homeward.is_some()
    }

    /// Whether a continuous sensor has fallen silent.
    fn is_blind(&self, now: &Situation) -> bool {
        let scanned = now.points.map_or(Stamp(0), |points| points.stamp);
        !now.scans_on_command && now.stamp.since(scanned) > self.config.safe.stale_after
    }

    fn wait_for_scan(&mut self) -> Command {
        // Standing for want of scans is no lack of progress.
        self.errand.watch.reset();
        let seconds = self.config.safe.stale_after;
        self.status = Status::Waiting(Failure::NoScan { seconds });
        self.commanded = (0.0, 0.0);
        Command::Stop
    }

    /// The requested speeds, as far as the last scan and the bumpers allow; standing if a
    /// continuous sensor has fallen silent.
    fn safely(&mut self, wish: Speeds, now: &Situation, config: SafeConfig) -> Command {
        if self.is_blind(now) {
            return self.wait_for_scan();
        }
        let wish = match now.bumpers.any() {
            true => (wish.0.min(0.0), wish.1),
            false => wish,
        };
        let (forward, turn) = match now.points {
            Some(points) => self.limited(wish, points, now, &config).among_people,
            None if now.scans_on_command => within_model(wish, &self.model),
            None => (0.0, 0.0),
        };
        self.commanded = (forward, turn);
        Command::Velocity { forward, turn }
    }

    fn limited(
        &self,
        wish: Speeds,
        points: &Points,
        now: &Situation,
        config: &SafeConfig,
    ) -> Limited {
        let underway = self.underway(points, now);
        let limits = (&self.model, config);
        let among_things = match self.goes_by_outline(now) {
            true => limit_outline(wish, points, &underway, limits),
            false => limit_speed(wish, points, &underway, limits),
        };
        Limited {
            among_things,
            among_people: limit_among_walkers(among_things, now.walkers, &underway, limits),
        }
    }

    fn underway(&self, points: &Points, now: &Situation) -> Underway {
        Underway {
            commanded: self.commanded,
            runs: now.speeds,
            since_scan: now.motion_since_scan,
            // The age of a commanded scan does not matter: partial scans show who has come since.
            scan_age: match now.scans_on_command {
                true => 0.0,
                false => now.stamp.since(points.stamp),
            },
        }
    }

    /// What it is to do.
    #[must_use]
    pub fn mode(&self) -> Mode {
        self.mode
    }

    /// What it is doing.
    #[must_use]
    pub fn status(&self) -> &Status {
        &self.status
    }

    /// The way it follows.
    #[must_use]
    pub fn route(&self) -> Option<&Route> {
        self.errand.route.as_ref()
    }

    /// Edges of the trees of the last plan.
    #[must_use]
    pub fn tree(&self) -> &[Segment] {
        &self.errand.tree
    }

    /// Frontiers as of the last search, best first.
    #[must_use]
    pub fn frontiers(&self) -> &[Frontier] {
        &self.errand.explorer.frontiers
    }

    /// Where it is going.
    #[must_use]
    pub fn goal(&self) -> Option<Point2<f64>> {
        match self.mode {
            Mode::Manual => None,
            Mode::GoTo(goal) => Some(goal),
            Mode::Explore => self.errand.goal.filter(|_| !self.status.is_over()),
        }
    }
}
