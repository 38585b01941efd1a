//! Finds where a loaded map lies in the one that is being drawn, without a start given by hand.
//!
//! In: walls, trajectory and landmarks of the loaded map in a frame of its own, and the grid and
//! the landmarks of the other. Out: the pose of the loaded map, and how much agrees; or why its
//! pose is not known.
//!
//! 1. Walls are placed on walls, at any position and rotation (`starts`): the smaller map is
//!    searched for in the larger one by branch and bound ([`crate::registration::modes`]), which
//!    finds all places that look alike.
//! 2. Landmarks are matched by the distances among them, which needs no start either
//!    ([`crate::association::PointMatching::Relations`]). The matched ones give one more place.
//! 3. From each place the walls are matched, points to lines, and judged (`said`): a wall of either
//!    map agrees if it stands on a wall of the other, and contradicts if the other is free all
//!    around it. Where the other saw nothing, it counts as neither. The loaded trajectory
//!    contradicts where it leads through a wall.
//! 4. The place with the most agreement is right if half of one of the maps agrees there, and
//!    nearly all of what is known there; if no other place comes near it; and if the walls
//!    constrain it in all directions. If walls fit several places alike, landmarks may decide: when
//!    their relations fit twice, none is matched.
//!
//! A file of points does not say what was free. From each of its poses the robot saw everything up
//! to the nearest wall in each direction: that is assumed to be free (`seen`). When judged in one
//! direction only, the map of an office was placed in a hall, most of it where nothing is known.
//!
//! Sources: Hess et al. (2016), section V-B, for step 1; Pilch 2016 §1.2.3 and §3.3, who aligns
//! loaded submaps by their landmarks and by registration; free space as evidence as in Bosse &
//! Zlot (2008).

mod said;
mod seen;
mod starts;
#[cfg(test)]
mod tests;

use std::borrow::Cow;

use nalgebra::{Point2, Vector2};

use self::said::{fits, said};
use self::seen::seen_from;
use self::starts::{by_landmarks, by_walls, shared};
use super::agreement::Agreement;
use crate::geom::{Length, Pose2, wrap};
use crate::map::{CellState, Grid, GridError};
use crate::points::thinned;
use crate::registration::{
    Cloud, CloudError, IcpConfig, JudgeConfig, Registration, Verdict, register_clouds_by_icp,
};

/// A map to be aligned with another, in a frame of its own, m.
#[derive(Clone, Debug, Default)]
pub struct MapPoints {
    /// Where walls stand: at least [`FEWEST_POINTS`].
    pub walls: Vec<Point2<f64>>,
    /// The robot's positions.
    pub way: Vec<Point2<f64>>,
    /// Recognisable points.
    pub landmarks: Vec<Point2<f64>>,
    /// Known free space; if there is none, it is what can be seen from `way`.
    pub grid: Option<Grid>,
}

impl MapPoints {
    /// The contents of a grid, with the trajectory and the landmarks of the same map.
    #[must_use]
    pub fn of_grid(
        grid: &Grid,
        way: impl IntoIterator<Item = Point2<f64>>,
        landmarks: impl IntoIterator<Item = Point2<f64>>,
    ) -> Self {
        Self {
            walls: grid.occupied(),
            way: way.into_iter().collect(),
            landmarks: landmarks.into_iter().collect(),
            grid: Some(grid.clone()),
        }
    }

    fn seen(&self) -> Result<Cow<'_, Grid>, GridError> {
        match &self.grid {
            Some(grid) => Ok(Cow::Borrowed(grid)),
            None => seen_from(&self.way, &self.walls).map(Cow::Owned),
        }
    }
}

/// Where a loaded map lies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MapAlignment {
    /// Its pose in the map that it was aligned with.
    pub map_from_loaded: Pose2,
    /// The part of its walls that stand on walls of the other, 0 to 1.
    pub agrees: f64,
    /// The part of the walls of either map that stand where the other is free, 0 to 1: the larger
    /// of the two.
    pub contradicts: f64,
    /// Distance between matching walls, root mean square, m.
    pub residual: f64,
    /// Number of landmarks that both have.
    pub landmarks: usize,
    /// What determined the place.
    pub by: AlignedBy,
}

