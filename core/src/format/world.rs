//! World files: JSON, after the schema in [`SCHEMA`].
//!
//! ```
//! let text = r#"{
//!   "slamlab_world": 1,
//!   "name": "room",
//!   "start": { "x": 1.0, "y": 1.0, "heading": 0.0 },
//!   "goal": { "x": 3.0, "y": 2.0 },
//!   "robot": "rp6", "sensor": "lidar", "seed": 7,
//!   "obstacles": [
//!     { "shape": "polyline", "closed": true, "points": [[0, 0], [4, 0], [4, 3], [0, 3]] },
//!     { "shape": "rectangle", "centre": [2, 2], "size": [0.5, 0.3], "angle": 0.4, "material": "dark" },
//!     { "shape": "circle", "centre": [3, 1], "radius": 0.2 }
//!   ],
//!   "movers": [ { "waypoints": [[1, 2.5], [3, 2.5]], "speed": 0.5, "radius": 0.2 } ]
//! }"#;
//! let world = slamlab_core::format::world::read(text.as_bytes())?;
//! assert_eq!(world.walls().len(), 4 + 4 + 23);
//! # Ok::<(), slamlab_core::format::world::WorldFileError>(())
//! ```
//!
//! | field | meaning |
//! |---|---|
//! | `slamlab_world` | version of the format: 1 |
//! | `name` | for people, at most 200 bytes |
//! | `start` | pose of the robot, m and rad, world frame |
//! | `goal` | optional: where to go, m |
//! | `robot` | optional: `rp6` (default) or `pioneer` |
//! | `sensor` | optional: `lidar` (default), `sick`, `rangers` or `sonar` |
//! | `seed` | optional: whole number, default 1 |
//! | `obstacles` | `polyline` (`points`, optional `closed`), `polygon` (`points`), `rectangle` (`centre`, `size`, optional `angle`), `circle` (`centre`, `radius`); each with an optional `material`: `opaque` (default), `glass`, `dark` |
//! | `doors` | optional: `from`, `to` (ends of the shut leaf), optional `open` at time 0 (default false), optional `switches`: rising times, s, at each of which it opens or shuts |
//! | `movers` | optional: `waypoints`, `speed`, `radius`, optional `closed`, optional `pause` at each way-point, s |
//!
//! A field that is not in the table is refused, because it is more likely misspelt than meant.
//! Every error gives the line and column, counted from 1.

mod record;

use self::record::WorldFile;
use crate::sim::{World, WorldError};

/// JSON schema of a world file (2020-12), for editors.
pub const SCHEMA: &str = include_str!("world.schema.json");

/// Longest file that is read, bytes.
const LONGEST: usize = 64 << 20;

/// Why a world file cannot be read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum WorldFileError {
    /// The file is empty.
    #[error("world file: the file is empty, expected a JSON object")]
    Empty,
    /// The file is too long.
    #[error("world file: {bytes} bytes, expected at most {LONGEST}")]
    TooLong {
        /// Length of the file.
        bytes: usize,
    },
    /// Not JSON, or not of this shape.
    #[error("world file, line {line}, column {column}: {what}")]
    Syntax {
        /// Line, from 1.
        line: usize,
        /// Column, from 1.
        column: usize,
        /// What was found and what was expected.
        what: String,
    },
    /// An obstacle that lacks what its shape needs, or has a field of another shape.
    #[error("world file, line {line}: obstacle {index}: {what}")]
    Obstacle {
        /// Line on which it begins, from 1.
        line: usize,
        /// Its number, from 0.
        index: usize,
        /// What is wrong.
        what: String,
    },
    /// Well-formed, but not a world that a robot can be in.
    #[error("world file, line {line}: {source}")]
    World {
        /// Line on which the invalid part begins, from 1.
        line: usize,
        /// What is wrong.
        source: WorldError,
    },
}

/// What is wrong with a world, for a person who sees its drawing and no lines of text.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct WorldFault {
    /// The kind of the invalid part: `start`, `goal`, `world`, `obstacle`, `door` or `mover`;
    /// `file` if there is no world to draw at all.
    pub part: String,
    /// Its number from 0, if there are several of the kind.
    pub index: Option<usize>,
    /// What is wrong, in words.
    pub text: String,
}

impl From<&WorldFileError> for WorldFault {
    fn from(error: &WorldFileError) -> Self {
        let (part, index, text) = match error {
            WorldFileError::World { source, .. } => {
                let (part, index) = source.part();
                (part, index, source.to_string())
            }
            _ => ("file", None, error.to_string()),
        };
        Self {
            part: part.to_owned(),
            index,
            text,
        }
    }
}

