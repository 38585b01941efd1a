//! Maps: they own data, queries and insertion. They stand below association, registration and
//! estimation, because matching reads the map that it later writes.

mod beam;
mod cell;
mod distance;
mod evidence;
mod field;
mod grid;
mod layers;
mod likelihood;
mod line;
mod outline;
mod ray;
mod spread;
mod surfaces;
mod surfel_tiles;
mod surfels;
mod topology;
mod vector;
mod wall_distance;

pub use beam::{BeamFigures, LeafFigures, beam_among};
pub use cell::{BlockIndex, CellIndex, CellRect, CellState};
pub use distance::DistanceField;
pub use evidence::{Evidence, EvidenceConfig};
pub use field::{Field, FieldBlocks};
pub(crate) use grid::Canvas;
pub use grid::{BLOCK_CELLS, CellFigures, FreeCells, Grid, GridConfig, GridError, without_stripes};
pub use layers::{Layer, Layers};
pub use likelihood::LikelihoodPyramid;
pub(crate) use line::CellLine;
pub use outline::outlines;
pub use ray::cells_on_ray;
pub(crate) use spread::{Rings, cells_around, spread};
pub use surfaces::surfaces;
pub use surfel_tiles::SurfelTiles;
pub(crate) use surfels::SEEN_OFTEN;
pub use surfels::{FixedSurfels, Surfel, SurfelConfig, SurfelMap};
pub use topology::{Door, Region, RegionKind, Topology, TopologyConfig};
pub use vector::{Sighting, VectorMap, Wall};
pub use wall_distance::WallDistance;
