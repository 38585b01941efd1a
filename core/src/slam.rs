//! Estimation: from odometry and scans to a pose and a map.
//!
//! ```text
//!   odometry ─────────────> predict ─┐
//!   scan ─> points ─> lines ─> match ─> correct ─> estimate ─> grid
//! ```
//!
//! Every source (simulation, bridge, recorded log) feeds the same two verbs, and every method
//! answers in the same form, so methods can be swapped and compared on the same run.

mod config;
mod drawn;
mod method;
mod prepared;
mod prior_map;
#[cfg(test)]
mod prior_map_tests;
mod shown;
mod sonars;
#[cfg(test)]
mod tests;
mod view;
mod walls;

use std::borrow::Cow;

use nalgebra::Point2;

use crate::bounds::OutOfBounds;
use crate::estimation::{
    EditError, EditKind, EkfError, GridParticlesError, RemovalError, RestoreError, ScanMatcher,
    ScanMatcherError,
};
use crate::features::LineError;
use crate::geom::Pose2;
use crate::map::{Grid, GridError, VectorMap};
use crate::points::{BlindZone, MotionHistory, Points, Walkers, sectors};
use crate::robot::{Odometry, OdometryError, Scan, ScanError, Stamp};
use crate::tracking::MovingObjects;
pub use config::{EarlierMap, SlamConfig};
use drawn::Drawn;
use method::Estimator;
pub use method::{Method, UnknownMethod};
use prepared::PreparedScan;
pub use prior_map::{PriorMap, PriorMapFit, PriorMapMatching};
pub use sonars::SonarsConfig;
pub use view::{OwnMap, View};

