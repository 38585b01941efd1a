//! Grid mapping by particles. Each particle has a map. The map of the best particle is shown, and
//! another particle may become the best at any scan, so the method has a map and a trajectory of
//! its own.

use super::{Estimator, PreparedScan, SlamConfig, SlamError, View};
use crate::estimation::GridParticles;
use crate::geom::PoseEstimate;
use crate::map::Evidence;
use crate::robot::Odometry;

pub(super) fn begin(config: &SlamConfig) -> Result<Box<dyn Estimator>, SlamError> {
    // As in scan matching, few scans are drawn, so whatever one of them saw through has to become
    // free.
    let (front, grid) = (config.matcher, config.matcher.grid);
    let filter = GridParticles::new(config.grid_particles, front, grid)?;
    Ok(Box::new(filter))
}

impl Estimator for GridParticles {
    fn predict(&mut self, odometry: &Odometry) -> Result<(), SlamError> {
        self.odometry(odometry);
        Ok(())
    }

    fn update(&mut self, scan: &PreparedScan) -> Result<Option<Evidence>, SlamError> {
        let sigmas = scan.direction_sigmas();
        Self::update(self, &scan.points, &sigmas, || scan.evidence());
        Ok(None)
    }

    fn estimate(&self) -> PoseEstimate {
        Self::estimate(self)
    }

    fn view(&self) -> View<'_> {
        View {
            particles: self.particles(),
            effective_particles: Some(self.effective_particles()),
            pose_quality: Some(self.quality()),
            own_map: Some(self),
            ..View::default()
        }
    }
}
