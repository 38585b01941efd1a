//! The distance to the nearest wall anywhere in a map, and whether a wall lies between two places.
//!
//! In: walls as segments. Out: a grid of distances, a byte each, up to [`WallDistance::REACH`].
//!
//! 1. The exact distance transform ([`DistanceField`]) of the cells that walls run through, from
//!    cell centre to cell centre.
//! 2. Near a wall these distances are wrong by up to half a cell, so cells there take the distance
//!    of their centre from the wall itself.
//! 3. A ray advances by the distance to the nearest wall, within which it can meet none (sphere
//!    tracing: Hart 1996).

use nalgebra::Point2;

use super::{CellIndex, CellRect, DistanceField};
use crate::geom::{Length, Segment, bounds};

/// Most cells: a byte each, and five more while they are built.
const MOST_CELLS: f64 = 16e6;
/// How often the cell size may be doubled if the walls span more.
const DOUBLINGS: u32 = 5;
/// Distance of one step of the byte, m.
const STEP: f64 = 0.004;
/// Walls are exact within this many cells (step 2).
const EXACT_CELLS: i32 = 5;
/// A ray touches a wall when it comes this near to it, in cells; it has passed through when it is
/// then this far from every wall, in cells. In between it may run along the wall, or past a corner.
const TOUCHES: f64 = 0.8;
const IS_CLEAR: f64 = 4.0;

/// Distances to walls.
#[derive(Clone, Debug)]
pub struct WallDistance {
    low: Point2<f64>,
    cell: f64,
    cols: i32,
    rows: i32,
    steps: Vec<u8>,
}

impl WallDistance {
    /// Greater distances are given as this, m.
    pub const REACH: f64 = 255.0 * STEP;

    /// The distances to `faces`, in cells of `cell` metres, or doubled until the map can be held.
    /// `None` if there are no faces, or they span too much even then.
    #[must_use]
    pub fn new(faces: &[Segment], cell: f64) -> Option<Self> {
        let finite =
            |face: &&Segment| face.a.coords.sum().is_finite() && face.b.coords.sum().is_finite();
        let faces: Vec<&Segment> = faces.iter().filter(finite).collect();
        let (low, high) = bounds(faces.iter().flat_map(|face| [face.a, face.b]))?;
        let extent = (high - low).add_scalar(2.0 * Self::REACH);
        let cell = (0..=DOUBLINGS)
            .map(|times| cell * f64::from(1 << times))
            .find(|cell| (extent.x / cell + 1.0) * (extent.y / cell + 1.0) <= MOST_CELLS)?;
        let [cols, rows] = [extent.x, extent.y].map(|along| (along / cell).ceil() as i32 + 1);
        let mut field = Self {
            low: Point2::from(low.coords.add_scalar(-Self::REACH)),
            cell,
            cols,
            rows,
            steps: vec![],
        };
        field.measure(&faces);
        Some(field)
    }

    fn measure(&mut self, faces: &[&Segment]) {
        let mut sources = vec![false; (self.cols * self.rows) as usize];
        let mut near = vec![f32::INFINITY; sources.len()];
        for face in faces {
            let count = (face.length() / self.cell).ceil().max(1.0) as usize;
            for i in 0..=count {
                let piece = face.a + face.vector() * (i as f64 / count as f64);
                let (col, row) = self.cell_of(piece);
                if let Some(at) = self.index((col, row)) {
                    sources[at] = true;
                }
                for r in row - EXACT_CELLS..=row + EXACT_CELLS {
                    for c in col - EXACT_CELLS..=col + EXACT_CELLS {
                        if let Some(at) = self.index((c, r)) {
                            let distance = face.distance(self.middle_of((c, r))) as f32;
                            near[at] = near[at].min(distance);
                        }
                    }
                }
            }
        }
        let rect = CellRect {
            min: CellIndex::new(0, 0),
            max: CellIndex::new(self.cols, self.rows),
        };
        let far = DistanceField::new(rect, self.cell, &sources).into_distances();
        let exact = (f64::from(EXACT_CELLS - 1) * self.cell) as f32;
        let nearest = near
            .iter()
            .zip(&far)
            .map(|(near, far)| match *near < exact {
                true => *near,
                false => *far,
            });
        self.steps = nearest
            .map(|distance| (f64::from(distance) / STEP).round().min(255.0) as u8)
            .collect();
    }

    /// Side of a cell, m.
    #[must_use]
    pub fn cell(&self) -> f64 {
        self.cell
    }

    /// The bounding rectangle of the walls, extended by [`Self::REACH`] on each side.
    #[must_use]
    pub fn extent(&self) -> (Point2<f64>, Point2<f64>) {
        let along = |cells: i32| f64::from(cells) * self.cell;
        let size = nalgebra::Vector2::new(along(self.cols), along(self.rows));
        (self.low, self.low + size)
    }

