//! ROS map_server: an occupancy grid as an image (PGM or PNG) and a YAML file that says where the
//! image lies.
//!
//! In: a [`Grid`], or the bytes of both files. Out: both files, or an [`OccupancyMap`].
//!
//! 1. A map is what ROS calls `nav_msgs/OccupancyGrid`: each cell is a percentage or unknown
//!    ([`OccupancyMap`]).
//! 2. The YAML names the image, by a path relative to itself, and gives its scale, its position and
//!    the meaning of its greys ([`MapInfo`]).
//! 3. Rows of the image run from the top of the map (largest y) down. Dark is occupied, unless
//!    `negate` is set.
//! 4. What a grey means depends on the mode:
//!
//! | mode | written | read |
//! |---|---|---|
//! | `trinary` | 0 occupied, 205 unknown, 254 free | darker than `occupied_thresh` is occupied, lighter than `free_thresh` free |
//! | `scale` | 255 (1 - p), transparent where unknown (PNG only) | the same thresholds; between them p is stretched to 0 to 100 % |
//! | `raw` | the percentage itself, 255 where unknown | the percentage itself; above 100 is unknown |
//!
//! Source: ROS 2 Navigation, `nav2_map_server`, `map_io.cpp` (functions `loadMapFromFile` and
//! `tryWriteMapToFile`), whose behaviour this follows; ROS `map_server` documentation. There are
//! three differences: `scale` is written with thresholds of 0 and 1, so what is read back equals
//! what was written; `scale` as PGM, which has no transparency, is refused; and sizes are checked
//! before memory is allocated.

mod error;
mod pgm;
mod png_file;
mod read;
#[cfg(test)]
mod tests;
mod write;
mod yaml;

use std::path::{Path, PathBuf};
use std::str::FromStr;

use nalgebra::Point2;

use crate::geom::Pose2;
use crate::map::{CellIndex, CellRect, CellState, Grid};

pub use self::error::{MapImageError, MapInfoError, MapServerError};
pub use self::read::{read, read_image};
pub use self::write::{MapFiles, MapImage, write};

/// Grey of an occupied cell in mode `trinary`.
pub const OCCUPIED: u8 = 0;
/// Grey of an unknown cell in mode `trinary`.
pub const UNKNOWN: u8 = 205;
/// Grey of a free cell in mode `trinary`.
pub const FREE: u8 = 254;
/// The value of an unknown cell in [`OccupancyMap::cells`].
pub const NOTHING_KNOWN: i8 = -1;
/// Maps with more cells than this are refused: a square kilometre in cells of 10 cm.
pub const MOST_CELLS: usize = super::MOST_CELLS;

/// What the greys of the image mean.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum MapMode {
    /// Three greys: occupied, unknown, free.
    #[default]
    Trinary,
    /// Greys between two thresholds are probabilities.
    Scale,
    /// Greys are percentages.
    Raw,
}

impl MapMode {
    /// All modes, with the names they have in YAML.
    pub const ALL: [(&'static str, Self); 3] = [
        ("trinary", Self::Trinary),
        ("scale", Self::Scale),
        ("raw", Self::Raw),
    ];
}

/// There is no mode of that name.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("there is no mode `{0}` of a map; expected trinary, scale or raw")]
pub struct UnknownMapMode(String);

impl FromStr for MapMode {
    type Err = UnknownMapMode;

    fn from_str(name: &str) -> Result<Self, UnknownMapMode> {
        let found = Self::ALL.into_iter().find(|(known, _)| *known == name);
        let mode = found.map(|(_, mode)| mode);
        mode.ok_or_else(|| UnknownMapMode(name.to_owned()))
    }
}

/// The YAML file of a map.
#[derive(Clone, Debug, PartialEq)]
pub struct MapInfo {
    /// Path of the image; a relative one starts at the folder of the YAML file.
    pub image: String,
    /// What its greys mean.
    pub mode: MapMode,
    /// Side of a cell, m.
    pub resolution: f64,
    /// `map_from_image`: the lower left corner of the lower left cell, and the direction of the
    /// rows.
    pub origin: Pose2,
    /// Whether light is occupied and dark is free. Mode `raw` ignores it.
    pub negate: bool,
    /// Cells with a higher probability are occupied.
    pub occupied_thresh: f64,
    /// Cells with a lower probability are free.
    pub free_thresh: f64,
}

impl MapInfo {
    /// Reads the YAML file.
    ///
    /// # Errors    [`MapInfoError`], with the line: not YAML, a key that is missing or appears
    /// twice, or an invalid value.
    pub fn parse(yaml: &[u8]) -> Result<Self, MapInfoError> {
        yaml::parse(yaml)
    }

