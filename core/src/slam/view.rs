//! What a method shows of itself.

use std::fmt::Debug;

use nalgebra::Point2;

use super::PriorMapFit;
use crate::estimation::{
    Correlations, FeatureCounts, GridParticles, Hypothesis, Landmark, Match, OdometryErrors,
    Particle, PointLandmark, PoseGraph, PoseQuality, ScanFit, ScanMatcher, SymmetricMatrix,
    UpdateReport,
};
use crate::features::{LineFeature, PointFeature};
use crate::geom::Pose2;
use crate::map::Grid;
use crate::robot::Stamp;

/// A map and a trajectory that a method may change after they were drawn.
pub trait OwnMap: Debug {
    /// The map.
    fn grid(&self) -> &Grid;

    /// Grows by one whenever it is another grid: what was shown of the old one is void then.
    fn grid_version(&self) -> u64;

    /// The pose at each scan, as known now.
    fn trajectory(&self) -> Vec<(Stamp, Pose2)>;
}

impl OwnMap for ScanMatcher {
    fn grid(&self) -> &Grid {
        Self::grid(self)
    }

    fn grid_version(&self) -> u64 {
        Self::grid_version(self)
    }

    fn trajectory(&self) -> Vec<(Stamp, Pose2)> {
        Self::trajectory(self).collect()
    }
}

impl OwnMap for GridParticles {
    fn grid(&self) -> &Grid {
        Self::grid(self)
    }

    fn grid_version(&self) -> u64 {
        Self::grid_version(self)
    }

    fn trajectory(&self) -> Vec<(Stamp, Pose2)> {
        Self::trajectory(self)
    }
}

/// What a method shows of itself after the last scan. What it does not have is empty.
#[derive(Clone, Copy, Debug, Default)]
pub struct View<'a> {
    /// Lines of the last scan, robot frame.
    pub features: &'a [LineFeature],
    /// Walls of the line map, in the order of the state.
    pub landmarks: &'a [Landmark],
    /// Points of the last scan that may become landmarks, robot frame.
    pub points: &'a [PointFeature],
    /// Corners and posts that the map keeps, in the order of the state.
    pub point_landmarks: &'a [PointLandmark],
    /// What the last scan did to the line map and why, with the normalised innovation squared.
    pub update: Option<&'a UpdateReport>,
    /// The common covariance of pose and walls.
    pub covariance: Option<&'a SymmetricMatrix>,
    /// What was learned of the odometry's systematic errors, and the standard deviations of that.
    pub odometry_errors: Option<[OdometryErrors; 2]>,
    /// Whether what is seen stands in the prior map.
    pub prior_map_fit: Option<&'a PriorMapFit>,
    /// Poses that the robot may have, the likeliest first.
    pub hypotheses: &'a [Hypothesis],
    /// The particles that stand for them.
    pub particles: &'a [Particle],
    /// Whether the pose is to be believed, of methods that know.
    pub pose_quality: Option<PoseQuality>,
    /// Number of loops closed by the pose graph.
    pub loop_closures: usize,
    /// The pose graph of a method that keeps one.
    pub graph: Option<&'a PoseGraph>,
    /// Of the particles, how many of equal weight would estimate as well; of methods that map by
    /// them.
    pub effective_particles: Option<f64>,
    /// How the last scan fits to the map, of methods that match whole scans.
    pub scan_fit: Option<ScanFit>,
    /// The submaps of scan matching.
    pub map: Option<&'a ScanMatcher>,
    /// The map and trajectory of a method that changes what it has drawn.
    pub own_map: Option<&'a dyn OwnMap>,
}

impl<'a> View<'a> {
    /// Which lines of the last scan were recognised as which walls.
    #[must_use]
    pub fn matches(&self) -> &'a [Match] {
        self.update.map_or(&[], |update| &update.matches)
    }

    /// How much the last scan showed, and what became of it; `None` of methods that take scans
    /// otherwise, and where the scan could not be matched.
    #[must_use]
    pub fn feature_counts(&self) -> Option<FeatureCounts> {
        let by_features = self.update.map(UpdateReport::feature_counts);
        by_features.or(self.scan_fit.map(|fit| fit.counts))
    }

    /// Number of walls that were seen often enough.
    #[must_use]
    pub fn confirmed(&self) -> usize {
        let walls = self.landmarks.iter();
        walls.filter(|wall| wall.is_confirmed).count()
    }

    /// Where the points are that were seen often enough, and how often they were found again.
    pub fn confirmed_points(&self) -> impl Iterator<Item = (Point2<f64>, u32)> + use<'a> {
        let points = self.point_landmarks.iter();
        let confirmed = points.filter(|point| point.is_confirmed);
        confirmed.map(|point| (point.position, point.confidence()))
    }

    /// Points by which others recognise a place of this map, and how often each was found again:
    /// those that the method keeps and, of a map of submaps, those found in it now
    /// ([`ScanMatcher::landmarks`]).
    #[must_use]
    pub fn landmark_points(&self) -> Vec<(Point2<f64>, u32)> {
        let of_map = self.map.map(ScanMatcher::landmarks).unwrap_or_default();
        let of_map = of_map
            .iter()
            .map(|point| (point.position, point.confidence));
        self.confirmed_points().chain(of_map).collect()
    }

    /// How the errors of pose and walls hang together; `None` for methods without a common
    /// covariance. O(n²).
    #[must_use]
    pub fn correlations(&self) -> Option<Correlations> {
        let covariance = self.covariance?;
        let walls = self.landmarks.iter().map(|wall| wall.id);
        let points = self.point_landmarks.iter().map(|point| point.id);
        Some(Correlations::of(covariance, walls.chain(points)))
    }
}
