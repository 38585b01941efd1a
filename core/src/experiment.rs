//! A simulated robot as the source of a [`Session`], in one deterministic loop; and what only a
//! simulation knows: the truth, and so the errors.
//!
//! ```text
//!   Simulation ── odometry, scans ──> Session ── command ──> Simulation
//! ```
//!
//! The same configuration gives the same bits natively and in the browser;
//! [`Experiment::state_hash`] shows it.

mod actions;
mod config;
mod figures;
mod link;
mod refinding;
#[cfg(test)]
mod tests;

use std::f64::consts::PI;

use nalgebra::Point2;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use self::actions::Actions;
use self::refinding::Refinding;
use crate::association::RefindingCurve;
use crate::estimation::EditKind;
use crate::format::carmen::CarmenLog;
use crate::geom::Pose2;
use crate::hash::StateHash;
use crate::pilot::{Mode, Stage};
use crate::robot::{Command, OdometryCalibration, Scan};
use crate::session::{Session, SessionConfig};
use crate::settings::Settings;
use crate::sim::{Blocked, NoDoor, SimError, Simulation, reachable_area};
use crate::slam::{EarlierMap, SlamError};
pub use actions::{Action, AgainError, TimedAction, Untold};
pub use config::ExperimentConfig;
pub use figures::{Figures, Record, Sample};
pub use link::{Link, LinkError, Place};

/// Simulated time of one step, s: how often the pilot decides.
pub const CONTROL_PERIOD: f64 = 0.05;
/// Most control periods for one stage of the cycle, or for scans of a standing robot: ten minutes.
const MOST_PERIODS: usize = 12_000;
/// Most readings that are kept for a log: 40 MB, three quarters of an hour of a lidar with 360
/// beams at 10 Hz.
const MOST_LOGGED: usize = 10_000_000;
/// Odometry readings per step. They de-skew the scans of a turning sensor, so they come faster than
/// decisions.
const READINGS: u32 = 5;

/// Side of the cells among which a place for a kidnapped robot is drawn, m; and how often to try,
/// if people stand in the way.
const KIDNAP_CELL: f64 = 0.1;
const KIDNAP_TRIES: usize = 100;

