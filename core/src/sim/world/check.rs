//! Which figures a world may have, and why one cannot be used.

use std::ops::RangeBounds;

use nalgebra::Point2;

/// Coordinates beyond this are refused, m.
pub(super) const FARTHEST: f64 = 10_000.0;

/// Why a [`World`](super::World) cannot be used.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum WorldError {
    /// A figure is out of its range.
    #[error("{part}: {field} is {value}, expected {expected}")]
    Value {
        /// The part of the world: "start", "obstacle 3", "mover 0".
        part: String,
        /// The field of that part.
        field: &'static str,
        /// The value found.
        value: f64,
        /// The values allowed.
        expected: &'static str,
    },
    /// A list is too short or too long.
    #[error("{part}: has {count} {field}, expected {expected}")]
    Count {
        /// The part of the world.
        part: String,
        /// What is counted.
        field: &'static str,
        /// How many there are.
        count: usize,
        /// How many are allowed.
        expected: &'static str,
    },
    /// The robot cannot stand where it should start.
    #[error(
        "start: a robot of radius {radius} m at ({x}, {y}) stands in {what}, {distance:.3} m from its surface; \
         expected free room of at least the radius"
    )]
    StartBlocked {
        /// Start, m.
        x: f64,
        /// Start, m.
        y: f64,
        /// Radius of the robot, m.
        radius: f64,
        /// What it collides with.
        what: String,
        /// Distance of the robot's middle from that surface, m.
        distance: f64,
    },
}

impl WorldError {
    /// The part of the world that is wrong, by its kind (`start`, `goal`, `world`, `obstacle`,
    /// `door`, `mover`) and, if there are several, its index from 0.
    #[must_use]
    pub fn part(&self) -> (&str, Option<usize>) {
        let part = match self {
            Self::Value { part, .. } | Self::Count { part, .. } => part.as_str(),
            Self::StartBlocked { .. } => "start",
        };
        match part.split_once(' ') {
            Some((kind, number)) => (kind, number.parse().ok()),
            None => (part, None),
        }
    }
}

pub(super) fn check_point(part: &str, point: &Point2<f64>) -> Result<(), WorldError> {
    check_coordinate(part, "x", point.x)?;
    check_coordinate(part, "y", point.y)
}

pub(super) fn check_coordinate(
    part: &str,
    field: &'static str,
    value: f64,
) -> Result<(), WorldError> {
    let expected = "a finite number within ±10000";
    check_value(part, field, value, -FARTHEST..=FARTHEST, expected)
}

pub(super) fn check_value(
    part: &str,
    field: &'static str,
    value: f64,
    range: impl RangeBounds<f64>,
    expected: &'static str,
) -> Result<(), WorldError> {
    if range.contains(&value) {
        return Ok(());
    }
    Err(WorldError::Value {
        part: part.to_owned(),
        field,
        value,
        expected,
    })
}

pub(super) fn check_count(
    part: &str,
    field: &'static str,
    count: usize,
    range: impl RangeBounds<usize>,
    expected: &'static str,
) -> Result<(), WorldError> {
    if range.contains(&count) {
        return Ok(());
    }
    Err(WorldError::Count {
        part: part.to_owned(),
        field,
        count,
        expected,
    })
}
