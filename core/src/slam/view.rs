//! What a method makes visible of itself.

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

/// A map and a trajectory that a method may change after drawing them.
pub trait OwnMap: Debug {
    /// The map.
    fn grid(&self) -> &Grid;

    /// Grows by one whenever the grid is replaced: what was shown of the old one is then void.
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

/// What a method shows after the last scan. What it does not have is empty.
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
    /// The joint covariance of pose and walls.
    pub covariance: Option<&'a SymmetricMatrix>,
    /// The learned systematic errors of the odometry, and their standard deviations.
    pub odometry_errors: Option<[OdometryErrors; 2]>,
    /// How well what is seen fits the prior map.
    pub prior_map_fit: Option<&'a PriorMapFit>,
    /// Poses that the robot may have, the likeliest first.
    pub hypotheses: &'a [Hypothesis],
    /// The particles of these hypotheses.
    pub particles: &'a [Particle],
    /// Whether the pose can be trusted, for methods that know.
    pub pose_quality: Option<PoseQuality>,
    /// Number of loops closed by the pose graph.
    pub loop_closures: usize,
    /// The pose graph, for methods that keep one.
    pub graph: Option<&'a PoseGraph>,
    /// Effective number of particles, for methods that map with them.
    pub effective_particles: Option<f64>,
    /// How the last scan fits the map, for methods that match whole scans.
    pub scan_fit: Option<ScanFit>,
    /// The submaps of scan matching.
    pub map: Option<&'a ScanMatcher>,
    /// The map and trajectory, for methods that change what they have drawn.
    pub own_map: Option<&'a dyn OwnMap>,
}

impl<'a> View<'a> {
    /// Which lines of the last scan were matched to which walls.
    #[must_use]
    pub fn matches(&self) -> &'a [Match] {
        self.update.map_or(&[], |update| &update.matches)
    }

    /// How much the last scan showed, and what became of it; `None` for methods that do not match
    /// whole scans, and if the scan could not be matched.
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

    /// Positions of the points that were seen often enough, and how often each was found again.
    pub fn confirmed_points(&self) -> impl Iterator<Item = (Point2<f64>, u32)> + use<'a> {
        let points = self.point_landmarks.iter();
        let confirmed = points.filter(|point| point.is_confirmed);
        confirmed.map(|point| (point.position, point.confidence()))
    }

    /// Points by which other runs recognise a place of this map, and how often each was found
    /// again: those that the method keeps and, in a map of submaps, those found in it now
    /// ([`ScanMatcher::landmarks`]).
    #[must_use]
    pub fn landmark_points(&self) -> Vec<(Point2<f64>, u32)> {
        let of_map = self.map.map(ScanMatcher::landmarks).unwrap_or_default();
        let of_map = of_map
            .iter()
            .map(|point| (point.position, point.confidence));
        self.confirmed_points().chain(of_map).collect()
    }

    /// How the errors of pose and walls are correlated; `None` for methods without a joint
    /// covariance. O(n²).
    #[must_use]
    pub fn correlations(&self) -> Option<Correlations> {
        let covariance = self.covariance?;
        let walls = self.landmarks.iter().map(|wall| wall.id);
        let points = self.point_landmarks.iter().map(|point| point.id);
        Some(Correlations::of(covariance, walls.chain(points)))
    }
}
