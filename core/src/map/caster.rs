//! How far a beam goes over a grid.
//!
//! In: a rectangle of cells and which of them are occupied; rays. Out: the distance at which each ray enters the first occupied cell.
//!
//! 1. Each cell keeps how many rings of cells around it have none that is occupied: its Chebyshev distance from the nearest occupied
//!    cell, a byte. Two sweeps over eight neighbours give it exactly (Rosenfeld & Pfaltz 1966).
//! 2. A ray goes at once to where it leaves the square of free cells around its cell. Where the square is the cell alone that is the
//!    step of Amanatides & Woo (1987), so the answer is the same, cell by cell; in the open a step spans a room.
//!
//! Squares fit a building better than the discs of an Euclidean distance field: the side of the square lies along the wall, and the
//! ray that leaves it there is at the wall.

use nalgebra::{Point2, Vector2};

use super::CellRect;

/// A grid made ready for many rays.
#[derive(Clone, Debug)]
pub struct GridCaster {
    rect: CellRect,
    resolution: f64,
    /// 0 where occupied; never more than 255.
    rings: Vec<u8>,
}

impl GridCaster {
    /// `occupied` holds the rows of `rect` one after another, lower row first; cells that it is too short for are free.
    ///
    /// # Units    `resolution`: side of a cell, m.
    #[must_use]
    pub fn new(rect: CellRect, resolution: f64, occupied: &[bool]) -> Self {
        let mut rings = vec![u8::MAX; rect.width() * rect.height()];
        for (rings, _) in rings.iter_mut().zip(occupied).filter(|(_, is)| **is) {
            *rings = 0;
        }
        let width = rect.width();
        for row in 0..rect.height() {
            let (before, from) = rings.split_at_mut(row * width);
            let below = before.len().checked_sub(width).map(|at| &before[at..]);
            spread(below, &mut from[..width]);
        }
        // The same from the other end.
        rings.reverse();
        for row in 0..rect.height() {
            let (before, from) = rings.split_at_mut(row * width);
            let above = before.len().checked_sub(width).map(|at| &before[at..]);
            spread(above, &mut from[..width]);
        }
        rings.reverse();
        Self {
            rect,
            resolution,
            rings,
        }
    }

    /// Distance from `origin` to where the ray enters the first occupied cell, m; 0 in an occupied cell. `None` where there is none
    /// within `range`, or the ray leaves the rectangle before (or begins outside).
    ///
    /// # Units    map frame, m; `direction` of length 1.
    #[inline]
    #[must_use]
    pub fn cast(&self, origin: Point2<f64>, direction: Vector2<f64>, range: f64) -> Option<f64> {
        let scale = 1.0 / self.resolution;
        let low = Vector2::new(f64::from(self.rect.min.col), f64::from(self.rect.min.row));
        let start = origin.coords * scale - low;
        self.cast_in_cells(start, direction, range * scale)
            .map(|cells| cells * self.resolution)
    }

    /// In cells, from the corner of the rectangle.
    #[inline]
    fn cast_in_cells(&self, start: Vector2<f64>, way: Vector2<f64>, range: f64) -> Option<f64> {
        let (width, height) = (self.rect.width(), self.rect.height());
        let size = Vector2::new(width as f64, height as f64);
        let is_inside = start.x >= 0.0 && start.y >= 0.0 && start.x < size.x && start.y < size.y;
        if !is_inside {
            return None;
        }
        let x = Axis::new(start.x, way.x);
        let y = Axis::new(start.y, way.y);
        let (mut col, mut row) = (x.cell(0.0), y.cell(0.0));
        let mut gone = 0.0;
        while gone <= range {
            // Negative ones become large.
            if col as usize >= width || row as usize >= height {
                return None;
            }
            let rings = i64::from(self.rings[row as usize * width + col as usize]);
            if rings == 0 {
                return Some(gone);
            }
            let (leaves_x, leaves_y) = (x.leaves(col, rings), y.leaves(row, rings));
            if leaves_x < leaves_y {
                gone = leaves_x;
                // Rounding must not carry it out of the square on the other side.
                row = y.cell(gone).clamp(row - rings + 1, row + rings - 1);
                col += x.step * rings;
            } else {
                gone = leaves_y;
                col = x.cell(gone).clamp(col - rings + 1, col + rings - 1);
                row += y.step * rings;
            }
        }
        None
    }
}

/// One coordinate of a ray.
struct Axis {
    start: f64,
    way: f64,
    inverse: f64,
    step: i64,
    /// From the lower side of a cell to that by which the ray leaves it.
    side: i64,
}

impl Axis {
    #[inline]
    fn new(start: f64, way: f64) -> Self {
        let is_forward = way >= 0.0;
        Self {
            start,
            way,
            // 1 / -0 would be behind.
            inverse: if way == 0.0 { f64::INFINITY } else { 1.0 / way },
            step: if is_forward { 1 } else { -1 },
            side: i64::from(is_forward),
        }
    }

    #[inline]
    fn cell(&self, gone: f64) -> i64 {
        let at = self.start + gone * self.way;
        // `floor` by hand: where the machine has no instruction for it, it is a call.
        at as i64 - i64::from(at < (at as i64) as f64)
    }

    /// Where the ray leaves the square of free cells around a cell by this coordinate.
    #[inline]
    fn leaves(&self, cell: i64, rings: i64) -> f64 {
        let side = cell + self.side + self.step * (rings - 1);
        (side as f64 - self.start) * self.inverse
    }
}

