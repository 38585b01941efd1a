//! The whole laboratory in one deterministic loop: a simulated robot senses, [`Slam`] estimates and maps, [`Pilot`]
//! decides, the robot drives.
//!
//! ```text
//!   Simulation ── ticks, scans ──> Slam ── estimate, grid, points ──> Pilot ── command ──> Simulation
//! ```
//!
//! The same configuration gives the same bits natively and in the browser; [`Experiment::state_hash`] shows it.

mod config;
mod figures;
mod known_map;
mod stages;
#[cfg(test)]
mod tests;

use crate::format::carmen::CarmenLog;
use crate::geom::{Pose2, PoseEstimate};
use crate::hash::StateHash;
use crate::pilot::{self, Mode, Pilot, PilotConfig, Situation, Stage};
use crate::robot::{Command, Robot, Scan, TrackNoise, TrackWear};
use crate::sim::{NoDoor, SimError, Simulation};
use crate::slam::{Slam, SlamConfig, SlamError};
pub use config::ExperimentConfig;
pub use figures::{Figures, Record, Sample};

/// Simulated time of one step, s: how often the pilot decides.
pub const CONTROL_PERIOD: f64 = 0.05;
/// Control periods that one stage of the cycle, or scans of a standing robot, may take: ten minutes.
const MOST_PERIODS: usize = 12_000;
/// Readings that are kept for a log: 40 MB, three quarters of an hour of a lidar with 360 beams at 10 Hz.
const MOST_LOGGED: usize = 10_000_000;
/// Odometry readings in one step. A turning sensor is de-skewed by them, so they come faster than decisions.
const READINGS: u32 = 5;

