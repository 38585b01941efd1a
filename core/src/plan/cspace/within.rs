//! The cells from which a geofence keeps the robot's centre.
//!
//! In: cells, and a fence with the distance to keep from its border. Out: a mask of cells.

use nalgebra::Point2;

use crate::geom::geofence::Geofence;
use crate::map::CellRect;

/// Side of a block that is tested as a whole first, cells.
const BLOCK: usize = 16;

/// Where the robot's centre may be, whatever the map holds.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Within {
    /// The fence, map frame; without zones the centre may be everywhere.
    pub fence: Geofence,
    /// The clearance that the robot's centre keeps within the fence, m.
    pub keep: f64,
}

impl Within {
    /// Whether the robot's centre may be at a point.
    #[must_use]
    pub fn allows(&self, point: Point2<f64>) -> bool {
        self.fence.is_empty() || self.fence.clearance(point) >= self.keep
    }

    /// Those cells of `rect` in whose centres the robot's centre may not be, in rows from the lower
    /// left one.
    ///
    /// The clearance changes by no more than the distance moved, so most blocks are decided by
    /// their middle.
    pub(super) fn outside(&self, rect: CellRect, resolution: f64) -> Vec<bool> {
        let width = rect.width();
        let height = (rect.max.row - rect.min.row).max(0) as usize;
        let mut mask = vec![false; width * height];
        let at = |col: f64, row: f64| {
            Point2::new(
                (f64::from(rect.min.col) + col) * resolution,
                (f64::from(rect.min.row) + row) * resolution,
            )
        };
        for low in (0..height).step_by(BLOCK) {
            for left in (0..width).step_by(BLOCK) {
                let high = (low + BLOCK).min(height);
                let right = (left + BLOCK).min(width);
                let (mid_col, mid_row) = (0.5 * (left + right) as f64, 0.5 * (low + high) as f64);
                let spare = self.fence.clearance(at(mid_col, mid_row)) - self.keep;
                let is_decided = spare.abs()
                    > 0.5 * resolution * libm::hypot((right - left) as f64, (high - low) as f64);
                for row in low..high {
                    for col in left..right {
                        mask[row * width + col] = match is_decided {
                            true => spare < 0.0,
                            false => !self.allows(at(col as f64 + 0.5, row as f64 + 0.5)),
                        };
                    }
                }
            }
        }
        mask
    }
}
