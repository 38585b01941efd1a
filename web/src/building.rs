//! Prior maps, as they cross to the page and back.

use nalgebra::Point2;
use serde::{Deserialize, Serialize};
use slamlab_core::format::building::{BuildingFile, PriorWalls};
use slamlab_core::geom::{Pose2, Segment};
use slamlab_core::slam::PriorMap;
use tsify::Tsify;

use crate::border::{Float64Array, WebError};

/// σ with which a person places a robot in a map, m and rad.
const PLACED_SIGMAS: [f64; 2] = [0.1, 0.05];

/// A prior map, in the frame of its file; m and rad.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Tsify)]
pub struct PriorMapSetup {
    /// For people.
    pub name: String,
    /// x1 y1 x2 y2 of each face; free space lies to its left.
    pub faces: Float64Array,
    /// Standard deviation of the faces.
    pub sigma: f64,
    /// Where the robot begins in the map: x, y, heading.
    pub start: [f64; 3],
    /// Whether the robot may begin anywhere instead, and has to find out where.
    pub anywhere: bool,
}

/// A prior map as its file shows it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Tsify)]
#[serde(rename_all = "camelCase")]
pub struct PriorMapFile {
    /// The map.
    pub prior_map: PriorMapSetup,
    /// What was left out of the file, in words.
    pub skipped: Vec<String>,
}

impl PriorMapFile {
    pub(crate) fn of(name: &str, file: &BuildingFile) -> Result<Self, WebError> {
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
}

impl From<&PriorMapSetup> for PriorMap {
    /// Faces whose coordinates are not finite are dropped.
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