/// Reads a world and checks that its robot can stand at the start.
///
/// # Errors    [`WorldFileError`], with the line of the error. Never panics, whatever the bytes.
pub fn read(bytes: &[u8]) -> Result<World, WorldFileError> {
    if bytes.len() > LONGEST {
        return Err(WorldFileError::TooLong { bytes: bytes.len() });
    }
    if bytes.iter().all(u8::is_ascii_whitespace) {
        return Err(WorldFileError::Empty);
    }
    let wrong = |(index, what)| WorldFileError::Obstacle {
        line: line_of_key(bytes, "obstacles", Some(index)).unwrap_or(1),
        index,
        what,
    };
    let world = parse(bytes)?.into_world().map_err(wrong)?;
    if let Err(source) = world.validate(world.robot.model().radius()) {
        let line = line_of_part(bytes, &source);
        return Err(WorldFileError::World { line, source });
    }
    Ok(world)
}

/// Writes a world. [`read`] gives back the same world to the bit, except for the heading (a pose
/// keeps sine and cosine).
#[must_use]
pub fn write(world: &World) -> String {
    // This cannot fail: no keys other than strings and no failing writers are involved.
    let mut text = serde_json::to_string_pretty(&WorldFile::from(world)).unwrap_or_default();
    text.push('\n');
    text
}

fn parse(bytes: &[u8]) -> Result<WorldFile, WorldFileError> {
    let syntax = |error: &serde_json::Error, what: String| WorldFileError::Syntax {
        line: error.line().max(1),
        column: error.column().max(1),
        what,
    };
    let mut json = serde_json::Deserializer::from_slice(bytes);
    let file =
        serde_path_to_error::deserialize(&mut json).map_err(|e| syntax(e.inner(), in_words(&e)))?;
    let more = "something stands after the end of the world";
    json.end().map_err(|e| syntax(&e, more.to_owned()))?;
    Ok(file)
}

/// Messages of serde in terms of Rust, and their meaning in plain words.
const PLAIN: [(&str, &str); 4] = [
    ("expected f64", "expected a number"),
    ("expected u32", "expected a whole number of 0 or more"),
    ("expected u64", "expected a whole number of 0 or more"),
    (
        "expected an array of length 2",
        "expected a pair of numbers [x, y]",
    ),
];

/// The part of the world that is wrong, and what is wrong with it; line and column are given
/// elsewhere.
fn in_words(error: &serde_path_to_error::Error<serde_json::Error>) -> String {
    let (inner, part) = (error.inner(), error.path().to_string());
    let text = inner.to_string();
    let place = format!(" at line {} column {}", inner.line(), inner.column());
    let text = text.strip_suffix(&place).unwrap_or(&text).to_owned();
    let in_plain = |text: String, (rust, plain): &(&str, &str)| text.replace(rust, plain);
    let text = PLAIN.iter().fold(text, in_plain);
    match part.as_str() {
        "." => text,
        part => format!("{part}: {text}"),
    }
}

/// The line on which the part that an error names begins: the key of the world, or the element of
/// its list.
fn line_of_part(bytes: &[u8], error: &WorldError) -> usize {
    let (kind, index) = error.part();
    let key = match index {
        Some(_) => format!("{kind}s"),
        None => kind.to_owned(),
    };
    line_of_key(bytes, &key, index).unwrap_or(1)
}

/// Line of a key of the outermost object, or of the `index`-th object in the list that is the key's
/// value.
fn line_of_key(bytes: &[u8], key: &str, index: Option<usize>) -> Option<usize> {
    let (mut depth, mut line, mut found, mut elements) = (0_i32, 1, false, 0);
    let mut rest = bytes.iter().enumerate();
    while let Some((at, &byte)) = rest.next() {
        match byte {
            b'\n' => line += 1,
            b'{' | b'[' => {
                if found && depth == 2 && byte == b'{' {
                    if Some(elements) == index {
                        return Some(line);
                    }
                    elements += 1;
                }
                depth += 1;
            }
            b'}' | b']' => depth -= 1,
            b'"' => {
                let mut escaped = false;
                let end = rest.find(|&(_, &b)| {
                    let ends = b == b'"' && !escaped;
                    escaped = b == b'\\' && !escaped;
                    ends
                })?;
                let text = bytes.get(at + 1..end.0)?;
                let after = bytes.get(end.0 + 1..)?;
                let is_key = after.iter().find(|b| !b.is_ascii_whitespace()) == Some(&b':');
                if depth == 1 && is_key {
                    found = text == key.as_bytes();
                    if found && index.is_none() {
                        return Some(line);
                    }
                }
            }
            _ => {}
        }
    }
    None
}

#[cfg(test)]
mod tests;
