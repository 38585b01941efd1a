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
//! | `movers` | optional: `waypoints`, `speed`, `radius`, optional `closed`, optional `pause` at each way-point, s |
//!
//! A field that is not in the table is refused: it is a misspelt one more often than a wish. Every error says the line
//! and column, counted from 1.

mod words;

use nalgebra::{Point2, Vector2};
use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize};

use crate::geom::Pose2;
use crate::sim::{Material, Mover, Obstacle, RobotKind, SensorKind, Shape, World, WorldError};

/// JSON schema of a world file (2020-12), for editors.
pub const SCHEMA: &str = include_str!("world.schema.json");

/// Longest file that is read, bytes.
const LONGEST: usize = 64 << 20;
/// Longest name, bytes.
const LONGEST_NAME: usize = 200;

/// Why a world file cannot be read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum WorldFileError {
    /// Nothing in it.
    #[error("world file: the file is empty, expected a JSON object")]
    Empty,
    /// Absurdly long.
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
    /// An obstacle that lacks what its shape needs, or has what belongs to another.
    #[error("world file, line {line}: obstacle {index}: {what}")]
    Obstacle {
        /// Line on which it begins, from 1.
        line: usize,
        /// Its number, from 0.
        index: usize,
        /// What is wrong.
        what: String,
    },
    /// Well-formed, but no world that a robot can be in.
    #[error("world file, line {line}: {source}")]
    World {
        /// Line on which the part in question begins, from 1.
        line: usize,
        /// What is wrong.
        source: WorldError,
    },
}

/// Reads a world and checks that its robot can stand at the start.
///
/// # Errors    [`WorldFileError`], with the line of what is wrong. Never panics, whatever the bytes.
pub fn read(bytes: &[u8]) -> Result<World, WorldFileError> {
    if bytes.len() > LONGEST {
        return Err(WorldFileError::TooLong { bytes: bytes.len() });
    }
    if bytes.iter().all(u8::is_ascii_whitespace) {
        return Err(WorldFileError::Empty);
    }
    let file = parse(bytes)?;
    let world = file
        .into_world()
        .map_err(|(index, what)| WorldFileError::Obstacle {
            line: line_of_key(bytes, "obstacles", Some(index)).unwrap_or(1),
            index,
            what,
        })?;
    match world.validate(world.robot.model().radius()) {
        Ok(()) => Ok(world),
        Err(source) => Err(WorldFileError::World {
            line: line_of_part(bytes, &source),
            source,
        }),
    }
}

/// Writes a world; [`read`] gives the same world back, all but the heading to the bit (a pose keeps sine and cosine).
#[must_use]
pub fn write(world: &World) -> String {
    // Neither maps with odd keys nor failing writers are involved: this cannot fail.
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
    let file = serde_path_to_error::deserialize(&mut json)
        .map_err(|e| syntax(e.inner(), words::in_words(e.path(), e.inner())))?;
    match json.end() {
        Ok(()) => Ok(file),
        Err(e) => Err(syntax(
            &e,
            "something stands after the end of the world".to_owned(),
        )),
    }
}

/// The line on which the part that an error names begins: the key of the world, or the element of its list.
fn line_of_part(bytes: &[u8], error: &WorldError) -> usize {
    let part = match error {
        WorldError::Value { part, .. } | WorldError::Count { part, .. } => part.as_str(),
        _ => "start",
    };
    let (key, index) = match part.split_once(' ') {
        Some((list, number)) => (format!("{list}s"), number.parse().ok()),
        None => (part.to_owned(), None),
    };
    line_of_key(bytes, &key, index).unwrap_or(1)
}

