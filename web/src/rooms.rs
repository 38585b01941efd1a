//! Rooms, corridors and doors, flattened for the page.

use nalgebra::Point2;
use slamlab_core::map::{Door, Grid, Region, RegionKind, Topology, TopologyConfig};
use wasm_bindgen::prelude::wasm_bindgen;

/// The topological map; strides as of `Rooms` in www/src/protocol/rooms.ts, map frame, m.
#[wasm_bindgen(getter_with_clone)]
#[derive(Clone, Debug, PartialEq)]
pub struct Rooms {
    /// Of each region: kind (0 room, 1 corridor), area (m²), x and y of its middle, width (m).
    pub regions: Vec<f64>,
    /// Of each door: the two regions, x1 y1 x2 y2 of its posts, x and y of its middle, width (m), whether both posts were seen.
    pub doors: Vec<f64>,
    /// x y of the corners of all outlines.
    pub corners: Vec<f32>,
    /// Of each outline its region and number of corners.
    pub rings: Vec<u32>,
    /// Version of the grid that they are of.
    pub generation: u32,
    /// Its revision.
    pub revision: f64,
}

impl Rooms {
    /// What a version of a grid holds.
    pub(crate) fn of(grid: &Grid, generation: u32) -> Self {
        let topology = Topology::of_grid(grid, &TopologyConfig::default());
        let mut rooms = Self {
            regions: topology.regions().iter().flat_map(region).collect(),
            doors: topology.doors().iter().flat_map(door).collect(),
            corners: vec![],
            rings: vec![],
            generation,
            revision: grid.revision() as f64,
        };
        for (number, outlines) in topology.outlines().iter().enumerate() {
            for ring in outlines {
                rooms.rings.extend([number as u32, ring.len() as u32]);
                rooms.corners.extend(ring.iter().flat_map(corner));
            }
        }
        rooms
    }
}

fn region(region: &Region) -> [f64; 5] {
    let kind = match region.kind {
        RegionKind::Room => 0.0,
        RegionKind::Corridor => 1.0,
    };
    let centre = region.centre;
    [kind, region.area, centre.x, centre.y, region.width]
}

fn door(door: &Door) -> [f64; 10] {
    let ([from, to], (a, b)) = (door.regions, (door.posts.a, door.posts.b));
    let middle = a + (b - a) * 0.5;
    let framed = f64::from(u8::from(door.is_framed));
    [
        from as f64,
        to as f64,
        a.x,
        a.y,
        b.x,
        b.y,
        middle.x,
        middle.y,
        door.width,
        framed,
    ]
}

fn corner(at: &Point2<f64>) -> [f32; 2] {
    [at.x as f32, at.y as f32]
}
