//! What an experiment measures.

use super::Experiment;
use crate::estimation::ate_rmse;
use crate::geom::{Length, Pose2, PoseEstimate, wrap};
use crate::map::CellState;
use crate::robot::Stamp;
use crate::sim::{Contacts, ReachableArea};

/// Poses at one scan, map frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// When.
    pub stamp: Stamp,
    /// Where the robot was.
    pub truth: Pose2,
    /// The estimated pose.
    pub estimate: PoseEstimate,
    /// The pose by odometry alone.
    pub odometry: Pose2,
}

/// The run so far, one sample for each scan.
#[derive(Clone, Debug, Default)]
pub struct Record {
    samples: Vec<Sample>,
    distance: f64,
    nees_sum: f64,
    nees_count: usize,
}

impl Record {
    pub(super) fn push(&mut self, sample: Sample) {
        if let Some(last) = self.samples.last() {
            self.distance += (sample.truth.position() - last.truth.position()).length();
        }
        if let Some(nees) = sample.estimate.nees(&sample.truth) {
            self.nees_sum += nees;
            self.nees_count += 1;
        }
        self.samples.push(sample);
    }

    /// One sample for each scan.
    #[must_use]
    pub fn samples(&self) -> &[Sample] {
        &self.samples
    }

    /// True distance driven, m.
    #[must_use]
    pub fn distance(&self) -> f64 {
        self.distance
    }

    /// Mean NEES over the scans of the run, 3 if the covariance is consistent; `None` before the
    /// first scan.
    #[must_use]
    pub fn nees_mean(&self) -> Option<f64> {
        (self.nees_count > 0).then(|| self.nees_sum / self.nees_count as f64)
    }
}

/// The figures of a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Figures {
    /// Simulated time, s.
    pub sim_seconds: f64,
    /// Part of the reachable area that is known, 0 to 1.
    pub explored_fraction: f64,
    /// How often the robot touched something, and who moved.
    pub contacts: Contacts,
    /// Distance between estimated and true position now, m.
    pub position_error: f64,
    /// Difference of the headings now, rad, not negative.
    pub heading_error: f64,
    /// Distance between the position by odometry and the true one now, m.
    pub odometry_error: f64,
    /// Absolute trajectory error, m, after alignment.
    pub ate_rmse: Option<f64>,
    /// Mean NEES over the run, 3 if consistent.
    pub nees_mean: Option<f64>,
    /// Walls in the line map.
    pub features: usize,
    /// True distance driven, m.
    pub distance: f64,
    /// See [`Experiment::state_hash`].
    pub state_hash: u64,
}

impl Experiment {
    /// The figures of the run so far. `area` is that of the world, see
    /// [`crate::sim::reachable_area`]: computing it takes longer than a step, and it does not
    /// change.
    #[must_use]
    pub fn figures(&self, area: &ReachableArea) -> Figures {
        Figures {
            sim_seconds: self.sim.stamp().seconds(),
            explored_fraction: self.explored_fraction(area),
            contacts: self.sim.contacts(),
            position_error: self.position_error(),
            heading_error: wrap(self.truth().heading() - self.session.estimate().pose.heading())
                .abs(),
            odometry_error: self.odometry_error(),
            ate_rmse: self.ate_rmse(),
            nees_mean: self.record.nees_mean(),
            features: self.session.slam().view().confirmed(),
            distance: self.record.distance,
            state_hash: self.state_hash(),
        }
    }

    /// Distance between estimated and true position now, m.
    pub(crate) fn position_error(&self) -> f64 {
        self.off(self.session.estimate().pose)
    }

    /// Distance between the position by odometry and the true one now, m.
    pub(crate) fn odometry_error(&self) -> f64 {
        self.off(self.session.dead_reckoning())
    }

    fn off(&self, pose: Pose2) -> f64 {
        (self.truth().position() - pose.position()).length()
    }

    /// Absolute trajectory error, m, after alignment.
    pub(crate) fn ate_rmse(&self) -> Option<f64> {
        let positions = |of: fn(&Sample) -> Pose2| -> Vec<_> {
            let poses = self.record.samples.iter().map(of);
            poses.map(|pose| pose.position()).collect()
        };
        ate_rmse(&positions(|s| s.truth), &positions(|s| s.estimate.pose))
    }

    /// Part of the reachable area that the map knows, 0 to 1.
    #[must_use]
    pub fn explored_fraction(&self, area: &ReachableArea) -> f64 {
        let grid = self.session.slam().grid();
        area.known_fraction(|in_world| {
            grid.state(grid.cell_at(self.map_from_world * in_world)) != CellState::Unknown
        })
    }
}
