//! Finds nearby walls with a coarse raster over the bounds.
//!
//! In: walls, a distance, bounds. Out: for a cell, for the cells along a leg and for the rings of
//! cells around a point, every wall that is within that distance of the cell.

use nalgebra::{Point2, Vector2};

use crate::geom::{Segment, sides_of};
use crate::plan::point_index::ring_around;

/// Cells for each wall: more cells make lists shorter and walks longer.
const CELLS_PER_WALL: f64 = 8.0;
/// Least and greatest number of cells along the longer side.
const SIDE_CELLS: (f64, f64) = (8.0, 512.0);

/// Walls by the cells that they are near; cells row by row, their lists one after another.
#[derive(Clone, Debug)]
pub(super) struct Raster {
    low: Point2<f64>,
    side: f64,
    cols: i32,
    rows: i32,
    /// Where the list of each cell begins; one more than there are cells.
    starts: Vec<u32>,
    walls: Vec<u32>,
}

impl Raster {
    /// Registers each wall in all cells that are `reach` metres or less away from it.
    pub(super) fn new(
        segments: &[Segment],
        reach: f64,
        (low, high): (Point2<f64>, Point2<f64>),
    ) -> Self {
        let extent = high - low;
        let count = CELLS_PER_WALL * segments.len().max(1) as f64;
        let side = (extent.x * extent.y / count)
            .sqrt()
            .clamp(extent.max() / SIDE_CELLS.1, extent.max() / SIDE_CELLS.0);
        let cells = |length: f64| (length / side).ceil().clamp(1.0, SIDE_CELLS.1 + 1.0) as i32;
        let mut raster = Self {
            low,
            side,
            cols: cells(extent.x),
            rows: cells(extent.y),
            starts: vec![],
            walls: vec![],
        };
        let mut entries = vec![];
        for (wall, segment) in segments.iter().enumerate() {
            raster.cells_near(segment, reach, |cell| entries.push((cell, wall as u32)));
        }
        entries.sort_unstable();
        let cells = (raster.cols * raster.rows) as u32;
        let mut at = 0;
        for cell in 0..=cells {
            while entries.get(at).is_some_and(|&(of, _)| of < cell) {
                at += 1;
            }
            raster.starts.push(at as u32);
        }
        raster.walls = entries.into_iter().map(|(_, wall)| wall).collect();
        raster
    }

    fn cells_near(&self, segment: &Segment, reach: f64, mut visit: impl FnMut(u32)) {
        // Rounding must not lose a wall that only touches.
        let reach = reach + 1e-6 * self.side;
        let spare = Vector2::new(reach, reach);
        let (low, high) = (
            self.cell_at(segment.a.inf(&segment.b) - spare),
            self.cell_at(segment.a.sup(&segment.b) + spare),
        );
        for row in low.1..=high.1 {
            for col in low.0..=high.0 {
                let corner = self.low + Vector2::new(f64::from(col), f64::from(row)) * self.side;
                if distance_to_box(segment, corner, self.side) <= reach {
                    visit((row * self.cols + col) as u32);
                }
            }
        }
    }

    /// The cell of a point; the nearest one if it lies outside.
    fn cell_at(&self, point: Point2<f64>) -> (i32, i32) {
        let at = (point - self.low) / self.side;
        let cell = |at: f64, count: i32| (at.floor() as i32).clamp(0, count - 1);
        (cell(at.x, self.cols), cell(at.y, self.rows))
    }

    #[inline]
    fn list(&self, col: i32, row: i32) -> &[u32] {
        let cell = (row * self.cols + col) as usize;
        &self.walls[self.starts[cell] as usize..self.starts[cell + 1] as usize]
    }

    /// The walls within reach of the cell of a point.
    #[inline]
    pub(super) fn at(&self, point: Point2<f64>) -> &[u32] {
        let (col, row) = self.cell_at(point);
        self.list(col, row)
    }

    /// Passes the walls of each cell along a leg to `visit`, with the distance along the leg at
    /// which the cell ends; stops when `visit` returns `false`.
    #[inline]
    pub(super) fn walk(
        &self,
        origin: Point2<f64>,
        direction: Vector2<f64>,
        length: f64,
        mut visit: impl FnMut(&[u32], f64) -> bool,
    ) {
        let (mut col, mut row) = self.cell_at(origin);
        let axis = |at: f64, low: f64, along: f64, cell: i32| {
            let step = if along > 0.0 { 1 } else { -1 };
            let border = low + f64::from(cell + i32::from(along > 0.0)) * self.side;
            let inverse = 1.0 / along;
            // The leg is parallel to these borders and never meets one (0 · ∞ would be NaN).
            if along == 0.0 {
                (0, f64::INFINITY, f64::INFINITY)
            } else {
                (step, (border - at) * inverse, self.side * inverse.abs())
            }
        };
        let (step_col, mut to_col, d_col) = axis(origin.x, self.low.x, direction.x, col);
        let (step_row, mut to_row, d_row) = axis(origin.y, self.low.y, direction.y, row);
        loop {
            let until = to_col.min(to_row);
            if !visit(self.list(col, row), until) || until >= length {
                return;
            }
            if to_col < to_row {
                col += step_col;
                to_col += d_col;
                if !(0..self.cols).contains(&col) {
                    return;
                }
            } else {
                row += step_row;
                to_row += d_row;
                if !(0..self.rows).contains(&row) {
                    return;
                }
            }
        }
    }

    /// Passes the walls of the cells around a point to `visit`, ring by ring, with the distance
    /// within which all walls have then been seen; stops when `visit` returns `false`.
    pub(super) fn rings(&self, point: Point2<f64>, mut visit: impl FnMut(&[u32], f64) -> bool) {
        let (col, row) = self.cell_at(point);
        let at = (point - self.low) / self.side - Vector2::new(f64::from(col), f64::from(row));
        let to_border = at.min().min(1.0 - at.max()).max(0.0);
        for ring in 0..self.cols.max(self.rows) {
            let covered = (f64::from(ring) + to_border) * self.side;
            let mut goes_on = true;
            ring_around((col, row), ring, (self.cols, self.rows), |c, r| {
                goes_on = visit(self.list(c, r), covered);
            });
            if !goes_on {
                return;
            }
        }
    }
}

/// Distance of a segment from a square given by its lower left corner, m.
fn distance_to_box(segment: &Segment, low: Point2<f64>, side: f64) -> f64 {
    let high = low + Vector2::new(side, side);
    let is_inside = |p: Point2<f64>| (p - low).min() >= 0.0 && (high - p).min() >= 0.0;
    if is_inside(segment.a) || is_inside(segment.b) {
        return 0.0;
    }
    let corners = [
        low,
        Point2::new(high.x, low.y),
        high,
        Point2::new(low.x, high.y),
    ];
    sides_of(&corners)
        .map(|(a, b)| Segment::new(*a, *b).distance_to(segment))
        .fold(f64::INFINITY, f64::min)
}
