//! Settings of the grid, and why some cannot be used.

use super::FreeCells;
use crate::bounds::{Bounds, OutOfBounds, check, config};

config! {
    /// How sightings change the grid.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct GridConfig {
        /// Side of a cell, m. Default 0.05; smaller is sharper and slower.
        pub resolution: f64 = 0.05,
        /// Probability that a cell is occupied given that a beam ended in it. Default 0.7 (lidar);
        /// Celej's preset is 0.8.
        pub hit: f64 = 0.7,
        /// Probability that a cell is occupied given that a beam crossed it. Default 0.4 (lidar);
        /// Celej's preset is 0.2.
        pub miss: f64 = 0.4,
        /// Probabilities are kept in [`clamp`, 1 - `clamp`]. Default 0.02; larger changes its mind
        /// sooner.
        pub clamp: f64 = 0.02,
        /// How the cells that a scan leaves free are found. Default [`FreeCells::Crossed`].
        pub free_cells: FreeCells = FreeCells::default(),
        /// Most blocks the grid may hold; beams beyond are dropped; [`super::Grid::is_whole`] says
        /// so. Default 65 536 blocks, 268 million cells, 0.67 km² at 5 cm. Streets, halls and rooms
        /// that were seen for a while take a third of a gigabyte; 1.1 GB if there is something in
        /// every block.
        pub max_blocks: usize = 65_536,
    }
}

/// Why a [`GridConfig`] cannot be used.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum GridError {
    /// A value of [`GridConfig`] is out of its bounds.
    #[error("grid: {0}")]
    Bounds(#[from] OutOfBounds),
    /// Something was seen where the grid may not grow.
    #[error("grid: holds {blocks} blocks of at most {max_blocks}; what was seen beyond is skipped")]
    Full {
        /// Number of blocks that it holds.
        blocks: usize,
        /// Greatest number that it may hold.
        max_blocks: usize,
    },
}

impl GridConfig {
    /// Celej's own values: prior 0.5, hit 0.8, miss 0.2.
    #[must_use]
    pub fn celej() -> Self {
        Self {
            hit: 0.8,
            miss: 0.2,
            ..Self::default()
        }
    }

    /// Bounds of [`Self::resolution`], m.
    pub const RESOLUTION: Bounds = [0.01, 0.5];
    /// Bounds of [`Self::hit`].
    pub const HIT: Bounds = [0.51, 0.99];
    /// Bounds of [`Self::miss`].
    pub const MISS: Bounds = [0.01, 0.49];
    /// Bounds of [`Self::clamp`].
    pub const CLAMP: Bounds = [0.001, 0.4];

    /// # Errors    [`GridError::Bounds`] naming the first value out of its bounds.
    pub fn validate(&self) -> Result<(), GridError> {
        Ok(check(&[
            ("resolution", self.resolution, Self::RESOLUTION),
            ("hit", self.hit, Self::HIT),
            ("miss", self.miss, Self::MISS),
            ("clamp", self.clamp, Self::CLAMP),
        ])?)
    }
}
