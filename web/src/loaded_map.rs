//! Maps and paths that are loaded beside the run, to be looked at and placed on what is drawn: a
//! submap (`.smap`), a saved map (`.slamlab`), or a path of poses over time.

use nalgebra::Point2;
use serde::{Deserialize, Serialize};
use slamlab_core::estimation::{MapPoints, align_map};
use slamlab_core::format::map_points::{self, LoadedMap};
use slamlab_core::format::poses::read_poses;
use slamlab_core::geom::Pose2;
use slamlab_core::replay::PoseTrack;
use tsify::Tsify;
use wasm_bindgen::prelude::wasm_bindgen;

use crate::border::{AlignedName, Float32Array, PathPlaced, Typed, WebError, typed};
use crate::run::{Source, WebRun};

/// Maximum number of wall points that the page is given: enough to see the walls.
pub(crate) const MOST_WALLS: usize = 6000;
/// Maximum number of positions of the path that the page is given.
const MOST_PLACES: usize = 2000;

/// A map that was loaded.
#[wasm_bindgen]
#[derive(Debug)]
pub struct WebLoadedMap {
    points: MapPoints,
    submaps: usize,
}

/// What a loaded map looks like, in its own frame, m.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Tsify)]
#[serde(rename_all = "camelCase")]
pub struct LoadedMapPicture {
    /// x y of its walls.
    pub walls: Float32Array,
    /// x y of the robot's path.
    pub way: Float32Array,
    /// x y of its landmarks.
    pub landmarks: Float32Array,
    /// Number of points of its walls.
    pub points: usize,
    /// Number of submaps that it is made of.
    pub submaps: usize,
}

/// Where a loaded map lies in the one that is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Tsify)]
#[serde(rename_all = "camelCase")]
pub struct MapAlignment {
    /// x y heading of its frame, map frame, m and rad.
    pub pose: [f64; 3],
    /// Part of its walls that lie on walls, 0 to 1.
    pub agrees: f64,
    /// Part of its walls that lie where the map is free, 0 to 1.
    pub contradicts: f64,
    /// Root mean square distance of the walls from each other, m.
    pub residual: f64,
    /// Number of landmarks that both have.
    pub landmarks: usize,
    /// What the alignment is based on.
    pub by: AlignedName,
}

#[wasm_bindgen]
impl WebLoadedMap {
    /// Reads a submap or a saved map.
    ///
    /// # Errors    A sentence on what is wrong with it, and where.
    #[wasm_bindgen(constructor)]
    pub fn new(bytes: &[u8]) -> Result<Self, WebError> {
        let LoadedMap { points, submaps } = map_points::read(bytes)?;
        Ok(Self { points, submaps })
    }

    /// What it looks like.
    ///
    /// # Errors    None that a page can cause.
    pub fn picture(&self) -> Typed<LoadedMapPicture> {
        let MapPoints {
            walls,
            way,
            landmarks,
            ..
        } = &self.points;
        typed(&LoadedMapPicture {
            walls: flat_points(walls, MOST_WALLS),
            way: flat_points(way, MOST_PLACES),
            landmarks: flat_points(landmarks, MOST_PLACES),
            points: walls.len(),
            submaps: self.submaps,
        })
    }
}

/// A path of poses that was loaded.
#[wasm_bindgen]
#[derive(Debug)]
pub struct WebPosePath {
    track: PoseTrack,
    repeated: usize,
}

/// What such a path looks like, in its own frame.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Tsify)]
pub struct PosePathPicture {
    /// x y of its positions, m.
    pub way: Float32Array,
    /// Number of its poses.
    pub poses: usize,
    /// Number of poses that were left out because another one has the same time.
    pub repeated: usize,
    /// Duration from the first to the last, s.
    pub seconds: f64,
}

/// Where a path lies in the map.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Tsify)]
pub struct PathPlace {
    /// x y heading of its frame, map frame, m and rad.
    pub pose: [f64; 3],
    /// How it was placed there.
    pub by: PathPlaced,
}

#[wasm_bindgen]
impl WebPosePath {
    /// Reads a file of poses.
    ///
    /// # Errors    A sentence on what is wrong with it, with line and field.
    #[wasm_bindgen(constructor)]
    pub fn new(bytes: &[u8]) -> Result<Self, WebError> {
        let file = read_poses(bytes)?;
        Ok(Self {
            repeated: file.repeated,
            track: file.into(),
        })
    }

    /// What it looks like.
    ///
    /// # Errors    None that a page can cause.
    pub fn picture(&self) -> Typed<PosePathPicture> {
        let poses = self.track.poses();
        let way: Vec<Point2<f64>> = poses.iter().map(|(_, pose)| pose.position()).collect();
        let ends = poses.first().zip(poses.last());
        typed(&PosePathPicture {
            way: flat_points(&way, MOST_PLACES),
            poses: poses.len(),
            repeated: self.repeated,
            seconds: ends.map_or(0.0, |((from, _), (to, _))| to - from),
        })
    }
}

#[wasm_bindgen]
impl WebRun {
    /// Where a path lies in the map: if it is on the clock of a recording, aligned by time to bring
    /// both paths as close as possible; otherwise with its first pose where the map begins.
    ///
    /// # Errors    None that a page can cause.
    pub fn place_path(&self, path: &WebPosePath) -> Typed<PathPlace> {
        let by_time = match &self.source {
            Source::Recording(replay) => replay.map_from_track(&path.track),
            Source::Simulation(_) | Source::Live(_) => None,
        };
        let begin = path.track.poses().first();
        let begin = begin.map_or_else(Pose2::identity, |(_, pose)| pose.inverse());
        let pose = by_time.unwrap_or(begin);
        typed(&PathPlace {
            pose: [pose.x(), pose.y(), pose.heading()],
            by: match by_time {
                Some(_) => PathPlaced::Time,
                None => PathPlaced::Begin,
            },
        })
    }

    /// Where a loaded map lies in the map as it is drawn now, found without a start.
    ///
    /// # Errors    A sentence on why its place is unknown.
    pub fn align_map(&self, loaded: &WebLoadedMap) -> Typed<MapAlignment> {
        let slam = self.slam();
        let landmarks = slam.view().landmark_points().into_iter();
        let landmarks: Vec<_> = landmarks.map(|(at, _)| at).collect();
        let found = align_map(&loaded.points, slam.grid(), &landmarks)?;
        let pose = found.map_from_loaded;
        typed(&MapAlignment {
            pose: [pose.x(), pose.y(), pose.heading()],
            agrees: found.agrees,
            contradicts: found.contradicts,
            residual: found.residual,
            landmarks: found.landmarks,
            by: (&found.by).into(),
        })
    }
}

pub(crate) fn flat_points(points: &[Point2<f64>], most: usize) -> Float32Array {
    let every = points.len().div_ceil(most).max(1);
    let some = points.iter().step_by(every);
    some.flat_map(|p| [p.x as f32, p.y as f32]).collect()
}
