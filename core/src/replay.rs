//! A recorded log through the same SLAM that drives a robot.
//!
//! In: a [`Log`]: a CARMEN log, or a recording of the bridge. Out: scan by scan, the pose, the trajectory and the map.
//!
//! 1. A CARMEN log holds odometry in each laser message. It is turned into motions between scans, with the noise of a Pioneer.
//! 2. A recording holds what the bridge heard. It goes through the timeline that a live robot goes through
//!    ([`crate::wire::timeline`]), so that a recorded drive is mapped as it would have been live.

mod feed;
mod log;
#[cfg(test)]
mod tests;

use crate::estimation::{ConsistencyWindow, Drive, DriveFit, OdometryFit};
use crate::format::carmen::CarmenLog;
use crate::geom::Pose2;
use crate::hash::StateHash;
use crate::points::{SigmaConfig, estimate_sigma_of_stretches};
use crate::robot::{RobotModel, Scan, Stamp, ToldOdometry};
use crate::slam::{Method, Slam, SlamConfig, SlamError};
use crate::twin::Twin;
use feed::{Feed, Step};

pub use log::{Log, LogError, LogReader};

/// Motion between two scans that counts as none, m and rad: less than what logs are rounded to.
const STILL: f64 = 1e-4;

/// A log that is being replayed.
#[derive(Debug)]
pub struct Replay {
    log: Log,
    robot: RobotModel,
    feed: Feed,
    scans_done: usize,
    first: Option<(Stamp, Pose2)>,
    last: Option<(Stamp, Pose2)>,
    /// Of each scan that was used, as many as the trajectory has poses.
    used: Vec<Used>,
    /// What is known better of the robot than the log says.
    told: ToldOdometry,
    /// What its tracks counted.
    drive: Drive,
    twin: Option<Twin>,
    notes: Vec<String>,
    slam: Slam,
    consistency: ConsistencyWindow,
}

/// A scan that was used: its time as the log counts it, s, and where the wheels alone put the robot.
#[derive(Clone, Copy, Debug)]
struct Used {
    seconds: f64,
    odom_from_robot: Pose2,
}

impl Replay {
    /// Begins at the first scan. A recording without a robot is mapped by scan matching, whatever the method: lines alone do
    /// not tell how far along a corridor a sensor was carried.
    ///
    /// # Errors   [`SlamError`] for a setting out of range.
    pub fn new(log: impl Into<Log>, method: Method, config: SlamConfig) -> Result<Self, SlamError> {
        let log = log.into();
        let mut notes: Vec<String> = log.damage().iter().map(ToString::to_string).collect();
        let method = if log.has_odometry() {
            method
        } else {
            notes.push("No robot is in this recording: it is mapped by scan matching".into());
            Method::ScanMatching
        };
        let mut slam = Slam::new(method, config)?;
        slam.leave_walkers_out();
        Ok(Self {
            robot: log.robot(),
            feed: Feed::of(&log),
            log,
            scans_done: 0,
            first: None,
            last: None,
            used: vec![],
            told: ToldOdometry::default(),
            drive: Drive::default(),
            twin: None,
            notes,
            slam,
            consistency: ConsistencyWindow::default(),
        })
    }

    /// From here on the odometry is that of a robot of which so much is known; what is fitted stays what was recorded.
    pub fn tell_odometry(&mut self, told: ToldOdometry) {
        self.told = told;
    }

    /// From here on a twin with these figures runs beside the robot; none: no longer.
    pub fn set_twin(&mut self, told: Option<ToldOdometry>) {
        let at = self.slam.estimate().pose;
        self.twin = told.map(|told| Twin::new(told, self.robot.track_width, at));
    }

    /// The twin that runs beside the robot.
    #[must_use]
    pub fn twin(&self) -> Option<&Twin> {
        self.twin.as_ref()
    }

    /// Takes the next scan; `false` when there is none left, and then all work that was put off is done.
    ///
    /// # Errors   [`SlamError`] for a scan that cannot be used; it is passed over by the next call.
    pub fn step(&mut self) -> Result<bool, SlamError> {
        let step = self.feed.next(&self.log, &self.robot);
        self.notes.append(self.feed.notes());
        let Some(step) = step else {
            self.slam.finish();
            return Ok(false);
        };
        self.scans_done += 1;
        self.last = Some((step.scan.stamp, step.odom_from_robot));
        self.first = self.first.or(self.last);
        self.take(&step)?;
        self.drive.scan();
        self.used.push(Used {
            seconds: step.seconds,
            odom_from_robot: step.odom_from_robot,
        });
        if let Some(report) = self.slam.view().update {
            self.consistency
                .push(None, report.nis, report.nis_degrees());
        }
        Ok(true)
    }

    fn take(&mut self, step: &Step) -> Result<(), SlamError> {
        if step.is_after_gap {
            self.drive.gap();
        }
        for odometry in &step.odometry {
            self.drive.odometry(odometry);
            if let Some(twin) = &mut self.twin {
                twin.odometry(odometry);
            }
            let odometry = self.told.corrected(odometry, self.robot.track_width);
            self.slam.odometry(&odometry)?;
        }
        self.slam.scan(&step.scan)?;
        if let (Some(twin), Some(points)) = (&mut self.twin, self.slam.points()) {
            let at = step.scan.stamp.seconds();
            twin.scan(at, &self.slam.estimate(), points, self.slam.grid());
        }
        Ok(())
    }

