//! The whole loop on one robot, the same for every source: SLAM, pilot, and what people want to
//! know about both.
//!
//! ```text
//!                     ┌────────────────── Session ───────────────────┐
//!   odometry, scans ──┼─> calibration ─> Slam ── estimate, map ─> Pilot ─┼── command
//!   settings ─────────┼─> reconfigure    figures: twin, fit, …       │
//!                     └──────────────────────────────────────────────┘
//! ```
//!
//! A source feeds it and gives access to it by `session()`: [`crate::experiment::Experiment`] for a
//! simulated robot, [`crate::replay::Replay`] for a recording, [`crate::live::Live`] for a robot
//! behind a bridge. The source itself has only what is its own (truth, progress, the right to
//! drive); everything else is in the session.
//!
//! | verb | when |
//! |---|---|
//! | [`Session::odometry`] | the robot measured a motion, in order of time |
//! | [`Session::scan`], [`Session::partial_scan`], [`Session::sonar_scan`] | a sensor measured, not later than the newest odometry |
//! | [`Session::gap`] | time passed that nobody watched |
//! | [`Session::decide`] | every control period, if the robot can be commanded: what to tell it, if anything |
//! | [`Session::set_mode`], [`Session::drive`], [`Session::stop`] | a person wants something else |
//! | [`Session::reconfigure`] | a person changed settings: they hold from the next scan and decision on |
//!
//! The same odometry and scans give the same bits, whatever the source.

mod config;
mod dead_reckoned;
mod stages;
#[cfg(test)]
mod tests;

use nalgebra::Point2;

use crate::estimation::{ConsistencyWindow, Drive, DriveFit, EditKind, OdometryFit};
use crate::geom::geofence::Geofence;
use crate::geom::{Length, Pose2, PoseEstimate};
use crate::map::Grid;
use crate::pilot::{Mode, Pilot, Situation, Stage, StageRecord, Status};
use crate::robot::{Bumpers, Command, Odometry, OdometryCalibration, RobotModel, Scan, Stamp};
use crate::settings::Settings;
use crate::slam::{EarlierMap, Method, Slam, SlamError};
use crate::twin::Twin;
pub use config::SessionConfig;
use dead_reckoned::DeadReckonedMap;

/// One robot that is mapped and driven.
#[derive(Debug)]
pub struct Session {
    robot: RobotModel,
    scans_on_command: bool,
    slam: Slam,
    pilot: Pilot,
    calibration: OdometryCalibration,
    twin: Option<Twin>,
    /// The tracks' counts, for [`Session::fit`].
    drive: Drive,
    consistency: ConsistencyWindow,
    dead_reckoning: Pose2,
    /// Only once somebody asks for it.
    dead_reckoned: Option<DeadReckonedMap>,
    distance: f64,
    scans: usize,
    now: Stamp,
}

impl Session {
    /// Begins at the origin of the map, standing.
    ///
    /// # Errors    [`SlamError`] naming the first setting out of range.
    pub fn new(config: SessionConfig) -> Result<Self, SlamError> {
        let mut slam = Slam::new(config.method, config.slam)?;
        if !config.is_driven {
            slam.disable_walkers();
        }
        Ok(Self {
            robot: config.robot,
            scans_on_command: config.scans_on_command,
            slam,
            pilot: Pilot::new(config.robot, config.pilot, config.seed),
            calibration: config.calibration,
            twin: None,
            drive: Drive::default(),
            consistency: ConsistencyWindow::default(),
            dead_reckoning: Pose2::identity(),
            dead_reckoned: None,
            distance: 0.0,
            scans: 0,
            now: Stamp(0),
        })
    }

    /// Takes the motion since the last call, as the robot counted it.
    ///
    /// # Errors    [`SlamError::Odometry`]; then nothing changes.
    pub fn odometry(&mut self, counted: &Odometry) -> Result<(), SlamError> {
        counted.validate()?;
        let odometry = self.calibration.corrected(counted, self.robot.track_width);
        self.slam.odometry(&odometry)?;
        self.now = odometry.to;
        self.drive.odometry(counted);
        if let Some(twin) = &mut self.twin {
            twin.odometry(counted);
        }
        self.dead_reckoning = self.dead_reckoning * odometry.motion;
        self.distance += odometry.motion.position().coords.length();
        Ok(())
    }

    /// Takes a scan, whose last beam was taken at or before the end of the newest odometry.
    ///
    /// # Errors    [`SlamError`] for a scan that cannot be used; then it is not counted.
    pub fn scan(&mut self, scan: &Scan) -> Result<(), SlamError> {
        self.scan_with_truth(scan, None)
    }

