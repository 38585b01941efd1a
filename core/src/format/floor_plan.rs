//! The vector map as files that other programs open: SVG to view and print, DXF for CAD programs,
//! GeoJSON for everything else. Each wall comes with its length in metres.
//!
//! In: walls of a [`crate::map::VectorMap`]. Out: the text of a file. All coordinates are those of
//! the map, m, with the origin where the robot began, x forward and y left; only the SVG turns y
//! down.
//!
//! Sources: W3C, Scalable Vector Graphics 1.1; Autodesk, DXF Reference, release 12; RFC 7946, "The
//! GeoJSON Format".

mod dxf;
mod geojson;
mod svg;
#[cfg(test)]
mod tests;

pub use dxf::dxf;
pub use geojson::geojson;
pub use svg::svg;

use std::f64::consts::{FRAC_PI_2, PI};

use nalgebra::Point2;

use crate::geom::{self, Length, Segment};
use crate::map::Wall;

/// Why walls cannot be written.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FloorPlanError {
    /// There are no walls.
    #[error("the vector map is empty; expected at least one wall")]
    Empty,
    /// A wall has a coordinate that is not finite.
    #[error("wall {id} has a coordinate that is not finite")]
    NotFinite {
        /// Its name.
        id: u32,
    },
}

/// Lower left and upper right corner of the bounding box of all walls.
fn bounds(walls: &[Wall]) -> Result<(Point2<f64>, Point2<f64>), FloorPlanError> {
    let is_finite = |end: &Point2<f64>| end.x.is_finite() && end.y.is_finite();
    if let Some(wall) = walls.iter().find(|wall| !ends(wall).iter().all(is_finite)) {
        return Err(FloorPlanError::NotFinite { id: wall.id });
    }
    geom::bounds(walls.iter().flat_map(ends)).ok_or(FloorPlanError::Empty)
}

fn ends(wall: &Wall) -> [Point2<f64>; 2] {
    [wall.segment.a, wall.segment.b]
}

/// Where a length is written: beside the middle of the wall, on the side that the wall was seen
/// from; and the direction of the text, rad, chosen so it is never upside down.
struct Label {
    at: Point2<f64>,
    direction: f64,
    text: String,
}

impl Label {
    /// `None` for a wall that is shorter than the text.
    fn of(wall: &Wall, height: f64) -> Option<Self> {
        let Segment { a, b } = wall.segment;
        let along = b - a;
        let length = along.length();
        if length < 4.0 * height {
            return None;
        }
        let left = nalgebra::Vector2::new(-along.y, along.x) / length;
        let turned = libm::atan2(along.y, along.x);
        let is_upright = turned.abs() <= FRAC_PI_2 + 1e-9;
        let upright = turned - PI.copysign(turned);
        Some(Self {
            at: a + along * 0.5 + left * height,
            direction: if is_upright { turned } else { upright },
            text: format!("{length:.2}"),
        })
    }
}
