//! GeoJSON: a feature for each wall, with its properties.

use serde_json::{Value, json};

use super::{FloorPlanError, bounds};
use crate::map::Wall;

/// The walls as a collection of line strings. Coordinates are metres in the map frame, not degrees;
/// the file says so.
///
/// # Errors    [`FloorPlanError`].
pub fn geojson(walls: &[Wall]) -> Result<String, FloorPlanError> {
    let (low, high) = bounds(walls)?;
    let features: Vec<Value> = walls.iter().map(feature).collect();
    let collection = json!({
        "type": "FeatureCollection",
        "bbox": [low.x, low.y, high.x, high.y],
        "coordinates_are": "metres in the frame of the map: x forward, y left of where the robot began",
        "features": features,
    });
    Ok(format!("{collection:#}\n"))
}

fn feature(wall: &Wall) -> Value {
    let (a, b) = (wall.segment.a, wall.segment.b);
    json!({
        "type": "Feature",
        "id": wall.id,
        "geometry": { "type": "LineString", "coordinates": [[a.x, a.y], [b.x, b.y]] },
        "properties": {
            "length_m": wall.segment.length(),
            "sigma_across_m": wall.sigma_across,
            "sigma_direction_rad": wall.sigma_direction,
            "sightings": wall.sightings,
        },
    })
}