    /// Takes a scan taken at a known true pose, map frame, by which the filter's consistency is
    /// judged too.
    pub(crate) fn scan_with_truth(
        &mut self,
        scan: &Scan,
        truth: Option<&Pose2>,
    ) -> Result<(), SlamError> {
        let before = self.slam.estimate();
        self.slam.scan(scan)?;
        self.scans += 1;
        self.drive.scan();
        let estimate = self.slam.estimate();
        if let (Some(twin), Some(points)) = (&mut self.twin, self.slam.points()) {
            twin.scan(scan.stamp.seconds(), &estimate, points, self.slam.grid());
        }
        if let (Some(map), Some(points)) = (&mut self.dead_reckoned, self.slam.points()) {
            map.scan(points, &self.dead_reckoning);
        }
        if let Some(report) = self.slam.view().update {
            let nees = truth.and_then(|truth| estimate.nees(truth));
            self.consistency
                .push(nees, report.nis, report.nis_degrees());
        }
        if self.scans_on_command && self.pilot.awaits_scan() {
            for report in stages::of_scan(&self.slam, &before) {
                self.pilot.stages_mut().record(report);
            }
        }
        Ok(())
    }

    /// Takes a few readings on the move, of a sensor that scans only standing; see
    /// [`Slam::partial_scan`].
    ///
    /// # Errors    [`SlamError::Scan`].
    pub fn partial_scan(&mut self, scan: &Scan) -> Result<(), SlamError> {
        self.slam.partial_scan(scan)
    }

    /// Takes one round of readings of the sonars beside the main sensor; see [`Slam::sonar_scan`].
    ///
    /// # Errors    [`SlamError`].
    pub fn sonar_scan(&mut self, scan: &Scan) -> Result<(), SlamError> {
        self.slam.sonar_scan(scan)
    }

    /// Notes that time passed without readings: the drives before and after are not fitted as one.
    pub fn gap(&mut self) {
        self.drive.gap();
    }

    /// Goes on in a saved map, before anything was seen; see [`Slam::go_on_in`].
    ///
    /// # Errors    [`SlamError`]; then nothing changes.
    pub fn go_on_in(&mut self, saved: EarlierMap) -> Result<(), SlamError> {
        self.slam.go_on_in(saved)
    }

    /// Changes the map by hand; see [`Slam::edit`].
    ///
    /// # Errors    [`SlamError`]; then the map does not change.
    pub fn edit(&mut self, kind: EditKind, corners: &[Point2<f64>]) -> Result<(), SlamError> {
        self.slam.edit(kind, corners)
    }

    /// Takes back the last change that was made by hand; `false` if there is none.
    pub fn undo_edit(&mut self) -> bool {
        self.slam.undo_edit()
    }

    /// Takes a submap out of the map; see [`crate::slam::Slam::remove_submap`].
    ///
    /// # Errors    [`SlamError`]; then the map does not change.
    pub fn remove_submap(&mut self, submap: usize) -> Result<(), SlamError> {
        self.slam.remove_submap(submap)
    }

    /// Puts back the submap that was taken out last and returns its number; `None` if there is none
    /// that can come back.
    pub fn undo_removal(&mut self) -> Option<usize> {
        self.slam.undo_removal()
    }

    /// Completes all postponed work, at the end of a recording.
    pub fn finish(&mut self) {
        self.slam.finish();
    }

    /// What to tell the robot now, given which bumpers are pressed and whether the last command is
    /// still under way; `None`: nothing new, it carries on.
    pub fn decide(&mut self, bumpers: Bumpers, robot_is_busy: bool) -> Option<Command> {
        self.pilot.steer(&Situation {
            stamp: self.now,
            estimate: &self.slam.estimate(),
            known_in_map: self.slam.known_in_map(),
            grid: self.slam.grid(),
            graph: self.slam.view().graph,
            points: self.slam.obstacles(),
            walkers: self.slam.walkers(),
            bumpers,
            motion_since_scan: self.slam.motion_since_scan(),
            drives_unsure: self.slam.view().pose_quality.is_some()
                || self.slam.method() == Method::Odometry,
            heading_drift: self.slam.heading_drift(),
            speeds: self.slam.speeds(),
            robot_is_busy,
            scans_on_command: self.scans_on_command,
        })
    }

    /// Uses other settings from the next scan and the next decision on, as far as they can change
    /// during a run (see [`Slam::reconfigure`]).
    ///
    /// # Errors    [`SlamError`] naming the first setting out of range; then the old ones stay.
    pub fn reconfigure(&mut self, settings: &Settings) -> Result<(), SlamError> {
        self.slam.reconfigure(&settings.slam)?;
        self.pilot.reconfigure(settings.pilot.clone());
        self.calibration = settings.odometry.calibration(&self.robot);
        Ok(())
    }

    /// Keeps ways and frontiers within this fence, map frame; see [`Pilot::set_fence`].
    pub fn set_fence(&mut self, fence: Geofence) {
        self.pilot.set_fence(fence);
    }

    /// Gives the robot another task.
    pub fn set_mode(&mut self, mode: Mode) {
        self.pilot.set_mode(mode);
    }

    /// Drives by hand with these speeds, m/s and rad/s, until commanded otherwise.
    pub fn drive(&mut self, forward: f64, turn: f64) {
        self.pilot.drive(forward, turn);
    }

