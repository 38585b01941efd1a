//! The first story: from odometry and scans to a pose and a map.
//!
//! ```text
//!   odometry ─────────────> predict ─┐
//!   scan ─> points ─> lines ─> match ─> correct ─> estimate ─> grid
//! ```
//!
//! Every source (simulation, bridge, recorded log) feeds the same two verbs, and every method answers alike, so that
//! they can be swapped and compared on the same run.

mod config;
mod estimator;
mod known;
#[cfg(test)]
mod known_tests;
mod localiser;
mod method;
mod sonars;
#[cfg(test)]
mod tests;
mod walls;

use std::borrow::Cow;

use nalgebra::Point2;

use crate::estimation::{
    Correlations, EkfError, Landmark, Match, OdometryErrors, ScanMatcherError, UpdateReport,
};
use crate::features::{LineError, LineFeature};
use crate::geom::{Pose2, PoseEstimate};
use crate::hash::StateHash;
use crate::map::{Grid, GridError, VectorMap};
use crate::points::{MotionHistory, NearField, Points, WalkerConfig, Walkers, sectors};
use crate::robot::{Odometry, OdometryError, Scan, ScanError, Stamp};
pub use config::SlamConfig;
use estimator::{Estimator, Sweep};
pub use known::{KnownBy, KnownFit, KnownMap};
pub use method::{Method, UnknownMethod};
pub use sonars::SonarsConfig;

