//! One scan in the running submap: how much of the odometry's uncertainty remains after the match.

use nalgebra::Matrix3;

use super::{ScanMatcher, Submap};
use crate::geom::{PoseEstimate, pose_cov, symmetrize};
use crate::registration::{Registration, Verdict};

/// A submap that begins with nothing has too few surfaces of its own until it holds this many
/// keyframes. Often it was begun because a person walked by, who then makes up much of it: in a
/// corridor nothing else tells how far the robot went, and the match follows the person.
const FEW_KEYFRAMES: usize = 3;
/// The part of the odometry floor that is used with so few keyframes.
const OF_FEW: f64 = 0.2;

impl ScanMatcher {
    /// The matched pose with its covariance: that of the match where the points are informative,
    /// that of odometry since the last keyframe where they are not.
    pub(super) fn corrected(&self, found: &Registration, predicted: &PoseEstimate) -> PoseEstimate {
        let mut floor = self.odometry_floor();
        if let Verdict::Degenerate { direction } = found.verdict {
            let said = &found.information;
            let turn = -(said[(0, 2)] * direction.x + said[(1, 2)] * direction.y);
            let free = direction.push(turn / said[(2, 2)].max(1e-12)).normalize();
            // Between two scans odometry may err by more than it says, but not always in the same
            // direction.
            let observed = Matrix3::identity() - free * free.transpose();
            floor = observed * floor * observed;
        }
        let believed = (predicted.cov + floor).try_inverse();
        let cov = believed.and_then(|b| (b + found.information).try_inverse());
        let mut cov = cov.unwrap_or(found.estimate.cov);
        symmetrize(&mut cov);
        PoseEstimate {
            pose: found.estimate.pose,
            cov,
        }
    }

    /// The least covariance of odometry between two scans.
    pub(super) fn odometry_floor(&self) -> Matrix3<f64> {
        let config = &self.config;
        let begins = |s: &Submap| s.is_loose && s.own_keyframes < FEW_KEYFRAMES;
        let part = match self.submaps.last().is_some_and(begins) {
            true => OF_FEW,
            false => 1.0,
        };
        pose_cov(
            part * config.odometry_sigma,
            part * config.odometry_turn_sigma,
        )
    }
}
