//! A recorded log as the source of a [`Session`]: the same SLAM that drives a robot.
//!
//! In: a [`Log`], from CARMEN, from the bridge, from a rover, from four rangers or from a lidar
//! alone. Out: scan by scan, the pose, the trajectory and the map.
//!
//! 1. A CARMEN log has odometry in each laser message. It is turned into motions between scans,
//!    with the noise of a Pioneer.
//! 2. A recording holds what the bridge received. It goes through the same timeline as a live robot
//!    ([`crate::wire::timeline`]), so a recorded drive is mapped as it would have been live.
//! 3. A rover's log holds encoder counts. The distance per count and the distance of the tracks are
//!    settings ([`crate::settings::LogSettings`]); so is whether odometry is used at all.
//! 4. A log of revolutions has neither odometry nor time: it is mapped as from a hand-carried
//!    sensor, at a rate that is a setting.
//! 5. Poses from another file, on the clock of the log, replace its odometry ([`PosedLog`]), or
//!    serve as the truth with which the run is compared ([`Replay::set_truth`]).

mod feed;
mod log;
mod pose_track;
mod posed_log;
mod reader;
mod ros;
#[cfg(test)]
mod tests;
mod truth;

use std::sync::Arc;

use nalgebra::Point2;

use crate::estimation::{DriveFit, EditKind, SavedMap, ScanMatcher};
use crate::format::LeftOut;
use crate::format::carmen::CarmenLog;
use crate::format::revolution_log::RevolutionLog;
use crate::geom::{Length, Pose2};
use crate::hash::StateHash;
use crate::points::{Growth, estimate_sigma};
use crate::robot::{OdometryCalibration, Scan, Stamp};
use crate::session::{Session, SessionConfig};
use crate::settings::{LogSettings, Settings};
use crate::slam::{EarlierMap, Method, SlamError};
use feed::{Feed, Step};
use posed_log::scan_times;
use truth::Truth;

pub use log::Log;
pub use pose_track::{PoseTrack, PosesMisfit};
pub use posed_log::PosedLog;
pub use reader::{LogError, LogReader};
pub use ros::{ImportError, Imported, Offered, RosChoice, RosOffer, import_ros};
pub use truth::{PoseError, TruthErrors};

/// Motion between two scans below this counts as none, m and rad: less than the rounding of logs.
const STILL: f64 = 1e-4;

/// Why a log cannot be replayed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ReplayError {
    /// A setting of the estimation is out of range.
    #[error(transparent)]
    Slam(#[from] SlamError),
    /// Without odometry the robot cannot be localised in a prior map.
    #[error(
        "this recording has no odometry, or it is not to be used: without it nothing can be found in a prior map; choose scan-matching"
    )]
    NoOdometry,
    /// Something was done to the map that is not in the recording.
    #[error("{0}: from its beginning the recording would not come to the same map")]
    Untold(&'static str),
}

const CHANGED: &str = "the map was changed by hand";

/// A log that is being replayed.
#[derive(Debug)]
pub struct Replay {
    log: Arc<Log>,
    /// The method asked for, and the latest settings.
    method: Method,
    settings: Settings,
    /// Why it cannot be repeated, if it cannot.
    untold: Option<&'static str>,
    feed: Feed,
    /// As at the beginning of the replay.
    figures: LogSettings,
    first: Option<Stamp>,
    /// Stamp and the log's odometry of the last scan.
    last: Option<(Stamp, Pose2)>,
    /// For each scan that was used, as many as the trajectory has poses.
    used: Vec<Used>,
    /// Stamps and times of scans of earlier runs, rising, if it continues in their map.
    earlier: Vec<(Stamp, f64)>,
    notes: Vec<String>,
    /// The truth with which it is compared.
    truth: Option<Truth>,
    session: Session,
}

