//! In: a scene, and who limits the stick. Out: what was touched, and whether the robot could turn
//! away and leave, and stopped when it received no scans.
//!
//! 1. Six seconds of the stick. In every fourth trial the lidar falls silent for 1.5 s at some
//!    time: the robot has to stand after half a second plus its braking time.
//! 2. The stick commands a turn on the spot, towards where the robot could leave: it has to get
//!    there.
//! 3. The stick is pushed forward for four seconds: the robot has to move on, if that way is free.

use anyhow::Result;
use nalgebra::Point2;
use slamlab_core::control::SafeMode;
use slamlab_core::experiment::CONTROL_PERIOD;
use slamlab_core::geom::{Length, unit_vector, wrap};
use slamlab_core::pilot::{Pilot, PilotConfig, Situation};
use slamlab_core::robot::{Command, Odometry, Scan};
use slamlab_core::sim::{Contacts, SensorModel, Simulation};
use slamlab_core::slam::{Method, Slam, SlamConfig};

use super::scene::{Scene, Stick};

const DRIVE: f64 = 6.0;
const SILENCE: f64 = 1.5;
const READINGS: u32 = 5;
/// Directions that are tested for a way out.
const WAYS: u32 = 24;
/// A way out is free over this distance, m; the robot has to drive [`LEFT`] of it.
const WAY_OUT: f64 = 0.6;
const LEFT: f64 = 0.05;
/// Clearance beside a way out, m, and the step in which it is tested.
const ROOM: f64 = 0.1;
const STEPS: u32 = 20;
const TURN_TIME: f64 = 8.0;
const LEAVE_TIME: f64 = 4.0;
/// Time that the motors need to stand, beyond the model's braking time, s.
const SETTLING: f64 = 0.3;

/// Who limits the stick.
pub(crate) enum Guard {
    /// The pilot, as in the laboratory.
    Pilot(Box<(Slam, Pilot)>),
    /// Safe mode alone, as in the bridge.
    Bridge(Box<SafeMode>),
}

/// The result of a trial.
#[derive(Default)]
pub(crate) struct Shown {
    pub(crate) contacts: Contacts,
    pub(crate) could_not_turn: bool,
    pub(crate) could_not_leave: bool,
    pub(crate) ran_blind: bool,
    pub(crate) was_silent: bool,
    pub(crate) had_way_out: bool,
    /// Distance driven under the stick, m.
    pub(crate) driven: f64,
}

/// Drives one trial.
pub(crate) fn drive(scene: &Scene, seed: u64) -> Result<Shown> {
    let sensor = SensorModel::lidar();
    let sim = Simulation::new(scene.world.clone(), scene.robot, sensor, seed)?;
    let guard = match seed / 5 % 2 {
        0 => Guard::Pilot(Box::new((
            Slam::new(Method::Odometry, SlamConfig::default())?,
            Pilot::new(scene.robot, PilotConfig::default(), seed),
        ))),
        _ => Guard::Bridge(Box::new(SafeMode::new(scene.robot, false))),
    };
    let mut trial = Trial {
        sim,
        guard,
        is_silent: false,
        shown: Shown::default(),
    };
    trial.under_the_stick(&mut Stick::new(seed), seed)?;
    trial.turn_away()?;
    let mut shown = trial.shown;
    shown.contacts = trial.sim.contacts();
    Ok(shown)
}

struct Trial {
    sim: Simulation,
    guard: Guard,
    is_silent: bool,
    shown: Shown,
}

impl Trial {
    fn under_the_stick(&mut self, stick: &mut Stick, seed: u64) -> Result<()> {
        let robot = *self.sim.robot();
        let silent_from =
            (seed % 4 == 3).then_some(1.0 + (seed % 97) as f64 / 97.0 * (DRIVE - 3.0));
        let stands_within = 0.5 + robot.max_speed / robot.max_acceleration + SETTLING;
        while self.sim.stamp().seconds() < DRIVE {
            let now = self.sim.stamp().seconds();
            let silent_for = silent_from.map_or(-1.0, |from| now - from);
            self.is_silent = (0.0..SILENCE.max(stands_within + 0.2)).contains(&silent_for);
            let before = self.sim.truth().position();
            self.tick(stick.at(now, &robot))?;
            let moved = (self.sim.truth().position() - before).length();
            self.shown.driven += moved;
            self.shown.was_silent |= self.is_silent;
            if self.is_silent && silent_for > stands_within {
                self.shown.ran_blind |= self.sim.speeds().0.abs() > 0.01;
            }
        }
        self.is_silent = false;
        Ok(())
    }

