//! The points of a scan by their bearings: the one that a sensor saw in a direction is found by one
//! look, and the one nearest to a place by few.
//!
//! Bearings are measured along a diamond, not along a circle: y / (|x| + |y|) grows with the angle
//! and takes a division instead of an arc tangent.

use nalgebra::Point2;

/// Points to either side of one that are looked at; a search ends after so many that are no nearer.
const BESIDE: usize = 2;

/// Where the points of a scan, which are sorted by their bearings, lie all round.
#[derive(Clone, Debug)]
pub(super) struct Bearings {
    /// Of each point, its place on the diamond.
    along: Vec<f64>,
    /// Of each part of the diamond, the first point in it or after it.
    first: Vec<u32>,
}

/// A place on the diamond, from 0 to 4, from the negative x axis on with the angle.
#[inline]
fn along_diamond(point: &Point2<f64>) -> f64 {
    let part = point.y / (point.x.abs() + point.y.abs());
    let along = match (point.x >= 0.0, point.y >= 0.0) {
        (true, _) => 2.0 + part,
        (false, true) => 4.0 - part,
        (false, false) => -part,
    };
    // At the sensor itself there is no direction.
    if along.is_nan() { 0.0 } else { along }
}

impl Bearings {
    /// Sorts the points by their bearings.
    pub(super) fn sort(points: &mut Vec<Point2<f64>>) -> Self {
        let count = points.len();
        let mut along: Vec<f64> = points.iter().map(along_diamond).collect();
        if !along.is_sorted() {
            let mut keyed: Vec<_> = along.iter().copied().zip(points.iter().copied()).collect();
            keyed.sort_by(|a, b| a.0.total_cmp(&b.0));
            (along, *points) = keyed.into_iter().unzip();
        }
        let parts = count.next_power_of_two();
        let scale = 4.0 / parts as f64;
        let mut first = Vec::with_capacity(parts);
        let mut at = 0;
        for part in 0..parts {
            let begins = part as f64 * scale;
            while along.get(at).is_some_and(|along| *along < begins) {
                at += 1;
            }
            first.push(at as u32);
        }
        Self { along, first }
    }

    /// The points in the direction of `place`: the last one before it and the first one after it,
    /// all round.
    pub(super) fn about(&self, place: &Point2<f64>) -> [usize; 2] {
        let after = self.first_after(place);
        let before = after.checked_sub(1).unwrap_or(self.along.len() - 1);
        [before, after]
    }

    /// The first point at or after the bearing of `place`, all round.
    #[inline]
    fn first_after(&self, place: &Point2<f64>) -> usize {
        let along = along_diamond(place);
        let parts = self.first.len();
        let part = ((along * 0.25 * parts as f64) as usize).min(parts - 1);
        let mut at = self.first.get(part).map_or(0, |first| *first as usize);
        while self.along.get(at).is_some_and(|other| *other < along) {
            at += 1;
        }
        if at >= self.along.len() { 0 } else { at }
    }

    /// The point nearest to `place` among those in about its direction, and its squared distance.
    /// It is the nearest of all wherever walls do not lie one behind the other. `points` are those
    /// that were sorted.
    #[inline]
    pub(super) fn nearest(
        &self,
        points: &[Point2<f64>],
        place: &Point2<f64>,
    ) -> Option<(usize, f64)> {
        nearest_from(points, self.first_after(place), place)
    }
}

/// The point nearest to `place` about the one at `hint`, as far as points get nearer, and its
/// squared distance.
#[inline]
pub(super) fn nearest_from(
    points: &[Point2<f64>],
    hint: usize,
    place: &Point2<f64>,
) -> Option<(usize, f64)> {
    let from = hint.wrapping_sub(BESIDE);
    let Some(beside) = points.get(from..hint.wrapping_add(BESIDE + 1)) else {
        // At the ends of the list, which goes on all round.
        let start = (hint, square(points.get(hint)?, place));
        return Some(walk(points, place, walk(points, place, start, true), false));
    };
    // Which one it is is chance: all are asked, without a branch.
    let (mut best, mut least) = (from, f64::INFINITY);
    for (index, point) in (from..).zip(beside) {
        let here = square(point, place);
        best = if here < least { index } else { best };
        least = if here < least { here } else { least };
    }
    let found = (best, least);
    Some(match best {
        _ if best == from => walk(points, place, found, false),
        _ if best == hint + BESIDE => walk(points, place, found, true),
        _ => found,
    })
}

/// Goes on from a point, up the list or down, as long as points get nearer.
fn walk(
    points: &[Point2<f64>],
    place: &Point2<f64>,
    (mut best, mut least): (usize, f64),
    is_up: bool,
) -> (usize, f64) {
    let count = points.len();
    let (mut at, mut since) = (best, 0);
    while since < BESIDE {
        at = match (is_up, at) {
            (true, _) if at + 1 == count => 0,
            (true, _) => at + 1,
            (false, 0) => count - 1,
            (false, _) => at - 1,
        };
        let here = points
            .get(at)
            .map_or(f64::INFINITY, |point| square(point, place));
        if here < least {
            (best, least, since) = (at, here, 0);
        } else {
            since += 1;
        }
    }
    (best, least)
}

#[inline]
fn square(a: &Point2<f64>, b: &Point2<f64>) -> f64 {
    let (x, y) = (a.x - b.x, a.y - b.y);
    x * x + y * y
}
