//! Odometry alone.

use super::{Estimator, PreparedScan, SlamConfig, SlamError};
use crate::geom::{Pose2, PoseEstimate};
use crate::map::Evidence;
use crate::robot::Odometry;

pub(super) fn begin(_: &SlamConfig) -> Result<Box<dyn Estimator>, SlamError> {
    Ok(Box::new(DeadReckoning::default()))
}

#[derive(Debug, Default)]
struct DeadReckoning {
    /// The motion since the start.
    motion: Option<Odometry>,
}

impl Estimator for DeadReckoning {
    fn predict(&mut self, odometry: &Odometry) -> Result<(), SlamError> {
        self.motion = Some(
            self.motion
                .map_or(*odometry, |so_far| so_far.then(odometry)),
        );
        Ok(())
    }

    fn update(&mut self, scan: &PreparedScan) -> Result<Option<Evidence>, SlamError> {
        Ok(Some(scan.evidence_of_all()))
    }

    fn estimate(&self) -> PoseEstimate {
        self.motion
            .map_or(PoseEstimate::exact(Pose2::identity()), |so_far| {
                PoseEstimate {
                    pose: so_far.motion,
                    cov: so_far.cov,
                }
            })
    }
}