    /// The part that is done, 0 to 1.
    #[must_use]
    pub fn progress(&self) -> f64 {
        self.feed.progress(&self.log)
    }

    /// Scans taken so far.
    #[must_use]
    pub fn scans_done(&self) -> usize {
        self.scans_done
    }

    /// Messages of a recording taken so far, those that came with the last scan included; scans of a CARMEN log.
    #[must_use]
    pub fn messages_done(&self) -> usize {
        self.feed.position()
    }

    /// Where the odometry of the log itself puts the robot at the last scan.
    #[must_use]
    pub fn odom_from_robot(&self) -> Pose2 {
        self.last.map_or_else(Pose2::identity, |(_, pose)| pose)
    }

    /// From the first scan to the one taken last, s.
    #[must_use]
    pub fn time(&self) -> f64 {
        match (self.first, self.last) {
            (Some((first, _)), Some((last, _))) => last.since(first),
            _ => 0.0,
        }
    }

    /// The log.
    #[must_use]
    pub fn log(&self) -> &Log {
        &self.log
    }

    /// The robot that it was recorded with; a Pioneer where the log does not tell.
    #[must_use]
    pub fn robot(&self) -> &RobotModel {
        &self.robot
    }

    /// What a person should read: damage, and time that was missed; it is forgotten here.
    pub fn take_notes(&mut self) -> Vec<String> {
        std::mem::take(&mut self.notes)
    }

    /// Stretches of scans during which the odometry stood still, three scans or more.
    #[must_use]
    pub fn standing_stretches(&self) -> Vec<Vec<Scan>> {
        let mut feed = Feed::of(&self.log);
        let (mut stretches, mut stretch) = (vec![], vec![]);
        let mut last: Option<Pose2> = None;
        while let Some(step) = feed.next(&self.log, &self.robot) {
            let stands = last.is_some_and(|last| {
                let motion = last.delta_to(&step.odom_from_robot);
                motion.position().coords.norm() < STILL && motion.heading().abs() < STILL
            });
            if !stands {
                stretches.push(std::mem::take(&mut stretch));
            }
            stretch.push(step.scan);
            last = Some(step.odom_from_robot);
        }
        stretches.push(stretch);
        stretches.retain(|stretch: &Vec<Scan>| stretch.len() >= 3);
        stretches
    }

    /// What the drive so far tells of the robot and its sensor, with the poses of this run as the truth. Its settings turn this run's
    /// odometry into that of the robot as it is: they are no changes to those that it ran with.
    #[must_use]
    pub fn fit(&self) -> DriveFit {
        let poses: Vec<Pose2> = self
            .slam
            .trajectory()
            .iter()
            .map(|(_, pose)| *pose)
            .collect();
        let stretches = self.standing_stretches();
        let stretches: Vec<&[Scan]> = stretches.iter().map(Vec::as_slice).collect();
        DriveFit {
            odometry: OdometryFit::new(&self.drive, &poses, &self.robot),
            ranges: Some(estimate_sigma_of_stretches(
                &stretches,
                &SigmaConfig::default(),
            )),
            is_lidar: !self.log.scans_on_command(),
        }
    }

    /// What does the work.
    #[must_use]
    pub fn slam(&self) -> &Slam {
        &self.slam
    }

    /// Whether the innovations of the last scans were as large as claimed; empty for methods without a line map.
    #[must_use]
    pub fn consistency(&self) -> &ConsistencyWindow {
        &self.consistency
    }

    /// The pose by odometry alone at the last scan; the map's frame begins at the first.
    #[must_use]
    pub fn odometry_pose(&self) -> Pose2 {
        self.last
            .map_or_else(Pose2::identity, |(_, pose)| self.map_from_odom() * pose)
    }

    /// The motion that takes the log's odometry frame to the map's.
    #[must_use]
    pub fn map_from_odom(&self) -> Pose2 {
        self.first
            .map_or_else(Pose2::identity, |(_, pose)| pose.inverse())
    }

    /// Where odometry alone puts the robot at each scan used so far, map frame.
    pub fn odometry_trajectory(&self) -> impl Iterator<Item = Pose2> {
        let map_from_odom = self.map_from_odom();
        self.used
            .iter()
            .map(move |used| map_from_odom * used.odom_from_robot)
    }

    /// The pose of the robot's base at each scan used so far, as known now, with the scan's time: `ipc_timestamp` of a CARMEN
    /// log, the robot's clock in a recording.
    #[must_use]
    pub fn trajectory(&self) -> Vec<(f64, Pose2)> {
        let used = self.used.iter();
        used.zip(self.slam.trajectory())
            .map(|(used, (_, pose))| (used.seconds, pose))
            .collect()
    }

    /// All scans of the log with their odometry, those too that were not taken yet, as a CARMEN log.
    #[must_use]
    pub fn carmen_log(&self) -> CarmenLog {
        let recording = match &self.log {
            Log::Carmen(log) => return log.clone(),
            recording @ Log::Recording(_) => recording,
        };
        let mut feed = Feed::of(recording);
        let mut log = CarmenLog::empty();
        while let Some(step) = feed.next(recording, &self.robot) {
            log.push(step.seconds, &step.odom_from_robot, &step.scan);
        }
        log
    }

    /// The hash of the whole trajectory: equal bits natively and in the browser.
    #[must_use]
    pub fn state_hash(&self) -> u64 {
        let mut hash = StateHash::new();
        for (seconds, pose) in self.trajectory() {
            hash.number(seconds).pose(&pose);
        }
        hash.finish()
    }
}
