//! What was mapped, as a prior map.

use slamlab_core::format::building::BuildingFile;
use slamlab_core::format::map_server::{MapMode, OccupancyMap};
use slamlab_core::slam::Slam;
use wasm_bindgen::prelude::wasm_bindgen;

use crate::border::{Typed, WebError, typed};
use crate::building::PriorMapFile;
use crate::run::{Source, WebRun};

#[wasm_bindgen]
impl WebRun {
    /// A prior map made of the present grid. A real robot is not put back to where the map began:
    /// it starts where it is.
    ///
    /// # Errors    A sentence on what the grid lacks.
    pub fn as_prior_map(&self, name: &str) -> Typed<PriorMapFile> {
        let mut file = PriorMapFile::of_grid(name, self.slam())?;
        if let Source::Live(_) = self.source {
            let pose = self.slam().estimate().pose;
            file.prior_map.start = [pose.x(), pose.y(), pose.heading()];
        }
        typed(&file)
    }
}

impl PriorMapFile {
    /// What was mapped, as a prior map: as if it had been saved for ROS and opened again.
    pub(crate) fn of_grid(name: &str, slam: &Slam) -> Result<Self, WebError> {
        let map = OccupancyMap::of_grid(slam.grid(), MapMode::Trinary)?;
        Self::of(name, &BuildingFile::Map(map))
    }
}
