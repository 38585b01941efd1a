//! The extended Kalman filter over lines and points: it finds them in each scan, matches them to
//! the walls, corners and posts known so far, and corrects these and the pose by them.

use super::{Estimator, PreparedScan, SlamConfig, SlamError, View};
use crate::estimation::{EkfSlam, Landmark, PointLandmark, SweepSmoother, SweepTiming};
use crate::features::{LineExtractor, LineFeature, PointFeature, find_points};
use crate::geom::PoseEstimate;
use crate::map::Evidence;
use crate::robot::Odometry;

pub(super) fn begin(config: &SlamConfig) -> Result<Box<dyn Estimator>, SlamError> {
    config.lines.validate()?;
    Ok(Box::new(LineEkf {
        extractor: LineExtractor::new(config.lines),
        features: vec![],
        points: vec![],
        ekf: EkfSlam::new(config.ekf)?,
        landmarks: vec![],
        point_landmarks: vec![],
        smoother: SweepSmoother::default(),
    }))
}

#[derive(Debug)]
struct LineEkf {
    extractor: LineExtractor,
    /// The lines of the last scan.
    features: Vec<LineFeature>,
    /// The points of the last scan; empty if points are not used as landmarks.
    points: Vec<PointFeature>,
    ekf: EkfSlam,
    /// The walls after the last scan.
    landmarks: Vec<Landmark>,
    point_landmarks: Vec<PointLandmark>,
    smoother: SweepSmoother,
}

impl Estimator for LineEkf {
    fn predict(&mut self, odometry: &Odometry) -> Result<(), SlamError> {
        Ok(self.ekf.predict(odometry)?)
    }

    fn update(&mut self, scan: &PreparedScan) -> Result<Option<Evidence>, SlamError> {
        self.extractor.extract(&scan.points, &mut self.features)?;
        let timing = SweepTiming::at(scan.points.stamp, &scan.scan);
        self.points = points_of(scan, &self.features)?;
        let report = (self.ekf).update_with_points(&self.features, &self.points, &timing)?;
        let poses = self
            .smoother
            .smooth(&scan.scan, &scan.moved, &report.fixes, scan.history);
        self.landmarks.clear();
        self.landmarks.extend(self.ekf.landmarks());
        self.point_landmarks.clear();
        self.point_landmarks.extend(self.ekf.point_landmarks());
        Ok(Some(scan.evidence_from(&poses)))
    }

    fn estimate(&self) -> PoseEstimate {
        self.ekf.estimate()
    }

    fn view(&self) -> View<'_> {
        View {
            features: &self.features,
            landmarks: &self.landmarks,
            points: &self.points,
            point_landmarks: &self.point_landmarks,
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

/// The points of a scan that may become landmarks.
fn points_of(scan: &PreparedScan, lines: &[LineFeature]) -> Result<Vec<PointFeature>, SlamError> {
    let config = scan.config;
    if !config.ekf.landmarks.has_points() {
        return Ok(vec![]);
    }
    let asked = config.point_features.of_landmarks();
    Ok(find_points(&scan.points, lines, &config.lines, &asked)?)
}
