//! Localisation in a map that is known: the map's lines, and what a scan's lines say of them.
//!
//! A drawn map is not exact: walls of a grid are off by up to half a cell. The filter takes its map for exact, so that what is not known
//! of the map is added to what is not known of each line seen: σ of the offset, and √12 σ over its length of the direction, as if
//! both ends were off by independent errors of about that size.

use crate::estimation::KnownLine;
use crate::features::LineFeature;
use crate::geom::sin_cos;

/// A map to be localised in.
#[derive(Clone, Debug, PartialEq)]
pub struct KnownMap {
    /// Its lines, map frame; the robot begins at the origin.
    pub lines: Vec<KnownLine>,
    /// How far its walls may be off, m: standard deviation. Default 0.01; of a grid, a third of its cells.
    pub sigma: f64,
}

impl Default for KnownMap {
    fn default() -> Self {
        Self {
            lines: vec![],
            sigma: 0.01,
        }
    }
}

impl KnownMap {
    /// A line of a scan, as uncertain as scan and map are together.
    pub(super) fn loosened(&self, feature: &LineFeature) -> LineFeature {
        let mut loose = *feature;
        let variance = self.sigma * self.sigma;
        let length = feature.length().max(self.sigma);
        // The direction errs about the middle of the piece; r is that of the foot point, as far along the line.
        let middle = nalgebra::center(&feature.ends[0], &feature.ends[1]);
        let (sin, cos) = sin_cos(feature.line.alpha());
        let along = cos * middle.y - sin * middle.x;
        let turned = 12.0 * variance / (length * length);
        loose.cov[(0, 0)] += turned;
        loose.cov[(0, 1)] += along * turned;
        loose.cov[(1, 0)] += along * turned;
        loose.cov[(1, 1)] += variance + along * along * turned;
        loose
    }
}