/// Why SLAM cannot begin, or a scan cannot be used. The state stays as it was.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SlamError {
    /// The odometry is no motion.
    #[error(transparent)]
    Odometry(#[from] OdometryError),
    /// The scan breaks its promises.
    #[error(transparent)]
    Scan(#[from] ScanError),
    /// A beam or a setting that the search for lines cannot use.
    #[error(transparent)]
    Lines(#[from] LineError),
    /// What the filter over lines refuses.
    #[error(transparent)]
    Ekf(#[from] EkfError),
    /// A setting of the grid.
    #[error(transparent)]
    Grid(#[from] GridError),
    /// A setting of the scan matcher.
    #[error(transparent)]
    Matcher(#[from] ScanMatcherError),
    /// A method that needs a map, and none is there.
    #[error("known-map needs a known map with walls to find the robot in; none was given")]
    NoKnownMap,
}

/// Estimates the robot's pose and builds the map. The map's frame begins where the robot does.
#[derive(Clone, Debug)]
pub struct Slam {
    method: Method,
    config: SlamConfig,
    history: MotionHistory,
    estimator: Estimator,
    points: Option<Points>,
    near: NearField,
    /// `None` where nobody is driven.
    walkers: Option<Walkers>,
    /// The same points, with what is near and was not seen.
    obstacles: Option<Points>,
    motion_since_scan: Pose2,
    /// Variance of the heading at the last scan, rad².
    heading_variance: f64,
    vector: VectorMap,
    /// What sonars beside the main sensor have drawn.
    sonar_grid: Option<Grid>,
    /// A scan that is taken in part by part.
    pending: Option<Pending>,
}

/// The parts in which a scan is taken in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ScanPart {
    /// Lines are found.
    Lines,
    /// The pose is corrected.
    Localise,
    /// The map is drawn.
    Map,
}

#[derive(Clone, Debug)]
struct Pending {
    scan: Scan,
    points: Points,
    next: ScanPart,
}

impl Slam {
    /// Begins at the origin of the map.
    ///
    /// # Errors    [`SlamError`] naming the first setting out of range.
    pub fn new(method: Method, config: SlamConfig) -> Result<Self, SlamError> {
        Ok(Self {
            method,
            estimator: Estimator::new(method, &config)?,
            // The slowest sweep is that of a ranger on a servo, a few seconds.
            history: MotionHistory::new(5.0),
            near: NearField::new(config.near),
            walkers: Some(Walkers::new(WalkerConfig::default())),
            vector: VectorMap::new(config.vector),
            sonar_grid: None,
            config,
            points: None,
            obstacles: None,
            motion_since_scan: Pose2::identity(),
            heading_variance: 0.0,
            pending: None,
        })
    }

    /// Takes the motion since the last call. Readings come in order of time.
    ///
    /// # Errors    [`SlamError::Odometry`] for a motion that is not finite, whatever the method.
    pub fn odometry(&mut self, odometry: &Odometry) -> Result<(), SlamError> {
        odometry.validate()?;
        while self.continue_scan()?.is_some() {}
        self.estimator.predict(odometry)?;
        self.history.push(odometry);
        self.motion_since_scan = self.motion_since_scan * odometry.motion;
        Ok(())
    }

    /// Takes a scan, whose last beam was taken at or before the end of the newest odometry.
    ///
    /// # Errors    [`SlamError::Scan`] for a scan that breaks its promises, [`SlamError::Lines`] and [`SlamError::Ekf`] for one
    /// that the line extraction or the filter refuses.
    pub fn scan(&mut self, scan: &Scan) -> Result<(), SlamError> {
        while self.continue_scan()?.is_some() {}
        scan.validate()?;
        let scan = self.prepared(scan);
        let points = self.points_of(&scan);
        for part in [ScanPart::Lines, ScanPart::Localise, ScanPart::Map] {
            self.take_in(part, &scan, &points)?;
        }
        self.conclude(points);
        Ok(())
    }

    /// Without readings that look far and are near, and by sectors where that is set.
    fn prepared<'a>(&self, scan: &'a Scan) -> Cow<'a, Scan> {
        let scan = self.near.without_folded(scan, &self.motion_since_scan);
        match &self.config.sectors {
            Some(config) => Cow::Owned(sectors(&scan, config)),
            None => scan,
        }
    }

    /// The same part by part: [`Self::continue_scan`] does the parts. The next motion or scan does those that are left.
    ///
    /// # Errors    [`SlamError::Scan`] for a scan that breaks its promises.
    #[allow(
        clippy::needless_pass_by_value,
        reason = "it is kept, as it came or with invalid readings in it"
    )]
    pub fn begin_scan(&mut self, scan: Scan) -> Result<(), SlamError> {
        while self.continue_scan()?.is_some() {}
        scan.validate()?;
        let scan = self.prepared(&scan).into_owned();
        self.pending = Some(Pending {
            points: self.points_of(&scan),
            scan,
            next: ScanPart::Lines,
        });
        Ok(())
    }

    /// Does the next part of the scan that was begun, and tells which; `None` where nothing is left to do.
    ///
    /// # Errors    [`SlamError`] as of [`Self::scan`]; what is left of the scan is given up.
    pub fn continue_scan(&mut self) -> Result<Option<ScanPart>, SlamError> {
        let Some(Pending { scan, points, next }) = self.pending.take() else {
            return Ok(None);
        };
        self.take_in(next, &scan, &points)?;
        let after = match next {
            ScanPart::Lines => Some(ScanPart::Localise),
            ScanPart::Localise => Some(ScanPart::Map),
            ScanPart::Map => None,
        };
        match after {
            Some(next) => self.pending = Some(Pending { scan, points, next }),
            None => self.conclude(points),
        }
        Ok(Some(next))
    }

    fn points_of(&self, scan: &Scan) -> Points {
        Points::from_rolling_scan(scan, &self.history, &self.config.points)
    }

    fn take_in(&mut self, part: ScanPart, scan: &Scan, points: &Points) -> Result<(), SlamError> {
        let sweep = Sweep {
            scan,
            points,
            history: &self.history,
            config: &self.config,
        };
        match part {
            ScanPart::Lines => self.estimator.find_lines(points),
            ScanPart::Localise => self.estimator.correct(&sweep),
            ScanPart::Map => {
                self.estimator.draw(&sweep);
                Ok(())
            }
        }
    }

    fn conclude(&mut self, points: Points) {
        walls::observe(&mut self.vector, &self.estimator, &points);
        self.near.update(&points, &self.motion_since_scan);
        if let Some(walkers) = &mut self.walkers {
            walkers.update(&points, &self.motion_since_scan);
        }
        self.obstacles = Some(self.near.with_unseen(&points));
        self.points = Some(points);
        self.motion_since_scan = Pose2::identity();
        self.heading_variance = self.estimate().cov[(2, 2)];
    }

    /// Takes a few readings on the move, of a sensor that scans only standing: they tell who came since the last scan
    /// ([`Self::walkers`]), and nothing of pose or map.
    ///
    /// # Errors    [`SlamError::Scan`]: the readings break a scan's promises.
    pub fn look(&mut self, look: &Scan) -> Result<(), SlamError> {
        look.validate()?;
        let moved = self.motion_since_scan;
        let look = self.near.without_folded(look, &moved);
        let points = self.points_of(&look);
        let Some(walkers) = &mut self.walkers else {
            return Ok(());
        };
        for at in walkers.look(&points, &moved) {
            self.near.came(at);
        }
        Ok(())
    }

    /// Other settings from the next scan on: points, lines, the filter and what it draws. Those of grids, of the vector map and of the scan matcher
    /// hold for a whole run, and so do the known map, and so does what the filter knew of the odometry beforehand.
    ///
    /// # Errors    [`SlamError::Lines`] naming the first setting out of range; then the old ones stay.
    pub fn reconfigure(&mut self, config: &SlamConfig) -> Result<(), SlamError> {
        config.lines.validate()?;
        self.config = SlamConfig {
            matcher: self.config.matcher,
            grid: self.config.grid,
            vector: self.config.vector,
            known: std::mem::take(&mut self.config.known),
            ..config.clone()
        };
        self.near.reconfigure(self.config.near);
        self.estimator.reconfigure(&self.config);
        Ok(())
    }

    /// Completes all work that was put off, at the end of a log.
    pub fn finish(&mut self) {
        if let Estimator::Matching { matcher, .. } = &mut self.estimator {
            matcher.finish();
        }
    }

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

    /// The occupancy grid.
    #[must_use]
    pub fn grid(&self) -> &Grid {
        self.estimator.grid()
    }

    /// The walls as segments with ends; empty for methods without lines.
    #[must_use]
    pub fn vector_map(&self) -> &VectorMap {
        &self.vector
    }

    /// Walls of the line map; empty for methods without one.
    #[must_use]
    pub fn landmarks(&self) -> Vec<Landmark> {
        match &self.estimator {
            Estimator::Lines { ekf, .. } => ekf.landmarks().collect(),
            _ => vec![],
        }
    }

    /// Lines of the last scan, robot frame; empty for methods without.
    #[must_use]
    pub fn features(&self) -> &[LineFeature] {
        match &self.estimator {
            Estimator::Lines { features, .. } | Estimator::Known { features, .. } => features,
            _ => &[],
        }
    }

    /// Whether what is seen stands in the known map; `None` for other methods.
    #[must_use]
    pub fn known_fit(&self) -> Option<&KnownFit> {
        match &self.estimator {
            Estimator::Known { fit, .. } => Some(fit),
            _ => None,
        }
    }

    /// Which lines of the last scan were recognised as which walls.
    #[must_use]
    pub fn matches(&self) -> &[Match] {
        match &self.estimator {
            Estimator::Lines { ekf, .. } => &ekf.report().matches,
            _ => &[],
        }
    }

    /// What the last scan did to the line map and why, with the normalised innovation squared; `None` for methods without.
    #[must_use]
    pub fn explain(&self) -> Option<&UpdateReport> {
        match &self.estimator {
            Estimator::Lines { ekf, .. } => Some(ekf.report()),
            _ => None,
        }
    }

    /// What the filter has learned of the odometry's systematic errors, and the standard deviations of that; `None` for
    /// methods that do not learn them.
    #[must_use]
    pub fn odometry_errors(&self) -> Option<[OdometryErrors; 2]> {
        match &self.estimator {
            Estimator::Lines { ekf, .. } => {
                Some([ekf.odometry_errors(), ekf.odometry_error_sigmas()])
            }
            _ => None,
        }
    }

    /// How the errors of pose and walls hang together; `None` for methods without a common covariance.
    #[must_use]
    pub fn correlations(&self) -> Option<Correlations> {
        match &self.estimator {
            Estimator::Lines { ekf, .. } => Some(ekf.correlations()),
            _ => None,
        }
    }

    /// Points of the last scan, in the robot frame when it came.
    #[must_use]
    pub fn points(&self) -> Option<&Points> {
        self.points.as_ref()
    }

    /// Points of the scan that is taken in part by part, before its last part.
    #[must_use]
    pub fn pending_points(&self) -> Option<&Points> {
        self.pending.as_ref().map(|pending| &pending.points)
    }

    /// The next part of the scan that is taken in part by part.
    #[must_use]
    pub fn pending_part(&self) -> Option<ScanPart> {
        self.pending.as_ref().map(|pending| pending.next)
    }

    /// The same points and, beside them, what was seen before and stands nearer now than the sensor sees: what a pilot must
    /// not drive into.
    #[must_use]
    pub fn obstacles(&self) -> Option<&Points> {
        self.obstacles.as_ref()
    }

    /// Nobody is driven by what is seen: from here on nobody is looked for who walks about, and [`Self::look`] tells nothing.
    pub fn leave_walkers_out(&mut self) {
        self.walkers = None;
    }

    /// Points of those who walk about, or did so a moment ago; in the robot frame when the last scan came.
    #[must_use]
    pub fn walkers(&self) -> &[Point2<f64>] {
        self.walkers.as_ref().map_or(&[], Walkers::points)
    }

    /// `robot_at_scan_from_robot`: the motion since the last scan, by odometry.
    #[must_use]
    pub fn motion_since_scan(&self) -> Pose2 {
        self.motion_since_scan
    }

    /// How uncertain the heading has become since the last scan, rad: what odometry may err, as far as that is known by now.
    #[must_use]
    pub fn heading_drift(&self) -> f64 {
        let grown = self.estimate().cov[(2, 2)] - self.heading_variance;
        grown.max(0.0).sqrt()
    }

    /// How fast the robot runs by its odometry, m/s and rad/s: a mean over a tenth of a second.
    #[must_use]
    pub fn speeds(&self) -> (f64, f64) {
        self.history.speeds(0.1)
    }

    /// The pose at each scan, as known now: a closed loop changes earlier ones.
    #[must_use]
    pub fn trajectory(&self) -> Vec<(Stamp, Pose2)> {
        self.estimator.trajectory()
    }

    /// Number of loops closed by the pose graph.
    #[must_use]
    pub fn loop_closures(&self) -> usize {
        match &self.estimator {
            Estimator::Matching { matcher, .. } => matcher.loop_closures(),
            _ => 0,
        }
    }

    /// Grows by one whenever the grid was drawn anew: what was shown of the old one is void then.
    #[must_use]
    pub fn grid_version(&self) -> u64 {
        match &self.estimator {
            Estimator::Matching { matcher, .. } => matcher.grid_version(),
            _ => 0,
        }
    }

    /// Adds pose, walls and map to a hash.
    pub fn add_to(&self, hash: &mut StateHash) {
        hash.estimate(&self.estimate());
        for landmark in self.landmarks() {
            hash.integer(u64::from(landmark.id.0))
                .number(landmark.line.alpha())
                .number(landmark.line.r());
        }
        let grids = [Some(self.grid()), self.sonar_grid.as_ref()];
        for (block, cells) in grids.into_iter().flatten().flat_map(|g| g.blocks_since(0)) {
            hash.integer(block.col as u64)
                .integer(block.row as u64)
                .singles(cells);
        }
    }
}
