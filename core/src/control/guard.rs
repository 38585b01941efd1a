//! Safe mode: commands are limited to what the last scan leaves free, no matter who gives them.
//!
//! In: odometry, scans, and the requested command. Out: the command that is safe, [`Command::Stop`]
//! if need be.
//!
//! 1. A scan becomes points in the robot's frame, de-skewed by the odometry of its sweep; the
//!    motion since then is kept, and so is what has entered the blind zone.
//! 2. Speeds: [`limit_speed`], and [`limit_among_walkers`] if there are walkers. A leg: no longer
//!    than its free part.
//! 3. A speed under way is limited again with each scan: somebody may have stepped into the way.
//! 4. A sensor that scans all the time and was silent for half a second allows no motion but a turn
//!    on the spot, and whatever is under way is stopped. A sensor that scans on command only limits
//!    legs by its last scan, however old; its pilot does the same.
//! 5. Its partial scans on the move show who came since: they limit speeds, and end a leg that is
//!    no longer safe ([`leg_is_safe`]).
//!
//! Source: Celej §5.

use super::{
    SafeConfig, Speeds, Underway, free_distance, leg_is_safe, limit_among_walkers, limit_speed,
    within_model,
};
use crate::geom::Pose2;
use crate::points::{BlindZone, BlindZoneConfig, MotionHistory, PointConfig, Points, Walkers};
use crate::robot::{Command, Odometry, RobotModel, Scan};

/// Seconds of odometry that are kept: the slowest sweep is that of rangers on a servo.
const HISTORY: f64 = 5.0;

/// Speeds are averaged over this time, s.
const RUNS: f64 = 0.1;

/// Limits commands by what is around the robot.
#[derive(Clone, Debug)]
pub struct SafeMode {
    model: RobotModel,
    scans_on_command: bool,
    config: SafeConfig,
    history: MotionHistory,
    near: BlindZone,
    walkers: Walkers,
    /// Points of the last scan, and those in the blind zone.
    points: Option<Points>,
    motion_since_scan: Pose2,
    /// The speeds that were let through last.
    commanded: Speeds,
    /// The command under way, as it was requested.
    wish: Command,
    /// What remains of a leg under way, m.
    leg: f64,
}

/// Scans scatter: a leg that was free is not stopped for less than this, m.
const SCATTER: f64 = 0.02;

impl SafeMode {
    /// Safe mode before the first scan.
    #[must_use]
    pub fn new(model: RobotModel, scans_on_command: bool) -> Self {
        let near = match scans_on_command {
            true => BlindZoneConfig::short_range(),
            false => BlindZoneConfig::default(),
        };
        Self {
            model,
            scans_on_command,
            config: SafeConfig::default().by_hand(),
            history: MotionHistory::new(HISTORY),
            near: BlindZone::new(near),
            walkers: Walkers::default(),
            points: None,
            motion_since_scan: Pose2::identity(),
            commanded: (0.0, 0.0),
            wish: Command::Stop,
            leg: 0.0,
        }
    }

    /// Takes a motion; returns what to tell the robot now, if its sensor has fallen silent while it
    /// drives.
    pub fn odometry(&mut self, odometry: &Odometry) -> Option<Command> {
        self.history.push(odometry);
        self.motion_since_scan = self.motion_since_scan * odometry.motion;
        let ran = odometry.motion.x() * self.leg.signum();
        self.leg = (self.leg.abs() - ran).max(0.0).copysign(self.leg);
        let drives = self.commanded.0 != 0.0 || self.leg != 0.0;
        (drives && self.is_blind()).then(|| self.limit(self.wish))
    }

    /// Takes a scan; returns what to tell the robot now, if that has changed.
    pub fn scan(&mut self, scan: &Scan) -> Option<Command> {
        let moved = &self.motion_since_scan;
        let scan = self.near.without_folded(scan, moved);
        let points = Points::from_rolling_scan(&scan, &self.history, &PointConfig::default());
        self.near.update(&points, moved);
        self.walkers.update(&points, moved);
        self.points = Some(self.near.with_unseen(&points));
        self.motion_since_scan = Pose2::identity();
        self.again()
    }

