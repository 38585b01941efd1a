//! One scan in the running submap: what of odometry's doubt stays after the match.

use nalgebra::Matrix3;

use super::ScanMatcher;
use crate::geom::{PoseEstimate, pose_cov, symmetrize};
use crate::registration::{Registration, Verdict};

impl ScanMatcher {
    /// The matched pose with its covariance: that of the match where the points say something,
    /// odometry's since the last keyframe where they do not.
    pub(super) fn corrected(&self, found: &Registration, predicted: &PoseEstimate) -> PoseEstimate {
        let mut floor = self.odometry_floor();
        if let Verdict::Degenerate { direction } = found.verdict {
            let said = &found.information;
            let turn = -(said[(0, 2)] * direction.x + said[(1, 2)] * direction.y);
            let free = direction.push(turn / said[(2, 2)].max(1e-12)).normalize();
            // Between two scans odometry may err by more than it says, but not always to the same
            // side.
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

    /// What odometry is not believed better than between two scans.
    pub(super) fn odometry_floor(&self) -> Matrix3<f64> {
        pose_cov(self.config.odometry_sigma, self.config.odometry_turn_sigma)
    }
}
