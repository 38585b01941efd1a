//! Errors of a run, compared with true poses from another file.
//!
//! In: a [`PoseTrack`] and the poses of the run. Out: the errors after alignment. The two have
//! frames of their own, so the rigid motion that brings all positions closest is removed first
//! (Umeyama 1991 without scale), as in `evo_ape --align`.
//!
//! 1. While a run goes on, the poses as estimated at each scan are aligned; if the map was
//!    deformed, all of them are taken anew.
//! 2. For the errors of the whole run, all poses are taken as they are known now.

use super::pose_track::PoseTrack;
use crate::estimation::Alignment;
use crate::geom::{Length, Pose2, wrap};

/// The truth about a run, and its alignment with the run's map.
#[derive(Clone, Debug)]
pub(super) struct Truth {
    pub(super) track: PoseTrack,
    /// `map_from_truth`.
    alignment: Alignment,
    /// Version of the map when all poses were last taken.
    map_version: u64,
}

impl Truth {
    pub(super) fn new(track: PoseTrack) -> Self {
        Self {
            track,
            alignment: Alignment::default(),
            map_version: 0,
        }
    }

    /// Takes the pose of the scan at a time, s; `whole` returns all poses if the map was deformed.
    pub(super) fn take(
        &mut self,
        (seconds, pose): (f64, Pose2),
        map_version: u64,
        whole: impl FnOnce() -> Vec<(f64, Pose2)>,
    ) {
        if map_version != self.map_version {
            self.map_version = map_version;
            self.alignment = aligned(&self.track, &whole());
        } else if let Some(truth) = self.track.at(seconds) {
            self.alignment.push(pose.position(), truth.position());
        }
    }

    /// The run is over: all poses are taken as they are known now.
    pub(super) fn settle(&mut self, whole: &[(f64, Pose2)]) {
        self.alignment = aligned(&self.track, whole);
    }

    /// The true pose of the robot at a time, map frame; `None` if it is not covered, or the
    /// alignment is not known yet.
    pub(super) fn at(&self, seconds: f64) -> Option<Pose2> {
        Some(self.alignment.target_from_source()? * self.track.at(seconds)?)
    }
}

/// The alignment of the track with a trajectory.
pub(super) fn aligned(track: &PoseTrack, trajectory: &[(f64, Pose2)]) -> Alignment {
    let mut alignment = Alignment::default();
    for (seconds, pose) in trajectory {
        if let Some(truth) = track.at(*seconds) {
            alignment.push(pose.position(), truth.position());
        }
    }
    alignment
}

/// How far a scan's pose is from the truth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PoseError {
    /// Time of the scan as the log counts it, s.
    pub seconds: f64,
    /// Where the robot truly was, map frame.
    pub truth: Pose2,
    /// Distance of the positions, m.
    pub position: f64,
    /// Estimate minus truth, rad.
    pub heading: f64,
}

/// Errors of a run compared with the truth.
#[derive(Clone, Debug, PartialEq)]
pub struct TruthErrors {
    /// Where the frame of the truth lies in the map.
    pub map_from_truth: Pose2,
    /// For each scan that the truth covers.
    pub poses: Vec<PoseError>,
    /// Number of scans that it does not cover.
    pub left_out: usize,
    /// Root of the mean squared distance, m.
    pub rmse: f64,
    /// The largest distance, m.
    pub max: f64,
}

impl TruthErrors {
    /// Errors of a trajectory; `None` if fewer than two of its poses are covered.
    pub(super) fn of(track: &PoseTrack, trajectory: &[(f64, Pose2)]) -> Option<Self> {
        let map_from_truth = aligned(track, trajectory).target_from_source()?;
        let error = |(seconds, pose): &(f64, Pose2)| {
            let truth = map_from_truth * track.at(*seconds)?;
            Some(PoseError {
                seconds: *seconds,
                truth,
                position: (pose.position() - truth.position()).length(),
                heading: wrap(pose.heading() - truth.heading()),
            })
        };
        let poses: Vec<PoseError> = trajectory.iter().filter_map(error).collect();
        let squares: f64 = poses.iter().map(|e| e.position * e.position).sum();
        Some(Self {
            map_from_truth,
            left_out: trajectory.len() - poses.len(),
            rmse: (squares / poses.len() as f64).sqrt(),
            max: poses.iter().fold(0.0, |most, e| e.position.max(most)),
            poses,
        })
    }

    /// A sentence about them.
    #[must_use]
    pub fn words(&self) -> String {
        let Self { rmse, max, .. } = self;
        let (count, all) = (self.poses.len(), self.poses.len() + self.left_out);
        format!(
            "Against the poses that are true: off by {rmse:.3} m (root mean square), at most {max:.3} m, over {count} of {all} scans"
        )
    }
}
