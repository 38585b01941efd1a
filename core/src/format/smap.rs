//! Submaps in the format of Pilch's program (`.smap`): points, the robot's path and landmarks, as
//! text.
//!
//! In: bytes. Out: an [`Smap`]. And back. [`Smap::of_run`] makes one from all that a run has
//! mapped, [`Smap::of_submap`] from one of its submaps.
//!
//! ```text
//! #points
//! 2                            how many follow
//! -2110.33, -2760.47           x, y
//! 563.693, 3974.48
//! #robot
//! 1
//! 0, 0                         x, y, in the order of the drive
//! #landmarks
//! 1
//! -2110.33, -2760.47, 5, 0     x, y, confidence, type: 0 point or corner, 1 edge
//! ```
//!
//! Numbers are millimetres. The confidence counts how often a landmark was found again.
//!
//! 1. Each section appears once, in any order, with as many lines as it states. Blanks, line ends
//!    and empty lines are free.
//! 2. The file's y axis points to the right. The source takes x = d cos θ and y = d sin θ (3.4)
//!    with angles that an RPLIDAR counts clockwise, so its maps are seen from below. Here y is
//!    flipped on reading and writing, so a file of its program shows the building as it is.
//! 3. More than [`MOST_POINTS`] points are refused: the source begins a new submap there.
//!
//! Source: Pilch 2016 §3.4.2 and (3.5); the bound from fig. 3.24. It does not say which point of an
//! edge `x, y` is: here it is the middle.

mod read;
#[cfg(test)]
mod tests;

use std::fmt::Write as _;

use nalgebra::Point2;

use super::FieldError;
use super::map_server::{MapServerError, known_rect};
use crate::estimation::{MapLandmark, MapPoints, ScanMatcher};
use crate::map::{CellState, Grid, Wall};

pub use self::read::parse;

/// Most points of a submap.
pub const MOST_POINTS: usize = 100_000;

/// A submap, in a frame of its own: m, right-handed.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Smap {
    /// Where beams hit something.
    pub points: Vec<Point2<f64>>,
    /// Positions of the robot, in the order of the drive.
    pub path: Vec<Point2<f64>>,
    /// What can be recognised again.
    pub landmarks: Vec<SmapLandmark>,
}

/// A landmark of a submap.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SmapLandmark {
    /// Its position, m; for an edge its middle.
    pub at: Point2<f64>,
    /// How often it was found again.
    pub confidence: u32,
    /// What it is.
    pub kind: LandmarkKind,
}

/// What a landmark of a submap is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LandmarkKind {
    /// A point or a corner.
    Point,
    /// A straight piece of wall.
    Edge,
}

/// Why a file is not a submap, or a run cannot be saved as one.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SmapError {
    /// A line that cannot be read, or the wrong number of lines.
    #[error(transparent)]
    Field(#[from] FieldError),
    /// A section is missing.
    #[error("the section `{section}` is missing; the file ends after line {lines}")]
    Missing {
        /// Its first line.
        section: &'static str,
        /// Lines of the file.
        lines: usize,
    },
    /// A file has more points than a submap may have.
    #[error(
        "line {line}: {found} points, expected at most {MOST_POINTS}: a larger map is saved as several submaps"
    )]
    TooManyPoints {
        /// Line, from 1.
        line: usize,
        /// The number that it states.
        found: usize,
    },
    /// A map to be saved has more points than a submap may have.
    #[error(
        "the map has {found} occupied cells, and a submap (.smap) at most {MOST_POINTS} points: save it as a map for ROS"
    )]
    MapTooLarge {
        /// Number of its occupied cells.
        found: usize,
    },
    /// A submap that holds nothing yet.
    #[error("submap {submap} is still being made: save it when the next one has begun")]
    Unfinished {
        /// Its number.
        submap: usize,
    },
    /// A submap to be saved has more surfaces than the file may have.
    #[error(
        "submap {submap} has {found} surfaces, and a file (.smap) at most {MOST_POINTS} points"
    )]
    SubmapTooLarge {
        /// Its number.
        submap: usize,
        /// Number of its surfaces.
        found: usize,
    },
    /// There is no submap of this number.
    #[error("there is no submap {submap}: the map has {count}, counted from 0")]
    NoSubmap {
        /// The number.
        submap: usize,
        /// Number of submaps.
        count: usize,
    },
    /// There is nothing to save, or the known cells span too large an area.
    #[error(transparent)]
    Map(#[from] MapServerError),
}