    /// Stops the robot and forgets its task.
    pub fn stop(&mut self) {
        self.pilot.stop();
    }

    /// Whether the sensor scans only on command or all the time from here on; the task starts
    /// again.
    pub fn set_scans_on_command(&mut self, scans_on_command: bool) {
        self.scans_on_command = scans_on_command;
        self.pilot.set_mode(self.pilot.mode());
    }

    /// Runs a twin with this calibration beside the robot from here on; `None` ends it.
    pub fn set_twin(&mut self, calibration: Option<OdometryCalibration>) {
        let (width, at) = (self.robot.track_width, self.slam.estimate().pose);
        self.twin = calibration.map(|calibration| Twin::new(calibration, width, at));
    }

    /// From here on also keeps the map that dead reckoning alone would have drawn, see
    /// [`Session::dead_reckoned`].
    pub fn draw_dead_reckoned(&mut self) {
        let config = *self.slam.grid().config();
        let begin = || Grid::new(config).ok().map(DeadReckonedMap::new);
        self.dead_reckoned = self.dead_reckoned.take().or_else(begin);
    }

    /// Shows the next recorded stage of the cycle that was not shown yet, if any; see
    /// [`StageRecord`].
    pub fn step_stage(&mut self) -> Option<Stage> {
        self.pilot.stages_mut().step()
    }

    /// Shows all stages of the cycle as soon as they are recorded.
    pub fn show_all_stages(&mut self) {
        self.pilot.stages_mut().show_all();
    }

    /// The robot's figures.
    #[must_use]
    pub fn robot(&self) -> &RobotModel {
        &self.robot
    }

    /// Whether the sensor scans only on command, while the robot stands: then the robot drives by
    /// the cycle.
    #[must_use]
    pub fn scans_on_command(&self) -> bool {
        self.scans_on_command
    }

    /// Pose and map.
    #[must_use]
    pub fn slam(&self) -> &Slam {
        &self.slam
    }

    /// The estimated pose, map frame.
    #[must_use]
    pub fn estimate(&self) -> PoseEstimate {
        self.slam.estimate()
    }

    /// The estimate to show: the newest, or the one before a correction that waits to be shown
    /// ([`Session::step_stage`]).
    #[must_use]
    pub fn shown_estimate(&self) -> PoseEstimate {
        let held = self.stages().held_estimate();
        held.copied().unwrap_or_else(|| self.estimate())
    }

    /// The pilot: mode, path, frontiers, search tree.
    #[must_use]
    pub fn pilot(&self) -> &Pilot {
        &self.pilot
    }

    /// What the robot is doing.
    #[must_use]
    pub fn status(&self) -> &Status {
        self.pilot.status()
    }

    /// What the stages of the cycle gave; empty for a robot that drives while its sensor scans.
    #[must_use]
    pub fn stages(&self) -> &StageRecord {
        self.pilot.stages()
    }

    /// What is known of the odometry.
    #[must_use]
    pub fn calibration(&self) -> &OdometryCalibration {
        &self.calibration
    }

    /// The twin that runs beside the robot, if any.
    #[must_use]
    pub fn twin(&self) -> Option<&Twin> {
        self.twin.as_ref()
    }

    /// The filter's consistency (NEES, NIS) over the last scans; empty for methods without a line
    /// map.
    #[must_use]
    pub fn consistency(&self) -> &ConsistencyWindow {
        &self.consistency
    }

    /// The pose by odometry alone, calibrated, map frame.
    #[must_use]
    pub fn dead_reckoning(&self) -> Pose2 {
        self.dead_reckoning
    }

    /// The map that dead reckoning alone would have drawn, in the frame of the map; only since
    /// somebody asked for it ([`Session::draw_dead_reckoned`]).
    #[must_use]
    pub fn dead_reckoned(&self) -> Option<&Grid> {
        self.dead_reckoned.as_ref().map(DeadReckonedMap::grid)
    }

    /// Distance travelled by odometry, m.
    #[must_use]
    pub fn distance(&self) -> f64 {
        self.distance
    }

    /// Number of scans taken in.
    #[must_use]
    pub fn scans(&self) -> usize {
        self.scans
    }

    /// The end of the newest odometry.
    #[must_use]
    pub fn stamp(&self) -> Stamp {
        self.now
    }

    /// What the drive so far tells about the odometry, with the poses of this run as the truth.
    /// Scans are not kept, so it tells nothing about the ranges. The settings it finds correct the
    /// raw odometry; they are not changes relative to the settings of this session.
    #[must_use]
    pub fn fit(&self) -> DriveFit {
        let trajectory = self.slam.trajectory();
        let poses: Vec<Pose2> = trajectory.iter().map(|(_, pose)| *pose).collect();
        DriveFit {
            odometry: OdometryFit::new(&self.drive, &poses, &self.robot),
            ranges: None,
            is_lidar: false,
        }
    }
}