/// Why SLAM cannot begin, or a scan cannot be used. The state does not change.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SlamError {
    /// The odometry is not a valid motion.
    #[error(transparent)]
    Odometry(#[from] OdometryError),
    /// The scan breaks its invariants.
    #[error(transparent)]
    Scan(#[from] ScanError),
    /// A beam or a setting that line extraction cannot use.
    #[error(transparent)]
    Lines(#[from] LineError),
    /// The filter over lines refuses a value.
    #[error(transparent)]
    Ekf(#[from] EkfError),
    /// A setting of the grid is refused.
    #[error(transparent)]
    Grid(#[from] GridError),
    /// A setting of the scan matcher is refused.
    #[error(transparent)]
    Matcher(#[from] ScanMatcherError),
    /// A setting of grid mapping by particles is refused.
    #[error(transparent)]
    GridParticles(#[from] GridParticlesError),
    /// A setting for the tracking of moving objects is refused.
    #[error("moving objects: {0}")]
    Tracking(#[from] OutOfBounds),
    /// A saved map that the scan matcher cannot restore.
    #[error(transparent)]
    Restore(#[from] RestoreError),
    /// A saved map for a method that cannot go on in one.
    #[error("only scan matching goes on in a saved map")]
    NoSavedMap,
    /// A change by hand, but the map of the method cannot be edited.
    #[error("only the map of scan matching can be changed by hand")]
    NoEdits,
    /// A change by hand that is refused.
    #[error(transparent)]
    Edit(#[from] EditError),
    /// A submap was named, but the method has none.
    #[error("only the map of scan matching is made of submaps")]
    NoSubmaps,
    /// The submap cannot be taken out.
    #[error(transparent)]
    Removal(#[from] RemovalError),
    /// The method needs a prior map, and none was given.
    #[error("the method needs a prior map with walls to find the robot in; none was given")]
    NoPriorMap,
}

/// Estimates the robot's pose and builds the map. The map's frame begins where the robot does.
#[derive(Debug)]
pub struct Slam {
    method: Method,
    config: SlamConfig,
    history: MotionHistory,
    estimator: Box<dyn Estimator>,
    /// How many poses of the trajectory come from earlier runs in the same map.
    earlier: usize,
    /// The map, for methods without one of their own.
    drawn: Drawn,
    /// The pose at each scan, for methods without a map of their own.
    track: Vec<(Stamp, Pose2)>,
    points: Option<Points>,
    blind_zone: BlindZone,
    moving: MovingObjects,
    /// `None` if nobody drives the robot by what is seen.
    walkers: Option<Walkers>,
    /// The points of the last scan, and what is near but was not seen in it.
    obstacles: Option<Points>,
    motion_since_scan: Pose2,
    /// Variance of the heading at the last scan, rad².
    heading_variance: f64,
    vector: VectorMap,
    /// The grid drawn from the sonars beside the main sensor.
    sonar_grid: Option<Grid>,
}

impl Slam {
    /// Begins at the origin of the map.
    ///
    /// # Errors    [`SlamError`] naming the first setting out of range.
    pub fn new(method: Method, mut config: SlamConfig) -> Result<Self, SlamError> {
        if config.saved_map.is_some() && method != Method::ScanMatching {
            return Err(SlamError::NoSavedMap);
        }
        (config.point_features.validate()).map_err(LineError::from)?;
        config.tracking.validate()?;
        let estimator = method.begin(&config)?;
        // From here on the estimator holds it.
        config.saved_map = None;
        Ok(Self {
            method,
            earlier: places_of(&*estimator),
            estimator,
            drawn: Drawn::new(config.grid)?,
            track: vec![],
            // The slowest sweep is that of a ranger on a servo: a few seconds.
            history: MotionHistory::new(5.0),
            blind_zone: BlindZone::new(config.blind_zone),
            moving: MovingObjects::new(config.tracking),
            walkers: Some(Walkers::default()),
            vector: VectorMap::default(),
            sonar_grid: None,
            config,
            points: None,
            obstacles: None,
            motion_since_scan: Pose2::identity(),
            heading_variance: 0.0,
        })
    }

    /// Takes the motion since the last call. Readings come in order of time.
    ///
    /// # Errors    [`SlamError::Odometry`] for a motion that is not finite, whatever the method.
    pub fn odometry(&mut self, odometry: &Odometry) -> Result<(), SlamError> {
        odometry.validate()?;
        self.estimator.predict(odometry)?;
        self.history.push(odometry);
        self.motion_since_scan = self.motion_since_scan * odometry.motion;
        Ok(())
    }

    /// Takes a scan, whose last beam was taken at or before the end of the newest odometry.
    ///
    /// # Errors    [`SlamError::Scan`] for a scan that breaks its invariants, [`SlamError::Lines`]
    /// and [`SlamError::Ekf`] for one that the line extraction or the filter refuses.
    pub fn scan(&mut self, scan: &Scan) -> Result<(), SlamError> {
        scan.validate()?;
        let scan = PreparedScan::new(self.readable(scan), &self.history, &self.config);
        let (points, moved) = (scan.points.clone(), self.motion_since_scan);
        let expected = self.estimator.estimate().pose;
        let grid = grid_of(&*self.estimator, &self.drawn);
        let theirs = (self.moving).taken_out(&points, &moved, grid, &expected);
        let scan = scan.without(theirs);
        if let Some(evidence) = self.estimator.update(&scan)? {
            let pose = self.estimator.estimate().pose;
            let quality = self.estimator.view().pose_quality;
            self.drawn.grid_for(quality)?.draw(&evidence, &pose);
            self.track.push((scan.points.stamp, pose));
        }
        let (pose, matched) = (self.estimator.estimate().pose, self.estimator.matched());
        let grid = grid_of(&*self.estimator, &self.drawn);
        self.moving.update(&points, &moved, grid, &pose, &matched);
        self.conclude(points);
        Ok(())
    }

    /// The scan without readings that seem far but are near, reduced to sectors if that is set.
    fn readable<'a>(&self, scan: &'a Scan) -> Cow<'a, Scan> {
        let scan = self
            .blind_zone
            .without_folded(scan, &self.motion_since_scan);
        match &self.config.sectors {
            Some(config) => Cow::Owned(sectors(&scan, config)),
            None => scan,
        }
    }

    /// Updates what the next scan and the pilot need of this one.
    fn conclude(&mut self, points: Points) {
        let (view, estimate) = (self.estimator.view(), self.estimator.estimate());
        walls::observe(&mut self.vector, &view, &estimate, &points);
        self.blind_zone.update(&points, &self.motion_since_scan);
        if let Some(walkers) = &mut self.walkers {
            walkers.update(&points, &self.motion_since_scan);
        }
        self.obstacles = Some(self.blind_zone.with_unseen(&points));
        self.points = Some(points);
        self.motion_since_scan = Pose2::identity();
        self.heading_variance = estimate.cov[(2, 2)];
    }

    /// Takes a few readings on the move, from a sensor that scans only while the robot stands. They
    /// show who came since the last scan ([`Self::walkers`]), and do not change pose or map.
    ///
    /// # Errors    [`SlamError::Scan`]: the readings break a scan's invariants.
    pub fn partial_scan(&mut self, readings: &Scan) -> Result<(), SlamError> {
        readings.validate()?;
        let moved = self.motion_since_scan;
        let readings = self.blind_zone.without_folded(readings, &moved);
        let points = Points::from_rolling_scan(&readings, &self.history, &self.config.points);
        let Some(walkers) = &mut self.walkers else {
            return Ok(());
        };
        for at in walkers.partial_scan(&points, &moved) {
            self.blind_zone.came(at);
        }
        Ok(())
    }

    /// Uses other settings from the next scan on: points, lines, the filter and what it draws. The
    /// settings of grids, of the vector map and of the scan matcher are fixed for a whole run, as
    /// are the prior map and what the filter knew of the odometry beforehand.
    ///
    /// # Errors    [`SlamError::Lines`] naming the first setting out of range; then the old ones
    /// stay.
    pub fn reconfigure(&mut self, config: &SlamConfig) -> Result<(), SlamError> {
        config.lines.validate()?;
        (config.point_features.validate()).map_err(LineError::from)?;
        config.tracking.validate()?;
        self.config = SlamConfig {
            matcher: self.config.matcher,
            grid_particles: self.config.grid_particles,
            grid: self.config.grid,
            prior_map: std::mem::take(&mut self.config.prior_map),
            saved_map: None,
            ..config.clone()
        };
        self.moving.reconfigure(self.config.tracking);
        self.blind_zone.reconfigure(self.config.blind_zone);
        self.estimator.reconfigure(&self.config);
        Ok(())
    }

    /// Goes on in a saved map, before anything was seen.
    ///
    /// # Errors    [`SlamError::NoSavedMap`] for methods other than scan matching,
    /// [`SlamError::Restore`]; then nothing changes.
    pub fn go_on_in(&mut self, saved: EarlierMap) -> Result<(), SlamError> {
        if self.method != Method::ScanMatching {
            return Err(SlamError::NoSavedMap);
        }
        let config = SlamConfig {
            saved_map: Some(saved),
            ..self.config.clone()
        };
        self.estimator = self.method.begin(&config)?;
        self.earlier = places_of(&*self.estimator);
        Ok(())
    }

    /// Changes the map by hand; see [`ScanMatcher::edit`].
    ///
    /// # Errors    [`SlamError::NoEdits`] for methods other than scan matching,
    /// [`SlamError::Edit`]; then the map does not change.
    pub fn edit(&mut self, kind: EditKind, corners: &[Point2<f64>]) -> Result<(), SlamError> {
        let map = self.estimator.editable().ok_or(SlamError::NoEdits)?;
        Ok(map.edit(kind, corners)?)
    }

    /// Takes back the last change that was made by hand; `false` if there is none.
    pub fn undo_edit(&mut self) -> bool {
        let map = self.estimator.editable();
        map.is_some_and(ScanMatcher::undo_edit)
    }

    /// Takes a submap out of the map; see [`ScanMatcher::remove_submap`].
    ///
    /// # Errors    [`SlamError::NoSubmaps`] for methods other than scan matching,
    /// [`SlamError::Removal`]; then the map does not change.
    pub fn remove_submap(&mut self, submap: usize) -> Result<(), SlamError> {
        let map = self.estimator.editable().ok_or(SlamError::NoSubmaps)?;
        Ok(map.remove_submap(submap)?)
    }

    /// Puts back the submap that was taken out last and returns its number; `None` if there is none
    /// that can come back.
    pub fn undo_removal(&mut self) -> Option<usize> {
        self.estimator.editable()?.undo_removal()
    }

    /// Completes all postponed work, at the end of a log.
    pub fn finish(&mut self) {
        self.estimator.finish();
    }

    /// Turns the search for walkers off, for a robot that nobody drives by what is seen: from here
    /// on [`Self::partial_scan`] does nothing.
    pub fn disable_walkers(&mut self) {
        self.walkers = None;
    }
}

/// The map: a method's own, or what is drawn for it.
fn grid_of<'a>(estimator: &'a dyn Estimator, drawn: &'a Drawn) -> &'a Grid {
    let own = estimator.view().own_map;
    own.map_or_else(|| drawn.grid(), OwnMap::grid)
}

/// Number of poses of the trajectory that a method keeps itself.
fn places_of(estimator: &dyn Estimator) -> usize {
    let map = estimator.view().map;
    map.map_or(0, |map| map.trajectory().count())
}
