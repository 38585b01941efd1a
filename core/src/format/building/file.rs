//! Files that show a building, recognised by how they begin or, where that is not enough, by their
//! names.
//!
//! In: names and bytes of a map of ROS (YAML and image), an `OGmap.txt`, a submap (`.smap`), a
//! floor plan (SVG) or a world (JSON). Out: a [`BuildingFile`], which becomes a world to drive in,
//! walls to localise a robot by, or both.

use super::submap::map_of;
use super::{BuildingError, FENCE_SIDES, Imported, of_map, of_svg, start_in_map, surfaces_of_map};
use crate::format::map_server::{self, MapServerError, OccupancyMap};
use crate::format::smap::{self, SmapError};
use crate::format::world::{self, WorldFileError};
use crate::format::{FieldError, og_map};
use crate::geom::{Pose2, Segment};
use crate::sim::World;

/// σ of the walls of a drawing, m: they are drawn to about a centimetre.
const DRAWN_SIGMA: f64 = 0.01;
/// σ of the walls of a grid, in cells: that of a uniform distribution over a cell, 1/√12, and a
/// little more.
const GRID_SIGMA: f64 = 1.0 / 3.0;

/// A building that was read.
#[derive(Clone, Debug, PartialEq)]
pub enum BuildingFile {
    /// A grid: of ROS, an `OGmap.txt`, or the cells of a submap.
    Map(OccupancyMap),
    /// A floor plan.
    Plan(Imported),
    /// A world file.
    World(World),
}

/// What a robot can be localised by, in the frame of the file.
#[derive(Clone, Debug, PartialEq)]
pub struct PriorWalls {
    /// Faces of the walls: free space lies to the left of the direction from `a` to `b`.
    pub faces: Vec<Segment>,
    /// Standard deviation of their positions, m.
    pub sigma: f64,
    /// Where a robot begins if no other pose is given: `file_from_robot`.
    pub start: Pose2,
    /// What was skipped, in words.
    pub skipped: Vec<String>,
}

/// Why files do not show a building.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum BuildingFileError {
    /// The name tells no format.
    #[error(
        "`{0}` is no building; expected .yaml with .pgm or .png, OGmap.txt, .smap, .svg or a world as .json"
    )]
    Unknown(String),
    /// The YAML of a map without its image, or the image without the YAML.
    #[error("`{0}` is one half of a map; expected its YAML and its image (.pgm or .png) together")]
    Half(String),
    /// The map of ROS.
    #[error(transparent)]
    Map(#[from] MapServerError),
    /// The map as text.
    #[error("{0} (a text is read as an OGmap.txt)")]
    Text(#[from] FieldError),
    /// The submap.
    #[error(transparent)]
    Submap(#[from] SmapError),
    /// What the file holds does not make a building.
    #[error(transparent)]
    Building(#[from] BuildingError),
    /// The world file.
    #[error(transparent)]
    World(#[from] WorldFileError),
}

impl BuildingFile {
    /// Reads one file, or the YAML and the image of a map in any order. `svg_unit`: metres per unit
    /// of a floor plan that does not say it itself.
    ///
    /// # Errors    [`BuildingFileError`], with the place, what was found and what was expected.
    pub fn read(files: &[(&str, &[u8])], svg_unit: Option<f64>) -> Result<Self, BuildingFileError> {
        let of_kind = |kinds: &[&str]| {
            let is_one = |name: &str, bytes: &[u8]| kinds.contains(&kind(name, bytes).as_str());
            let mut files = files.iter();
            files.find(|(name, bytes)| is_one(name, bytes)).copied()
        };
        let image = of_kind(&["pgm", "png"]);
        if let Some((name, yaml)) = of_kind(&["yaml", "yml"]) {
            let (_, image) = image.ok_or_else(|| BuildingFileError::Half(name.to_owned()))?;
            return Ok(Self::Map(map_server::read(yaml, image)?));
        }
        if let Some((name, _)) = image {
            return Err(BuildingFileError::Half(name.to_owned()));
        }
        let (name, bytes) = files.first().copied().unwrap_or_default();
        match kind(name, bytes).as_str() {
            "txt" => Ok(Self::Map(og_map::parse(bytes)?.into())),
            "smap" => Ok(Self::Map(map_of(&smap::parse(bytes)?)?)),
            "svg" => Ok(Self::Plan(of_svg(bytes, svg_unit, name)?)),
            "json" => Ok(Self::World(world::read(bytes)?)),
            _ => Err(BuildingFileError::Unknown(name.to_owned())),
        }
    }

    /// The building to drive in. A world file keeps its own name.
    ///
    /// # Errors    [`BuildingError`].
    pub fn into_world(self, name: &str) -> Result<Imported, BuildingError> {
        Ok(match self {
            Self::Map(map) => of_map(&map, name)?,
            Self::Plan(plan) => plan,
            Self::World(world) => Imported {
                world,
                skipped: vec![],
            },
        })
    }

    /// The walls to localise a robot by.
    ///
    /// # Errors    [`BuildingError`]: too many cells, no wall.
    pub fn prior_walls(&self) -> Result<PriorWalls, BuildingError> {
        match self {
            Self::Map(map) => Ok(PriorWalls {
                faces: surfaces_of_map(map)?,
                sigma: GRID_SIGMA * map.resolution,
                start: start_in_map(map)?,
                skipped: vec![],
            }),
            Self::Plan(plan) => Ok(PriorWalls {
                skipped: plan.skipped.clone(),
                ..of_thin_walls(&plan.world, FENCE_SIDES)?
            }),
            Self::World(world) => of_thin_walls(world, 0),
        }
    }
}

/// Both faces of all walls except the `last` ones.
fn of_thin_walls(world: &World, last: usize) -> Result<PriorWalls, BuildingError> {
    let mut walls = world.walls();
    walls.truncate(walls.len().saturating_sub(last));
    if walls.is_empty() {
        return Err(BuildingError::NoWalls);
    }
    let both = |Segment { a, b }: Segment| [Segment::new(a, b), Segment::new(b, a)];
    Ok(PriorWalls {
        faces: walls.iter().flat_map(|wall| both(wall.segment)).collect(),
        sigma: DRAWN_SIGMA,
        start: world.start,
        skipped: vec![],
    })
}

/// The usual extension of a file of this kind, whatever it is called.
fn kind(name: &str, bytes: &[u8]) -> String {
    let text = bytes.trim_ascii_start();
    let begins = |signs: &[&[u8]]| signs.iter().any(|sign| text.starts_with(sign));
    let head = text.get(..YAML_HEAD).unwrap_or(text);
    let mut lines = head.split(|b| *b == b'\n');
    let found = match () {
        () if bytes.starts_with(b"\x89PNG") => "png",
        () if begins(&[b"P2", b"P5"]) => "pgm",
        () if begins(&[b"#points", b"#robot", b"#landmarks"]) => "smap",
        () if begins(&[b"<svg", b"<?xml", b"<!--"]) => "svg",
        () if begins(&[b"{"]) => "json",
        () if lines.any(|line| line.starts_with(IMAGE_KEY)) => "yaml",
        () => return extension(name),
    };
    found.to_owned()
}

/// The key that the YAML of a map has, and the number of bytes in which it is looked for.
const IMAGE_KEY: &[u8] = b"image:";
const YAML_HEAD: usize = 1 << 12;

fn extension(name: &str) -> String {
    let end = name.rsplit_once('.').map_or("", |(_, end)| end);
    end.to_ascii_lowercase()
}
