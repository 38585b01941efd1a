//! Rooms, corridors and doors, for the page.

use serde::{Deserialize, Serialize};
use slamlab_core::map::{self, Grid, Topology, TopologyConfig};
use tsify::{Ts, Tsify};
use wasm_bindgen::prelude::wasm_bindgen;

use crate::border::{Float32Array, RegionName, WebError, typed};
use crate::run::WebRun;
use crate::view::polyline;

/// The topological map: rooms, corridors and doors; map frame, m.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Tsify)]
pub struct Rooms {
    /// Rooms and corridors, the largest first.
    pub regions: Vec<Region>,
    /// The doors between them.
    pub doors: Vec<Doorway>,
    /// Version of the grid that they are derived from.
    pub generation: u32,
    /// Its revision.
    pub revision: f64,
}

/// A room or a corridor.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Tsify)]
pub struct Region {
    /// Room or corridor.
    pub kind: RegionName,
    /// Free floor, m².
    pub area: f64,
    /// x y of a point in its middle.
    pub middle: [f64; 2],
    /// Distance between its walls.
    pub width: f64,
    /// x y of the corners of each outline.
    pub outlines: Vec<Float32Array>,
}

/// A door between two regions.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Tsify)]
pub struct Doorway {
    /// The indices of its two regions.
    pub regions: [u32; 2],
    /// x1 y1 x2 y2 of its posts.
    pub posts: [f64; 4],
    /// x y of the point between them.
    pub middle: [f64; 2],
    /// Distance between the posts.
    pub width: f64,
    /// Whether both posts were seen.
    pub framed: bool,
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
    /// The topological map of this version of a grid.
    pub(crate) fn of(grid: &Grid, generation: u32) -> Self {
        let topology = Topology::of_grid(grid, &TopologyConfig::default());
        let regions = topology.regions().iter().zip(topology.outlines());
        let regions = regions.map(|(region, outlines)| Region {
            kind: (&region.kind).into(),
            area: region.area,
            middle: region.centre.into(),
            width: region.width,
            outlines: outlines.iter().map(|ring| polyline(ring).into()).collect(),
        });
        Self {
            regions: regions.collect(),
            doors: topology.doors().iter().map(Into::into).collect(),
            generation,
            revision: grid.revision() as f64,
        }
    }
}

impl From<&map::Door> for Doorway {
    fn from(door: &map::Door) -> Self {
        let (a, b) = (door.posts.a, door.posts.b);
        Self {
            regions: door.regions.map(|region| region as u32),
            posts: [a.x, a.y, b.x, b.y],
            middle: (a + (b - a) * 0.5).into(),
            width: door.width,
            framed: door.is_framed,
        }
    }
}
