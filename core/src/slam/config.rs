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
    /// Which points of a scan are kept.
    pub points: PointConfig,
    /// How a scan is reduced to sectors before anything else. Default none: every beam counts.
    pub sectors: Option<SectorConfig>,
    /// What is remembered of things in the blind zone.
    pub blind_zone: BlindZoneConfig,
    /// How moving things are tracked and kept out of pose and map.
    pub tracking: TrackingConfig,
    /// How lines are found.
    pub lines: LineConfig,
    /// Which points are found beside them: to be shown, and as landmarks of the filter if
    /// [`EkfConfig::landmarks`] asks for them.
    pub point_features: PointFeatureConfig,
    /// The filter over lines.
    pub ekf: EkfConfig,
    /// The scan matcher, with the grid that it redraws after a loop closure.
    pub matcher: ScanMatcherConfig,
    /// Grid mapping by particles.
    pub grid_particles: GridParticlesConfig,
    /// The grid of the other methods.
    pub grid: GridConfig,
    /// What the filter over lines draws of a scan.
    pub evidence: EvidenceConfig,
    /// Sonars beside the main sensor.
    pub sonars: SonarsConfig,
    /// The map in which a method localises the robot ([`Method::needs_prior_map`]).
    ///
    /// [`Method::needs_prior_map`]: super::Method::needs_prior_map
    pub prior_map: PriorMap,
    /// Which parts of a scan are matched to it. Default surfaces; for rangers, whose few readings
    /// fit many places equally well, lines.
    pub prior_map_matching: PriorMapMatching,
    /// The saved map in which scan matching goes on. Default none: it begins with an empty one.
    pub saved_map: Option<EarlierMap>,
    /// The particles that localise the robot in the prior map, wherever it is.
    pub particles: MonteCarloConfig,
    /// The pose cells by which it is localised in a small map.
    pub histogram: HistogramConfig,
}

/// A saved map to go on in, and the robot's start in it.
#[derive(Clone, Debug, PartialEq)]
pub struct EarlierMap {
    /// The map.
    pub map: Arc<SavedMap>,
    /// Where the robot is.
    pub start: Start,
}

impl SlamConfig {
    /// For a sensor that scans only on command: it sees each cell a few times at most and little of
    /// each wall, with long drives by odometry between scans. It takes Celej's quicker grid, and
    /// the `short_range` figures of lines, filter, grid and blind zone.
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