/// What determined where a map lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AlignedBy {
    /// Its walls alone.
    Walls,
    /// Its landmarks, among places that walls could not tell apart, or had not found.
    Landmarks,
    /// Both, independently.
    Both,
}

/// Why it is not known where a map lies.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MapAlignmentError {
    /// Too little to compare.
    #[error(
        "the {which} map has {found} points of walls, and at least {FEWEST_POINTS} are needed to say where it lies"
    )]
    TooFewPoints {
        /// Which: `loaded` or `drawn`.
        which: &'static str,
        /// How many it has.
        found: usize,
    },
    /// Free space that cannot be determined.
    #[error(transparent)]
    Grid(#[from] GridError),
    /// Points that are invalid, or too many.
    #[error("the {which} map cannot be compared: {error}")]
    Cloud {
        /// Which: `loaded` or `drawn`.
        which: &'static str,
        /// Why.
        error: CloudError,
    },
    /// It fits nowhere.
    #[error(
        "no part of the map looks like it: at the best place {:.0} % of its walls stand on walls, \
         and {:.0} % of the walls of either map where the other is free",
        100.0 * agrees,
        100.0 * contradicts
    )]
    Nowhere {
        /// See [`MapAlignment::agrees`], at the best place.
        agrees: f64,
        /// See [`MapAlignment::contradicts`].
        contradicts: f64,
    },
    /// It fits in several places.
    #[error(
        "it fits in {places} places alike: at the best {:.0} % of the walls agree, at the next {:.0} %",
        100.0 * best,
        100.0 * next
    )]
    Ambiguous {
        /// In how many.
        places: usize,
        /// Part of the walls of both maps that agrees at the best, less what contradicts.
        best: f64,
        /// At the next.
        next: f64,
    },
    /// The walls do not constrain its position in one direction.
    #[error(
        "its walls do not say how far along the direction ({:.2}, {:.2}) of the map it lies, as in a corridor",
        direction.x,
        direction.y
    )]
    Degenerate {
        /// Unit vector, frame of the map.
        direction: Vector2<f64>,
    },
}

/// Fewer wall points than this say nothing: 3 m, in cells of 5 cm.
pub const FEWEST_POINTS: usize = 60;
/// At least this part of all walls of one map or of the other has to agree.
const LEAST_AGREES: f64 = 0.5;
/// Another place with at least this part of the agreement is just as good.
const RIVAL: f64 = 0.85;
/// Places nearer to each other than this, m and rad, count as one.
const APART: (f64, f64) = (0.5, 0.2);
/// The most points that are matched or judged, and the most that are matched to.
const MOST_MATCHED: usize = 2000;
const MOST_FIXED: usize = 30_000;

/// Finds where a loaded map lies in the map of `grid` and `landmarks`.
///
/// # Errors    [`MapAlignmentError`]: why it is not known.
pub fn align_map(
    loaded: &MapPoints,
    grid: &Grid,
    landmarks: &[Point2<f64>],
) -> Result<MapAlignment, MapAlignmentError> {
    let drawn = grid.occupied();
    let cloud = |which: &'static str, points: &[Point2<f64>], most: usize| {
        let found = points.len();
        if found < FEWEST_POINTS {
            return Err(MapAlignmentError::TooFewPoints { which, found });
        }
        Cloud::any(thinned(points, most, 0))
            .map_err(|error| MapAlignmentError::Cloud { which, error })
    };
    let moving = cloud("loaded", &loaded.walls, MOST_MATCHED)?;
    let fixed = cloud("drawn", &drawn, MOST_FIXED)?;
    let seen = loaded.seen()?;
    let judged = thinned(fixed.points(), MOST_MATCHED, 0);
    let told = by_landmarks(&loaded.landmarks, landmarks);
    let starts = by_walls(&loaded.walls, &drawn).into_iter().chain(told);
    let icp = IcpConfig::default();
    let mut places: Vec<Place> = vec![];
    for start in starts {
        let judge = JudgeConfig::default();
        let found = register_clouds_by_icp(&moving, &fixed, &start, &icp, &judge);
        let pose = found.estimate.pose;
        let place = Place {
            forth: said(moving.points(), &pose, grid),
            back: said(&judged, &pose.inverse(), &seen),
            crossed: crossed(&loaded.way, &pose, grid),
            found,
        };
        if !place.pose().is_finite() {
            continue;
        }
        // If several starts lead to one place, keep the result with the best agreement.
        match places.iter_mut().find(|other| other.is_near(place.pose())) {
            Some(other) if other.net() < place.net() => *other = place,
            Some(_) => {}
            None => places.push(place),
        }
    }
    // Stable: of equal ones the first comes first.
    places.sort_by_key(|place| std::cmp::Reverse(place.net()));
    decide(&places, told.as_ref(), loaded, landmarks)
}

