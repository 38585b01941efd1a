//! Buildings from files of others, for the page: to drive in, and to be found in.
#![allow(
    clippy::needless_pass_by_value,
    reason = "lists cross the border by value only"
)]

use nalgebra::Point2;
use serde::{Deserialize, Serialize};
use slamlab_core::format::building::{BuildingFile, PriorWalls};
use slamlab_core::format::map_server::{MapMode, OccupancyMap};
use slamlab_core::format::world;
use slamlab_core::geom::{Pose2, Segment};
use slamlab_core::slam::{PriorMap, Slam};
use tsify::{Ts, Tsify};
use wasm_bindgen::prelude::wasm_bindgen;

use crate::border::{Float64Array, Typed, Uint8Array, WebError, typed};
use crate::run::{Source, WebRun};

/// How far off a person may place a robot in a map, m and rad: standard deviations.
const PLACED_SIGMAS: [f64; 2] = [0.1, 0.05];

/// A file as it was dropped or chosen; its name tells what it is.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Tsify)]
pub struct GivenFile {
    /// Without its folder.
    pub name: String,
    /// What stands in it.
    pub bytes: Uint8Array,
}

/// A building as a world file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Tsify)]
#[serde(rename_all = "camelCase")]
pub struct Building {
    /// Text of the world file.
    pub world_json: String,
    /// What of the file is not in it, in words.
    pub skipped: Vec<String>,
}

/// A map to be found in, in the frame of its file; m and rad.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Tsify)]
pub struct PriorMapSetup {
    /// For people.
    pub name: String,
    /// x1 y1 x2 y2 of each face; what is free lies to its left.
    pub faces: Float64Array,
    /// How far they may be off: standard deviation.
    pub sigma: f64,
    /// Where the robot begins in it: x, y, heading.
    pub start: [f64; 3],
    /// Whether it may begin anywhere instead, and is to find out where.
    pub anywhere: bool,
}

/// A map to be found in as its file shows it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Tsify)]
#[serde(rename_all = "camelCase")]
pub struct PriorMapFile {
    /// The map.
    pub prior_map: PriorMapSetup,
    /// What of the file is not in it, in words.
    pub skipped: Vec<String>,
}

/// A building to drive in, from files that show it: a floor plan, a world, an `OGmap.txt`, a submap
/// (`.smap`), or the YAML and the image of a map of ROS.
///
/// # Errors    A sentence on what stands where and what was expected.
#[wasm_bindgen]
pub fn read_building(name: &str, files: Vec<Ts<GivenFile>>) -> Typed<Building> {
    let imported = read(&files)?.into_world(name)?;
    typed(&Building {
        world_json: world::write(&imported.world),
        skipped: imported.skipped,
    })
}

/// Its walls, to find a robot by.
///
/// # Errors    A sentence on what stands where and what was expected.
#[wasm_bindgen]
pub fn read_prior_map(name: &str, files: Vec<Ts<GivenFile>>) -> Typed<PriorMapFile> {
    typed(&PriorMapFile::of(name, &read(&files)?)?)
}

#[wasm_bindgen]
impl WebRun {
    /// A map to be found in, made of the grid as it is. A real robot is not put back to where the
    /// map began: it begins where it is.
    ///
    /// # Errors    A sentence on what is missing in it.
    pub fn as_prior_map(&self, name: &str) -> Typed<PriorMapFile> {
        let mut file = PriorMapFile::of_grid(name, self.slam())?;
        if let Source::Live(_) = self.source {
            let pose = self.slam().estimate().pose;
            file.prior_map.start = [pose.x(), pose.y(), pose.heading()];
        }
        typed(&file)
    }
}

fn read(files: &[Ts<GivenFile>]) -> Result<BuildingFile, WebError> {
    let files: Vec<GivenFile> = files.iter().map(Ts::to_rust).collect::<Result<_, _>>()?;
    let files: Vec<(&str, &[u8])> = files.iter().map(|f| (f.name.as_str(), &*f.bytes)).collect();
    Ok(BuildingFile::read(&files, None)?)
}

impl PriorMapFile {
    fn of(name: &str, file: &BuildingFile) -> Result<Self, WebError> {
        let PriorWalls {
            faces,
            sigma,
            start,
            skipped,
        } = file.prior_walls()?;
        let flat = |Segment { a, b }: &Segment| [a.x, a.y, b.x, b.y];
        let prior_map = PriorMapSetup {
            name: name.to_owned(),
            faces: faces.iter().flat_map(flat).collect(),
            sigma,
            start: [start.x(), start.y(), start.heading()],
            anywhere: false,
        };
        Ok(Self { prior_map, skipped })
    }

    /// What was mapped, as a map to be found in: as if it had been saved for ROS and opened again.
    pub(crate) fn of_grid(name: &str, slam: &Slam) -> Result<Self, WebError> {
        let map = OccupancyMap::of_grid(slam.grid(), MapMode::Trinary)?;
        Self::of(name, &BuildingFile::Map(map))
    }
}

impl From<&PriorMapSetup> for PriorMap {
    /// What is no number makes no line.
    fn from(prior_map: &PriorMapSetup) -> Self {
        let point = |x, y| Point2::new(x, y);
        let face = |c: &[f64; 4]| Segment::new(point(c[0], c[1]), point(c[2], c[3]));
        let (faces, _) = prior_map.faces.as_chunks::<4>();
        let faces: Vec<Segment> = faces.iter().map(face).collect();
        let [x, y, heading] = prior_map.start;
        Self {
            start_sigmas: PLACED_SIGMAS,
            anywhere: prior_map.anywhere,
            ..Self::of_faces(&faces, prior_map.sigma, &Pose2::new(x, y, heading))
        }
    }
}
