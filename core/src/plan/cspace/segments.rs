//! Configuration space over wall segments, exact.
//!
//! In: walls, the distance that the robot's centre keeps from them, bounds. Out: the room at any
//! point and how far a leg can be driven, both in closed form.
//!
//! 1. Each wall grows to a capsule (TDK 2016 §5.1 draws a rectangle; the capsule is what a disc
//!    really needs).
//! 2. Capsules are registered in all cells of a coarse raster that they enter, so a point needs
//!    only its own cell, and a leg the cells it crosses, in order, until it is stopped.

use nalgebra::{Point2, Vector2};

use super::ConfigSpace;
use super::capsule::Capsule;
use super::raster::Raster;
use crate::geom::Segment;
use crate::plan::squares::floods_apart;

/// Legs that are stopped end this far before the wall, m, so that a leg starting there is free in
/// spite of rounding.
const BACK_OFF: f64 = 1e-6;

/// Configuration space over wall segments.
#[derive(Clone, Debug)]
pub struct SegmentSpace {
    segments: Vec<Segment>,
    capsules: Vec<Capsule>,
    raster: Raster,
    keep: f64,
    bounds: (Point2<f64>, Point2<f64>),
}

/// Why the space cannot be built.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SpaceError {
    /// A wall has a coordinate that is not finite.
    #[error("wall {index} has a coordinate that is not finite")]
    Wall {
        /// Its number.
        index: usize,
    },
    /// The bounds have no area.
    #[error(
        "bounds from ({}, {}) to ({}, {}) m hold nothing: expected finite, lower left below upper right",
        .low.x, .low.y, .high.x, .high.y
    )]
    Bounds {
        /// Lower left, m.
        low: Point2<f64>,
        /// Upper right, m.
        high: Point2<f64>,
    },
    /// The distance to keep is not valid.
    #[error("distance to keep is {keep} m, expected finite and not negative")]
    Keep {
        /// What was asked for, m.
        keep: f64,
    },
}

impl SegmentSpace {
    /// The space in which the robot's centre keeps `keep` metres away from every segment and stays
    /// within `bounds` (lower left, upper right).
    ///
    /// # Errors    [`SpaceError`]: a wall or a bound that is not finite, bounds without area, a
    /// negative distance.
    pub fn new(
        segments: Vec<Segment>,
        keep: f64,
        bounds: (Point2<f64>, Point2<f64>),
    ) -> Result<Self, SpaceError> {
        let finite = |p: Point2<f64>| p.x.is_finite() && p.y.is_finite();
        if let Some(index) = segments.iter().position(|s| !finite(s.a) || !finite(s.b)) {
            return Err(SpaceError::Wall { index });
        }
        let (low, high) = bounds;
        if !(finite(low) && finite(high) && low < high && (high - low).min() > 0.0) {
            return Err(SpaceError::Bounds { low, high });
        }
        if !(keep >= 0.0 && keep.is_finite()) {
            return Err(SpaceError::Keep { keep });
        }
        Ok(Self::of(segments, keep, bounds))
    }

    fn of(segments: Vec<Segment>, keep: f64, bounds: (Point2<f64>, Point2<f64>)) -> Self {
        Self {
            capsules: segments.iter().map(|s| Capsule::new(s, keep)).collect(),
            raster: Raster::new(&segments, keep, bounds),
            segments,
            keep,
            bounds,
        }
    }

    /// The same walls and bounds for a robot whose centre keeps a different distance, m; not
    /// negative.
    #[must_use]
    pub fn with_keep(&self, keep: f64) -> Self {
        Self::of(self.segments.clone(), keep.max(0.0), self.bounds)
    }

    /// The walls.
    #[must_use]
    pub fn segments(&self) -> &[Segment] {
        &self.segments
    }

    /// Distance that the robot's centre keeps from walls, m.
    #[must_use]
    pub fn keep(&self) -> f64 {
        self.keep
    }