impl Smap {
    /// What a run has mapped: the centres of the occupied cells, the positions of the robot, each
    /// wall as an edge, and points. The confidence of an edge counts how often the wall was seen
    /// after the first time; that of a point, how often it was found again.
    ///
    /// # Errors    [`SmapError::Map`], [`SmapError::MapTooLarge`].
    pub fn of_run(
        grid: &Grid,
        path: impl IntoIterator<Item = Point2<f64>>,
        walls: &[Wall],
        points: impl IntoIterator<Item = (Point2<f64>, u32)>,
    ) -> Result<Self, SmapError> {
        let is_occupied = |odds| grid.state_of(odds) == CellState::Occupied;
        let rect = known_rect(grid, is_occupied)?;
        let occupied = || rect.cells().filter(|&c| is_occupied(grid.log_odds(c)));
        let found = occupied().count();
        if found > MOST_POINTS {
            return Err(SmapError::MapTooLarge { found });
        }
        let edge = |wall: &Wall| SmapLandmark {
            at: nalgebra::center(&wall.segment.a, &wall.segment.b),
            confidence: wall.sightings.saturating_sub(1),
            kind: LandmarkKind::Edge,
        };
        let point = |(at, confidence)| SmapLandmark {
            at,
            confidence,
            kind: LandmarkKind::Point,
        };
        Ok(Self {
            points: occupied().map(|cell| grid.centre_of(cell)).collect(),
            path: path.into_iter().collect(),
            landmarks: walls
                .iter()
                .map(edge)
                .chain(points.into_iter().map(point))
                .collect(),
        })
    }

    /// One submap of scan matching, in its frame: its surfaces, the positions of the robot, and the
    /// landmarks found again in it.
    ///
    /// # Errors    [`SmapError::NoSubmap`], [`SmapError::Unfinished`],
    /// [`SmapError::SubmapTooLarge`].
    pub fn of_submap(matcher: &ScanMatcher, submap: usize) -> Result<Self, SmapError> {
        let count = matcher.submaps().len();
        let missing = SmapError::NoSubmap { submap, count };
        let points: Vec<_> = matcher
            .submaps()
            .nth(submap)
            .ok_or(missing)?
            .surfaces()
            .collect();
        let point = |found: &MapLandmark| SmapLandmark {
            at: found.position,
            confidence: found.confidence,
            kind: LandmarkKind::Point,
        };
        match points.len() {
            0 => Err(SmapError::Unfinished { submap }),
            found if found > MOST_POINTS => Err(SmapError::SubmapTooLarge { submap, found }),
            _ => Ok(Self {
                points,
                path: matcher.way_in(submap).collect(),
                landmarks: matcher.landmarks_in(submap).iter().map(point).collect(),
            }),
        }
    }

    /// What is needed to find where it lies in another map. Edges are not among the landmarks,
    /// because the file does not say which point of an edge it gives.
    #[must_use]
    pub fn map_points(&self) -> MapPoints {
        let landmarks = self.landmarks.iter();
        let points = landmarks.filter(|landmark| landmark.kind == LandmarkKind::Point);
        MapPoints {
            walls: self.points.clone(),
            way: self.path.clone(),
            landmarks: points.map(|landmark| landmark.at).collect(),
            grid: None,
        }
    }

    /// The text of the file, with a resolution of a micrometre.
    #[must_use]
    pub fn write(&self) -> String {
        let mut text = String::new();
        // Writing to a string does not fail, here and below.
        for (section, places) in [(POINTS, &self.points), (ROBOT, &self.path)] {
            let _ = writeln!(text, "{section}\n{}", places.len());
            for place in places {
                let _ = writeln!(text, "{}", in_file(place));
            }
        }
        let _ = writeln!(text, "{LANDMARKS}\n{}", self.landmarks.len());
        for landmark in &self.landmarks {
            let at = in_file(&landmark.at);
            let kind = match landmark.kind {
                LandmarkKind::Point => 0,
                LandmarkKind::Edge => 1,
            };
            let _ = writeln!(text, "{at}, {}, {kind}", landmark.confidence);
        }
        text
    }
}

const POINTS: &str = "#points";
const ROBOT: &str = "#robot";
const LANDMARKS: &str = "#landmarks";

/// Millimetres, y to the right.
fn in_file(place: &Point2<f64>) -> String {
    let number = |metres: f64| {
        let micrometres = (1e6 * metres).round();
        // Removes the sign of a negative zero.
        (micrometres + 0.0) / 1e3
    };
    format!("{}, {}", number(place.x), number(-place.y))
}

/// m, y to the left.
fn from_file([x, y]: [f64; 2]) -> Point2<f64> {
    Point2::new(1e-3 * x, 0.0 - 1e-3 * y)
}
