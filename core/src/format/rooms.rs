//! The topological map as GeoJSON: a polygon for each room and corridor, a line for each door.
//!
//! In: a [`Topology`]. Out: the text of a file, for programs that read GeoJSON. Coordinates are
//! metres in the map frame, not degrees; the file says so.
//!
//! Source: RFC 7946, "The GeoJSON Format": outer rings counter-clockwise, holes clockwise, the
//! first point again at the end.

use nalgebra::Point2;
use serde_json::{Value, json};

use crate::geom::sides_of;
use crate::map::{Door, Region, Topology};

/// Why no file can be written: no region is known.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("no room is known yet; expected at least one region of free floor")]
pub struct NoRooms;

/// Rooms, corridors and doors as a collection of features.
///
/// # Errors    [`NoRooms`].
pub fn geojson(topology: &Topology) -> Result<String, NoRooms> {
    if topology.regions().is_empty() {
        return Err(NoRooms);
    }
    let outlines = topology.outlines();
    let regions = topology.regions().iter().zip(&outlines).enumerate();
    let regions = regions.map(|(number, (region, rings))| region_feature(number, region, rings));
    let doors = topology.doors().iter().enumerate();
    let doors = doors.map(|(number, door)| door_feature(number, door));
    let collection = json!({
        "type": "FeatureCollection",
        "coordinates_are": "metres in the frame of the map: x forward, y left of where the robot began",
        "features": regions.chain(doors).collect::<Vec<_>>(),
    });
    Ok(format!("{collection:#}\n"))
}

fn region_feature(number: usize, region: &Region, rings: &[Vec<Point2<f64>>]) -> Value {
    json!({
        "type": "Feature",
        "id": format!("region-{number}"),
        "geometry": { "type": "MultiPolygon", "coordinates": polygons(rings) },
        "properties": {
            "kind": region.kind.name(),
            "area_m2": region.area,
            "width_m": region.width,
            "elongation": region.elongation,
            "centre": [region.centre.x, region.centre.y],
            "doors": region.doors.iter().map(|door| format!("door-{door}")).collect::<Vec<_>>(),
        },
    })
}

fn door_feature(number: usize, door: &Door) -> Value {
    let [a, b] = [door.posts.a, door.posts.b];
    json!({
        "type": "Feature",
        "id": format!("door-{number}"),
        "geometry": { "type": "LineString", "coordinates": [[a.x, a.y], [b.x, b.y]] },
        "properties": {
            "kind": "door",
            "width_m": door.width,
            "between": door.regions.map(|region| format!("region-{region}")),
            "both_posts_seen": door.is_framed,
        },
    })
}

/// A polygon for each outer ring, with the holes that lie in it.
fn polygons(rings: &[Vec<Point2<f64>>]) -> Vec<Vec<Vec<[f64; 2]>>> {
    let outer = rings.iter().filter(|ring| signed_area(ring) > 0.0);
    let polygon = |outer: &Vec<Point2<f64>>| {
        let holes = rings.iter().filter(|ring| signed_area(ring) <= 0.0);
        let holes = holes.filter(|hole| hole.first().is_some_and(|at| is_inside(outer, *at)));
        let rings = std::iter::once(outer).chain(holes);
        rings.map(|ring| closed(ring)).collect()
    };
    outer.map(polygon).collect()
}

fn closed(ring: &[Point2<f64>]) -> Vec<[f64; 2]> {
    let again = ring.first();
    ring.iter().chain(again).map(|at| [at.x, at.y]).collect()
}

/// Positive for a counter-clockwise ring.
fn signed_area(ring: &[Point2<f64>]) -> f64 {
    let crosses = sides_of(ring).map(|(a, b)| a.x * b.y - b.x * a.y);
    0.5 * crosses.sum::<f64>()
}

/// By how often a ray to the east crosses the ring.
fn is_inside(ring: &[Point2<f64>], at: Point2<f64>) -> bool {
    let crosses = |(a, b): &(&Point2<f64>, &Point2<f64>)| {
        (a.y > at.y) != (b.y > at.y) && at.x < a.x + (at.y - a.y) / (b.y - a.y) * (b.x - a.x)
    };
    sides_of(ring).filter(crosses).count() % 2 == 1
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::Length;
    use crate::map::{CellIndex, CellRect, CellState, TopologyConfig};

    /// Two rooms of 4 m x 3 m, a door of 0.9 m between them, a pillar in the first; cells of 5 cm.
    fn topology() -> Topology {
        let (width, height) = (170, 64);
        let state = |index: i32| {
            let (col, row) = (index % width, index / width);
            let is_room =
                (2..62).contains(&row) && ((2..82).contains(&col) || (86..166).contains(&col));
            let is_door = (82..86).contains(&col) && (20..38).contains(&row);
            let is_pillar = (30..38).contains(&col) && (30..38).contains(&row);
            match (is_room || is_door) && !is_pillar {
                true => CellState::Free,
                false => CellState::Occupied,
            }
        };
        let states: Vec<_> = (0..width * height).map(state).collect();
        let rect = CellRect {
            min: CellIndex { col: 0, row: 0 },
            max: CellIndex::new(width, height),
        };
        Topology::of_cells(rect, 0.05, &states, &TopologyConfig::default())
    }

    fn ring_area(ring: &Value) -> f64 {
        let points: Vec<Point2<f64>> = ring.as_array().unwrap().iter().map(point).collect();
        assert_eq!(points.first(), points.last());
        signed_area(&points)
    }

    fn point(value: &Value) -> Point2<f64> {
        Point2::new(value[0].as_f64().unwrap(), value[1].as_f64().unwrap())
    }

    #[test]
    fn rooms_are_polygons_of_their_area_and_doors_lines_of_their_width() {
        let text = geojson(&topology()).unwrap();
        let file: Value = serde_json::from_str(&text).unwrap();
        let features = file["features"].as_array().unwrap();
        let kinds: Vec<_> = features
            .iter()
            .map(|f| f["properties"]["kind"].as_str().unwrap())
            .collect();
        assert_eq!(kinds, ["room", "room", "door"]);
        for feature in &features[..2] {
            let polygons = feature["geometry"]["coordinates"].as_array().unwrap();
            assert_eq!(polygons.len(), 1);
            let rings = polygons[0].as_array().unwrap();
            let area: f64 = rings.iter().map(ring_area).sum();
            let stated = feature["properties"]["area_m2"].as_f64().unwrap();
            assert!((area - stated).abs() < 0.03 * stated, "{area} {stated}");
            assert!(ring_area(&rings[0]) > 11.0);
        }
        let holes = |feature: &Value| {
            feature["geometry"]["coordinates"][0]
                .as_array()
                .unwrap()
                .len()
                - 1
        };
        assert_eq!(features[..2].iter().map(holes).sum::<usize>(), 1);
        let door = &features[2];
        let ends = [0, 1].map(|i| point(&door["geometry"]["coordinates"][i]));
        let width = door["properties"]["width_m"].as_f64().unwrap();
        assert!(((ends[1] - ends[0]).length() - width).abs() < 1e-9 && (width - 0.9).abs() < 0.06);
        assert_eq!(
            door["properties"]["between"],
            json!(["region-0", "region-1"])
        );
    }

    #[test]
    fn without_a_room_there_is_no_file() {
        let rect = CellRect {
            min: CellIndex { col: 0, row: 0 },
            max: CellIndex { col: 9, row: 9 },
        };
        let none = Topology::of_cells(rect, 0.05, &[], &TopologyConfig::default());
        assert_eq!(geojson(&none), Err(NoRooms));
    }
}
