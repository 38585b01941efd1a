//! The vector map as files that other programs open: SVG to look at and print, DXF for drawing,
//! GeoJSON for everything else. Each wall comes with its length in metres.
//!
//! In: walls of a [`crate::map::VectorMap`]. Out: the text of a file. All coordinates are those of
//! the map, m, x forward and y left of where the robot began; the picture alone turns y down.
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

use nalgebra::Point2;

use crate::geom::Segment;
use crate::map::Wall;

/// Why walls cannot be written.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FloorPlanError {
    /// There are none.
    #[error("the vector map is empty; expected at least one wall")]
    Empty,
    /// One has a coordinate that is no number.
    #[error("wall {id} has a coordinate that is not finite")]
    NotFinite {
        /// Its name.
        id: u32,
    },
}

/// Lower left and upper right corner of what holds all walls.
fn bounds(walls: &[Wall]) -> Result<(Point2<f64>, Point2<f64>), FloorPlanError> {
    let mut bounds: Option<(Point2<f64>, Point2<f64>)> = None;
    for wall in walls {
        for end in [wall.segment.a, wall.segment.b] {
            if !(end.x.is_finite() && end.y.is_finite()) {
                return Err(FloorPlanError::NotFinite { id: wall.id });
            }
            let (low, high) = bounds.unwrap_or((end, end));
            bounds = Some((low.inf(&end), high.sup(&end)));
        }
    }
    bounds.ok_or(FloorPlanError::Empty)
}

/// Where a length is written: its middle beside the wall, on the side that the wall was seen from,
/// and the direction of the text, rad, so that nobody reads it upside down.
struct Label {
    at: Point2<f64>,
    direction: f64,
    text: String,
}

impl Label {
    /// `None` for a wall that is too short for its own length.
    fn of(wall: &Wall, height: f64) -> Option<Self> {
        let Segment { a, b } = wall.segment;
        let along = b - a;
        let length = along.norm();
        if length < 4.0 * height {
            return None;
        }
        let left = nalgebra::Vector2::new(-along.y, along.x) / length;
        let turned = libm::atan2(along.y, along.x);
        let is_upright = turned.abs() <= std::f64::consts::FRAC_PI_2 + 1e-9;
        Some(Self {
            at: a + along * 0.5 + left * height,
            direction: match is_upright {
                true => turned,
                false => turned - std::f64::consts::PI.copysign(turned),
            },
            text: format!("{length:.2}"),
        })
    }
}