/// A place of the loaded map, and what both maps say about each other there.
struct Place {
    found: Registration,
    /// Of the loaded walls, and of the walls of the other map.
    forth: Agreement,
    back: Agreement,
    /// Number of positions of the loaded trajectory that are walls.
    crossed: usize,
}

impl Place {
    fn pose(&self) -> &Pose2 {
        &self.found.estimate.pose
    }

    fn is_near(&self, pose: &Pose2) -> bool {
        let off = self.pose().position() - pose.position();
        off.length() < APART.0 && wrap(self.pose().heading() - pose.heading()).abs() < APART.1
    }

    /// What agrees minus what contradicts.
    fn net(&self) -> usize {
        let agree = self.forth.agree + self.back.agree;
        agree.saturating_sub(self.forth.contradict + self.back.contradict + self.crossed)
    }

    fn part(&self) -> f64 {
        self.net() as f64 / (self.forth.total + self.back.total).max(1) as f64
    }

    fn contradicts(&self) -> f64 {
        self.forth.against().max(self.back.against())
    }

    fn fits(&self) -> bool {
        let forth = Agreement {
            contradict: self.forth.contradict + self.crossed,
            ..self.forth
        };
        self.forth.agree >= FEWEST_POINTS
            && fits(&forth)
            && fits(&self.back)
            && self.forth.overlap().max(self.back.overlap()) >= LEAST_AGREES
    }
}

/// How many positions of a trajectory are walls of the other map.
fn crossed(way: &[Point2<f64>], pose: &Pose2, grid: &Grid) -> usize {
    let some = thinned(way, MOST_MATCHED, 0);
    let is_wall = |at: &&Point2<f64>| grid.state(grid.cell_at(*pose * **at)) == CellState::Occupied;
    some.iter().filter(is_wall).count()
}

/// Step 4.
fn decide(
    places: &[Place],
    told: Option<&Pose2>,
    loaded: &MapPoints,
    landmarks: &[Point2<f64>],
) -> Result<MapAlignment, MapAlignmentError> {
    let nowhere = |place: Option<&Place>| MapAlignmentError::Nowhere {
        agrees: place.map_or(0.0, |place| place.forth.overlap()),
        contradicts: place.map_or(0.0, Place::contradicts),
    };
    let fitting: Vec<&Place> = places.iter().filter(|place| place.fits()).collect();
    let best = *fitting.first().ok_or_else(|| nowhere(places.first()))?;
    let is_rival = |place: &&&Place| place.net() as f64 >= RIVAL * best.net() as f64;
    let alike: Vec<&Place> = fitting.iter().filter(is_rival).copied().collect();
    let is_told = |place: &&&Place| told.is_some_and(|pose| place.is_near(pose));
    let by_landmarks = alike.iter().find(is_told).copied();
    let (place, by) = match (alike.len(), by_landmarks) {
        (1, Some(place)) => (place, AlignedBy::Both),
        (1, None) => (best, AlignedBy::Walls),
        (_, Some(place)) => (place, AlignedBy::Landmarks),
        (places, None) => {
            return Err(MapAlignmentError::Ambiguous {
                places,
                best: best.part(),
                next: alike.get(1).map_or(0.0, |next| next.part()),
            });
        }
    };
    if let Verdict::Degenerate { direction } = place.found.verdict
        && by == AlignedBy::Walls
    {
        return Err(MapAlignmentError::Degenerate { direction });
    }
    Ok(MapAlignment {
        map_from_loaded: *place.pose(),
        agrees: place.forth.overlap(),
        contradicts: place.contradicts(),
        residual: place.found.residual,
        landmarks: shared(&loaded.landmarks, landmarks, place.pose()),
        by,
    })
}
