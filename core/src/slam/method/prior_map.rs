//! Localisation in a prior map, by its lines or by whole scans.

use super::{Estimator, PreparedScan, SlamConfig, SlamError, View};
use crate::estimation::{LineLocaliser, RobotState, ScanLocaliser};
use crate::features::{LineExtractor, LineFeature};
use crate::geom::PoseEstimate;
use crate::map::Evidence;
use crate::points::oriented_points;
use crate::robot::Odometry;
use crate::slam::{PriorMapFit, PriorMapMatching};

pub(super) fn begin(config: &SlamConfig) -> Result<Box<dyn Estimator>, SlamError> {
    config.lines.validate()?;
    let map = &config.prior_map;
    if map.faces.is_empty() {
        return Err(SlamError::NoPriorMap);
    }
    Ok(Box::new(InPriorMap {
        state: RobotState::starting(&map.start(), &config.ekf.odometry_prior)?,
        localiser: match config.prior_map_matching {
            PriorMapMatching::Lines => {
                Localiser::Lines(LineLocaliser::new(&map.faces, config.ekf.association)?)
            }
            PriorMapMatching::Surfaces => {
                Localiser::Surfaces(Box::new(ScanLocaliser::new(&map.faces)?))
            }
        },
        extractor: LineExtractor::new(config.lines),
        features: vec![],
        fit: PriorMapFit::default(),
    }))
}

#[derive(Debug)]
struct InPriorMap {
    state: RobotState,
    localiser: Localiser,
    extractor: LineExtractor,
    /// Of the last scan.
    features: Vec<LineFeature>,
    fit: PriorMapFit,
}

#[derive(Debug)]
enum Localiser {
    Lines(LineLocaliser),
    Surfaces(Box<ScanLocaliser>),
}

impl Estimator for InPriorMap {
    fn predict(&mut self, odometry: &Odometry) -> Result<(), SlamError> {
        Ok(self.state.predict(odometry)?)
    }

    fn update(&mut self, scan: &PreparedScan) -> Result<Option<Evidence>, SlamError> {
        self.extractor.extract(&scan.points, &mut self.features)?;
        let map = &scan.config.prior_map;
        let turned = scan.heading_variances();
        match &mut self.localiser {
            Localiser::Lines(localiser) => {
                let loosened = self.features.iter().map(|f| map.loosened(f, &turned));
                localiser.update(&mut self.state, &loosened.collect::<Vec<_>>())?;
            }
            Localiser::Surfaces(localiser) => {
                let surfaces = oriented_points(&scan.points);
                let mean = turned.iter().sum::<f64>() / turned.len().max(1) as f64;
                localiser.update(&mut self.state, &surfaces, mean);
            }
        }
        self.fit.push(&scan.points, &self.estimate().pose, map);
        Ok(Some(scan.evidence()))
    }

    fn estimate(&self) -> PoseEstimate {
        self.state.estimate()
    }

    fn view(&self) -> View<'_> {
        View {
            features: &self.features,
            prior_map_fit: Some(&self.fit),
            ..View::default()
        }
    }

    fn reconfigure(&mut self, config: &SlamConfig) {
        self.extractor = LineExtractor::new(config.lines);
    }
}
