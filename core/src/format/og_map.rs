//! `OGmap.txt`: an occupancy grid as text, what Celej's programs hand to each other.
//!
//! In: a [`Grid`]. Out: a line `width height resolution origin_x origin_y` (cells, m), then a line for each row of cells, the
//! lowest first, with the probability of an obstacle in each cell from left to right; 0.5 where nothing is known. And back.
//!
//! Source: Celej §4 names the file and leaves its layout open; this one is the specification's.

#[cfg(test)]
mod tests;

use std::fmt::Write as _;

use nalgebra::Point2;

use super::MOST_CELLS;
use super::map_server::{NOTHING_KNOWN, OccupancyMap};
use crate::geom::Pose2;
use crate::map::{CellIndex, Grid};

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
    /// Probability of an obstacle in each cell, row by row, the lowest first.
    pub probabilities: Vec<f64>,
}

impl From<OgMap> for OccupancyMap {
    /// Percentages instead of probabilities; one half is where nothing is known.
    fn from(map: OgMap) -> Self {
        let percentage = |p: f64| {
            if p == 0.5 {
                NOTHING_KNOWN
            } else {
                (100.0 * p).round() as i8
            }
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

/// Why a map cannot be written, or bytes are none.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum OgMapError {
    /// Nothing was ever seen.
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
    /// The first line is not five numbers.
    #[error("line 1: found {found} fields, expected 5: width height resolution origin_x origin_y")]
    Header {
        /// Number of fields.
        found: usize,
    },
    /// A field of the first line that cannot be.
    #[error("line 1: {name} is \"{found}\", expected {expected}")]
    HeaderField {
        /// Which one.
        name: &'static str,
        /// What stands there.
        found: String,
        /// What should.
        expected: &'static str,
    },
    /// A field that is no probability.
    #[error("line {line}, field {field} is \"{found}\", expected a number from 0 to 1")]
    Field {
        /// Line, from 1.
        line: usize,
        /// Field, from 1.
        field: usize,
        /// What stands there.
        found: String,
    },
    /// A row that is longer or shorter than the first line says.
    #[error("line {line}: found {found} cells, expected {expected} as line 1 says")]
    RowLength {
        /// Line, from 1.
        line: usize,
        /// Cells found.
        found: usize,
        /// Cells expected.
        expected: usize,
    },
    /// More or fewer rows than the first line says.
    #[error("found {found} rows, expected {expected} as line 1 says")]
    Rows {
        /// Rows found; counting ends with the first too many.
        found: usize,
        /// Rows expected.
        expected: usize,
    },
}

/// The rectangle of all that is known of a grid.
///
/// # Errors    [`OgMapError::Empty`], [`OgMapError::TooLarge`].
pub fn of_grid(grid: &Grid) -> Result<OgMap, OgMapError> {
    let known = grid.rect_where(|odds| odds != 0.0);
    let rect = known.ok_or(OgMapError::Empty)?;
    let (width, height) = (rect.width(), rect.height());
    if width * height > MOST_CELLS {
        return Err(OgMapError::TooLarge { width, height });
    }
    let resolution = grid.resolution();
    let rows = rect.min.row..rect.max.row;
    let cells =
        rows.flat_map(|row| (rect.min.col..rect.max.col).map(move |col| CellIndex { col, row }));
    Ok(OgMap {
        width,
        height,
        resolution,
        origin: Point2::new(f64::from(rect.min.col), f64::from(rect.min.row)) * resolution,
        probabilities: cells.map(|cell| grid.probability(cell)).collect(),
    })
}

/// The text of the file: four digits of a probability.
#[must_use]
pub fn write(map: &OgMap) -> String {
    let OgMap {
        width,
        height,
        resolution,
        origin,
        probabilities,
    } = map;
    let mut text = format!("{width} {height} {resolution} {} {}\n", origin.x, origin.y);
    for row in probabilities.chunks((*width).max(1)) {
        for (col, p) in row.iter().enumerate() {
            // Writing to a string does not fail.
            let _ = write!(text, "{}{p:.4}", if col == 0 { "" } else { " " });
        }
        text.push('\n');
    }
    text
}

/// Reads such a file; spaces and line ends may be any, empty lines are skipped.
///
/// # Errors    [`OgMapError`] with line and field; sizes are checked before memory is taken.
pub fn parse(bytes: &[u8]) -> Result<OgMap, OgMapError> {
    let text = String::from_utf8_lossy(bytes);
    let lines = (1..).zip(text.lines());
    let mut lines = lines.filter(|(_, line)| !line.trim().is_empty());
    let mut map = header(lines.next().map_or("", |(_, line)| line))?;
    let expected = map.height;
    let mut found = 0;
    for (line, row) in lines {
        found += 1;
        if found > expected {
            return Err(OgMapError::Rows { found, expected });
        }
        read_row(line, row, &mut map)?;
    }
    if found < expected {
        return Err(OgMapError::Rows { found, expected });
    }
    Ok(map)
}

fn header(line: &str) -> Result<OgMap, OgMapError> {
    let words: Vec<&str> = line.split_whitespace().collect();
    let &[width, height, resolution, x, y] = words.as_slice() else {
        let found = words.len();
        return Err(OgMapError::Header { found });
    };
    let wrong = |name, word: &str, expected| OgMapError::HeaderField {
        name,
        found: short(word),
        expected,
    };
    let count = |name, word: &str| {
        let number = word.parse().ok().filter(|n| (1..=MOST_CELLS).contains(n));
        number.ok_or_else(|| wrong(name, word, "a whole number from 1 to 100000000"))
    };
    let number = |name, word: &str| {
        let number = word.parse().ok().filter(|n: &f64| n.is_finite());
        number.ok_or_else(|| wrong(name, word, "a finite number"))
    };
    let side = number("resolution", resolution)?;
    if side <= 0.0 {
        return Err(wrong("resolution", resolution, "more than 0 m"));
    }
    let (columns, rows): (usize, usize) = (count("width", width)?, count("height", height)?);
    if columns
        .checked_mul(rows)
        .is_none_or(|cells| cells > MOST_CELLS)
    {
        return Err(wrong("height", height, "at most 100000000 cells together"));
    }
    Ok(OgMap {
        width: columns,
        height: rows,
        resolution: side,
        origin: Point2::new(number("origin_x", x)?, number("origin_y", y)?),
        // Grows with what the file holds, not with what it promises.
        probabilities: vec![],
    })
}

fn read_row(line: usize, row: &str, map: &mut OgMap) -> Result<(), OgMapError> {
    let before = map.probabilities.len();
    for (index, word) in row.split_whitespace().enumerate() {
        let p = word.parse().ok().filter(|p| (0.0..=1.0).contains(p));
        map.probabilities.push(p.ok_or_else(|| OgMapError::Field {
            line,
            field: index + 1,
            found: short(word),
        })?);
    }
    let found = map.probabilities.len() - before;
    if found == map.width {
        return Ok(());
    }
    Err(OgMapError::RowLength {
        line,
        found,
        expected: map.width,
    })
}

fn short(word: &str) -> String {
    word.chars().take(24).collect()
}
