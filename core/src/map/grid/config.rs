//! Settings of the grid, and why some cannot be used.

use super::FreeCells;

/// How sightings change the grid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GridConfig {
    /// Side of a cell, m. Default 0.05; smaller is sharper and slower.
    pub resolution: f64,
    /// Probability that a cell is occupied given that a beam ended in it. Default 0.7 (lidar); Celej's preset is 0.8.
    pub hit: f64,
    /// Probability that a cell is occupied given that a beam crossed it. Default 0.4 (lidar); Celej's preset is 0.2.
    pub miss: f64,
    /// Probabilities are kept in [`clamp`, 1 - `clamp`]. Default 0.02; larger changes its mind sooner.
    pub clamp: f64,
    /// Cells count as occupied above this probability. Default 0.65, as in ROS map_server.
    pub occupied_above: f64,
    /// Cells count as free below this probability. Default 0.35.
    pub free_below: f64,
    /// How the cells that a scan leaves free are found. Default [`FreeCells::Crossed`].
    pub free_cells: FreeCells,
    /// Most blocks the grid may hold; beams beyond are dropped; [`super::Grid::is_whole`] says so. Default 65 536 blocks, 268 million cells, 0.67 km² at 5 cm.
    /// Streets, halls and rooms that were seen for a while take a third of a gigabyte; 1.1 GB if there is something in every block.
    pub max_blocks: usize,
}

impl Default for GridConfig {
    fn default() -> Self {
        Self {
            resolution: 0.05,
            hit: 0.7,
            miss: 0.4,
            clamp: 0.02,
            occupied_above: 0.65,
            free_below: 0.35,
            free_cells: FreeCells::default(),
            max_blocks: 65_536,
        }
    }
}

/// Why a [`GridConfig`] cannot be used.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum GridError {
    /// A field outside of its range.
    #[error("grid: {field} is {value}, expected {expected}")]
    Config {
        /// The field.
        field: &'static str,
        /// What stands there.
        value: f64,
        /// What may stand there.
        expected: &'static str,
    },
    /// Something was seen where the grid may not grow.
    #[error("grid: holds {blocks} blocks of at most {max_blocks}; what was seen beyond is skipped")]
    Full {
        /// Blocks that it holds.
        blocks: usize,
        /// Most that it may hold.
        max_blocks: usize,
    },
}

impl GridConfig {
    /// Celej's own figures: prior 0.5, hit 0.8, miss 0.2.
    #[must_use]
    pub fn celej() -> Self {
        Self {
            hit: 0.8,
            miss: 0.2,
            ..Self::default()
        }
    }

    /// # Errors    [`GridError::Config`] naming the first field out of range.
    pub fn validate(&self) -> Result<(), GridError> {
        let check = |field, value: f64, low: f64, high: f64, expected| {
            if value > low && value < high {
                Ok(())
            } else {
                Err(GridError::Config {
                    field,
                    value,
                    expected,
                })
            }
        };
        check(
            "resolution",
            self.resolution,
            1e-3,
            10.0,
            "between 0.001 and 10 m",
        )?;
        check("hit", self.hit, 0.5, 1.0, "between 0.5 and 1")?;
        check("miss", self.miss, 0.0, 0.5, "between 0 and 0.5")?;
        check("clamp", self.clamp, 0.0, 0.5, "between 0 and 0.5")?;
        check(
            "occupied_above",
            self.occupied_above,
            0.5,
            1.0,
            "between 0.5 and 1",
        )?;
        check("free_below", self.free_below, 0.0, 0.5, "between 0 and 0.5")
    }
}