/// A scan that was used: its time as the log counts it, s, and the pose by odometry alone, map
/// frame.
#[derive(Clone, Copy, Debug)]
struct Used {
    seconds: f64,
    dead_reckoning: Pose2,
}

impl Replay {
    /// Begins at the first scan, with settings for the log's robot ([`Log::settings`]); those of a
    /// simulated sensor and body and of driving do not matter. A recording without a robot is
    /// mapped by scan matching, whatever the method: lines alone do not show how far along a
    /// corridor a sensor was carried.
    ///
    /// # Errors   [`ReplayError`]: a setting out of range, a prior map for a log that cannot be
    /// localised in one, or no prior map although the method needs one.
    pub fn new(
        log: impl Into<Log>,
        method: Method,
        settings: &Settings,
    ) -> Result<Self, ReplayError> {
        Self::begin(Arc::new(log.into()), method, settings)
    }

    /// The same recording from its beginning, with the present settings.
    ///
    /// # Errors   [`ReplayError`]: as for [`Self::new`], or the map was not made by the recording
    /// alone.
    pub fn again(&self) -> Result<Self, ReplayError> {
        match self.untold {
            Some(what) => Err(ReplayError::Untold(what)),
            None => {
                let again = Self::begin(Arc::clone(&self.log), self.method, &self.settings)?;
                let track = self.truth.as_ref().map(|truth| truth.track.clone());
                Ok(Self {
                    truth: track.map(Truth::new),
                    ..again
                })
            }
        }
    }

    /// Compares the run with true poses, on the clock of the log; to be called before the first
    /// scan. Returns a sentence about scans without a true pose.
    ///
    /// # Errors    [`PosesMisfit`]: the poses are those of another log.
    pub fn set_truth(&mut self, track: PoseTrack) -> Result<Option<String>, PosesMisfit> {
        let coverage = track.coverage(&scan_times(&self.log, &self.figures))?;
        self.truth = Some(Truth::new(track));
        Ok(coverage.words("no error is told of them"))
    }

    fn begin(log: Arc<Log>, method: Method, settings: &Settings) -> Result<Self, ReplayError> {
        let asked = method;
        let mut notes: Vec<String> = log.damage().iter().map(ToString::to_string).collect();
        notes.extend(log.left_out().into_iter().flat_map(LeftOut::sentences));
        if let Log::Posed(posed) = log.as_ref() {
            notes.extend(posed.note().map(str::to_owned));
        }
        let uses_odometry = settings.log.uses_odometry && log.has_odometry();
        if !uses_odometry {
            if method.needs_prior_map() {
                return Err(ReplayError::NoOdometry);
            }
            let why = match log.has_odometry() {
                true => "The recording's odometry is not used",
                false => "No robot is in this recording",
            };
            notes.push(format!("{why}: it is mapped by scan matching"));
        }
        let method = match uses_odometry {
            true => method,
            false => Method::ScanMatching,
        };
        let robot = log.robot(&settings.log);
        let saved = settings.slam.saved_map.as_ref();
        let earlier = saved.map_or(vec![], |saved| saved.map.times.clone());
        let session = Session::new(SessionConfig {
            method,
            is_driven: false,
            ..SessionConfig::of(settings, robot, log.scans_on_command())
        })?;
        Ok(Self {
            feed: Feed::of(&log, &settings.log),
            figures: settings.log,
            method: asked,
            settings: settings.clone(),
            untold: None,
            log,
            first: None,
            last: None,
            used: vec![],
            earlier,
            notes,
            truth: None,
            session,
        })
    }

    /// Applies other settings from the next scan on; see [`Session::reconfigure`].
    ///
    /// # Errors    [`SlamError`] naming the first setting out of range; the old ones then stay.
    pub fn reconfigure(&mut self, settings: &Settings) -> Result<(), SlamError> {
        self.session.reconfigure(settings)?;
        self.settings = settings.clone();
        Ok(())
    }

