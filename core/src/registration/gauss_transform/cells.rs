//! Points sorted into the cells of a grid, row by row, so all points near a place lie in a few
//! runs.

use std::ops::Range;

use nalgebra::Point2;

/// Cells across the radius of a search. More cells include fewer points that are too far away, but
/// need more runs.
const CELLS_A_RADIUS: f64 = 2.0;
/// With more cells than this per point, the cells are made larger.
const MOST_CELLS_A_POINT: f64 = 4.0;

/// The range of each cell's points in the sorted order.
pub(crate) struct Cells {
    least: Point2<f64>,
    /// Cells per metre.
    per_metre: f64,
    /// m.
    pub(crate) radius: f64,
    columns: usize,
    rows: usize,
    /// For each cell and one beyond, the index of its first point.
    first: Vec<u32>,
    /// The points' indices in the given list.
    pub(crate) order: Vec<u32>,
}

impl Cells {
    /// Cells for finding points nearer than `radius`, m.
    pub(crate) fn of(points: &[Point2<f64>], radius: f64) -> Self {
        let first = points.first().copied().unwrap_or_default();
        let (mut least, mut most) = (first, first);
        for point in points {
            least = Point2::new(least.x.min(point.x), least.y.min(point.y));
            most = Point2::new(most.x.max(point.x), most.y.max(point.y));
        }
        let extent = most - least;
        let mut side = radius / CELLS_A_RADIUS;
        let cells = |side: f64| (extent.x / side + 1.0).floor() * (extent.y / side + 1.0).floor();
        let most_cells = MOST_CELLS_A_POINT * points.len() as f64 + 16.0;
        while cells(side) > most_cells {
            side *= 2.0;
        }
        let (columns, rows) = (
            (extent.x / side) as usize + 1,
            (extent.y / side) as usize + 1,
        );
        let mut cells = Self {
            least,
            per_metre: 1.0 / side,
            radius,
            columns,
            rows,
            first: vec![0; columns * rows + 1],
            order: vec![0; points.len()],
        };
        let cell = |point: &Point2<f64>| {
            let column = (((point.x - least.x) / side) as usize).min(columns - 1);
            let row = (((point.y - least.y) / side) as usize).min(rows - 1);
            row * columns + column
        };
        for point in points {
            if let Some(count) = cells.first.get_mut(cell(point) + 1) {
                *count += 1;
            }
        }
        let mut sum = 0;
        for count in &mut cells.first {
            sum += *count;
            *count = sum;
        }
        let mut next = cells.first.clone();
        for (index, point) in (0..).zip(points) {
            if let Some(at) = next.get_mut(cell(point)) {
                if let Some(slot) = cells.order.get_mut(*at as usize) {
                    *slot = index;
                }
                *at += 1;
            }
        }
        cells
    }

    /// The runs of points, in the sorted order, that contain all points within the radius of
    /// `place`, and some more.
    pub(crate) fn near(&self, place: &Point2<f64>) -> impl Iterator<Item = Range<usize>> {
        let span = |along: f64, least: f64, count: usize| {
            let from = ((along - self.radius - least) * self.per_metre).max(0.0);
            let to = (along + self.radius - least) * self.per_metre;
            // Before the first cell and beyond the last there is nothing.
            match to < 0.0 || from >= count as f64 {
                true => 0..0,
                false => from as usize..(to as usize + 1).min(count),
            }
        };
        let columns = span(place.x, self.least.x, self.columns);
        let rows = if columns.is_empty() {
            0..0
        } else {
            span(place.y, self.least.y, self.rows)
        };
        rows.filter_map(move |row| {
            let at = |column: usize| self.first.get(row * self.columns + column).copied();
            Some(at(columns.start)? as usize..at(columns.end)? as usize)
        })
    }

    /// Points and their weights in the sorted order.
    pub(super) fn sorted<const K: usize>(
        &self,
        points: &[Point2<f64>],
        weights: &[[f64; K]],
    ) -> impl Iterator<Item = (Point2<f64>, [f64; K])> {
        self.order.iter().filter_map(|index| {
            let index = *index as usize;
            Some((*points.get(index)?, *weights.get(index)?))
        })
    }

    /// How many pairs all of these targets have together.
    pub(super) fn pairs(&self, targets: &[Point2<f64>]) -> f64 {
        let of = |target| self.near(target).map(|run| run.len()).sum::<usize>();
        targets.iter().map(of).sum::<usize>() as f64
    }
}
