//! A geofence: where a robot may be, as polygons in the frame of a map.
//!
//! 1. Each [`Zone`] is a polygon, to stay in or to keep out of. The robot may be where at least one
//!    of the keep-in zones is, if there are any, and none of the keep-out zones.
//! 2. [`Geofence::clearance`] is how far a place lies within that: the signed distances of the
//!    polygons, joined as sets are (the maximum for a union, the minimum for an intersection). Its
//!    sign is exact; outside of one polygon, or within one, its size is exact too; elsewhere it may
//!    be less than the distance to the border, but never more. So it changes by no more than the
//!    distance moved.
//! 3. Keep-in zones that only touch are not joined: they must overlap by the robot's width where it
//!    is to pass from one to the other.
//!
//! Source: keep-in and keep-out polygons as in PX4; the algebra of signed distances is that of
//! Ricci (1973).

#[cfg(test)]
pub(crate) mod tests;

use nalgebra::Point2;

use super::{Length, Pose2, Segment, ring_holds, sides_of};

/// Most zones of a fence.
pub const MOST_ZONES: usize = 8;
/// Most corners of a zone.
pub const MOST_CORNERS: usize = 32;
/// Greatest absolute coordinate, m.
const FARTHEST: f64 = 1e5;
/// Least distance between two consecutive corners, m.
const SHORTEST: f64 = 0.01;

/// What a zone is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ZoneKind {
    /// The robot stays in it.
    KeepIn,
    /// The robot keeps out of it.
    KeepOut,
}

/// A polygon.
#[derive(Clone, Debug, PartialEq)]
pub struct Zone {
    /// What it is for.
    pub kind: ZoneKind,
    /// Its corners, in either direction, map frame, m; the last is joined to the first.
    pub corners: Vec<Point2<f64>>,
}

/// Why polygons cannot be a fence.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum GeofenceError {
    /// There are too many zones.
    #[error("{found} zones; {MOST_ZONES} are possible")]
    Zones {
        /// How many there are.
        found: usize,
    },
    /// A zone has too few or too many corners.
    #[error("zone {zone} has {found} corners; expected 3 to {MOST_CORNERS}")]
    Corners {
        /// Its number, from 1.
        zone: usize,
        /// How many corners it has.
        found: usize,
    },
    /// A corner is too far away or not a finite number.
    #[error(
        "corner {corner} of zone {zone} is ({x}, {y}); expected finite numbers within {FARTHEST} m of 0"
    )]
    Place {
        /// Number of the zone, from 1.
        zone: usize,
        /// Number of the corner, from 1.
        corner: usize,
        /// x of the corner, m.
        x: f64,
        /// y of the corner, m.
        y: f64,
    },
    /// Two consecutive corners are in one place.
    #[error("corners {corner} and the next of zone {zone} lie in one place")]
    Short {
        /// Number of the zone, from 1.
        zone: usize,
        /// Number of the first of them, from 1.
        corner: usize,
    },
    /// A border that crosses itself has no inside.
    #[error("zone {zone}: the sides from corners {first} and {second} cross each other")]
    Crosses {
        /// Number of the zone, from 1.
        zone: usize,
        /// Number of the corner at which a side begins, from 1.
        first: usize,
        /// The same for the other side.
        second: usize,
    },
}

/// See the module.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Geofence {
    zones: Vec<Zone>,
}

impl Geofence {
    /// A fence of these zones; without any the robot may be everywhere.
    ///
    /// # Errors    [`GeofenceError`] with the number of zone and corner.
    pub fn new(zones: Vec<Zone>) -> Result<Self, GeofenceError> {
        if zones.len() > MOST_ZONES {
            let found = zones.len();
            return Err(GeofenceError::Zones { found });
        }
        for (zone, polygon) in (1..).zip(&zones) {
            check(zone, &polygon.corners)?;
        }
        Ok(Self { zones })
    }

    /// Its zones.
    #[must_use]
    pub fn zones(&self) -> &[Zone] {
        &self.zones
    }

    /// Whether the robot may be everywhere.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.zones.is_empty()
    }

    /// The same fence in another frame: `to_from_fence` takes the frame of its corners there. A
    /// rigid motion keeps the shape, so nothing is checked again.
    #[must_use]
    pub fn moved(&self, to_from_fence: &Pose2) -> Self {
        let moved = |zone: &Zone| Zone {
            kind: zone.kind,
            corners: (zone.corners.iter())
                .map(|corner| *to_from_fence * *corner)
                .collect(),
        };
        Self {
            zones: self.zones.iter().map(moved).collect(),
        }
    }

    /// How far `place` lies within what is allowed, m; negative outside, infinite without a fence.
    #[must_use]
    pub fn clearance(&self, place: Point2<f64>) -> f64 {
        let of = |kind: ZoneKind| {
            let zones = self.zones.iter().filter(move |zone| zone.kind == kind);
            zones.map(|zone| signed_distance(&zone.corners, place))
        };
        let within = of(ZoneKind::KeepIn).reduce(f64::max);
        let out = of(ZoneKind::KeepOut).map(|distance| -distance);
        out.fold(within.unwrap_or(f64::INFINITY), f64::min)
    }
}

/// The distance to the border of a polygon, m; negative outside.
fn signed_distance(corners: &[Point2<f64>], place: Point2<f64>) -> f64 {
    let sides = sides_of(corners).map(|(a, b)| Segment::new(*a, *b));
    let distance = sides.map(|side| side.distance(place));
    let distance = distance.fold(f64::INFINITY, f64::min);
    match ring_holds(corners, place) {
        true => distance,
        false => -distance,
    }
}

fn check(zone: usize, corners: &[Point2<f64>]) -> Result<(), GeofenceError> {
    let found = corners.len();
    if !(3..=MOST_CORNERS).contains(&found) {
        return Err(GeofenceError::Corners { zone, found });
    }
    for (corner, at) in (1..).zip(corners) {
        let (x, y) = (at.x, at.y);
        // This refuses NaN, too.
        if !(x.abs() <= FARTHEST && y.abs() <= FARTHEST) {
            return Err(GeofenceError::Place { zone, corner, x, y });
        }
    }
    for (corner, (a, b)) in (1..).zip(sides_of(corners)) {
        if (b - a).length() < SHORTEST {
            return Err(GeofenceError::Short { zone, corner });
        }
    }
    let sides: Vec<Segment> = (sides_of(corners))
        .map(|(a, b)| Segment::new(*a, *b))
        .collect();
    for (i, side) in sides.iter().enumerate() {
        for (j, other) in sides.iter().enumerate().skip(i + 1) {
            let are_neighbours = j == i + 1 || (i == 0 && j + 1 == sides.len());
            let meets = match are_neighbours {
                // They share a corner; a side that goes back along the other leaves no inside
                // there.
                true => folds_back(side, other, j == i + 1),
                false => side.distance_to(other) < SHORTEST,
            };
            if meets {
                let (first, second) = (i + 1, j + 1);
                return Err(GeofenceError::Crosses {
                    zone,
                    first,
                    second,
                });
            }
        }
    }
    Ok(())
}

/// Whether a side goes back along the one with which it shares a corner.
fn folds_back(side: &Segment, other: &Segment, follows: bool) -> bool {
    match follows {
        true => side.distance(other.b) < SHORTEST || other.distance(side.a) < SHORTEST,
        false => side.distance(other.a) < SHORTEST || other.distance(side.b) < SHORTEST,
    }
}
