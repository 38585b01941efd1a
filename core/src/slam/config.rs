//! The settings of every stage, nested as the stages are.

use std::sync::Arc;

use super::{PriorMap, PriorMapMatching, SonarsConfig};
use crate::estimation::{
    EkfConfig, GridParticlesConfig, HistogramConfig, MonteCarloConfig, SavedMap, ScanMatcherConfig,
    Start,
};
use crate::features::{LineConfig, PointFeatureConfig};
use crate::map::{EvidenceConfig, GridConfig};
use crate::points::{BlindZoneConfig, PointConfig, SectorConfig};
use crate::tracking::TrackingConfig;

/// Settings of every stage.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SlamConfig {
    /// What is kept of a scan.
    pub points: PointConfig,
    /// How a scan is reduced to sectors before anything else. Default none: every beam counts.
    pub sectors: Option<SectorConfig>,
    /// What is remembered of things too near to be seen.
    pub blind_zone: BlindZoneConfig,
    /// What moves, and how it is kept out of pose and map.
    pub tracking: TrackingConfig,
    /// How lines are found.
    pub lines: LineConfig,
    /// Which points are found beside them: to be looked at, and as landmarks of the filter where
    /// [`EkfConfig::landmarks`] asks for them.
    pub point_features: PointFeatureConfig,
    /// The filter over lines.
    pub ekf: EkfConfig,
    /// The scan matcher, with the grid that it redraws after closing a loop.
    pub matcher: ScanMatcherConfig,
    /// Grid mapping by particles.
    pub grid_particles: GridParticlesConfig,
    /// The grid of the other methods.
    pub grid: GridConfig,
    /// What the filter over lines draws of a scan.
    pub evidence: EvidenceConfig,
    /// Sonars beside the main sensor.
    pub sonars: SonarsConfig,
    /// The map that a method finds the robot in ([`Method::needs_prior_map`]).
    ///
    /// [`Method::needs_prior_map`]: super::Method::needs_prior_map
    pub prior_map: PriorMap,
    /// What of a scan is found in it. Default surfaces; with rangers, whose few readings stand in
    /// many places equally well, lines.
    pub prior_map_matching: PriorMapMatching,
    /// The saved map that scan matching goes on in. Default none: it begins with an empty one.
    pub saved_map: Option<EarlierMap>,
    /// The particles that find the robot in it, wherever it is.
    pub particles: MonteCarloConfig,
    /// The cells of poses by which it is found in a small one.
    pub histogram: HistogramConfig,
}

/// A saved map to go on in, and where in it the robot is.
#[derive(Clone, Debug, PartialEq)]
pub struct EarlierMap {
    /// The map.
    pub map: Arc<SavedMap>,
    /// Where the robot is.
    pub start: Start,
}

impl SlamConfig {
    /// For a sensor that scans only on command: it sees each cell a few times at most, little of
    /// each wall, and from afar in terms of odometry. It takes Celej's quicker grid, and the
    /// `short_range` figures of lines, filter, grid and what is near.
    #[must_use]
    pub fn short_range() -> Self {
        Self {
            blind_zone: BlindZoneConfig::short_range(),
            grid: GridConfig::celej(),
            lines: LineConfig::short_range(),
            prior_map_matching: PriorMapMatching::Lines,
            ekf: EkfConfig::short_range(),
            evidence: EvidenceConfig::short_range(),
            matcher: ScanMatcherConfig {
                evidence: EvidenceConfig::short_range(),
                ..ScanMatcherConfig::default()
            },
            ..Self::default()
        }
    }
}
