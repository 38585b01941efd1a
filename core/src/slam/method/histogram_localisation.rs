//! Localisation in a small prior map by the probability of every pose cell in it (Markov
//! localisation).
//!
//! The belief is exact up to the size of its cells: if the robot may be in several places, all of
//! them are there with their probabilities. A robot that is carried off is noticed by what it sees,
//! and may then be anywhere again.

use super::{Estimator, PreparedScan, SlamConfig, SlamError, View};
use crate::estimation::{
    HistogramLocaliser, Hypothesis, JudgementConfig, Localisation, Particle, PoseQuality,
};
use crate::geom::{Pose2, PoseEstimate, pose_cov};
use crate::map::Evidence;
use crate::points::Points;
use crate::robot::Odometry;
use crate::slam::PriorMapFit;

pub(super) fn begin(config: &SlamConfig) -> Result<Box<dyn Estimator>, SlamError> {
    let map = &config.prior_map;
    if map.faces.is_empty() {
        return Err(SlamError::NoPriorMap);
    }
    let (cells, particles) = (config.histogram, config.particles);
    let mut localiser = HistogramLocaliser::new(&map.faces, map.sigma, particles, cells)?;
    let start = map.start();
    if !map.anywhere {
        // Differences smaller than a cell cannot be resolved.
        let cell = pose_cov(cells.cell, std::f64::consts::TAU / cells.turns as f64);
        localiser.begin_at(&PoseEstimate {
            cov: start.cov + cell,
            ..start
        });
    }
    let localisation = match map.anywhere {
        true => Localisation::Lost,
        false => Localisation::Localised,
    };
    let mut by_histogram = ByHistogram {
        believed: localiser.estimate(),
        localiser,
        judgement: config.particles.judgement,
        cells: vec![],
        hypotheses: vec![],
        quality: PoseQuality {
            localisation,
            ..PoseQuality::default()
        },
        agreement: None,
        passed: 0,
        fit: PriorMapFit::default(),
    };
    if map.anywhere {
        by_histogram.believed.pose = Pose2::identity();
    } else {
        by_histogram.believed.pose = start.pose;
    }
    Ok(Box::new(by_histogram))
}

#[derive(Debug)]
struct ByHistogram {
    localiser: HistogramLocaliser,
    judgement: JudgementConfig,
    /// Where the robot is: the likeliest place, moved by the odometry since the last scan that was
    /// taken in. While the robot is not found: odometry from where it was last believed to be.
    believed: PoseEstimate,
    /// The likely poses after the last scan that was taken in.
    cells: Vec<Particle>,
    hypotheses: Vec<Hypothesis>,
    quality: PoseQuality,
    /// Agreement of the last scans with the map at the likeliest place; `None` before the first.
    agreement: Option<f64>,
    /// How many times in a row the likeliest place passed.
    passed: u32,
    fit: PriorMapFit,
}

impl ByHistogram {
    fn is_found(&self) -> bool {
        self.quality.localisation == Localisation::Localised
    }

    fn take(&mut self, points: &Points) {
        if !self.localiser.update(points) {
            return;
        }
        self.cells = self.localiser.likely();
        self.hypotheses = self.localiser.hypotheses();
        let Some(first) = self.hypotheses.first().copied() else {
            self.quality.localisation = Localisation::Lost;
            return;
        };
        let now = self.localiser.agreement(&first.estimate.pose, points);
        if let Some(now) = now {
            let before = self.agreement.unwrap_or(now);
            self.agreement = Some(before + self.judgement.rates[0] * (now - before));
        }
        let agreement = self.agreement.unwrap_or(0.0);
        self.quality.agreement = agreement;
        self.quality.recent_agreement = agreement;
        if self.is_found() && agreement < self.judgement.lost_below {
            self.localiser.forget();
            self.believed.cov = self.localiser.estimate().cov;
            (self.passed, self.agreement) = (0, None);
            self.quality.localisation = Localisation::Lost;
            return;
        }
        let passes = first.weight >= self.judgement.weight && agreement >= self.judgement.agreement;
        self.passed = if passes { self.passed + 1 } else { 0 };
        if self.is_found() || self.passed >= self.judgement.times {
            self.quality.localisation = Localisation::Localised;
            self.believed = first.estimate;
        } else {
            self.quality.localisation = Localisation::Ambiguous;
        }
    }
}

impl Estimator for ByHistogram {
    fn predict(&mut self, odometry: &Odometry) -> Result<(), SlamError> {
        self.localiser.predict(odometry);
        self.believed = odometry.after(&self.believed);
        Ok(())
    }

    fn update(&mut self, scan: &PreparedScan) -> Result<Option<Evidence>, SlamError> {
        self.take(&scan.points);
        let (pose, map) = (self.believed.pose, &scan.config.prior_map);
        self.fit.push(&scan.points, &pose, map);
        Ok(Some(scan.evidence()))
    }

    fn estimate(&self) -> PoseEstimate {
        self.believed
    }

    fn view(&self) -> View<'_> {
        View {
            prior_map_fit: Some(&self.fit),
            hypotheses: &self.hypotheses,
            particles: &self.cells,
            pose_quality: Some(self.quality),
            ..View::default()
        }
    }
}