/// Why an experiment cannot begin.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ExperimentError {
    /// The world or the robot in it.
    #[error(transparent)]
    Sim(#[from] SimError),
    /// A setting of the estimation.
    #[error(transparent)]
    Slam(#[from] SlamError),
}

/// A simulated robot that maps, finds itself, plans and drives.
#[derive(Debug)]
pub struct Experiment {
    sim: Simulation,
    slam: Slam,
    pilot: Pilot,
    dead_reckoning: Pose2,
    map_from_world: Pose2,
    record: Record,
    /// Whether the pilot has decided on the period that comes next.
    has_decided: bool,
    /// Scans with the odometry at which they were taken, as long as there is room.
    log: CarmenLog,
}

impl Experiment {
    /// Puts the robot at the start of its world. The map's frame begins there.
    ///
    /// # Errors    [`ExperimentError`] naming what cannot be.
    pub fn new(config: ExperimentConfig) -> Result<Self, ExperimentError> {
        let map_from_world = config.world.start.inverse();
        let slam = known_map::settings(&config);
        let mut sim = Simulation::new(config.world, config.robot, config.sensor, config.seed)?;
        if let Some(sonars) = &config.sonars_beside {
            sim.put_sonars_beside(sonars, config.seed)?;
        }
        // The pilot draws its own numbers: what it decides must not change the noise of the sensors.
        let mut pilot = Pilot::new(
            config.robot,
            config.pilot,
            config.seed ^ 0x9E37_79B9_7F4A_7C15,
        );
        pilot.set_mode(config.mode);
        sim.set_on_command(config.cycle);
        sim.tell_noise(config.odometry);
        sim.tell_wear(config.told_wear);
        if let Some(wear) = config.wear {
            sim.set_wear(wear);
        }
        Ok(Self {
            sim,
            slam: Slam::new(config.method, slam)?,
            pilot,
            dead_reckoning: Pose2::identity(),
            map_from_world,
            record: Record::default(),
            has_decided: false,
            log: CarmenLog::empty(),
        })
    }

    /// One control period: the pilot decides, the robot moves, odometry and scans are taken in. Tells whether a scan was.
    ///
    /// # Errors    [`SlamError`] for a scan that cannot be used; the simulated sensors make none such.
    pub fn step(&mut self) -> Result<bool, SlamError> {
        self.decide();
        self.advance()
    }

    /// The first half of a step: the pilot looks at the map and tells the robot what to do. Does nothing where it has
    /// decided already, as [`Self::next_stage`] may leave it.
    pub fn decide(&mut self) {
        self.pilot.stages_mut().show_all();
        self.steer();
    }

    fn steer(&mut self) {
        if std::mem::replace(&mut self.has_decided, true) {
            return;
        }
        let estimate = self.slam.estimate();
        let now = situation(&self.sim, &self.slam, &estimate);
        if let Some(command) = self.pilot.steer(&now) {
            self.sim.command(command);
        }
    }

    /// The second half of a step: the robot moves, odometry and scans are taken in. Tells whether a scan was.
    ///
    /// # Errors    [`SlamError`] for a scan that cannot be used; the simulated sensors make none such.
    pub fn advance(&mut self) -> Result<bool, SlamError> {
        self.pilot.stages_mut().show_all();
        self.sense()
    }

    fn sense(&mut self) -> Result<bool, SlamError> {
        self.has_decided = false;
        let mut has_scanned = false;
        for _ in 0..READINGS {
            if let Some(scan) = self.read()? {
                self.scan(&scan)?;
                has_scanned = true;
            }
        }
        Ok(has_scanned)
    }

    /// One reading of the odometry, and the scan that came with it.
    fn read(&mut self) -> Result<Option<Scan>, SlamError> {
        self.sim.advance(CONTROL_PERIOD / f64::from(READINGS));
        let odometry = self.sim.odometry();
        self.dead_reckoning = self.dead_reckoning * odometry.motion;
        self.slam.odometry(&odometry)?;
        if let Some(scan) = self.sim.take_scan_beside() {
            self.slam.sonar_scan(&scan)?;
        }
        while let Some(look) = self.sim.take_look() {
            self.slam.partial_scan(&look)?;
        }
        let scan = self.sim.take_scan();
        if let Some(scan) = scan.as_ref().filter(|_| self.log.len() < MOST_LOGGED) {
            self.log
                .push(scan.stamp.seconds(), &self.dead_reckoning, scan);
        }
        Ok(scan)
    }

    fn scan(&mut self, scan: &Scan) -> Result<(), SlamError> {
        let before = self.slam.estimate();
        self.slam.scan(scan)?;
        if self.is_in_cycle() {
            for report in stages::of_scan(&self.slam, &before) {
                self.pilot.stages_mut().record(report);
            }
        }
        let sample = Sample {
            stamp: self.sim.stamp(),
            truth: self.truth(),
            estimate: self.slam.estimate(),
            odometry: self.dead_reckoning,
        };
        self.record.push(sample, self.slam.view().update);
        Ok(())
    }

    /// Goes on to the next stage of the cycle that was not shown yet, and tells which it is; `None` where the errand is over
    /// or there is none. It steps through the record of the stages; the run itself goes on, to the next decision, only
    /// where that is used up, so that its bits are those of [`Self::step`].
    ///
    /// # Errors    [`SlamError`] for a scan that cannot be used; the simulated sensors make none such.
    pub fn next_stage(&mut self) -> Result<Option<Stage>, SlamError> {
        for _ in 0..2 * MOST_PERIODS {
            let stage = self.pilot.stages_mut().step();
            if stage.is_some() || self.status().is_over() || !self.is_in_cycle() {
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

    /// Other settings from here on, as far as they can be changed during a run (see [`Slam::reconfigure`]).
    ///
    /// # Errors    [`SlamError`] naming the first setting out of range; then the old ones stay.
    pub fn reconfigure(
        &mut self,
        slam: &SlamConfig,
        pilot: &PilotConfig,
        odometry: TrackNoise,
        told_wear: TrackWear,
    ) -> Result<(), SlamError> {
        self.slam.reconfigure(slam)?;
        self.pilot.reconfigure(pilot.clone());
        self.sim.tell_noise(odometry);
        self.sim.tell_wear(told_wear);
        Ok(())
    }

    /// `count` scans of a robot that is just like this one and stands where it stands, for [`crate::points::estimate_sigma`];
    /// fewer where they would take more than ten minutes. The run itself goes on as if nothing had been.
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
            // What was seen before it stood, and during the sweep in which it came to stand, does not count.
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

    /// Has the robot drive by the cycle, or as continuously as its sensor allows; its errand begins anew.
    pub fn set_cycle(&mut self, cycle: bool) {
        self.sim.set_on_command(cycle);
        self.pilot.set_mode(self.pilot.mode());
    }

    /// Gives the robot another errand.
    pub fn set_mode(&mut self, mode: Mode) {
        self.pilot.set_mode(mode);
    }

    /// Drives by hand with these speeds, m/s and rad/s, until told otherwise.
    pub fn drive(&mut self, forward: f64, turn: f64) {
        self.pilot.drive(forward, turn);
    }

    /// Whether it drives by the cycle: because it was told to, or because its sensor scans standing only.
    #[must_use]
    pub fn is_in_cycle(&self) -> bool {
        self.sim.scans_on_command()
    }

    /// Opens or shuts a door of the world.
    ///
    /// # Errors    [`NoDoor`].
    pub fn set_door(&mut self, index: usize, open: bool) -> Result<(), NoDoor> {
        self.sim.set_door(index, open)
    }

    /// Stops the robot at once; it forgets its errand.
    pub fn stop(&mut self) {
        self.pilot.stop();
        self.sim.command(Command::Stop);
    }

    /// The simulated robot in its world.
    #[must_use]
    pub fn sim(&self) -> &Simulation {
        &self.sim
    }

    /// What the robot believes.
    #[must_use]
    pub fn slam(&self) -> &Slam {
        &self.slam
    }

    /// What the robot intends.
    #[must_use]
    pub fn pilot(&self) -> &Pilot {
        &self.pilot
    }

    /// What was so far.
    #[must_use]
    pub fn record(&self) -> &Record {
        &self.record
    }

    /// The scans so far with the odometry at which they were taken: what an estimator needs, without the truth. Of a run that is very
    /// long the first ten million readings.
    #[must_use]
    pub fn log(&self) -> &CarmenLog {
        &self.log
    }

    /// How the errand goes.
    #[must_use]
    pub fn status(&self) -> &pilot::Status {
        self.pilot.status()
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

    /// The pose by odometry alone, map frame.
    #[must_use]
    pub fn odometry_pose(&self) -> Pose2 {
        self.dead_reckoning
    }

    /// The motion that takes the world's frame to the map's.
    #[must_use]
    pub fn map_from_world(&self) -> Pose2 {
        self.map_from_world
    }

    /// Where the robot believes to be.
    #[must_use]
    pub fn estimate(&self) -> PoseEstimate {
        self.slam.estimate()
    }

    /// Hash of the bits of the whole state: world, estimate and map.
    #[must_use]
    pub fn state_hash(&self) -> u64 {
        let mut hash = StateHash::new();
        let [left, right] = self.sim.ticks();
        hash.integer(self.sim.stamp().0)
            .integer(left as u64)
            .integer(right as u64);
        hash.pose(&self.sim.truth()).pose(&self.dead_reckoning);
        self.slam.add_to(&mut hash);
        hash.finish()
    }
}

/// Motors under control stand within a small fraction of a millimetre, not to the bit.
fn is_slow((forward, turn): (f64, f64)) -> bool {
    forward.abs() < 1e-3 && turn.abs() < 1e-3
}

fn situation<'a>(sim: &Simulation, slam: &'a Slam, estimate: &'a PoseEstimate) -> Situation<'a> {
    Situation {
        stamp: sim.stamp(),
        estimate,
        grid: slam.grid(),
        points: slam.obstacles(),
        walkers: slam.walkers(),
        bumpers: sim.bumpers(),
        motion_since_scan: slam.motion_since_scan(),
        heading_drift: slam.heading_drift(),
        speeds: slam.speeds(),
        robot_is_busy: sim.is_busy(),
        scans_on_command: sim.scans_on_command(),
    }
}