    fn turn_away(&mut self) -> Result<()> {
        let robot = *self.sim.robot();
        // A scan after the silence, and time to come to a stop.
        for _ in 0..(2.0 / CONTROL_PERIOD) as u32 {
            self.tick((0.0, 0.0))?;
        }
        let out = self.way_out();
        let aim = out.unwrap_or_else(|| wrap(self.sim.truth().heading() + 3.0));
        let end = self.sim.stamp().seconds() + TURN_TIME;
        let mut off = f64::INFINITY;
        while off.abs() > 0.1 && self.sim.stamp().seconds() < end {
            off = wrap(aim - self.sim.truth().heading());
            let rate = (1.5 * off).clamp(-robot.max_turn_rate, robot.max_turn_rate);
            self.tick((0.0, rate))?;
        }
        self.shown.could_not_turn = off.abs() > 0.1;
        // A walking person may have stepped into the way out meanwhile.
        self.shown.had_way_out = out.is_some() && self.is_free(self.sim.truth().heading());
        let before = self.sim.truth().position();
        for _ in 0..(LEAVE_TIME / CONTROL_PERIOD) as u32 {
            self.tick((robot.max_speed, 0.0))?;
        }
        let left = (self.sim.truth().position() - before).length();
        let has_people = !self.sim.movers().is_empty();
        self.shown.could_not_leave = self.shown.had_way_out && !has_people && left < LEFT;
        Ok(())
    }

    /// The free direction nearest to the robot's heading, world frame.
    fn way_out(&self) -> Option<f64> {
        let heading = self.sim.truth().heading();
        let turns = (0..WAYS).map(|i| {
            let half = f64::from(i.div_ceil(2));
            let side = if i % 2 == 0 { 1.0 } else { -1.0 };
            wrap(heading + side * half * std::f64::consts::TAU / f64::from(WAYS))
        });
        turns.into_iter().find(|way| self.is_free(*way))
    }

    /// Whether the robot could go in this direction with room to spare; it may only move away from
    /// what it already stands close to.
    fn is_free(&self, way: f64) -> bool {
        let direction = unit_vector(way);
        let wanted = self.sim.robot().radius() + ROOM;
        let here = self.sim.truth().position();
        let at_first = self.clearance(here);
        (1..=STEPS).all(|i| {
            let part = f64::from(i) / f64::from(STEPS);
            let clearance = self.clearance(here + direction * (WAY_OUT * part));
            clearance >= wanted || (part < 0.4 && clearance >= at_first)
        })
    }

    fn clearance(&self, at: Point2<f64>) -> f64 {
        let people = self.sim.movers().iter();
        let people = people.map(|disc| (disc.centre - at).length() - disc.radius);
        people.fold(self.sim.caster().clearance(at, 2.0), f64::min)
    }

    fn tick(&mut self, wish: (f64, f64)) -> Result<()> {
        let command = self.guard.limit(wish, &self.sim);
        if let Some(command) = command {
            self.sim.command(command);
        }
        for _ in 0..READINGS {
            self.sim.advance(CONTROL_PERIOD / f64::from(READINGS));
            let odometry = self.sim.odometry();
            let scan = self.sim.take_scan().filter(|_| !self.is_silent);
            if let Some(command) = self.guard.take(&odometry, scan.as_ref())? {
                self.sim.command(command);
            }
        }
        Ok(())
    }
}

impl Guard {
    /// The command for the robot when the stick says `wish`.
    fn limit(&mut self, wish: (f64, f64), sim: &Simulation) -> Option<Command> {
        match self {
            Self::Bridge(safe) => {
                let (forward, turn) = wish;
                Some(safe.limit(Command::Velocity { forward, turn }))
            }
            Self::Pilot(parts) => {
                let (slam, pilot) = parts.as_mut();
                pilot.drive(wish.0, wish.1);
                let estimate = slam.estimate();
                pilot.steer(&Situation {
                    stamp: sim.stamp(),
                    estimate: &estimate,
                    known_in_map: slam.known_in_map(),
                    graph: None,
                    grid: slam.grid(),
                    points: slam.obstacles(),
                    walkers: slam.walkers(),
                    motion_since_scan: slam.motion_since_scan(),
                    drives_unsure: false,
                    heading_drift: 0.0,
                    speeds: slam.speeds(),
                    bumpers: sim.bumpers(),
                    robot_is_busy: sim.is_busy(),
                    scans_on_command: false,
                })
            }
        }
    }

    /// Takes what the robot reports; returns its next command, if that has changed.
    fn take(&mut self, odometry: &Odometry, scan: Option<&Scan>) -> Result<Option<Command>> {
        match self {
            Self::Bridge(safe) => {
                let correction = safe.odometry(odometry);
                Ok(scan.and_then(|scan| safe.scan(scan)).or(correction))
            }
            Self::Pilot(parts) => {
                parts.0.odometry(odometry)?;
                if let Some(scan) = scan {
                    parts.0.scan(scan)?;
                }
                Ok(None)
            }
        }
    }
}
