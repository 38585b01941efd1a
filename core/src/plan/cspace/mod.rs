//! Configuration space: where the centre of the robot may be.
//!
//! In: obstacles (cells of a grid, or segments of walls) and the distance that the robot's centre
//! keeps from them. Out: for any point the remaining room, and for any straight leg how far it can
//! be driven.
//!
//! 1. The robot is the disc around its body, so walls grow by its radius and a margin (TDK 2016
//!    §5.1).
//! 2. Over a grid the distance to the nearest occupied cell comes from an exact distance transform;
//!    half a cell is subtracted, because the wall may be anywhere in its cell. Unknown cells are
//!    either no obstacle, or the centre of the robot keeps out of them, as the caller chooses.
//! 3. Over segments the distance is exact: walls become capsules.
//! 4. A leg is marched along in steps of the remaining room: long ones in the open, short ones at
//!    walls.

mod capsule;
mod grid;
mod raster;
mod segments;
mod snapshot;
#[cfg(test)]
mod tests;
mod within;

use nalgebra::Point2;

use crate::geom::Segment;

pub use grid::{GridSpace, Unknown};
pub use segments::{SegmentSpace, SpaceError};
pub use snapshot::rect_around;
pub use within::Within;

/// Where the centre of the robot may be.
pub trait ConfigSpace {
    /// How far the robot's centre may move from `point` in any direction, m; negative if it may not
    /// be there at all.
    fn room(&self, point: Point2<f64>) -> f64;

    /// Shortest step of a march, m.
    fn step(&self) -> f64;

    /// Lower left and upper right corner of the area in which to search for a path.
    fn bounds(&self) -> (Point2<f64>, Point2<f64>);

    /// Side of the cells of a space in which the room is bilinear between cell centres, m; `None`
    /// for all other spaces.
    fn cell(&self) -> Option<f64> {
        None
    }

    /// The walls, and the distance that the robot's centre keeps from them, m; `None` if the space
    /// has other obstacles too.
    fn walls(&self) -> Option<(&[Segment], f64)> {
        None
    }

    /// At least the walls within `reach` metres of a point, as lines: an outline that is not a disc
    /// is tested against them.
    fn walls_near(&self, point: Point2<f64>, reach: f64) -> Vec<Segment>;

    /// Whether it is proved that no path joins two free places. `false` proves nothing.
    fn are_apart(&self, _a: Point2<f64>, _b: Point2<f64>) -> bool {
        false
    }

    /// Whether the robot may be there.
    fn is_free(&self, point: Point2<f64>) -> bool {
        self.room(point) >= 0.0
    }

    /// How much of the leg is free, m; its whole length if nothing is in the way, 0 if the start is
    /// blocked.
    fn free_length(&self, leg: &Segment) -> f64 {
        let length = leg.length();
        if !(length > 0.0 && length.is_finite()) {
            return 0.0;
        }
        let along = leg.vector() / length;
        let mut at = 0.0;
        let mut free = 0.0;
        loop {
            let room = self.room(leg.a + along * at);
            if room.is_nan() || room < 0.0 {
                return free;
            }
            free = at;
            if at >= length {
                return length;
            }
            // Bilinear distances may change by √2 per metre.
            at = (at + (room * 0.7).max(self.step())).min(length);
        }
    }

    /// Whether the robot can drive the whole leg.
    fn leg_is_free(&self, leg: &Segment) -> bool {
        if leg.a == leg.b {
            return self.is_free(leg.a);
        }
        // The middle first: there a blocked leg is refused soonest.
        self.is_free(Point2::from((leg.a.coords + leg.b.coords) * 0.5))
            && self.is_free(leg.a)
            && self.free_length(leg) >= leg.length()
    }
}