    /// See [`Session::draw_dead_reckoned`].
    pub fn draw_dead_reckoned(&mut self) {
        self.session.draw_dead_reckoned();
    }

    /// Runs a twin with this calibration beside the robot from here on, or no twin.
    pub fn set_twin(&mut self, calibration: Option<OdometryCalibration>) {
        self.session.set_twin(calibration);
    }

    /// Takes the next scan; `false` if there is none left, and then all deferred work is done.
    ///
    /// # Errors   [`SlamError`] for a scan that cannot be used; the next call skips it.
    pub fn step(&mut self) -> Result<bool, SlamError> {
        let step = self.feed.next(&self.log, self.session.robot());
        self.notes.append(&mut self.feed.notes);
        let Some(step) = step else {
            self.session.finish();
            let whole = self.own_trajectory();
            if let Some(truth) = &mut self.truth {
                truth.settle(&whole);
            }
            return Ok(false);
        };
        self.first = self.first.or(Some(step.scan.stamp));
        self.last = Some((step.scan.stamp, step.odom_from_robot));
        self.take(&step)?;
        self.used.push(Used {
            seconds: step.seconds,
            dead_reckoning: self.session.dead_reckoning(),
        });
        self.hold_against_truth(step.seconds);
        Ok(true)
    }

    fn hold_against_truth(&mut self, seconds: f64) {
        let Some(mut truth) = self.truth.take() else {
            return;
        };
        let pose = self.session.shown_estimate().pose;
        let map = self.session.slam().view().map;
        let map_version = map.map_or(0, ScanMatcher::grid_version);
        truth.take((seconds, pose), map_version, || self.own_trajectory());
        self.truth = Some(truth);
    }

    fn take(&mut self, step: &Step) -> Result<(), SlamError> {
        if step.is_after_gap {
            self.session.gap();
        }
        for odometry in &step.odometry {
            self.session.odometry(odometry)?;
        }
        self.session.scan(&step.scan)
    }

    /// The part that is done, 0 to 1.
    #[must_use]
    pub fn progress(&self) -> f64 {
        self.feed.progress(&self.log)
    }

    /// Messages of a recording taken so far, including those that came with the last scan; for
    /// other logs, scans.
    #[must_use]
    pub fn messages_done(&self) -> usize {
        self.feed.position()
    }

    /// The pose by the log's own odometry at the last scan.
    #[must_use]
    pub fn odom_from_robot(&self) -> Pose2 {
        self.last.map_or_else(Pose2::identity, |(_, pose)| pose)
    }

    /// Time from the first scan to the last one taken, s.
    #[must_use]
    pub fn time(&self) -> f64 {
        let ends = self.first.zip(self.last);
        ends.map_or(0.0, |(first, (last, _))| last.since(first))
    }

    /// Time of the first scan that was used, as in [`Self::trajectory`], s; 0 if there was none
    /// yet.
    #[must_use]
    pub fn first_seconds(&self) -> f64 {
        self.used.first().map_or(0.0, |used| used.seconds)
    }

    /// Seconds from the beginning of the log to its end.
    #[must_use]
    pub fn duration(&self) -> f64 {
        self.log.duration(&self.figures)
    }

    /// The log.
    #[must_use]
    pub fn log(&self) -> &Log {
        &self.log
    }

    /// The present estimate.
    #[must_use]
    pub fn session(&self) -> &Session {
        &self.session
    }

    /// Adds messages for people.
    pub fn add_notes(&mut self, notes: impl IntoIterator<Item = String>) {
        self.notes.extend(notes);
    }

    /// Messages for people, on damage and missed time; the list is then empty.
    pub fn take_notes(&mut self) -> Vec<String> {
        std::mem::take(&mut self.notes)
    }

