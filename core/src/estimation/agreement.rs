//! How well points agree with the map that they are placed on: what agrees, and what contradicts.
//!
//! In: oriented points at a pose, surfels, and the space that beams passed through. Out: an
//! [`Agreement`]. A point agrees if it lies on a surface that faces the same way; it contradicts if
//! the map was seen as free there and no surface is near. Where the map saw nothing, a point counts
//! as neither.

use super::free_space::FreeSpace;
use crate::geom::Pose2;
use crate::points::OrientedPoint;
use crate::registration::Target;

/// A point agrees if it is nearer to a surface than this, m, measured across it: with more, the two
/// sides of a thin wall would be mistaken for one.
pub(super) const AGREES_WITHIN: f64 = 0.08;
/// Cosine of the largest angle between surfaces that agree.
pub(super) const AGREES_COSINE: f64 = 0.5;
/// A point contradicts only if it is farther than this from every surface, m.
pub(super) const CONTRADICTS_BEYOND: f64 = 0.25;

/// What a map says about a point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Says {
    Agrees,
    Contradicts,
    Nothing,
}

/// What the surfaces in `map` and the free space in `free` say about a point at `pose`.
pub(super) fn says(
    point: &OrientedPoint,
    pose: &Pose2,
    map: &impl Target,
    free: &FreeSpace,
) -> Says {
    let place = *pose * point.position;
    if let Some(surfel) = map.nearest(place) {
        let off = place - surfel.position;
        let faces = surfel.normal.dot(&pose.rotate(point.normal));
        if surfel.normal.dot(&off).abs() < AGREES_WITHIN && faces > AGREES_COSINE {
            return Says::Agrees;
        }
        if off.norm_squared() < CONTRADICTS_BEYOND * CONTRADICTS_BEYOND {
            return Says::Nothing;
        }
    }
    match free.contains(place) {
        true => Says::Contradicts,
        false => Says::Nothing,
    }
}

/// How many points agree with a map or contradict it, of how many in total.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Agreement {
    pub(super) agree: usize,
    pub(super) contradict: usize,
    pub(super) total: usize,
}

impl Agreement {
    /// The agreement of `points` at `pose`.
    pub(super) fn of(
        points: &[OrientedPoint],
        pose: &Pose2,
        map: &impl Target,
        free: &FreeSpace,
    ) -> Self {
        Self::sum(points.iter().map(|point| says(point, pose, map, free)))
    }

    /// The sum of what a map says about each point.
    pub(super) fn sum(said: impl Iterator<Item = Says>) -> Self {
        let mut sum = Self::default();
        for says in said {
            sum.total += 1;
            match says {
                Says::Agrees => sum.agree += 1,
                Says::Contradicts => sum.contradict += 1,
                Says::Nothing => {}
            }
        }
        sum
    }

    /// The part of all points that agrees.
    pub(super) fn overlap(&self) -> f64 {
        self.agree as f64 / self.total.max(1) as f64
    }

    /// The part of all points that contradicts.
    pub(super) fn against(&self) -> f64 {
        self.contradict as f64 / self.total.max(1) as f64
    }

    /// The part of all points about which the map says something.
    pub(super) fn spoken_of(&self) -> f64 {
        (self.agree + self.contradict) as f64 / self.total.max(1) as f64
    }

    /// Of the points about which the map says something, the part that agrees; 1 if there are none.
    pub(super) fn part(&self) -> f64 {
        let said = self.agree + self.contradict;
        if said == 0 {
            1.0
        } else {
            self.agree as f64 / said as f64
        }
    }
}
