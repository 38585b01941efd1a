//! Maps to be found in, as they cross.

use nalgebra::Point2;
use serde::{Deserialize, Serialize};
use slamlab_core::format::building::{BuildingFile, PriorWalls};
use slamlab_core::geom::{Pose2, Segment};
use slamlab_core::slam::PriorMap;
use tsify::Tsify;

use crate::border::{Float64Array, WebError};

/// How far off a person may place a robot in a map, m and rad: standard deviations.
const PLACED_SIGMAS: [f64; 2] = [0.1, 0.05];

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
