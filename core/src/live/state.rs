//! The robot behind the bridge: what it believes, and what it intends.
//!
//! In: what the timeline lets through. Out: estimate, map, and the pilot's commands. It begins anew with each robot that is named.

use super::LiveConfig;
use crate::estimation::{ConsistencyWindow, Drive};
use crate::geom::Pose2;
use crate::pilot::{Pilot, PilotConfig, Situation};
use crate::robot::{Bumpers, Command, Odometry, RobotModel, Scan, Stamp, ToldOdometry};
use crate::slam::{Method, Slam, SlamConfig, SlamError};
use crate::twin::Twin;
use crate::wire::message::{Motion, RobotFigures};
use crate::wire::timeline::Timeline;

/// Estimate and intention.
#[derive(Debug)]
pub(super) struct State {
    pub(super) figures: Option<RobotFigures>,
    pub(super) timeline: Timeline,
    pub(super) slam: Slam,
    pub(super) pilot: Pilot,
    pub(super) model: RobotModel,
    pub(super) bumpers: Bumpers,
    pub(super) now: Stamp,
    pub(super) scans: u32,
    pub(super) distance: f64,
    pub(super) dead_reckoning: Pose2,
    pub(super) consistency: ConsistencyWindow,
    /// Standing was told already.
    pub(super) is_told_to_stand: bool,
    /// What the tracks counted.
    pub(super) drive: Drive,
    /// What is known better of the robot than it says.
    pub(super) told: ToldOdometry,
    pub(super) twin: Option<Twin>,
}

impl State {
    pub(super) fn new(
        config: &LiveConfig,
        figures: Option<RobotFigures>,
    ) -> Result<Self, SlamError> {
        let (mut slam, pilot) = match &figures {
            Some(figures) if figures.scans_on_command => {
                (SlamConfig::short_range(), PilotConfig::short_range())
            }
            _ => (SlamConfig::default(), PilotConfig::default()),
        };
        // Without wheels, lines alone do not tell how far along a corridor the sensor was carried.
        let method = match (&figures, config.method, &config.known) {
            (Some(_), Method::PriorMap, Some(known)) => {
                slam.prior_map.clone_from(known);
                Method::PriorMap
            }
            // A bridge has no map to hand out.
            (Some(_), Method::PriorMap, None) => Method::LineEkf,
            (Some(_), method, _) => method,
            (None, ..) => Method::ScanMatching,
        };
        let model = figures.as_ref().and_then(RobotFigures::model);
        let model = model.unwrap_or_else(RobotModel::pioneer);
        Ok(Self {
            figures,
            timeline: Timeline::default(),
            slam: Slam::new(method, slam)?,
            pilot: Pilot::new(model, pilot, config.seed),
            model,
            bumpers: Bumpers::default(),
            now: Stamp(0),
            scans: 0,
            distance: 0.0,
            dead_reckoning: Pose2::identity(),
            consistency: ConsistencyWindow::default(),
            is_told_to_stand: false,
            drive: Drive::default(),
            told: ToldOdometry::default(),
            twin: None,
        })
    }

    pub(super) fn odometry(&mut self, odometry: &Odometry) -> Result<(), SlamError> {
        self.now = odometry.to;
        self.drive.odometry(odometry);
        if let Some(twin) = &mut self.twin {
            twin.odometry(odometry);
        }
        self.dead_reckoning = self.dead_reckoning * odometry.motion;
        self.distance += odometry.motion.position().coords.norm();
        let told = self.told.corrected(odometry, self.model.track_width);
        self.slam.odometry(&told)
    }

    pub(super) fn scan(&mut self, scan: &Scan) -> Result<(), SlamError> {
        self.scans += 1;
        self.slam.scan(scan)?;
        self.drive.scan();
        if let (Some(twin), Some(points)) = (&mut self.twin, self.slam.points()) {
            let at = scan.stamp.seconds();
            twin.scan(at, &self.slam.estimate(), points, self.slam.grid());
        }
        if let Some(report) = self.slam.view().update {
            self.consistency
                .push(None, report.nis, report.nis_degrees());
        }
        Ok(())
    }

    /// What to tell the robot; `None` where nothing is to be said.
    pub(super) fn decide(&mut self, robot_is_busy: bool) -> Option<Command> {
        let estimate = self.slam.estimate();
        let command = self.pilot.steer(&Situation {
            stamp: self.now,
            estimate: &estimate,
            grid: self.slam.grid(),
            points: self.slam.obstacles(),
            walkers: self.slam.walkers(),
            bumpers: self.bumpers,
            motion_since_scan: self.slam.motion_since_scan(),
            heading_drift: self.slam.heading_drift(),
            speeds: self.slam.speeds(),
            robot_is_busy,
            scans_on_command: self.figures.as_ref().is_some_and(|f| f.scans_on_command),
        })?;
        // A robot that stands is told so once; the lease is kept without.
        let stands = Motion::from(command) == Motion::Halt;
        let again = stands && self.is_told_to_stand;
        self.is_told_to_stand = stands;
        (!again).then_some(command)
    }
}
