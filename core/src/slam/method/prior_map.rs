//! Localisation in a prior map, by its lines or by whole scans.

use super::{Estimator, PreparedScan, SlamConfig, SlamError, View};
use crate::estimation::{LineLocaliser, ScanLocaliser, ScanLocaliserConfig};
use crate::features::{LineExtractor, LineFeature};
use crate::geom::{PoseEstimate, Segment};
use crate::map::Evidence;
use crate::points::oriented_points;
use crate::robot::Odometry;
use crate::slam::{PriorMapFit, PriorMapMatching};

pub(super) fn begin(config: &SlamConfig) -> Result<Box<dyn Estimator>, SlamError> {
    config.lines.validate()?;
    Ok(Box::new(InPriorMap {
        localiser: Localiser::new(config)?,
        extractor: LineExtractor::new(config.lines),
        features: vec![],
        fit: PriorMapFit::default(),
    }))
}

#[derive(Debug)]
struct InPriorMap {
    localiser: Localiser,
    extractor: LineExtractor,
    /// Of the last scan.
    features: Vec<LineFeature>,
    fit: PriorMapFit,
}

#[derive(Debug)]
enum Localiser {
    Lines(Box<LineLocaliser>),
    Surfaces(Box<ScanLocaliser>),
}

impl Localiser {
    fn new(config: &SlamConfig) -> Result<Self, SlamError> {
        let map = &config.prior_map;
        if map.lines.is_empty() {
            return Err(SlamError::NoPriorMap);
        }
        let (start, prior) = (map.start(), &config.ekf.odometry_prior);
        Ok(match config.prior_map_matching {
            PriorMapMatching::Lines => Self::Lines(Box::new(LineLocaliser::new(
                map.lines.clone(),
                &start,
                prior,
                config.ekf.association,
            )?)),
            PriorMapMatching::Surfaces => Self::Surfaces(Box::new(ScanLocaliser::new(
                map.lines.iter().map(|line| {
                    let [a, b] = line.ends;
                    Segment::new(a, b)
                }),
                &start,
                prior,
                ScanLocaliserConfig::default(),
            )?)),
        })
    }
}

impl Estimator for InPriorMap {
    fn predict(&mut self, odometry: &Odometry) -> Result<(), SlamError> {
        match &mut self.localiser {
            Localiser::Lines(localiser) => localiser.predict(odometry)?,
            Localiser::Surfaces(localiser) => localiser.predict(odometry)?,
        }
        Ok(())
    }

    fn update(&mut self, scan: &PreparedScan) -> Result<Option<Evidence>, SlamError> {
        self.extractor.extract(&scan.points, &mut self.features)?;
        let map = &scan.config.prior_map;
        let turned = scan.heading_variances();
        match &mut self.localiser {
            Localiser::Lines(localiser) => {
                let loosened = self.features.iter().map(|f| map.loosened(f, &turned));
                localiser.update(&loosened.collect::<Vec<_>>())?;
            }
            Localiser::Surfaces(localiser) => {
                let surfaces = oriented_points(&scan.points);
                let mean = turned.iter().sum::<f64>() / turned.len().max(1) as f64;
                localiser.update(&surfaces, mean);
            }
        }
        self.fit.push(&scan.points, &self.estimate().pose, map);
        Ok(Some(scan.evidence()))
    }

    fn estimate(&self) -> PoseEstimate {
        match &self.localiser {
            Localiser::Lines(localiser) => localiser.estimate(),
            Localiser::Surfaces(localiser) => localiser.estimate(),
        }
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
