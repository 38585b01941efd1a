//! Shortening of a path by its own chords.
//!
//! In: a path, and the configuration space it was made for. Out: the shortest path over the same
//! points.
//!
//! All collision-free chords between points of the path form a graph weighted by length; Dijkstra's
//! algorithm finds the shortest way from the first point to the last (TDK 2016 §5.3). Chords are
//! tested only when they could shorten something. This is the dense form of Dijkstra's algorithm,
//! without a heap: apart from chords blocked by walls the graph is complete.

use nalgebra::Point2;

use super::cspace::ConfigSpace;
use super::path::{Path, way_to};
use crate::geom::Segment;

/// The shortest path over the points of `path`. Legs of `path` itself count as free, whatever the
/// space says, because a robot must be able to leave a start too near to a wall.
#[must_use]
pub fn shorten(path: &Path, space: &dyn ConfigSpace) -> Path {
    let points = &path.points;
    let count = points.len();
    if count < 3 {
        return path.clone();
    }
    let mut best = vec![f64::INFINITY; count];
    let mut from = vec![0; count];
    let mut done = vec![false; count];
    best[0] = 0.0;
    for _ in 0..count {
        let open = (0..count).filter(|&i| !done[i] && best[i].is_finite());
        let Some(at) = open.min_by(|&a, &b| best[a].total_cmp(&best[b])) else {
            break;
        };
        if at + 1 == count {
            break;
        }
        done[at] = true;
        for to in (0..count).filter(|&i| !done[i]).collect::<Vec<_>>() {
            let chord = Segment::new(points[at], points[to]);
            let through = best[at] + chord.length();
            let is_leg = to.abs_diff(at) == 1;
            if through < best[to] && (is_leg || space.leg_is_free(&chord)) {
                best[to] = through;
                from[to] = at;
            }
        }
    }
    let shortest = way_to(count - 1, |&at| (at != 0).then(|| from[at]));
    let points = shortest.into_iter().map(|at| points[at]).collect();
    Path { points }
}

/// The same path with points at most `spacing` metres apart: which gives [`shorten`] more chords to
/// choose from.
#[must_use]
pub fn densify(path: &Path, spacing: f64) -> Path {
    let mut points: Vec<Point2<f64>> = path.points.first().copied().into_iter().collect();
    for leg in path.legs() {
        let pieces = (leg.length() / spacing).ceil().clamp(1.0, 1e4) as usize;
        points.extend((1..pieces).map(|i| leg.a + leg.vector() * (i as f64 / pieces as f64)));
        points.push(leg.b);
    }
    Path { points }
}
