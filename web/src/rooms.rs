//! Rooms, corridors and doors, flattened for the page.

use nalgebra::Point2;
use serde::{Deserialize, Serialize};
use slamlab_core::map::{Door, Grid, Region, Topology, TopologyConfig};
use tsify::{Ts, Tsify};
use wasm_bindgen::prelude::wasm_bindgen;

use crate::border::{
    DoorwayRow, Float32Array, Float64Array, RegionName, RegionRow, Uint32Array, WebError, flat,
    typed,
};
use crate::run::WebRun;
use crate::view::flag;

/// The topological map: rooms, corridors and doors, the largest region first; map frame, m.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Tsify)]
pub struct Rooms {
    /// See `REGION`.
    pub regions: Float64Array,
    /// See `DOORWAY`.
    pub doors: Float64Array,
    /// x y of the corners of all outlines.
    pub corners: Float32Array,
    /// Of each outline its region and number of corners.
    pub rings: Uint32Array,
    /// Version of the grid that they are of.
    pub generation: u32,
    /// Its revision.
    pub revision: f64,
}

#[wasm_bindgen]
impl WebRun {
    /// Rooms, corridors and doors of the map, if the grid that the pose's sensor draws has changed
    /// since `revision` of `generation`. Costs more than a step.
    ///
    /// # Errors    None that a page can cause.
    pub fn rooms(&self, generation: u32, revision: f64) -> Result<Option<Ts<Rooms>>, WebError> {
        let (grid, now) = (self.slam().grid(), self.slam().grid_version() as u32);
        let is_known = now == generation && grid.revision() == revision as u64;
        let rooms = (!is_known).then(|| Rooms::of(grid, now));
        rooms.as_ref().map(typed).transpose()
    }
}

impl Rooms {
    /// What a version of a grid holds.
    pub(crate) fn of(grid: &Grid, generation: u32) -> Self {
        let topology = Topology::of_grid(grid, &TopologyConfig::default());
        let (mut corners, mut rings) = (vec![], vec![]);
        for (number, outlines) in topology.outlines().iter().enumerate() {
            for ring in outlines {
                rings.extend([number as u32, ring.len() as u32]);
                corners.extend(ring.iter().flat_map(corner));
            }
        }
        Self {
            regions: flat(topology.regions().iter().map(region)),
            doors: flat(topology.doors().iter().map(door)),
            corners: corners.into(),
            rings: rings.into(),
            generation,
            revision: grid.revision() as f64,
        }
    }
}

fn region(region: &Region) -> RegionRow {
    RegionRow {
        kind: f64::from(RegionName::from(&region.kind) as u8),
        area: region.area,
        x: region.centre.x,
        y: region.centre.y,
        width: region.width,
    }
}

fn door(door: &Door) -> DoorwayRow {
    let ([from, to], (a, b)) = (door.regions, (door.posts.a, door.posts.b));
    let middle = a + (b - a) * 0.5;
    DoorwayRow {
        from: from as f64,
        to: to as f64,
        x1: a.x,
        y1: a.y,
        x2: b.x,
        y2: b.y,
        x: middle.x,
        y: middle.y,
        width: door.width,
        framed: flag(door.is_framed),
    }
}

fn corner(at: &Point2<f64>) -> [f32; 2] {
    [at.x as f32, at.y as f32]
}