    /// Where the image lies if the YAML file lies at `yaml`.
    #[must_use]
    pub fn image_beside(&self, yaml: &Path) -> PathBuf {
        yaml.parent().unwrap_or(Path::new("")).join(&self.image)
    }
}

/// A map as in ROS: `nav_msgs/OccupancyGrid`.
#[derive(Clone, Debug, PartialEq)]
pub struct OccupancyMap {
    /// Cells in a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Side of a cell, m.
    pub resolution: f64,
    /// The lower left corner of the lower left cell in the map frame, and the direction of the
    /// rows.
    pub origin: Pose2,
    /// Percentage of being occupied, 0 to 100, or [`NOTHING_KNOWN`]; row by row from the bottom.
    pub cells: Vec<i8>,
}

impl OccupancyMap {
    /// The known part of a grid. In mode [`MapMode::Trinary`] each cell is 0, 100 or unknown, as
    /// the grid believes; otherwise it is the probability.
    ///
    /// # Errors    [`MapServerError`]: a grid without known cells, or whose known cells lie too far
    /// apart.
    pub fn of_grid(grid: &Grid, mode: MapMode) -> Result<Self, MapServerError> {
        let rect = known_rect(grid, |odds| match mode {
            MapMode::Trinary => grid.state_of(odds) != CellState::Unknown,
            MapMode::Scale | MapMode::Raw => odds != 0.0,
        })?;
        let resolution = grid.resolution();
        let corner = |cell: i32| f64::from(cell) * resolution;
        Ok(Self {
            width: rect.width(),
            height: rect.height(),
            resolution,
            origin: Pose2::new(corner(rect.min.col), corner(rect.min.row), 0.0),
            cells: rect
                .cells()
                .map(|cell| occupancy(grid, cell, mode))
                .collect(),
        })
    }

    /// The centres of the cells that are more likely occupied than not, map frame.
    #[must_use]
    pub fn occupied(&self) -> Vec<Point2<f64>> {
        let middle = |at: usize| {
            let (row, col) = (at / self.width.max(1), at % self.width.max(1));
            let [x, y] = [col, row].map(|cell| (cell as f64 + 0.5) * self.resolution);
            self.origin * Point2::new(x, y)
        };
        let cells = self.cells.iter().enumerate();
        let occupied = cells.filter(|(_, cell)| **cell > 50);
        occupied.map(|(at, _)| middle(at)).collect()
    }
}

fn occupancy(grid: &Grid, cell: CellIndex, mode: MapMode) -> i8 {
    match mode {
        MapMode::Trinary => match grid.state(cell) {
            CellState::Occupied => 100,
            CellState::Free => 0,
            CellState::Unknown => NOTHING_KNOWN,
        },
        MapMode::Scale | MapMode::Raw if grid.log_odds(cell) == 0.0 => NOTHING_KNOWN,
        MapMode::Scale | MapMode::Raw => (100.0 * grid.probability(cell)).round() as i8,
    }
}

/// The smallest rectangle that holds all known cells.
///
/// # Errors    [`MapServerError::Empty`], [`MapServerError::TooLarge`].
pub(super) fn known_rect(
    grid: &Grid,
    is_known: impl Fn(f32) -> bool,
) -> Result<CellRect, MapServerError> {
    let rect = grid.rect_where(is_known).ok_or(MapServerError::Empty)?;
    let (width, height) = (rect.width(), rect.height());
    if width * height > MOST_CELLS {
        return Err(MapServerError::TooLarge { width, height });
    }
    Ok(rect)
}
