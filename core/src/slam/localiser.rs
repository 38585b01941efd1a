//! The two ways to be found in a prior map, behind one face.

use super::{PriorMapMatching, SlamConfig, SlamError, estimator::PreparedScan};
use crate::estimation::{LineLocaliser, ScanLocaliser, ScanLocaliserConfig};
use crate::features::LineFeature;
use crate::geom::{PoseEstimate, Segment};
use crate::points::oriented_points;
use crate::robot::Odometry;

/// What finds the robot.
#[derive(Clone, Debug)]
pub(super) enum Localiser {
    Lines(Box<LineLocaliser>),
    Surfaces(Box<ScanLocaliser>),
}

impl Localiser {
    pub(super) fn new(config: &SlamConfig) -> Result<Self, SlamError> {
        let known = &config.prior_map;
        if known.lines.is_empty() {
            return Err(SlamError::NoPriorMap);
        }
        let (start, prior) = (known.start(), &config.ekf.odometry_prior);
        Ok(match config.prior_map_matching {
            PriorMapMatching::Lines => Self::Lines(Box::new(LineLocaliser::new(
                known.lines.clone(),
                &start,
                prior,
                config.ekf.association,
            )?)),
            PriorMapMatching::Surfaces => Self::Surfaces(Box::new(ScanLocaliser::new(
                known.lines.iter().map(|line| {
                    let [a, b] = line.ends;
                    Segment::new(a, b)
                }),
                &start,
                prior,
                ScanLocaliserConfig::default(),
            )?)),
        })
    }

    pub(super) fn predict(&mut self, odometry: &Odometry) -> Result<(), SlamError> {
        match self {
            Self::Lines(localiser) => localiser.predict(odometry)?,
            Self::Surfaces(localiser) => localiser.predict(odometry)?,
        }
        Ok(())
    }

    /// Takes in a scan, the lines that were found in it, and what was `turned` since each of its beams
    /// ([`PreparedScan::heading_variances`]).
    pub(super) fn update(
        &mut self,
        sweep: &PreparedScan,
        features: &[LineFeature],
        turned: &[f64],
    ) -> Result<(), SlamError> {
        match self {
            Self::Lines(localiser) => {
                let known = &sweep.config.prior_map;
                let loose = features.iter().map(|f| known.loosened(f, turned));
                let loose: Vec<LineFeature> = loose.collect();
                localiser.update(&loose)?;
            }
            Self::Surfaces(localiser) => {
                let oriented = &sweep.config.matcher.oriented;
                let mean = turned.iter().sum::<f64>() / turned.len().max(1) as f64;
                localiser.update(&oriented_points(sweep.points, oriented), mean);
            }
        }
        Ok(())
    }

    pub(super) fn estimate(&self) -> PoseEstimate {
        match self {
            Self::Lines(localiser) => localiser.estimate(),
            Self::Surfaces(localiser) => localiser.estimate(),
        }
    }
}