    /// Takes a partial scan: a few readings on the move, of a sensor that scans on command. Returns
    /// what to tell the robot now, if that has changed.
    pub fn partial_scan(&mut self, scan: &Scan) -> Option<Command> {
        let moved = self.motion_since_scan;
        let scan = self.near.without_folded(scan, &moved);
        let points = Points::from_rolling_scan(&scan, &self.history, &PointConfig::default());
        for at in self.walkers.partial_scan(&points, &moved) {
            self.near.came(at);
        }
        self.again()
    }

    /// The command, limited to what is safe.
    pub fn limit(&mut self, wish: Command) -> Command {
        self.wish = wish;
        let safe = self.safe(wish);
        (self.commanded, self.leg) = match safe {
            Command::Velocity { forward, turn } => ((forward, turn), 0.0),
            Command::Forward(by) => ((0.0, 0.0), by),
            _ => ((0.0, 0.0), 0.0),
        };
        safe
    }

    /// Forgets the command under way: the robot was stopped.
    pub fn stopped(&mut self) {
        (self.wish, self.commanded, self.leg) = (Command::Stop, (0.0, 0.0), 0.0);
    }

    /// Checks the command under way again.
    fn again(&mut self) -> Option<Command> {
        match self.wish {
            Command::Velocity { .. } => {
                let before = self.commanded;
                let safe = self.limit(self.wish);
                (self.commanded != before).then_some(safe)
            }
            Command::Forward(_) if !self.is_safe_leg() => {
                self.stopped();
                Some(Command::Stop)
            }
            _ => None,
        }
    }

    /// Whether a leg may go on. A leg slows down by itself at its end; what has come into its way
    /// stops it.
    fn is_safe_leg(&self) -> bool {
        let (walkers, underway) = (self.walkers.points(), self.underway());
        self.free_ahead(self.leg) + SCATTER >= self.braking(self.leg)
            && leg_is_safe(self.leg, walkers, &underway, (&self.model, &self.config))
    }

    fn safe(&self, wish: Command) -> Command {
        match wish {
            Command::Velocity { forward, turn } if self.is_blind() => {
                let (_, turn) = within_model((forward, turn), &self.model);
                Command::Velocity { forward: 0.0, turn }
            }
            Command::Velocity { forward, turn } => {
                let (forward, turn) = self.limited((forward, turn));
                Command::Velocity { forward, turn }
            }
            Command::Forward(_) if self.is_blind() => Command::Stop,
            Command::Forward(by) => {
                let free = self.free_ahead(by);
                if free > 0.0 {
                    Command::Forward(free.copysign(by))
                } else {
                    Command::Stop
                }
            }
            Command::Stop | Command::Turn(_) | Command::Scan => wish,
        }
    }

    fn limited(&self, wish: Speeds) -> Speeds {
        match &self.points {
            Some(points) => {
                let (underway, limits) = (self.underway(), (&self.model, &self.config));
                let safe = limit_speed(wish, points, &underway, limits);
                limit_among_walkers(safe, self.walkers.points(), &underway, limits)
            }
            None => within_model(wish, &self.model),
        }
    }

    fn underway(&self) -> Underway {
        Underway {
            commanded: self.commanded,
            runs: self.history.speeds(RUNS),
            since_scan: self.motion_since_scan,
            // The age of a commanded scan does not matter: partial scans show who has come since.
            scan_age: match self.scans_on_command {
                true => 0.0,
                false => self.scan_age(),
            },
        }
    }

    /// How much of a leg of this length is free, m.
    fn free_ahead(&self, by: f64) -> f64 {
        let radius = self.model.radius() + self.config.gap;
        let (speed, since) = (by.signum(), &self.motion_since_scan);
        self.points.as_ref().map_or(by.abs(), |points| {
            free_distance((speed, 0.0), points, since, radius, by.abs())
        })
    }

    /// Distance that the robot still moves at most after a command to stop, m; not more than the
    /// leg.
    fn braking(&self, leg: f64) -> f64 {
        let braking = self.config.braking_of(self.model.max_acceleration);
        braking.way(self.model.max_speed).min(leg.abs())
    }

    fn is_blind(&self) -> bool {
        !self.scans_on_command && self.scan_age() > self.config.stale_after
    }

    fn scan_age(&self) -> f64 {
        match (&self.points, self.history.now()) {
            (Some(points), Some(now)) => now.since(points.stamp),
            _ => f64::INFINITY,
        }
    }
}
