//! A log that is mapped with the poses of another file as its odometry.
//!
//! In: a [`Log`] and a [`PoseTrack`] on the same clock. Out: its scans, each with the motions of
//! the track that led to it. Scans that the track does not cover are left out: a guessed motion
//! would look like a measured one.

use super::feed::{Feed, Step, recorded_odometry};
use super::log::Log;
use super::pose_track::{PoseTrack, PosesMisfit};
use crate::geom::Pose2;
use crate::robot::{Odometry, RobotModel, Stamp};
use crate::settings::LogSettings;

/// Poses nearer in time than this add nothing, s.
const LEAST_APART: f64 = 0.01;

/// A log with the poses of another file.
#[derive(Clone, Debug)]
pub struct PosedLog {
    log: Box<Log>,
    track: PoseTrack,
    note: Option<String>,
}

impl PosedLog {
    /// `figures`: what the log itself does not contain.
    ///
    /// # Errors    [`PosesMisfit`]: the poses are those of another log.
    pub fn new(log: Log, track: PoseTrack, figures: &LogSettings) -> Result<Self, PosesMisfit> {
        if let Log::Posed(_) = log {
            return Err(PosesMisfit::Twice);
        }
        let coverage = track.coverage(&scan_times(&log, figures))?;
        Ok(Self {
            log: Box::new(log),
            track,
            note: coverage.words("they are left out"),
        })
    }

    /// The log without the poses.
    #[must_use]
    pub fn log(&self) -> &Log {
        &self.log
    }

    /// What people should know about it.
    #[must_use]
    pub fn note(&self) -> Option<&str> {
        self.note.as_deref()
    }

    /// The step with the motions of the track since the last scan that was used; `None` for a scan
    /// that is left out.
    pub(super) fn moved(
        &self,
        mut step: Step,
        last: &mut Option<Moved>,
        robot: &RobotModel,
    ) -> Option<Step> {
        let pose = self.track.at(step.seconds)?;
        let stamp = step.scan.stamp;
        let here = Moved {
            seconds: step.seconds,
            stamp,
            pose,
        };
        step.odometry = match last.replace(here) {
            None => vec![Odometry::standing(stamp)],
            Some(from) => self.motions(from, here, robot),
        };
        step.is_after_gap = false;
        step.odom_from_robot = pose;
        Some(step)
    }

    fn motions(&self, from: Moved, to: Moved, robot: &RobotModel) -> Vec<Odometry> {
        let passed = self.track.between(from.seconds, to.seconds).iter();
        let stamps = passed.map(|(seconds, pose)| Moved {
            seconds: *seconds,
            stamp: Stamp::from_seconds(from.stamp.seconds() + (seconds - from.seconds)),
            pose: *pose,
        });
        let (mut last, mut out) = (from, vec![]);
        for next in stamps {
            let is_near = next.seconds - last.seconds < LEAST_APART
                || to.seconds - next.seconds < LEAST_APART
                || next.stamp >= to.stamp;
            if !is_near {
                out.push(last.to(&next, robot));
                last = next;
            }
        }
        out.push(last.to(&to, robot));
        out
    }
}

/// Where a motion ended.
#[derive(Clone, Copy, Debug)]
pub(super) struct Moved {
    /// On the clock of the log, s.
    seconds: f64,
    stamp: Stamp,
    pose: Pose2,
}

impl Moved {
    fn to(&self, next: &Self, robot: &RobotModel) -> Odometry {
        let motion = self.pose.delta_to(&next.pose);
        recorded_odometry(robot, self.stamp, next.stamp, motion)
    }
}

/// The times of all scans of a log, on its own clock, s.
pub(super) fn scan_times(log: &Log, figures: &LogSettings) -> Vec<f64> {
    let robot = log.robot(figures);
    let mut feed = Feed::of(log, figures);
    std::iter::from_fn(|| feed.next(log, &robot).map(|step| step.seconds)).collect()
}
