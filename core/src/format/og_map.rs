//! `OGmap.txt`: an occupancy grid as text, the file that Celej's programs exchange.
//!
//! In: a [`Grid`]. Out: a line `width height resolution origin_x origin_y` (cells, m), then a line
//! for each row of cells from the bottom, with the probability of an obstacle in each cell from
//! left to right; 0.5 where unknown. And back.
//!
//! Source: Celej §4 names the file but not its layout; this layout is from the project's
//! specification.

#[cfg(test)]
mod tests;

use std::fmt::Write as _;

use nalgebra::Point2;

use super::field_error::{number, read};
use super::map_server::{MapServerError, NOTHING_KNOWN, OccupancyMap, known_rect};
use super::{FieldError, MOST_CELLS};
use crate::geom::Pose2;
use crate::map::Grid;

/// A map as it stands in the file.
#[derive(Clone, Debug, PartialEq)]
pub struct OgMap {
    /// Cells in a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Side of a cell, m.
    pub resolution: f64,
    /// Lower left corner of the first cell, map frame, m.
    pub origin: Point2<f64>,
    /// Probability of an obstacle in each cell, row by row from the bottom.
    pub probabilities: Vec<f64>,
}

impl From<OgMap> for OccupancyMap {
    /// Converts to percentages; one half becomes unknown.
    fn from(map: OgMap) -> Self {
        let percentage = |p: f64| match p {
            0.5 => NOTHING_KNOWN,
            p => (100.0 * p).round() as i8,
        };
        Self {
            width: map.width,
            height: map.height,
            resolution: map.resolution,
            origin: Pose2::new(map.origin.x, map.origin.y, 0.0),
            cells: map.probabilities.into_iter().map(percentage).collect(),
        }
    }
}

/// The rectangle of all known cells of a grid.
///
/// # Errors    [`MapServerError::Empty`], [`MapServerError::TooLarge`].
pub fn of_grid(grid: &Grid) -> Result<OgMap, MapServerError> {
    let rect = known_rect(grid, |odds| odds != 0.0)?;
    let resolution = grid.resolution();
    Ok(OgMap {
        width: rect.width(),
        height: rect.height(),
        resolution,
        origin: Point2::new(f64::from(rect.min.col), f64::from(rect.min.row)) * resolution,
        probabilities: rect.cells().map(|cell| grid.probability(cell)).collect(),
    })
}

/// The text of the file: probabilities with four digits.
#[must_use]
pub fn write(map: &OgMap) -> String {
    let (width, Point2 { coords: at }) = (map.width, map.origin);
    let mut text = format!(
        "{width} {} {} {} {}\n",
        map.height, map.resolution, at.x, at.y
    );
    for row in map.probabilities.chunks(width.max(1)) {
        for (col, p) in row.iter().enumerate() {
            // Writing to a string does not fail.
            let _ = write!(text, "{}{p:.4}", if col == 0 { "" } else { " " });
        }
        text.push('\n');
    }
    text
}

/// Reads such a file; any spaces and line ends are accepted, empty lines are skipped.
///
/// # Errors    [`FieldError`]: an invalid number, or a line or a file with a different number of
/// them than the first line says; sizes are checked before memory is allocated.
pub fn parse(bytes: &[u8]) -> Result<OgMap, FieldError> {
    let text = String::from_utf8_lossy(bytes);
    let lines = (1..).zip(text.lines());
    let mut lines = lines.filter(|(_, line)| !line.trim().is_empty());
    let mut map = header(lines.next().map_or("", |(_, line)| line))?;
    let (expected, mut found, mut last) = (map.height, 0, 1);
    for (line, row) in lines {
        (found, last) = (found + 1, line);
        if found > expected {
            break;
        }
        read_row(line, row, &mut map)?;
    }
    if found != expected {
        let (found, expected) = (found.to_string(), format!("{expected} as line 1 says"));
        return Err(FieldError::new(
            last,
            "the number of rows",
            &found,
            expected,
        ));
    }
    Ok(map)
}

fn header(line: &str) -> Result<OgMap, FieldError> {
    let words: Vec<&str> = line.split_whitespace().collect();
    let &[width, height, resolution, x, y] = words.as_slice() else {
        let expected = "5: width height resolution origin_x origin_y";
        return Err(FieldError::count(1, words.len(), expected));
    };
    let count = |name, word| {
        let expected = "a whole number from 1 to 100000000";
        read(1, name, word, expected, |n| (1..=MOST_CELLS).contains(n))
    };
    let side = number(1, "resolution", resolution)?;
    if side <= 0.0 {
        return Err(FieldError::new(
            1,
            "resolution",
            resolution,
            "more than 0 m",
        ));
    }
    let (columns, rows): (usize, usize) = (count("width", width)?, count("height", height)?);
    let cells = columns.checked_mul(rows);
    if cells.is_none_or(|cells| cells > MOST_CELLS) {
        let expected = "at most 100000000 cells together";
        return Err(FieldError::new(1, "height", height, expected));
    }
    Ok(OgMap {
        width: columns,
        height: rows,
        resolution: side,
        origin: Point2::new(number(1, "origin_x", x)?, number(1, "origin_y", y)?),
        // Grows with what the file holds, not with what it promises.
        probabilities: vec![],
    })
}

fn read_row(line: usize, row: &str, map: &mut OgMap) -> Result<(), FieldError> {
    let before = map.probabilities.len();
    for (field, word) in (1..).zip(row.split_whitespace()) {
        let (field, expected) = (format_args!("field {field}"), "a number from 0 to 1");
        let p = read(line, field, word, expected, |p| (0.0..=1.0).contains(p))?;
        map.probabilities.push(p);
    }
    let (found, width) = (map.probabilities.len() - before, map.width);
    if found != width {
        let expected = format_args!("{width} as line 1 says");
        return Err(FieldError::count(line, found, expected));
    }
    Ok(())
}
