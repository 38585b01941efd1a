//! Buildings from files of others, for the page: to drive in, and to be found in.

use nalgebra::Point2;
use slamlab_core::format::building::{BuildingFile, BuildingFileError, Imported, KnownWalls};
use slamlab_core::format::map_server::{MapMode, OccupancyMap};
use slamlab_core::format::world;
use slamlab_core::geom::{Pose2, Segment};
use slamlab_core::slam::{PriorMap, Slam};
use wasm_bindgen::prelude::{JsError, wasm_bindgen};

/// How far off a person may place a robot in a map, m and rad: standard deviations.
const PLACED_SIGMAS: [f64; 2] = [0.1, 0.05];

/// Files that show one building: a floor plan, a world, an `OGmap.txt`, or the YAML and the image of a map of ROS.
#[wasm_bindgen]
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BuildingFiles {
    files: Vec<(String, Vec<u8>)>,
}

#[wasm_bindgen]
impl BuildingFiles {
    /// None yet.
    #[wasm_bindgen(constructor)]
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// One more; its name tells what it is.
    pub fn add(&mut self, name: &str, bytes: &[u8]) {
        self.files.push((name.to_owned(), bytes.to_owned()));
    }

    /// The building to drive in.
    ///
    /// # Errors    A sentence on what stands where and what was expected.
    pub fn world(&self, name: &str) -> Result<Building, JsError> {
        Ok(self.read()?.into_world(name)?.into())
    }

    /// Its walls, to find a robot by.
    ///
    /// # Errors    A sentence on what stands where and what was expected.
    pub fn known(&self) -> Result<Known, JsError> {
        Ok(self.read()?.known_walls()?.into())
    }
}

impl BuildingFiles {
    fn read(&self) -> Result<BuildingFile, BuildingFileError> {
        let files = self.files.iter();
        let files: Vec<(&str, &[u8])> = files.map(|(n, b)| (n.as_str(), b.as_slice())).collect();
        BuildingFile::read(&files, None)
    }
}

/// A building as a world file.
#[wasm_bindgen(getter_with_clone)]
#[derive(Clone, Debug, PartialEq)]
pub struct Building {
    /// Text of the world file.
    pub world: String,
    /// What of the file is not in it, in words.
    pub left_out: Vec<String>,
}

impl From<Imported> for Building {
    fn from(imported: Imported) -> Self {
        Self {
            world: world::write(&imported.world),
            left_out: imported.left_out,
        }
    }
}

/// A map to be found in, in the frame of its file.
#[wasm_bindgen(getter_with_clone)]
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Known {
    /// x1 y1 x2 y2 of each face, m; what is free lies to its left.
    pub faces: Vec<f64>,
    /// How far they may be off, m.
    pub sigma: f64,
    /// Where the robot begins: x, y, m, and heading, rad.
    pub start: Vec<f64>,
    /// What of the file is not in it, in words.
    pub left_out: Vec<String>,
}

#[wasm_bindgen]
impl Known {
    /// A map of these faces.
    #[wasm_bindgen(constructor)]
    #[must_use]
    pub fn new(faces: Vec<f64>, sigma: f64, start: Vec<f64>) -> Self {
        Self {
            faces,
            sigma,
            start,
            left_out: vec![],
        }
    }
}

impl From<KnownWalls> for Known {
    fn from(walls: KnownWalls) -> Self {
        let flat = |Segment { a, b }: &Segment| [a.x, a.y, b.x, b.y];
        let start = walls.start;
        Self {
            faces: walls.faces.iter().flat_map(flat).collect(),
            sigma: walls.sigma,
            start: vec![start.x(), start.y(), start.heading()],
            left_out: walls.left_out,
        }
    }
}

/// What was mapped, as a map to be found in: as if it had been saved for ROS and opened again.
pub(crate) fn known_of_grid(slam: &Slam) -> Result<Known, JsError> {
    let map = OccupancyMap::of_grid(slam.grid(), MapMode::Trinary)?;
    Ok(BuildingFile::Map(map).known_walls()?.into())
}

impl From<&Known> for PriorMap {
    /// What is no number makes no line.
    fn from(known: &Known) -> Self {
        let point = |x, y| Point2::new(x, y);
        let face = |c: &[f64; 4]| Segment::new(point(c[0], c[1]), point(c[2], c[3]));
        let (faces, _) = known.faces.as_chunks::<4>();
        let faces: Vec<Segment> = faces.iter().map(face).collect();
        let start = match *known.start {
            [x, y, heading] => Pose2::new(x, y, heading),
            _ => Pose2::identity(),
        };
        Self {
            start_sigmas: PLACED_SIGMAS,
            ..Self::of_faces(&faces, known.sigma, &start)
        }
    }
}
