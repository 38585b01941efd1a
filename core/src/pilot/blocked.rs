//! Whether the map still allows the way ahead, for a disc and for an outline.

use nalgebra::Point2;

use crate::geom::geofence::Geofence;
use crate::geom::{Footprint, Segment};
use crate::map::{CellRect, Grid};
use crate::plan::{ConfigSpace, GridSpace, Path, Unknown, follows};

/// Distance between two points of a way that are checked against a geofence, m.
const FENCE_STEP: f64 = 0.05;

/// Whether a wall blocks the next `reach` metres of a path. The first decimetres do not count: the
/// robot stands there, and may be leaving a place that is too near to a wall.
pub(super) fn is_blocked(grid: &Grid, ahead: &Path, keep: f64, reach: f64) -> bool {
    let mut left = reach;
    let mut skip = 0.15;
    for leg in ahead.legs() {
        let length = leg.length();
        if length <= skip {
            skip -= length;
            continue;
        }
        let along = leg.vector() / length;
        let part = Segment::new(
            leg.a + along * skip,
            leg.a + along * length.min(skip + left),
        );
        skip = 0.0;
        let Some(cells) = cells_around(grid, &[part.a, part.b], keep) else {
            continue;
        };
        let space = GridSpace::new(grid, cells, keep, Unknown::Free);
        if !space.leg_is_free(&part) {
            return true;
        }
        left -= part.length();
        if left <= 0.0 {
            break;
        }
    }
    false
}

/// The same for an outline: the legs in the next `reach` metres, without the turn at their
/// beginning.
pub(super) fn outline_is_blocked(
    grid: &Grid,
    ahead: &Path,
    outline: &Footprint,
    reach: f64,
) -> bool {
    let corners = beginning(ahead, reach);
    let Some(cells) = cells_around(grid, &corners, outline.radius_around()) else {
        return false;
    };
    let space = GridSpace::new(grid, cells, 0.0, Unknown::Free);
    !follows(outline, &corners, None, &space)
}

/// Whether the way ahead leads out of a geofence. The first decimetres do not count: the robot may
/// be on its way back.
pub(super) fn leads_outside(fence: &Geofence, ahead: &Path, keep: f64) -> bool {
    let is_outside = |leg: Segment| {
        let steps = (leg.length() / FENCE_STEP).ceil().max(1.0) as usize;
        (0..=steps).any(|step| {
            let at = leg.a + leg.vector() * (step as f64 / steps as f64);
            fence.clearance(at) < keep
        })
    };
    !fence.is_empty()
        && ahead
            .legs()
            .skip_while(|leg| fence.clearance(leg.a) < keep)
            .any(is_outside)
}

/// Whether a disc fits at a point.
pub(super) fn disc_fits(grid: &Grid, at: Point2<f64>, radius: f64) -> bool {
    cells_around(grid, &[at], radius)
        .is_none_or(|cells| GridSpace::new(grid, cells, radius, Unknown::Free).is_free(at))
}

/// The corners in the first `length` metres of a path, and the point where these end.
fn beginning(path: &Path, length: f64) -> Vec<Point2<f64>> {
    let mut corners: Vec<_> = path.points.first().copied().into_iter().collect();
    let mut left = length;
    for leg in path.legs() {
        let part = (left / leg.length().max(f64::MIN_POSITIVE)).min(1.0);
        corners.push(leg.a + leg.vector() * part);
        left -= leg.length();
        if left <= 0.0 {
            break;
        }
    }
    corners
}

/// The cells around points, and `spare` metres around them; `None` without points.
fn cells_around(grid: &Grid, points: &[Point2<f64>], spare: f64) -> Option<CellRect> {
    let spare = (spare / grid.resolution()).ceil() as i32 + 2;
    let cells = points.iter().map(|point| grid.cell_at(*point));
    let around = cells.map(CellRect::of).reduce(CellRect::around);
    around.map(|rect| rect.grown(spare))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::Pose2;
    use crate::map::GridConfig;
    use crate::pilot::tests::wall;
    use crate::points::fixture::look;

    fn path(points: &[(f64, f64)]) -> Path {
        let points = points.iter().map(|&(x, y)| Point2::new(x, y)).collect();
        Path { points }
    }

    #[test]
    fn the_beginning_of_a_path_ends_at_its_length() {
        let bent = path(&[(0.0, 0.0), (1.0, 0.0), (1.0, 5.0)]);
        assert_eq!(
            beginning(&bent, 0.5),
            path(&[(0.0, 0.0), (0.5, 0.0)]).points
        );
        assert_eq!(
            beginning(&bent, 3.0),
            path(&[(0.0, 0.0), (1.0, 0.0), (1.0, 2.0)]).points
        );
        assert_eq!(beginning(&bent, 99.0), bent.points);
        assert_eq!(beginning(&path(&[]), 1.0), vec![]);
    }

    #[test]
    fn a_wall_on_the_way_blocks_it_within_reach_only_whatever_else_the_map_holds() {
        let mut grid = Grid::new(GridConfig::default()).unwrap();
        let walls = [wall(3.0, -0.5, 3.0, 0.5), wall(901.0, 899.0, 901.0, 901.0)];
        // The second is far from the way and must not be examined.
        for at in [Pose2::identity(), Pose2::new(900.0, 900.0, 0.0)] {
            for _ in 0..9 {
                grid.insert(&look(&walls, &at, 8.0), &at);
            }
        }
        let outline = Footprint::rectangle(0.5, 0.3).unwrap();
        let ahead = path(&[(0.0, 0.0), (9.0, 0.0)]);
        assert!(!outline_is_blocked(&grid, &ahead, &outline, 2.5));
        assert!(outline_is_blocked(&grid, &ahead, &outline, 3.0));
        assert!(!outline_is_blocked(
            &grid,
            &path(&[(0.0, 0.0), (0.0, 9.0)]),
            &outline,
            3.0
        ));
        assert!(!outline_is_blocked(&grid, &path(&[]), &outline, 3.0));
    }
}