    /// Distance of a place from the nearest wall, accurate to about half a cell, m; [`Self::REACH`]
    /// if it is greater, and outside the map.
    #[inline]
    #[must_use]
    pub fn at(&self, place: Point2<f64>) -> f64 {
        f64::from(self.step_at(place)) * STEP
    }

    /// That distance as a number of steps, 0 to 255, each [`Self::REACH`] / 255: an index into a
    /// table.
    #[inline]
    #[must_use]
    pub fn step_at(&self, place: Point2<f64>) -> u8 {
        let index = self.index(self.cell_of(place));
        index
            .and_then(|at| self.steps.get(at))
            .copied()
            .unwrap_or(u8::MAX)
    }

    /// Whether the straight line between two places passes through a wall. A wall at which it ends,
    /// or that it only touches, does not count.
    #[must_use]
    pub fn is_between(&self, from: Point2<f64>, to: Point2<f64>) -> bool {
        let way = to - from;
        let length = way.length();
        if !(length > 0.0 && length.is_finite()) {
            return false;
        }
        let (mut gone, mut has_touched) = (0.0, false);
        while gone < length {
            let distance = self.at(from + way * (gone / length));
            if distance < TOUCHES * self.cell {
                has_touched = true;
            } else if has_touched && distance > IS_CLEAR * self.cell {
                return true;
            }
            gone += (distance - self.cell).max(0.5 * self.cell);
        }
        false
    }

    #[inline]
    fn cell_of(&self, place: Point2<f64>) -> (i32, i32) {
        let at = (place - self.low) / self.cell;
        // Saturates; NaN becomes 0, an empty cell at the rim.
        (at.x.floor() as i32, at.y.floor() as i32)
    }

    fn middle_of(&self, (col, row): (i32, i32)) -> Point2<f64> {
        let middle = nalgebra::Vector2::new(f64::from(col) + 0.5, f64::from(row) + 0.5);
        self.low + middle * self.cell
    }

    #[inline]
    fn index(&self, (col, row): (i32, i32)) -> Option<usize> {
        let is_inside = col >= 0 && row >= 0 && col < self.cols && row < self.rows;
        is_inside.then(|| row as usize * self.cols as usize + col as usize)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn wall(ax: f64, ay: f64, bx: f64, by: f64) -> Segment {
        Segment::new(Point2::new(ax, ay), Point2::new(bx, by))
    }

    proptest! {
        #[test]
        fn distances_are_those_of_the_segments(
            ends in proptest::collection::vec(prop::array::uniform4(-4.0..4.0_f64), 1..5),
            x in -4.5..4.5_f64, y in -4.5..4.5_f64,
        ) {
            let walls: Vec<_> = ends.iter().map(|[a, b, c, d]| wall(*a, *b, *c, *d)).collect();
            let field = WallDistance::new(&walls, 0.05).unwrap();
            let place = Point2::new(x, y);
            let brute = walls.iter().map(|w| w.distance(place)).fold(f64::INFINITY, f64::min);
            let brute = brute.min(WallDistance::REACH);
            // Half a diagonal of a cell for the place, another for the wall if it is far, and half
            // a step.
            let most = if brute < 0.15 { 0.0375 } else { 0.0725 };
            prop_assert!((field.at(place) - brute).abs() < most, "{} {brute}", field.at(place));
        }
    }

    #[test]
    fn a_ray_through_a_wall_is_told_from_one_that_ends_at_it_or_runs_along_it() {
        let walls = [wall(0.0, 0.0, 4.0, 0.0), wall(4.0, 0.0, 4.0, 3.0)];
        let field = WallDistance::new(&walls, 0.05).unwrap();
        let between = |ax, ay, bx, by| field.is_between(Point2::new(ax, ay), Point2::new(bx, by));
        assert!(between(2.0, 1.0, 2.0, -1.0));
        assert!(between(2.0, 1.0, 1.0, -0.6));
        assert!(!between(2.0, 1.0, 2.0, 0.0));
        assert!(!between(0.5, 1.0, 3.98, 0.02));
        // Two centimetres off the wall, all along.
        assert!(!between(0.0, 0.02, 3.9, 0.02));
        // Past the end of a wall.
        assert!(!between(-0.4, -1.0, -0.4, 1.0));
        assert!(!between(2.0, 1.0, 2.0, 1.0) && !between(f64::NAN, 1.0, 2.0, 1.0));
    }

    #[test]
    fn far_walls_are_laid_in_larger_cells_and_none_or_too_far_ones_not_at_all() {
        let far = WallDistance::new(&[wall(0.0, 0.0, 500.0, 500.0)], 0.05).unwrap();
        assert!(far.cell() > 0.1);
        assert!(WallDistance::new(&[wall(0.0, 0.0, 1e7, 1e7)], 0.05).is_none());
        assert!(WallDistance::new(&[], 0.05).is_none());
    }
}
