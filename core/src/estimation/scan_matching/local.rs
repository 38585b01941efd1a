//! One scan in the running submap: what odometry believes beforehand, and what of its doubt stays
//! after the match.

use nalgebra::Matrix3;

use super::ScanMatcher;
use crate::geom::{PoseEstimate, pose_cov, symmetrize};
use crate::registration::{Prior, Registration, Verdict};
use crate::robot::Odometry;

impl ScanMatcher {
    /// What odometry says since the last match; the pose at that match is the map's, and not
    /// doubted here.
    pub(super) fn prior(&self, predicted: &PoseEstimate, moved: &Odometry) -> Prior {
        let turned = self.local.pose.rotation();
        let since_match = if self.is_blind {
            predicted.cov
        } else {
            turned * moved.cov * turned.transpose()
        };
        let cov = since_match + self.odometry_floor();
        // A covariance that odometry spoilt says nothing.
        let information = cov.try_inverse().unwrap_or_else(Matrix3::zeros);
        Prior {
            pose: predicted.pose,
            information,
        }
    }

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
    fn odometry_floor(&self) -> Matrix3<f64> {
        pose_cov(self.config.odometry_sigma, self.config.odometry_turn_sigma)
    }
}
