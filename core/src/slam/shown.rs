//! What a run shows: estimate, map, what was seen and recognised, and how far it can be trusted.

use nalgebra::{Matrix3, Point2};

use super::{Method, OwnMap, Slam, SlamConfig, SlamError, View, grid_of};
use crate::estimation::SavedMap;
use crate::features::{LineExtractor, PointFeature, find_points};
use crate::geom::{Pose2, PoseEstimate};
use crate::hash::StateHash;
use crate::map::{Grid, VectorMap};
use crate::points::{Points, Walkers};
use crate::robot::Stamp;
use crate::tracking::Track;

impl Slam {
    /// How the pose is estimated.
    #[must_use]
    pub fn method(&self) -> Method {
        self.method
    }

    /// The settings.
    #[must_use]
    pub fn config(&self) -> &SlamConfig {
        &self.config
    }

    /// Where the robot is now, map frame, the odometry since the last scan included.
    #[must_use]
    pub fn estimate(&self) -> PoseEstimate {
        self.estimator.estimate()
    }

    /// The occupancy grid. While a robot is lost in its prior map: the grid drawn since it got
    /// lost.
    #[must_use]
    pub fn grid(&self) -> &Grid {
        grid_of(&*self.estimator, &self.drawn)
    }

    /// The walls as segments with ends; empty for methods without lines.
    #[must_use]
    pub fn vector_map(&self) -> &VectorMap {
        &self.vector
    }

    /// What the method shows of itself: what it saw, recognised and learned.
    #[must_use]
    pub fn view(&self) -> View<'_> {
        self.estimator.view()
    }

    /// Points of the last scan, in the robot frame when it came.
    #[must_use]
    pub fn points(&self) -> Option<&Points> {
        self.points.as_ref()
    }

    /// Corners, spikes, crossings and circles of the last scan, in the robot frame when it came.
    /// They are extracted by this call.
    ///
    /// # Errors    [`SlamError::Lines`] for a beam with a number that is not finite.
    pub fn point_features(&self) -> Result<Vec<PointFeature>, SlamError> {
        let Some(points) = &self.points else {
            return Ok(vec![]);
        };
        let SlamConfig {
            lines: line_config,
            point_features: config,
            ..
        } = &self.config;
        let mut lines = vec![];
        LineExtractor::new(*line_config).extract(points, &mut lines)?;
        Ok(find_points(points, &lines, line_config, config)?)
    }

    /// The points of the last scan and, beside them, what was seen before and is now in the blind
    /// zone: what a pilot must not drive into.
    #[must_use]
    pub fn obstacles(&self) -> Option<&Points> {
        self.obstacles.as_ref()
    }

    /// Points of walkers, or of those who walked just before; in the robot frame when the last scan
    /// came.
    #[must_use]
    pub fn walkers(&self) -> &[Point2<f64>] {
        self.walkers.as_ref().map_or(&[], Walkers::points)
    }

    /// What moves or moved before, and what stands where the map was free; in the robot frame when
    /// the last scan came.
    #[must_use]
    pub fn tracks(&self) -> &[Track] {
        self.moving.tracks()
    }

    /// Points of the last scan that were kept out of pose and map, in the robot frame when it came.
    #[must_use]
    pub fn taken_out(&self) -> &[Point2<f64>] {
        self.moving.taken_out_points()
    }

    /// `robot_at_scan_from_robot`: the motion since the last scan, by odometry.
    #[must_use]
    pub fn motion_since_scan(&self) -> Pose2 {
        self.motion_since_scan
    }

    /// Covariance of the pose in the map around it as of the last scan, map frame: in the running
    /// submap if the map is made of submaps, else the estimate's own covariance.
    #[must_use]
    pub fn known_in_map(&self) -> Matrix3<f64> {
        self.estimator.matched().cov
    }

    /// How uncertain the heading has become since the last scan, rad: the odometry's possible
    /// error, as far as it is known by now.
    #[must_use]
    pub fn heading_drift(&self) -> f64 {
        let grown = self.estimate().cov[(2, 2)] - self.heading_variance;
        grown.max(0.0).sqrt()
    }

    /// The robot's speeds by its odometry, m/s and rad/s: a mean over a tenth of a second.
    #[must_use]
    pub fn speeds(&self) -> (f64, f64) {
        self.history.speeds(0.1)
    }

    /// The pose at each scan, as known now: a loop closure changes earlier ones, and so does a
    /// change of the best particle.
    #[must_use]
    pub fn trajectory(&self) -> Vec<(Stamp, Pose2)> {
        let whole = self.whole_trajectory().into_iter();
        whole.skip(self.earlier).collect()
    }

    /// Number of poses of [`Self::whole_trajectory`] that come from earlier runs in the same map.
    #[must_use]
    pub fn earlier_scans(&self) -> usize {
        self.earlier
    }

    /// The trajectory of earlier runs in the same map, followed by that of this run.
    #[must_use]
    pub fn whole_trajectory(&self) -> Vec<(Stamp, Pose2)> {
        let own = self.view().own_map;
        own.map_or_else(|| self.track.clone(), OwnMap::trajectory)
    }

    /// The map in which a later run can go on, with the `times` of its scans; `None` for methods
    /// other than scan matching.
    #[must_use]
    pub fn saved_map(&self, times: Vec<(Stamp, f64)>) -> Option<SavedMap> {
        self.view().map.map(|map| map.saved(times))
    }

    /// Grows by one whenever the grid was redrawn: what was shown of the old one is then void.
    #[must_use]
    pub fn grid_version(&self) -> u64 {
        self.view()
            .own_map
            .map_or(self.drawn.changes(), OwnMap::grid_version)
    }

    /// Adds pose, walls and map to a hash.
    pub fn add_to(&self, hash: &mut StateHash) {
        hash.estimate(&self.estimate());
        for landmark in self.view().landmarks {
            hash.integer(u64::from(landmark.id.0))
                .number(landmark.line.alpha())
                .number(landmark.line.r());
        }
        for landmark in self.view().point_landmarks {
            hash.integer(u64::from(landmark.id.0))
                .number(landmark.position.x)
                .number(landmark.position.y);
        }
        let grids = [Some(self.grid()), self.sonar_grid.as_ref()];
        for (block, cells) in grids.into_iter().flatten().flat_map(|g| g.blocks_since(0)) {
            hash.integer(block.col as u64)
                .integer(block.row as u64)
                .singles(cells);
        }
    }
}
