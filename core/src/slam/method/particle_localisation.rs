//! Localisation in a prior map by particles: from a known start, or from anywhere.

use super::{Estimator, PreparedScan, SlamConfig, SlamError, View};
use crate::estimation::{Hypothesis, MonteCarlo};
use crate::geom::PoseEstimate;
use crate::map::Evidence;
use crate::robot::Odometry;
use crate::slam::PriorMapFit;

pub(super) fn begin(config: &SlamConfig) -> Result<Box<dyn Estimator>, SlamError> {
    let map = &config.prior_map;
    if map.faces.is_empty() {
        return Err(SlamError::NoPriorMap);
    }
    let start = (!map.anywhere).then(|| map.start());
    let localiser = MonteCarlo::new(&map.faces, map.sigma, start.as_ref(), config.particles)?;
    Ok(Box::new(ByParticles {
        localiser,
        hypotheses: vec![],
        fit: PriorMapFit::default(),
    }))
}

#[derive(Debug)]
struct ByParticles {
    localiser: MonteCarlo,
    /// The hypotheses after the last scan.
    hypotheses: Vec<Hypothesis>,
    fit: PriorMapFit,
}

impl Estimator for ByParticles {
    fn predict(&mut self, odometry: &Odometry) -> Result<(), SlamError> {
        self.localiser.predict(odometry);
        Ok(())
    }

    fn update(&mut self, scan: &PreparedScan) -> Result<Option<Evidence>, SlamError> {
        self.localiser.update(&scan.points);
        self.hypotheses = self.localiser.hypotheses().collect();
        let (pose, map) = (self.estimate().pose, &scan.config.prior_map);
        self.fit.push(&scan.points, &pose, map);
        Ok(Some(scan.evidence()))
    }

    fn estimate(&self) -> PoseEstimate {
        self.localiser.estimate()
    }

    fn view(&self) -> View<'_> {
        View {
            prior_map_fit: Some(&self.fit),
            hypotheses: &self.hypotheses,
            particles: self.localiser.particles(),
            pose_quality: Some(self.localiser.quality()),
            ..View::default()
        }
    }
}