/// Takes over what the row before and the cell before know; the row before has all of its own.
fn spread(before: Option<&[u8]>, row: &mut [u8]) {
    if let Some(before) = before {
        let last = before.len().saturating_sub(1);
        for (at, cell) in row.iter_mut().enumerate() {
            let near = &before[at.saturating_sub(1)..=(at + 1).min(last)];
            let least = near.iter().min().copied().unwrap_or(u8::MAX);
            *cell = (*cell).min(least.saturating_add(1));
        }
    }
    let mut left = u8::MAX;
    for cell in row {
        left = (*cell).min(left.saturating_add(1));
        *cell = left;
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::geom::sin_cos;
    use crate::map::CellIndex;

    const SIDE: usize = 24;

    fn caster(low: (i32, i32), occupied: &[bool]) -> GridCaster {
        let min = CellIndex {
            col: low.0,
            row: low.1,
        };
        let max = CellIndex {
            col: low.0 + SIDE as i32,
            row: low.1 + SIDE as i32,
        };
        GridCaster::new(CellRect { min, max }, 0.05, occupied)
    }

    fn of_cells(cells: &[usize]) -> Vec<bool> {
        (0..SIDE * SIDE).map(|at| cells.contains(&at)).collect()
    }

    /// The nearest of all occupied squares, each cut by the ray; those that it touches at a corner only are left open.
    fn brute(occupied: &[bool], start: Vector2<f64>, way: Vector2<f64>) -> (f64, f64) {
        let (mut surely, mut perhaps) = (f64::INFINITY, f64::INFINITY);
        for at in (0..occupied.len()).filter(|at| occupied[*at]) {
            let low = Vector2::new((at % SIDE) as f64, (at / SIDE) as f64) - start;
            let (mut enters, mut leaves) = (0.0_f64, f64::INFINITY);
            for axis in 0..2 {
                let (a, b) = (low[axis] / way[axis], (low[axis] + 1.0) / way[axis]);
                enters = enters.max(a.min(b));
                leaves = leaves.min(a.max(b));
            }
            if leaves > enters + 1e-9 {
                surely = surely.min(enters);
            }
            if leaves > enters - 1e-9 {
                perhaps = perhaps.min(enters);
            }
        }
        (surely, perhaps)
    }

    proptest! {
        #[test]
        fn every_ray_ends_where_it_enters_the_first_occupied_square(
            cells in proptest::collection::vec(0..SIDE * SIDE, 0..40),
            x in 0.0..24.0_f64, y in 0.0..24.0_f64, bearing in -3.2..3.2_f64, low in (-90..90, -90..90),
        ) {
            let occupied = of_cells(&cells);
            let (sin, cos) = sin_cos(bearing);
            let (start, way) = (Vector2::new(x, y), Vector2::new(cos, sin));
            let (surely, perhaps) = brute(&occupied, start, way);
            let corner = Vector2::new(f64::from(low.0), f64::from(low.1));
            let origin = Point2::from((start + corner) * 0.05);
            let found = caster(low, &occupied).cast(origin, way, 100.0).unwrap_or(f64::INFINITY) / 0.05;
            let is = |expected: f64| found == expected || (found - expected).abs() < 1e-6;
            prop_assert!(is(surely) || is(perhaps), "{found}, expected {surely} or {perhaps}");
        }

        #[test]
        fn rings_are_those_of_brute_force(cells in proptest::collection::vec(0..SIDE * SIDE, 0..6)) {
            let caster = caster((0, 0), &of_cells(&cells));
            for at in 0..SIDE * SIDE {
                let off = |c: &usize| (c % SIDE).abs_diff(at % SIDE).max((c / SIDE).abs_diff(at / SIDE));
                let expected = cells.iter().map(off).min().unwrap_or(255);
                prop_assert_eq!(usize::from(caster.rings[at]), expected);
            }
        }
    }

    #[test]
    fn along_the_axes_and_beyond_the_range() {
        let caster = caster((0, 0), &of_cells(&[12 * SIDE + 20]));
        let cast =
            |x, y, dx, dy, range| caster.cast(Point2::new(x, y), Vector2::new(dx, dy), range);
        let near = |found: Option<f64>, expected: f64| (found.unwrap() - expected).abs() < 1e-12;
        assert!(near(cast(0.1, 0.62, 1.0, 0.0, 9.0), 0.9));
        assert!(near(cast(0.1, 0.62, 1.0, -0.0, 9.0), 0.9));
        assert!(near(cast(1.02, 0.1, 0.0, 1.0, 9.0), 0.5));
        assert!(near(cast(1.02, 0.62, 0.0, 1.0, 9.0), 0.0));
        assert_eq!(cast(0.1, 0.62, 1.0, 0.0, 0.89), None);
        assert_eq!(cast(0.1, 0.62, -1.0, 0.0, 9.0), None);
        assert_eq!(cast(-0.1, 0.62, 1.0, 0.0, 9.0), None);
        assert_eq!(cast(f64::NAN, 0.62, 1.0, 0.0, 9.0), None);
        assert_eq!(cast(0.1, 0.62, f64::NAN, 0.0, 9.0), None);
        assert_eq!(cast(0.1, 0.62, 0.0, 0.0, f64::INFINITY), None);
    }
}
