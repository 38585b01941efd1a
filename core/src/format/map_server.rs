//! ROS map_server: an occupancy grid as a PGM image and a YAML file that says where it lies.
//!
//! In: a [`Grid`]. Out: the bytes of both files. Occupied cells are black (0), free ones nearly white (254), unknown ones
//! grey (205). Rows of the image run from the top of the map (largest y) down.
//!
//! Source: ROS `map_server` documentation, mode `trinary`.

use crate::map::{CellIndex, CellRect, CellState, Grid};

/// Grey of an occupied cell.
pub const OCCUPIED: u8 = 0;
/// Grey of an unknown cell.
pub const UNKNOWN: u8 = 205;
/// Grey of a free cell.
pub const FREE: u8 = 254;

/// More cells than this are no map: a square kilometre in cells of 10 cm.
pub(super) const MOST_CELLS: usize = 100_000_000;

/// Why a grid cannot be written.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MapServerError {
    /// Nothing was ever inserted.
    #[error("the map is empty; expected at least one known cell")]
    Empty,
    /// What is known lies too far apart.
    #[error("the map is {width} times {height} cells; expected at most {MOST_CELLS} together")]
    TooLarge {
        /// Columns.
        width: usize,
        /// Rows.
        height: usize,
    },
}

/// The two files of a map.
#[derive(Clone, Debug, PartialEq)]
pub struct MapFiles {
    /// Binary PGM (P5).
    pub pgm: Vec<u8>,
    /// YAML; it names the image as given to [`write()`].
    pub yaml: String,
    /// Columns of the image.
    pub width: usize,
    /// Rows of the image.
    pub height: usize,
}

/// Writes the known part of a grid. `image_name` is the name under which the PGM will be stored.
///
/// # Errors   [`MapServerError`]: a grid without a known cell, or whose known cells lie too far apart.
pub fn write(grid: &Grid, image_name: &str) -> Result<MapFiles, MapServerError> {
    let rect = known_rect(grid).ok_or(MapServerError::Empty)?;
    let (width, height) = (rect.width(), rect.height());
    if width * height > MOST_CELLS {
        return Err(MapServerError::TooLarge { width, height });
    }
    let mut pgm = format!("P5\n# slamlab\n{width} {height}\n255\n").into_bytes();
    pgm.reserve(width * height);
    for row in (rect.min.row..rect.max.row).rev() {
        for col in rect.min.col..rect.max.col {
            pgm.push(match grid.state(CellIndex { col, row }) {
                CellState::Occupied => OCCUPIED,
                CellState::Free => FREE,
                CellState::Unknown => UNKNOWN,
            });
        }
    }
    let resolution = grid.resolution();
    let yaml = format!(
        "image: {}\nmode: trinary\nresolution: {resolution}\norigin: [{:.6}, {:.6}, 0]\nnegate: 0\n\
         occupied_thresh: {}\nfree_thresh: {}\n",
        yaml_string(image_name),
        f64::from(rect.min.col) * resolution,
        f64::from(rect.min.row) * resolution,
        grid.config().occupied_above,
        // Free cells are written as 254, which map_server reads as an occupancy of 1/255.
        grid.config().free_below.min(0.196),
    );
    Ok(MapFiles {
        pgm,
        yaml,
        width,
        height,
    })
}

/// A plain word as it stands; anything else in double quotes, escaped (YAML 1.2 §7.3.1: as in JSON).
fn yaml_string(text: &str) -> String {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || matches!(c, '.' | '_' | '-' | '/');
    if text.starts_with(|c: char| c.is_ascii_alphabetic()) && text.chars().all(is_plain) {
        text.to_owned()
    } else {
        serde_json::Value::from(text).to_string()
    }
}

/// The smallest rectangle that holds all cells that are not unknown; `None` of a grid without any.
#[must_use]
pub fn known_rect(grid: &Grid) -> Option<CellRect> {
    rect_of(grid, |odds| grid.state_of(odds) != CellState::Unknown)
}

/// The smallest rectangle that holds all cells with such log odds.
pub(super) fn rect_of(grid: &Grid, is_wanted: impl Fn(f32) -> bool) -> Option<CellRect> {
    let mut found: Option<CellRect> = None;
    let side = crate::map::BLOCK_CELLS as i32;
    for (block, cells) in grid.blocks_since(0) {
        for (offset, &odds) in cells.iter().enumerate() {
            if !is_wanted(odds) {
                continue;
            }
            let (col, row) = (
                block.col * side + offset as i32 % side,
                block.row * side + offset as i32 / side,
            );
            let rect = found.get_or_insert(CellRect {
                min: CellIndex { col, row },
                max: CellIndex {
                    col: col + 1,
                    row: row + 1,
                },
            });
            rect.min.col = rect.min.col.min(col);
            rect.min.row = rect.min.row.min(row);
            rect.max.col = rect.max.col.max(col + 1);
            rect.max.row = rect.max.row.max(row + 1);
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::Pose2;
    use crate::map::GridConfig;
    use crate::points::{Beam, Points};
    use crate::robot::Stamp;
    use nalgebra::Point2;

    #[test]
    fn top_row_of_the_image_is_the_top_of_the_map() {
        let mut grid = Grid::new(GridConfig {
            resolution: 0.5,
            ..GridConfig::default()
        })
        .unwrap();
        let beam = Beam {
            beam_idx: 0,
            origin_in_robot: Point2::new(0.25, 0.25),
            end_in_robot: Point2::new(0.25, 1.25),
            range: 1.0,
            sigma: 0.01,
            is_hit: true,
            quality: None,
        };
        let points = Points {
            stamp: Stamp(0),
            sensor_in_robot: Point2::origin(),
            bearing_sigma: 0.0,
            beams: vec![beam],
        };
        for _ in 0..4 {
            grid.insert(&points, &Pose2::identity());
        }
        let files = write(&grid, "map.pgm").unwrap();
        assert_eq!((files.width, files.height), (1, 3));
        assert!(files.pgm.ends_with(&[OCCUPIED, FREE, FREE]));
        assert!(files.pgm.starts_with(b"P5\n"));
        assert!(
            files.yaml.contains("image: map.pgm\n") && files.yaml.contains("resolution: 0.5\n")
        );
        assert!(files.yaml.contains("origin: [0.000000, 0.000000, 0]"));
    }

    #[test]
    fn odd_names_of_images_are_quoted() {
        for (name, written) in [
            ("map.pgm", "map.pgm"),
            ("my map: 1.pgm", "\"my map: 1.pgm\""),
            ("a#b.pgm", "\"a#b.pgm\""),
            ("1.5", "\"1.5\""),
            ("say \"hi\".pgm", "\"say \\\"hi\\\".pgm\""),
            ("Küche.pgm", "\"Küche.pgm\""),
            ("", "\"\""),
        ] {
            assert_eq!(yaml_string(name), written);
        }
    }

    #[test]
    fn an_empty_map_is_refused() {
        let grid = Grid::new(GridConfig::default()).unwrap();
        assert_eq!(write(&grid, "map.pgm"), Err(MapServerError::Empty));
    }
}