/// Line of a key of the outermost object, or of the `index`-th object in the list that is its value.
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

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct WorldFile {
    #[serde(deserialize_with = "version")]
    slamlab_world: u32,
    #[serde(deserialize_with = "name")]
    name: String,
    start: PoseFile,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    goal: Option<PointFile>,
    #[serde(default)]
    robot: RobotFile,
    #[serde(default)]
    sensor: SensorFile,
    #[serde(default = "first_seed")]
    seed: u64,
    obstacles: Vec<ObstacleFile>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    movers: Vec<MoverFile>,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct PoseFile {
    x: f64,
    y: f64,
    #[serde(default)]
    heading: f64,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct PointFile {
    x: f64,
    y: f64,
}

#[derive(Clone, Copy, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
enum RobotFile {
    #[default]
    Rp6,
    Pioneer,
}

#[derive(Clone, Copy, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
enum SensorFile {
    #[default]
    Lidar,
    Sick,
    Rangers,
    Sonar,
}

#[derive(Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
enum MaterialFile {
    #[default]
    Opaque,
    Glass,
    Dark,
}

#[derive(Clone, Copy, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
enum ShapeFile {
    Polyline,
    Polygon,
    Rectangle,
    Circle,
}

/// All shapes in one flat record: a tagged enum would lose the line of what is wrong inside of it.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct ObstacleFile {
    shape: ShapeFile,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    points: Option<Vec<[f64; 2]>>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    closed: Option<bool>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    centre: Option<[f64; 2]>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    size: Option<[f64; 2]>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    angle: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    radius: Option<f64>,
    #[serde(default, skip_serializing_if = "is_opaque")]
    material: MaterialFile,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct MoverFile {
    waypoints: Vec<[f64; 2]>,
    #[serde(default)]
    closed: bool,
    speed: f64,
    radius: f64,
    #[serde(default, skip_serializing_if = "is_zero")]
    pause: f64,
}

fn is_zero(number: &f64) -> bool {
    *number == 0.0
}

fn is_opaque(material: &MaterialFile) -> bool {
    *material == MaterialFile::Opaque
}

fn first_seed() -> u64 {
    1
}

fn version<'de, D: Deserializer<'de>>(from: D) -> Result<u32, D::Error> {
    match u32::deserialize(from)? {
        1 => Ok(1),
        other => Err(D::Error::custom(format!(
            "slamlab_world is {other}, expected 1"
        ))),
    }
}

fn name<'de, D: Deserializer<'de>>(from: D) -> Result<String, D::Error> {
    let name = String::deserialize(from)?;
    if name.len() <= LONGEST_NAME {
        return Ok(name);
    }
    let bytes = name.len();
    Err(D::Error::custom(format!(
        "name has {bytes} bytes, expected at most {LONGEST_NAME}"
    )))
}

impl ObstacleFile {
    fn into_obstacle(self) -> Result<Obstacle, String> {
        self.refuse_strangers()?;
        let material = self.material.into();
        let shape = match self.shape {
            ShapeFile::Polyline => Shape::Polyline {
                points: points(&need("polyline", "points", self.points)?),
                closed: self.closed.unwrap_or(false),
            },
            ShapeFile::Polygon => Shape::Polygon(points(&need("polygon", "points", self.points)?)),
            ShapeFile::Rectangle => Shape::Rectangle {
                centre: need("rectangle", "centre", self.centre)?.into(),
                size: Vector2::from(need("rectangle", "size", self.size)?),
                angle: self.angle.unwrap_or(0.0),
            },
            ShapeFile::Circle => Shape::Circle {
                centre: need("circle", "centre", self.centre)?.into(),
                radius: need("circle", "radius", self.radius)?,
            },
        };
        Ok(Obstacle { shape, material })
    }

    /// A field that belongs to another shape is a mistake.
    fn refuse_strangers(&self) -> Result<(), String> {
        let (kind, fields): (_, &[&str]) = match self.shape {
            ShapeFile::Polyline => ("polyline", &["points", "closed"]),
            ShapeFile::Polygon => ("polygon", &["points"]),
            ShapeFile::Rectangle => ("rectangle", &["centre", "size", "angle"]),
            ShapeFile::Circle => ("circle", &["centre", "radius"]),
        };
        let given = [
            ("points", self.points.is_some()),
            ("closed", self.closed.is_some()),
            ("centre", self.centre.is_some()),
            ("size", self.size.is_some()),
            ("angle", self.angle.is_some()),
            ("radius", self.radius.is_some()),
        ];
        match given
            .iter()
            .find(|(field, given)| *given && !fields.contains(field))
        {
            None => Ok(()),
            Some((field, _)) => Err(format!(
                "{kind} has the field `{field}`, expected only `{}`",
                fields.join("`, `")
            )),
        }
    }

    fn of(obstacle: &Obstacle) -> Self {
        let bare = |shape| Self {
            shape,
            points: None,
            closed: None,
            centre: None,
            size: None,
            angle: None,
            radius: None,
            material: obstacle.material.into(),
        };
        match &obstacle.shape {
            Shape::Polyline { points, closed } => Self {
                points: Some(pairs(points)),
                closed: closed.then_some(true),
                ..bare(ShapeFile::Polyline)
            },
            Shape::Polygon(points) => Self {
                points: Some(pairs(points)),
                ..bare(ShapeFile::Polygon)
            },
            Shape::Rectangle {
                centre,
                size,
                angle,
            } => Self {
                centre: Some([centre.x, centre.y]),
                size: Some([size.x, size.y]),
                angle: Some(*angle),
                ..bare(ShapeFile::Rectangle)
            },
            Shape::Circle { centre, radius } => Self {
                centre: Some([centre.x, centre.y]),
                radius: Some(*radius),
                ..bare(ShapeFile::Circle)
            },
        }
    }
}

fn need<T>(kind: &str, field: &str, value: Option<T>) -> Result<T, String> {
    value.ok_or_else(|| format!("{kind} lacks the field `{field}`"))
}

fn points(pairs: &[[f64; 2]]) -> Vec<Point2<f64>> {
    pairs.iter().map(|&p| p.into()).collect()
}

fn pairs(points: &[Point2<f64>]) -> Vec<[f64; 2]> {
    points.iter().map(|p| [p.x, p.y]).collect()
}

impl WorldFile {
    /// The world, or the number of the obstacle that is none and why.
    fn into_world(self) -> Result<World, (usize, String)> {
        let mover = |m: MoverFile| Mover {
            waypoints: points(&m.waypoints),
            closed: m.closed,
            speed: m.speed,
            radius: m.radius,
            pause: m.pause,
        };
        let obstacle =
            |(index, o): (usize, ObstacleFile)| o.into_obstacle().map_err(|e| (index, e));
        let obstacles: Result<_, _> = self
            .obstacles
            .into_iter()
            .enumerate()
            .map(obstacle)
            .collect();
        Ok(World {
            name: self.name,
            obstacles: obstacles?,
            movers: self.movers.into_iter().map(mover).collect(),
            start: Pose2::new(self.start.x, self.start.y, self.start.heading),
            goal: self.goal.map(|g| Point2::new(g.x, g.y)),
            robot: self.robot.into(),
            sensor: self.sensor.into(),
            seed: self.seed,
        })
    }
}

impl From<&World> for WorldFile {
    fn from(world: &World) -> Self {
        let mover = |m: &Mover| MoverFile {
            waypoints: pairs(&m.waypoints),
            closed: m.closed,
            speed: m.speed,
            radius: m.radius,
            pause: m.pause,
        };
        Self {
            slamlab_world: 1,
            name: world.name.clone(),
            start: PoseFile {
                x: world.start.x(),
                y: world.start.y(),
                heading: world.start.heading(),
            },
            goal: world.goal.map(|g| PointFile { x: g.x, y: g.y }),
            robot: world.robot.into(),
            sensor: world.sensor.into(),
            seed: world.seed,
            obstacles: world.obstacles.iter().map(ObstacleFile::of).collect(),
            movers: world.movers.iter().map(mover).collect(),
        }
    }
}

/// The same closed set on both sides of the file.
macro_rules! same_names {
    ($file:ident, $core:ident: $($variant:ident),+) => {
        impl From<$file> for $core {
            fn from(file: $file) -> Self {
                match file {
                    $($file::$variant => Self::$variant),+
                }
            }
        }
        impl From<$core> for $file {
            fn from(core: $core) -> Self {
                match core {
                    $($core::$variant => Self::$variant),+
                }
            }
        }
    };
}

same_names!(RobotFile, RobotKind: Rp6, Pioneer);
same_names!(SensorFile, SensorKind: Lidar, Sick, Rangers, Sonar);
same_names!(MaterialFile, Material: Opaque, Glass, Dark);

#[cfg(test)]
mod tests;