/// Why an experiment cannot begin.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ExperimentError {
    /// The world, or the robot in it, cannot be used.
    #[error(transparent)]
    Sim(#[from] SimError),
    /// A setting of the estimation is out of range.
    #[error(transparent)]
    Slam(#[from] SlamError),
}

/// A simulated robot that maps, localises itself, plans and drives.
#[derive(Debug)]
pub struct Experiment {
    /// Its initial configuration.
    start: ExperimentConfig,
    sim: Simulation,
    session: Session,
    map_from_world: Pose2,
    record: Record,
    refinding: Refinding,
    /// Whether the pilot has already decided on the next period.
    has_decided: bool,
    /// Scans with the odometry at which they were taken, as long as there is room.
    log: CarmenLog,
    /// A random stream of its own: a kidnapping must not change the noise of the sensors.
    kidnapper: ChaCha8Rng,
    actions: Actions,
}

impl Experiment {
    /// Puts the robot at the start of its world, which becomes the origin of the map frame.
    ///
    /// # Errors    [`ExperimentError`], naming what cannot be used.
    pub fn new(config: ExperimentConfig) -> Result<Self, ExperimentError> {
        let start = config.clone();
        let map_from_world = config.world.start.inverse();
        let slam = config.slam_with_walls();
        let refinding = Refinding::new(&config.world);
        let mut sim = Simulation::new(config.world, config.robot, config.sensor, config.seed)?;
        if let Some(sonars) = &config.sonars_beside {
            sim.put_sonars_beside(sonars, config.seed)?;
        }
        sim.set_on_command(config.cycle);
        if let Some(wear) = config.wear {
            sim.set_wear(wear);
        }
        let mut session = Session::new(SessionConfig {
            robot: config.robot,
            scans_on_command: sim.scans_on_command(),
            is_driven: true,
            method: config.method,
            // The pilot draws from its own stream: what it decides must not change the noise of the
            // sensors.
            seed: config.seed ^ 0x9E37_79B9_7F4A_7C15,
            slam,
            pilot: config.pilot,
            calibration: config.calibration,
        })?;
        session.set_mode(config.mode);
        Ok(Self {
            start,
            sim,
            session,
            map_from_world,
            record: Record::default(),
            refinding,
            has_decided: false,
            log: CarmenLog::empty(),
            kidnapper: ChaCha8Rng::seed_from_u64(!config.seed),
            actions: Actions::default(),
        })
    }

    /// One control period: the pilot decides, the robot moves, odometry and scans are processed.
    /// Returns whether there was a scan.
    ///
    /// # Errors    [`SlamError`] for a scan that cannot be used; the simulated sensors never
    /// produce one.
    pub fn step(&mut self) -> Result<bool, SlamError> {
        self.decide();
        self.advance()
    }

    /// The first half of a step: the pilot looks at the map and commands the robot. Does nothing if
    /// it has already decided, as it may have after [`Self::next_stage`].
    pub fn decide(&mut self) {
        self.session.show_all_stages();
        self.steer();
    }

    fn steer(&mut self) {
        self.act_as_told();
        if std::mem::replace(&mut self.has_decided, true) {
            return;
        }
        let command = self.session.decide(self.sim.bumpers(), self.sim.is_busy());
        if let Some(command) = command {
            self.sim.command(command);
        }
    }

    /// The second half of a step: the robot moves, odometry and scans are processed. Returns
    /// whether there was a scan.
    ///
    /// # Errors    [`SlamError`] for a scan that cannot be used; the simulated sensors never
    /// produce one.
    pub fn advance(&mut self) -> Result<bool, SlamError> {
        self.session.show_all_stages();
        self.sense()
    }

    fn sense(&mut self) -> Result<bool, SlamError> {
        self.act_as_told();
        self.has_decided = false;
        self.actions.next_period();
        let mut has_scanned = false;
        for _ in 0..READINGS {
            has_scanned |= self.read()?;
        }
        Ok(has_scanned)
    }

    /// One reading of the odometry, and what the sensors measured meanwhile. Returns whether that
    /// included a scan.
    fn read(&mut self) -> Result<bool, SlamError> {
        self.sim.advance(CONTROL_PERIOD / f64::from(READINGS));
        self.session.odometry(&self.sim.odometry())?;
        if let Some(scan) = self.sim.take_scan_beside() {
            self.session.sonar_scan(&scan)?;
        }
        while let Some(scan) = self.sim.take_partial_scan() {
            self.session.partial_scan(&scan)?;
        }
        let Some(scan) = self.sim.take_scan() else {
            return Ok(false);
        };
        let odometry = self.session.dead_reckoning();
        if self.log.len() < MOST_LOGGED {
            self.log.push(scan.stamp.seconds(), &odometry, &scan);
        }
        let truth = self.truth();
        self.session.scan_with_truth(&scan, Some(&truth))?;
        let (slam, seen_from) = (self.session.slam(), self.sim.truth());
        let believed = slam.estimate().pose * slam.motion_since_scan().inverse();
        self.refinding
            .count(&slam.view(), slam.config(), &seen_from, &believed);
        self.record.push(Sample {
            stamp: self.sim.stamp(),
            truth,
            estimate: self.session.estimate(),
            odometry,
        });
        Ok(true)
    }

    /// Goes on to the next stage of the cycle that was not shown yet, and returns it; `None` if the
    /// task is over or there is none. It steps through the record of the stages. The run itself
    /// only goes on, to the next decision, once that record is used up, so its bits are those of
    /// [`Self::step`].
    ///
    /// # Errors    [`SlamError`] for a scan that cannot be used; the simulated sensors never
    /// produce one.
    pub fn next_stage(&mut self) -> Result<Option<Stage>, SlamError> {
        for _ in 0..2 * MOST_PERIODS {
            let session = &mut self.session;
            let stage = session.step_stage();
            if stage.is_some() || session.status().is_over() || !session.scans_on_command() {
                return Ok(stage);
            }
            if self.has_decided {
                self.sense()?;
            } else {
                self.steer();
            }
        }
        Ok(None)
    }

    /// Applies other settings from here on; see [`Session::reconfigure`].
    ///
    /// # Errors    [`SlamError`] naming the first setting out of range; the old ones then stay.
    pub fn reconfigure(&mut self, settings: &Settings) -> Result<(), SlamError> {
        self.session.reconfigure(settings)?;
        let action = Action::Configure(Box::new(settings.clone()));
        self.actions.note(self.has_decided, action);
        Ok(())
    }

    /// `count` scans of a robot just like this one, at the same place, for
    /// [`crate::points::estimate_sigma`]; fewer if they would take more than ten minutes. The run
    /// itself is not affected.
    #[must_use]
    pub fn standing_scans(&self, count: usize) -> Vec<Scan> {
        let mut sim = self.sim.clone();
        sim.command(Command::Stop);
        let on_command = sim.scans_on_command();
        let (mut scans, mut stands) = (vec![], false);
        for _ in 0..MOST_PERIODS {
            if on_command && stands && !sim.is_busy() {
                sim.command(Command::Scan);
            }
            sim.advance(CONTROL_PERIOD);
            let came = sim.take_scan();
            // Scans from before it stood, and from the sweep in which it came to a stop, do not
            // count.
            if stands {
                scans.extend(came);
            } else {
                stands = sim.speeds() == (0.0, 0.0) || (came.is_some() && is_slow(sim.speeds()));
            }
            if scans.len() == count {
                break;
            }
        }
        scans
    }

    /// Makes the robot drive by the cycle, or as continuously as its sensor allows; its task starts
    /// again.
    pub fn set_cycle(&mut self, cycle: bool) {
        self.sim.set_on_command(cycle);
        self.session
            .set_scans_on_command(self.sim.scans_on_command());
        self.actions.note(self.has_decided, Action::SetCycle(cycle));
    }

    /// Gives the robot another task.
    pub fn set_mode(&mut self, mode: Mode) {
        self.session.set_mode(mode);
        self.actions.note(self.has_decided, Action::SetMode(mode));
    }

    /// Drives by hand at these speeds, m/s and rad/s, until commanded otherwise.
    pub fn drive(&mut self, forward: f64, turn: f64) {
        self.session.drive(forward, turn);
        let action = Action::Drive([forward, turn]);
        self.actions.note(self.has_decided, action);
    }

    /// See [`Session::draw_dead_reckoned`].
    pub fn draw_dead_reckoned(&mut self) {
        self.session.draw_dead_reckoned();
    }

    /// Runs a twin with this calibration beside the robot from here on, or no twin.
    pub fn set_twin(&mut self, calibration: Option<OdometryCalibration>) {
        self.session.set_twin(calibration);
    }

    /// Carries the robot elsewhere: to a pose in the world frame, or to a free place drawn from the
    /// seed. It does not notice, and nothing that it knows changes.
    ///
    /// # Errors    [`Blocked`]: something stands at the pose; for a drawn place, people stand
    /// everywhere.
    pub fn kidnap(&mut self, world_from_robot: Option<&Pose2>) -> Result<(), Blocked> {
        match world_from_robot {
            Some(pose) => {
                self.actions.note_untold("the robot was carried to a pose");
                self.sim.kidnap(pose)
            }
            None => {
                // Refused or not, it used random numbers of the seed.
                self.actions.note(self.has_decided, Action::Kidnap);
                self.kidnap_anywhere()
            }
        }
    }

    fn kidnap_anywhere(&mut self) -> Result<(), Blocked> {
        let radius = self.sim.robot().radius();
        let area = reachable_area(self.sim.world(), radius, KIDNAP_CELL);
        let places: Vec<_> = area.places().collect();
        let mut blocked = Ok(());
        for _ in 0..KIDNAP_TRIES {
            let turn = self.kidnapper.random_range(-PI..PI);
            let place = self.kidnapper.random_range(0..places.len().max(1));
            let Some(place) = places.get(place) else {
                break;
            };
            blocked = self.sim.kidnap(&Pose2::new(place.x, place.y, turn));
            if blocked.is_ok() {
                break;
            }
        }
        blocked
    }

    /// Opens or shuts a door of the world.
    ///
    /// # Errors    [`NoDoor`].
    pub fn set_door(&mut self, index: usize, open: bool) -> Result<(), NoDoor> {
        self.sim.set_door(index, open)?;
        let action = Action::SetDoor { door: index, open };
        self.actions.note(self.has_decided, action);
        Ok(())
    }

    /// Stops the robot at once and drops its task.
    pub fn stop(&mut self) {
        self.session.stop();
        self.sim.command(Command::Stop);
        self.actions.note(self.has_decided, Action::Stop);
    }

    /// The simulated robot in its world.
    #[must_use]
    pub fn sim(&self) -> &Simulation {
        &self.sim
    }

    /// Continues in a saved map, before the first scan.
    ///
    /// # Errors    [`SlamError`]; then nothing changes.
    pub fn go_on_in(&mut self, saved: EarlierMap) -> Result<(), SlamError> {
        self.actions.note_untold("it went on in a saved map");
        self.session.go_on_in(saved)
    }

    /// Edits the map by hand; see [`crate::slam::Slam::edit`].
    ///
    /// # Errors    [`SlamError`]; then the map stays as it was.
    pub fn edit(&mut self, kind: EditKind, corners: &[Point2<f64>]) -> Result<(), SlamError> {
        self.actions.note_untold("the map was changed by hand");
        self.session.edit(kind, corners)
    }

    /// Undoes the last edit by hand; `false` if there is none.
    pub fn undo_edit(&mut self) -> bool {
        self.actions.fork();
        self.session.undo_edit()
    }

    /// Removes a submap from the map; see [`crate::slam::Slam::remove_submap`].
    ///
    /// # Errors    [`SlamError`]; then the map stays as it was.
    pub fn remove_submap(&mut self, submap: usize) -> Result<(), SlamError> {
        self.actions.note_untold("a submap was taken out");
        self.session.remove_submap(submap)
    }

    /// Puts back the submap that was removed last, and returns its number; `None` if there is none
    /// that can come back.
    pub fn undo_removal(&mut self) -> Option<usize> {
        self.actions.fork();
        self.session.undo_removal()
    }

    /// What the robot believes and intends.
    #[must_use]
    pub fn session(&self) -> &Session {
        &self.session
    }

    /// The samples recorded so far.
    #[must_use]
    pub fn record(&self) -> &Record {
        &self.record
    }

    /// How well landmarks were found again so far, gate by gate; nothing is counted with methods
    /// that have no landmarks.
    #[must_use]
    pub fn refinding(&self) -> &RefindingCurve {
        self.refinding.curve()
    }

    /// The scans so far with the odometry at which they were taken: what an estimator needs,
    /// without the truth. In a very long run, only the first ten million readings.
    #[must_use]
    pub fn log(&self) -> &CarmenLog {
        &self.log
    }

    /// Simulated time, s.
    #[must_use]
    pub fn seconds(&self) -> f64 {
        self.sim.stamp().seconds()
    }

    /// The true pose, map frame.
    #[must_use]
    pub fn truth(&self) -> Pose2 {
        self.map_from_world * self.sim.truth()
    }

    /// The transform from the world frame to the map frame.
    #[must_use]
    pub fn map_from_world(&self) -> Pose2 {
        self.map_from_world
    }

    /// Hash of the bits of the whole state: world, estimate and map.
    #[must_use]
    pub fn state_hash(&self) -> u64 {
        let mut hash = StateHash::new();
        let [left, right] = self.sim.ticks();
        hash.integer(self.sim.stamp().0)
            .integer(left as u64)
            .integer(right as u64);
        hash.pose(&self.sim.truth())
            .pose(&self.session.dead_reckoning());
        self.session.slam().add_to(&mut hash);
        hash.finish()
    }
}

/// Controlled motors come to a stop within a small fraction of a millimetre, not to the bit.
fn is_slow((forward, turn): (f64, f64)) -> bool {
    forward.abs() < 1e-3 && turn.abs() < 1e-3
}
