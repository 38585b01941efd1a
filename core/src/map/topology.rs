//! Rooms, corridors and the doors between them: the topological map.
//!
//! In: what a grid believes of its cells. Out: a [`Topology`]: regions of free floor with kind,
//! area and a place inside, the doors between them with their width, and to which region each cell
//! belongs.
//!
//! 1. Whatever is not free bounds the floor, unknown cells too. Exceptions are gaps between the far
//!    ends of beams, and islands no farther than `island` from their middle: tables, pillars and
//!    specks stand in a room, and do not divide it (`floor`).
//! 2. The exact distance transform gives the clearance of each cell. Its ridge is the Voronoi
//!    diagram of the walls, and its saddles are the critical points of the diagram: where the
//!    passage between two wider places is narrowest (Thrun 1998).
//! 3. The floor is flooded from its widest places down (the watershed of Vincent & Soille 1991,
//!    with a union-find instead of an immersion, so that no ridge need be thinned): two basins meet
//!    at such a saddle. They are united if it is wider than a door, or hardly narrower than the
//!    narrower of the two; otherwise it stays a border (`flood`). A wide way round unites them
//!    before a narrow one is met, so a gap between a table and a wall divides nothing.
//! 4. Cells of two basins that touch are a door; its posts are the wall nearest to its widest cell
//!    and the nearest wall opposite. Without walls for posts it is only the edge of what was seen,
//!    and divides nothing; a gap that no robot can pass is no door; a region too small for a room
//!    is merged into the neighbour with the widest door (`doors`, `unite`).
//! 5. A region is a corridor if it is much longer than wide: area over the square of the widest
//!    circle's diameter (`regions`).
//!
//! Sources: Thrun (1998), "Learning metric-topological maps for indoor mobile robot navigation";
//! Bormann et al. (2016), "Room segmentation: survey, implementation, and analysis", who compare
//! related methods. Linear in the number of cells, apart from the size of islands and doors. Limit:
//! a corridor as narrow as its doors does not become a region of its own.

mod disjoint_sets;
mod doors;
mod flood;
mod floor;
mod outline;
mod regions;
#[cfg(test)]
mod tests;
mod unite;

use nalgebra::Point2;

use self::floor::Floor;
use super::{CellIndex, CellRect, CellState, Grid};
use crate::bounds::config;
use crate::geom::Segment;

config! {
    /// What counts as a door, and as a room.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct TopologyConfig {
        /// Narrower gaps join nothing, m. Default 0.3: holes that noise makes in walls.
        pub narrowest_door: f64 = 0.3,
        /// Smaller regions are part of a neighbour, m². Default 2.
        pub least_area: f64 = 2.0,
        /// What stands free and reaches no farther from its middle is furniture, m. Default 0.9;
        /// larger: pieces of wall between two doors count as furniture.
        pub island: f64 = 0.9,
    }
}

/// What a region is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RegionKind {
    /// About as wide as long.
    Room,
    /// Much longer than wide: it leads somewhere.
    Corridor,
}

impl RegionKind {
    /// Its name in files and on the page.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Room => "room",
            Self::Corridor => "corridor",
        }
    }
}

/// A part of the floor that doors bound.
#[derive(Clone, Debug, PartialEq)]
pub struct Region {
    /// Room or corridor.
    pub kind: RegionKind,
    /// Free floor, m².
    pub area: f64,
    /// The free place in it farthest from everything, map frame, m.
    pub centre: Point2<f64>,
    /// Diameter of the widest circle between its walls, m, without furniture.
    pub width: f64,
    /// Area over the square of the width: how many times longer than wide.
    pub elongation: f64,
    /// Numbers of its doors, ascending.
    pub doors: Vec<usize>,
}

/// A narrow place between two regions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Door {
    /// Numbers of the regions it joins, ascending.
    pub regions: [usize; 2],
    /// The line from post to post, map frame, m.
    pub posts: Segment,
    /// Width from post to post, m: accurate to a cell, because posts stand anywhere within their
    /// cells.
    pub width: f64,
    /// A free place in it, map frame, m.
    pub centre: Point2<f64>,
    /// Whether walls were seen on both sides; otherwise unknown cells bound it.
    pub is_framed: bool,
}

impl Door {
    /// The region on the other side; `None` if the door does not belong to `from`.
    #[must_use]
    pub fn other(&self, from: usize) -> Option<usize> {
        match self.regions {
            [a, b] if a == from => Some(b),
            [a, b] if b == from => Some(a),
            _ => None,
        }
    }
}

/// Rooms, corridors and doors of a map.
#[derive(Clone, Debug, PartialEq)]
pub struct Topology {
    rect: CellRect,
    resolution: f64,
    regions: Vec<Region>,
    doors: Vec<Door>,
    /// Region of each cell of `rect`, in rows; [`NONE`] elsewhere.
    labels: Vec<u32>,
}

/// Label of cells that belong to no region.
const NONE: u32 = u32::MAX;

impl Topology {
    /// The topology of the whole grid.
    #[must_use]
    pub fn of_grid(grid: &Grid, config: &TopologyConfig) -> Self {
        let rect = grid.bounds().unwrap_or(CellRect::of_size(0, 0));
        Self::of_cells(rect, grid.resolution(), &grid.states(rect), config)
    }

    /// The topology of a rectangle of cells; regions are numbered by falling size.
    ///
    /// # Units    `resolution`: side of a cell, m. `states`: in rows from the lower left cell;
    /// cells beyond its end are unknown.
    #[must_use]
    pub fn of_cells(
        rect: CellRect,
        resolution: f64,
        states: &[CellState],
        config: &TopologyConfig,
    ) -> Self {
        let floor = Floor::new(rect, resolution, states, config);
        let basins = flood::basins(&floor);
        let gaps = doors::gaps(&floor, &basins);
        let plan = unite::unite(&floor, basins, &gaps, config);
        regions::gather(rect, &floor, &plan, &gaps, config)
    }

    /// All regions, the largest first.
    #[must_use]
    pub fn regions(&self) -> &[Region] {
        &self.regions
    }

    /// All doors.
    #[must_use]
    pub fn doors(&self) -> &[Door] {
        &self.doors
    }

    /// The cells it covers.
    #[must_use]
    pub fn rect(&self) -> CellRect {
        self.rect
    }

    /// Side of a cell, m.
    #[must_use]
    pub fn resolution(&self) -> f64 {
        self.resolution
    }

    /// Number of the region of a cell; `None` for walls, furniture, the unknown, and scraps of
    /// floor behind holes in walls.
    #[must_use]
    pub fn region_of(&self, cell: CellIndex) -> Option<usize> {
        let label = self.labels.get(self.rect.index_of(cell)?)?;
        (*label != NONE).then_some(*label as usize)
    }

    /// The region of each cell of [`Topology::rect`], in rows from the lower left one.
    pub fn cells(&self) -> impl Iterator<Item = Option<usize>> + '_ {
        let region = |&label: &u32| (label != NONE).then_some(label as usize);
        self.labels.iter().map(region)
    }
}
