//! Localisation in a prior map, by its lines or by whole scans.
//!
//! Whole scans are followed by scan matching, which is exact. Beside it particles watch whether the
//! robot is where it is believed to be. If it is not, or if its start is unknown, they search the
//! whole map for it.

use super::{Estimator, PreparedScan, SlamConfig, SlamError, View};
use crate::estimation::{
    Hypothesis, LineLocaliser, Localisation, MonteCarlo, RobotState, ScanFit, ScanLocaliser,
};
use crate::features::{LineExtractor, LineFeature};
use crate::geom::{Length, PoseEstimate, wrap};
use crate::map::Evidence;
use crate::points::{Points, oriented_points};
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
                let start = (!map.anywhere).then(|| map.start());
                let (sigma, particles) = (map.sigma, config.particles);
                Localiser::Surfaces(Box::new(Watched {
                    matching: ScanLocaliser::new(&map.faces)?,
                    particles: MonteCarlo::new(&map.faces, sigma, start.as_ref(), particles)?,
                    hypotheses: vec![],
                    is_placed: start.is_some(),
                    fit: None,
                }))
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
    /// The lines of the last scan.
    features: Vec<LineFeature>,
    fit: PriorMapFit,
}

#[derive(Debug)]
enum Localiser {
    Lines(LineLocaliser),
    Surfaces(Box<Watched>),
}

/// A robot that is followed by scan matching, with particles that watch.
#[derive(Debug)]
struct Watched {
    matching: ScanLocaliser,
    particles: MonteCarlo,
    /// The hypotheses after the last scan.
    hypotheses: Vec<Hypothesis>,
    /// Whether the robot's place in the map was ever known.
    is_placed: bool,
    /// How the last scan fits; `None` if it does not, or was not matched.
    fit: Option<ScanFit>,
}

/// If matching and particles differ by more than this, m and rad, they mean different places.
const APART: [f64; 2] = [0.5, 0.3];

impl Watched {
    fn is_sure(&self) -> bool {
        self.particles.quality().localisation == Localisation::Localised
    }

    /// `turned`: mean variance of the heading that odometry accumulated since the beams of the scan
    /// were taken, rad².
    fn update(&mut self, state: &mut RobotState, points: &Points, turned: f64) {
        self.particles.update(points);
        self.hypotheses = self.particles.hypotheses().collect();
        let found = self.particles.estimate();
        let off = found.pose.minus(&state.pose);
        let is_apart = off.xy().length() > APART[0] || wrap(off.z).abs() > APART[1];
        if self.is_sure() && (is_apart || !self.is_placed) {
            self.matching.restart(state, &found);
        }
        self.is_placed |= self.is_sure();
        // A map that fits badly may be followed nevertheless, but only from a known place in it.
        self.fit = None;
        if self.is_placed {
            let surfaces = oriented_points(points);
            self.fit = self.matching.update(state, &surfaces, turned);
        }
    }
}

impl Estimator for InPriorMap {
    fn predict(&mut self, odometry: &Odometry) -> Result<(), SlamError> {
        self.state.predict(odometry)?;
        if let Localiser::Surfaces(watched) = &mut self.localiser {
            watched.particles.predict(odometry);
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
                localiser.update(&mut self.state, &loosened.collect::<Vec<_>>())?;
            }
            Localiser::Surfaces(localiser) => {
                let mean = turned.iter().sum::<f64>() / turned.len().max(1) as f64;
                localiser.update(&mut self.state, &scan.points, mean);
            }
        }
        self.fit.push(&scan.points, &self.estimate().pose, map);
        Ok(Some(scan.evidence()))
    }

    fn estimate(&self) -> PoseEstimate {
        self.state.estimate()
    }

    fn view(&self) -> View<'_> {
        let view = View {
            features: &self.features,
            prior_map_fit: Some(&self.fit),
            ..View::default()
        };
        match &self.localiser {
            Localiser::Lines(_) => view,
            Localiser::Surfaces(watched) => View {
                hypotheses: &watched.hypotheses,
                particles: watched.particles.particles(),
                pose_quality: Some(watched.particles.quality()),
                scan_fit: watched.fit,
                ..view
            },
        }
    }

    fn reconfigure(&mut self, config: &SlamConfig) {
        self.extractor = LineExtractor::new(config.lines);
    }
}
