//! Which corners of a path an outline needs, and whether it can follow a path at all.

use nalgebra::Point2;

use crate::geom::{Footprint, Segment};
use crate::plan::cspace::ConfigSpace;
use crate::plan::path::Path;

/// Step 4: repeated from the start until every corner is needed.
pub(super) fn drop_corners(
    mut path: Path,
    heading: Option<f64>,
    outline: &Footprint,
    space: &dyn ConfigSpace,
) -> Path {
    let mut at = 1;
    let mut is_shorter = false;
    while at + 1 < path.points.len() {
        let before = match at {
            1 => heading,
            _ => Some(Segment::new(path.points[at - 2], path.points[at - 1]).heading()),
        };
        let mut around = vec![path.points[at - 1]];
        around.extend(path.points.iter().skip(at + 1).take(2));
        if follows(outline, &around, before, space) {
            path.points.remove(at);
            is_shorter = true;
        } else {
            at += 1;
        }
        if at + 1 >= path.points.len() && std::mem::take(&mut is_shorter) {
            at = 1;
        }
    }
    path
}

/// Whether the outline can follow straight legs over these corners without touching a wall of the
/// space, from a heading in rad, or from the heading of the first leg.
pub fn follows(
    outline: &Footprint,
    corners: &[Point2<f64>],
    heading: Option<f64>,
    space: &dyn ConfigSpace,
) -> bool {
    let mut heading = heading;
    corners.windows(2).all(|ends| {
        let leg = Segment::new(ends[0], ends[1]);
        let middle = nalgebra::center(&leg.a, &leg.b);
        let reach = 0.5 * leg.length() + outline.radius_around();
        if leg.length() == 0.0 {
            return true;
        }
        let along = leg.heading();
        let from = heading.replace(along).unwrap_or(along);
        outline.follows([leg], from, &space.walls_near(middle, reach))
    })
}
