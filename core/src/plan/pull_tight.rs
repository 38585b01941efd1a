//! A path pulled tight, as a rubber band would be.
//!
//! In: a path, and the configuration space it was made for. Out: the shortest path through the same
//! gaps, to a given accuracy.
//!
//! 1. Corners that a free chord can bypass are dropped.
//! 2. At every other corner the longest piece is cut off: two points on its legs, equally far from
//!    it, between which the chord is free; how far is found by bisection. One corner becomes two
//!    flatter ones, closer to the obstacle.
//! 3. Again, until a round gains less than `GAIN` of the length.
//!
//! A chord is taken only if the triangle that it cuts off holds no obstacle, tested by chords ever
//! nearer to the corner: so the path passes every obstacle on the same side as before. This is
//! local: other gaps are for planners to try.
//!
//! Legs of the path itself count as free, whatever the space says, because a robot must be able to
//! leave a start too near to a wall.

use nalgebra::Point2;

use super::cspace::ConfigSpace;
use super::path::Path;
use crate::geom::{Length, Segment};

/// Most rounds of cutting; each at least halves the distance of corners from the obstacle.
const ROUNDS: usize = 40;
/// A round that gains less than this fraction of the length is the last.
const GAIN: f64 = 2e-5;
/// A corner is not cut if that gains less than this, m.
const LEAST_CUT: f64 = 1e-6;
/// Bisection steps for a cut.
const HALVINGS: usize = 6;
/// Number of chords between a corner and a cut that must be free too.
const CHORDS: usize = 3;

/// The path pulled tight; never longer.
#[must_use]
pub fn pull_tight(path: &Path, space: &dyn ConfigSpace) -> Path {
    let mut points = path.points.clone();
    let mut length = path.length();
    for _ in 0..ROUNDS {
        drop_corners(&mut points, space);
        points = cut_corners(&points, space);
        let now = length_of(&points);
        let gain = length - now;
        length = now;
        if gain < GAIN * length {
            break;
        }
    }
    drop_corners(&mut points, space);
    Path { points }
}

fn length_of(points: &[Point2<f64>]) -> f64 {
    points
        .windows(2)
        .map(|leg| (leg[1] - leg[0]).length())
        .sum()
}

/// Step 1.
fn drop_corners(points: &mut Vec<Point2<f64>>, space: &dyn ConfigSpace) {
    let mut kept: Vec<Point2<f64>> = vec![];
    for &point in points.iter() {
        while let [.., before, corner] = kept[..]
            && is_cut_free(space, before, corner, point)
        {
            kept.pop();
        }
        kept.push(point);
    }
    *points = kept;
}

/// Step 2, once for every corner.
fn cut_corners(points: &[Point2<f64>], space: &dyn ConfigSpace) -> Vec<Point2<f64>> {
    let [first, .., last] = *points else {
        return points.to_vec();
    };
    let mut cut = vec![first];
    let mut before = first;
    for pair in points.windows(2).skip(1) {
        let [corner, after] = [pair[0], pair[1]];
        match longest_cut(space, before, corner, after) {
            Some((a, b)) => {
                cut.extend([a, b]);
                before = b;
            }
            None => {
                cut.push(corner);
                before = corner;
            }
        }
    }
    cut.push(last);
    cut
}

/// Where to cut a corner off; `None` if that gains nothing.
fn longest_cut(
    space: &dyn ConfigSpace,
    before: Point2<f64>,
    corner: Point2<f64>,
    after: Point2<f64>,
) -> Option<(Point2<f64>, Point2<f64>)> {
    let (back, on) = (before - corner, after - corner);
    let (back_length, on_length) = (back.length(), on.length());
    // Half of a leg at most: the other half is for the corner at its other end.
    let most = 0.5 * back_length.min(on_length);
    // Cutting c off either leg saves c times this.
    let saved = 2.0 - (on / on_length - back / back_length).length();
    if !(most > 0.0 && most * saved > LEAST_CUT) {
        return None;
    }
    let ends = |cut: f64| {
        (
            corner + back * (cut / back_length),
            corner + on * (cut / on_length),
        )
    };
    let (mut low, mut high) = (0.0, most);
    let is_free = |cut: f64| {
        let (a, b) = ends(cut);
        is_cut_free(space, a, corner, b)
    };
    if is_free(high) {
        return Some(ends(high));
    }
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        if is_free(middle) {
            low = middle;
        } else {
            high = middle;
        }
    }
    (low * saved > LEAST_CUT).then(|| ends(low))
}

/// Whether the chord from `a` to `b` is free, and those between it and the corner.
fn is_cut_free(
    space: &dyn ConfigSpace,
    a: Point2<f64>,
    corner: Point2<f64>,
    b: Point2<f64>,
) -> bool {
    (1..=CHORDS).all(|chord| {
        let part = 1.0 - (chord - 1) as f64 / CHORDS as f64;
        let end = |to: Point2<f64>| corner + (to - corner) * part;
        space.leg_is_free(&Segment::new(end(a), end(b)))
    })
}
