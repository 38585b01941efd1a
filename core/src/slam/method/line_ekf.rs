//! The Kalman filter over lines: lines are found in each scan, matched to the walls known so far,
//! and correct pose and walls.

use super::{Estimator, PreparedScan, SlamConfig, SlamError, View};
use crate::estimation::{EkfSlam, Landmark, SweepSmoother, SweepTiming};
use crate::features::{LineExtractor, LineFeature};
use crate::geom::PoseEstimate;
use crate::map::Evidence;
use crate::robot::Odometry;

pub(super) fn begin(config: &SlamConfig) -> Result<Box<dyn Estimator>, SlamError> {
    config.lines.validate()?;
    Ok(Box::new(LineEkf {
        extractor: LineExtractor::new(config.lines),
        features: vec![],
        ekf: EkfSlam::new(config.ekf)?,
        landmarks: vec![],
        smoother: SweepSmoother::default(),
    }))
}

#[derive(Debug)]
struct LineEkf {
    extractor: LineExtractor,
    /// Of the last scan.
    features: Vec<LineFeature>,
    ekf: EkfSlam,
    /// After the last scan.
    landmarks: Vec<Landmark>,
    smoother: SweepSmoother,
}

impl Estimator for LineEkf {
    fn predict(&mut self, odometry: &Odometry) -> Result<(), SlamError> {
        Ok(self.ekf.predict(odometry)?)
    }

    fn update(&mut self, scan: &PreparedScan) -> Result<Option<Evidence>, SlamError> {
        self.extractor.extract(&scan.points, &mut self.features)?;
        let timing = SweepTiming::at(scan.points.stamp, &scan.scan);
        let report = self.ekf.update(&self.features, &timing)?;
        let poses = self
            .smoother
            .smooth(&scan.scan, &scan.moved, &report.fixes, scan.history);
        self.landmarks.clear();
        self.landmarks.extend(self.ekf.landmarks());
        Ok(Some(scan.evidence_from(&poses)))
    }

    fn estimate(&self) -> PoseEstimate {
        self.ekf.estimate()
    }

    fn view(&self) -> View<'_> {
        View {
            features: &self.features,
            landmarks: &self.landmarks,
            update: Some(self.ekf.report()),
            covariance: Some(self.ekf.covariance()),
            odometry_errors: Some([self.ekf.odometry_errors(), self.ekf.odometry_error_sigmas()]),
            ..View::default()
        }
    }

    fn reconfigure(&mut self, config: &SlamConfig) {
        self.extractor = LineExtractor::new(config.lines);
        self.ekf.reconfigure(config.ekf);
    }
}