    fn is_inside(&self, point: Point2<f64>) -> bool {
        let (low, high) = self.bounds;
        // Comparisons, not differences: NaN lies outside.
        point.x >= low.x && point.y >= low.y && point.x <= high.x && point.y <= high.y
    }

    /// Where a leg inside the bounds meets a wall, m; infinite if it does not within `length`.
    fn first_entry(&self, origin: Point2<f64>, direction: Vector2<f64>, length: f64) -> f64 {
        let mut first = f64::INFINITY;
        self.raster.walk(origin, direction, length, |walls, until| {
            for &wall in walls {
                first = first.min(self.capsules[wall as usize].entry(origin, direction));
            }
            first > until
        });
        if first < length { first } else { f64::INFINITY }
    }

    /// How far a leg may go before it leaves the bounds, m.
    fn to_border(&self, origin: Point2<f64>, direction: Vector2<f64>) -> f64 {
        let (low, high) = self.bounds;
        let to = |at: f64, along: f64, low: f64, high: f64| match along {
            0.0 => f64::INFINITY,
            _ if along > 0.0 => (high - at) / along,
            _ => (low - at) / along,
        };
        to(origin.x, direction.x, low.x, high.x).min(to(origin.y, direction.y, low.y, high.y))
    }
}

impl ConfigSpace for SegmentSpace {
    fn room(&self, point: Point2<f64>) -> f64 {
        let (low, high) = self.bounds;
        if !(point.x.is_finite() && point.y.is_finite()) {
            return f64::NEG_INFINITY;
        }
        let border = (point - low).min().min((high - point).min());
        if border < 0.0 {
            return border;
        }
        let mut squared = f64::INFINITY;
        self.raster.rings(point, |walls, covered| {
            for &wall in walls {
                squared = squared.min(self.capsules[wall as usize].distance_squared(point));
            }
            squared > covered * covered
        });
        (squared.sqrt() - self.keep).min(border)
    }

    fn step(&self) -> f64 {
        1e-3
    }

    fn bounds(&self) -> (Point2<f64>, Point2<f64>) {
        self.bounds
    }

    fn walls(&self) -> Option<(&[Segment], f64)> {
        Some((&self.segments, self.keep))
    }

    fn walls_near(&self, point: Point2<f64>, reach: f64) -> Vec<Segment> {
        let walls = self.segments.iter();
        walls
            .filter(|wall| wall.distance(point) <= reach)
            .copied()
            .collect()
    }

    fn are_apart(&self, a: Point2<f64>, b: Point2<f64>) -> bool {
        // Smaller squares prove more, and take longer.
        let sides = [0.5, 0.1].map(|part| part * self.keep);
        sides.iter().any(|&side| floods_apart(self, a, b, side))
    }

    fn is_free(&self, point: Point2<f64>) -> bool {
        let walls = self.raster.at(point);
        self.is_inside(point)
            && !walls
                .iter()
                .any(|&wall| self.capsules[wall as usize].contains(point))
    }

    /// Exact: the leg is the axis of a capsule that no wall may enter.
    fn free_length(&self, leg: &Segment) -> f64 {
        let length = leg.length();
        if !(length > 0.0 && length.is_finite() && self.is_inside(leg.a)) {
            return 0.0;
        }
        let direction = leg.vector() / length;
        let border = if self.is_inside(leg.b) {
            f64::INFINITY
        } else {
            self.to_border(leg.a, direction)
        };
        let free = self
            .first_entry(leg.a, direction, length.min(border))
            .min(border);
        if free < length {
            (free - BACK_OFF).max(0.0)
        } else {
            length
        }
    }

    fn leg_is_free(&self, leg: &Segment) -> bool {
        let length = leg.length();
        if !(self.is_inside(leg.a) && self.is_inside(leg.b)) {
            return false;
        }
        if length <= 0.0 {
            return self.is_free(leg.a);
        }
        self.first_entry(leg.a, leg.vector() / length, length)
            .is_infinite()
    }
}