    /// Stretches of three or more scans during which the odometry stood still. None if no odometry
    /// is used, because then nothing shows when the sensor stood.
    #[must_use]
    pub fn standing_stretches(&self) -> Vec<Vec<Scan>> {
        let mut feed = Feed::of(&self.log, &self.figures);
        if !feed.has_robot() {
            return vec![];
        }
        let (mut stretches, mut stretch) = (vec![], vec![]);
        let mut last: Option<Pose2> = None;
        while let Some(step) = feed.next(&self.log, self.session.robot()) {
            let stands = last.is_some_and(|last| {
                let motion = last.delta_to(&step.odom_from_robot);
                motion.position().coords.length() < STILL && motion.heading().abs() < STILL
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

    /// What the drive so far shows about the robot ([`Session::fit`]), and the whole log about its
    /// sensor.
    #[must_use]
    pub fn fit(&self) -> DriveFit {
        let stretches = self.standing_stretches();
        let stretches: Vec<&[Scan]> = stretches.iter().map(Vec::as_slice).collect();
        DriveFit {
            ranges: Some(estimate_sigma(&stretches, Growth::Linear)),
            is_lidar: !self.log.scans_on_command(),
            ..self.session.fit()
        }
    }

    /// The pose by odometry alone, calibrated, at each scan used so far, map frame.
    pub fn odometry_trajectory(&self) -> impl Iterator<Item = Pose2> {
        self.used.iter().map(|used| used.dead_reckoning)
    }

    /// The pose of the robot's base at each scan used so far, as known now, with the scan's time:
    /// `ipc_timestamp` of a CARMEN log, `t_s` of one of rangers, the time since the beginning of a
    /// rover's log or one of revolutions, the robot's clock in a recording. Those of earlier runs
    /// in the same map come first.
    #[must_use]
    pub fn trajectory(&self) -> Vec<(f64, Pose2)> {
        let poses = self.session.slam().whole_trajectory();
        let times = self.times_of(&poses);
        let poses = poses.into_iter().map(|(_, pose)| pose);
        let mut poses: Vec<(f64, Pose2)> = times.into_iter().zip(poses).collect();
        // For a log whose stamps run backwards.
        poses.sort_by(|a, b| a.0.total_cmp(&b.0));
        poses
    }

    /// The true pose of the robot at the last scan, map frame; `None` without a truth, or if it has
    /// no pose at that time.
    #[must_use]
    pub fn truth(&self) -> Option<Pose2> {
        self.truth.as_ref()?.at(self.used.last()?.seconds)
    }

    /// The same for each scan used so far.
    pub fn truths(&self) -> impl Iterator<Item = Option<Pose2>> {
        let at = |used: &Used| self.truth.as_ref()?.at(used.seconds);
        self.used.iter().map(at)
    }

    /// Where the frame of other poses on the clock of the log lies in the map: the transform by
    /// which they come closest to the trajectory; `None` if they cover fewer than two scans.
    #[must_use]
    pub fn map_from_track(&self, track: &PoseTrack) -> Option<Pose2> {
        truth::aligned(track, &self.own_trajectory()).target_from_source()
    }

    /// Errors of the whole trajectory as known now; `None` without a truth, or if it covers fewer
    /// than two scans.
    #[must_use]
    pub fn truth_errors(&self) -> Option<TruthErrors> {
        TruthErrors::of(&self.truth.as_ref()?.track, &self.own_trajectory())
    }

    /// Without the poses of earlier runs, whose times are on other clocks.
    fn own_trajectory(&self) -> Vec<(f64, Pose2)> {
        let poses = self.session.slam().whole_trajectory();
        let earlier = self.session.slam().earlier_scans();
        let own = poses.into_iter().skip(earlier);
        let times = self.used.iter().map(|used| used.seconds);
        times.zip(own.map(|(_, pose)| pose)).collect()
    }

    /// For each scan used so far, its stamp and its time as in [`Self::trajectory`], s.
    pub fn scan_times(&self) -> impl Iterator<Item = (Stamp, f64)> {
        let poses = self.session.slam().whole_trajectory();
        let times = self.times_of(&poses);
        poses.into_iter().map(|(stamp, _)| stamp).zip(times)
    }

    /// The times of a trajectory, s.
    fn times_of(&self, poses: &[(Stamp, Pose2)]) -> Vec<f64> {
        let earlier = self.session.slam().earlier_scans();
        let time = |stamp: Stamp| {
            let at = self.earlier.partition_point(|(other, _)| *other < stamp);
            let known = self.earlier.get(at).filter(|(other, _)| *other == stamp);
            known.map_or(stamp.seconds(), |(_, seconds)| *seconds)
        };
        let of_earlier = poses[..earlier].iter().map(|(stamp, _)| time(*stamp));
        of_earlier
            .chain(self.used.iter().map(|used| used.seconds))
            .collect()
    }

    /// The map for a later run to continue in; `None` for methods other than scan matching.
    #[must_use]
    pub fn saved_map(&self) -> Option<SavedMap> {
        let mut times: Vec<(Stamp, f64)> = self.scan_times().collect();
        times.sort_by_key(|(stamp, _)| *stamp);
        times.dedup_by_key(|(stamp, _)| *stamp);
        self.session.slam().saved_map(times)
    }

    /// Continues in a saved map, before the first scan.
    ///
    /// # Errors    [`SlamError`]; then nothing changes.
    pub fn go_on_in(&mut self, saved: EarlierMap) -> Result<(), SlamError> {
        let earlier = saved.map.times.clone();
        self.session.go_on_in(saved)?;
        self.untold = Some("it went on in a saved map");
        self.earlier = earlier;
        Ok(())
    }

    /// Edits the map by hand; see [`crate::slam::Slam::edit`].
    ///
    /// # Errors    [`SlamError`]; then the map stays as it was.
    pub fn edit(&mut self, kind: EditKind, corners: &[Point2<f64>]) -> Result<(), SlamError> {
        self.session.edit(kind, corners)?;
        self.untold = Some(CHANGED);
        Ok(())
    }

    /// Undoes the last edit by hand; `false` if there is none.
    pub fn undo_edit(&mut self) -> bool {
        self.session.undo_edit()
    }

    /// Removes a submap from the map; see [`crate::slam::Slam::remove_submap`].
    ///
    /// # Errors    [`SlamError`]; then the map stays as it was.
    pub fn remove_submap(&mut self, submap: usize) -> Result<(), SlamError> {
        self.session.remove_submap(submap)?;
        self.untold = Some(CHANGED);
        Ok(())
    }

    /// Puts back the submap that was removed last, and returns its number; `None` if there is none
    /// that can come back.
    pub fn undo_removal(&mut self) -> Option<usize> {
        self.session.undo_removal()
    }

    /// Skips the next scans: they were taken by the run that this one continues.
    pub fn skip(&mut self, scans: usize) {
        for _ in 0..scans {
            self.feed.next(&self.log, self.session.robot());
        }
    }

    /// All scans of the log with their odometry, including those not taken yet, as a CARMEN log.
    #[must_use]
    pub fn carmen_log(&self) -> CarmenLog {
        let others = match self.log.as_ref() {
            Log::Carmen(log) => return log.clone(),
            others => others,
        };
        let mut feed = Feed::of(others, &self.figures);
        let mut log = CarmenLog::empty();
        while let Some(step) = feed.next(others, self.session.robot()) {
            log.push(step.seconds, &step.odom_from_robot, &step.scan);
        }
        log
    }

    /// All scans of the log, including those not taken yet, as a log of revolutions.
    #[must_use]
    pub fn revolution_log(&self) -> RevolutionLog {
        if let Log::Revolutions(log) = self.log.as_ref() {
            return log.clone();
        }
        let mut feed = Feed::of(&self.log, &self.figures);
        let mut log = RevolutionLog::default();
        while let Some(step) = feed.next(&self.log, self.session.robot()) {
            log.push(&step.scan);
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
