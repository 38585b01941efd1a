//! A spatial index of points that are added one by one.
//!
//! In: points, one by one. Out: the point nearest to a place, and all points within a distance of
//! it.
//!
//! A raster whose cells hold two points on average: when there are more, the cells are halved and
//! all points are registered again, at constant average cost per point. Points of a tree are evenly
//! spread, which suits a raster; a k-d tree would have to be kept balanced while it grows.

use nalgebra::Point2;

/// Passes on the cells of a raster with this many columns and rows that lie on a square ring of
/// cells around one of them; row by row. It uses loops, because chained iterators made RRT take
/// twice as long.
#[inline]
pub(super) fn ring_around(
    (col, row): (i32, i32),
    ring: i32,
    (cols, rows): (i32, i32),
    mut visit: impl FnMut(i32, i32),
) {
    for r in (row - ring).max(0)..=(row + ring).min(rows - 1) {
        let is_full_row = (r - row).abs() == ring;
        let step = if is_full_row { 1 } else { (2 * ring).max(1) };
        // A plain loop: a stepped range costs RRT a quarter of its time.
        let mut c = col - ring;
        while c <= col + ring {
            if (0..cols).contains(&c) {
                visit(c, r);
            }
            c += step;
        }
    }
}

const NONE: u32 = u32::MAX;
/// Cells along the longer side, at first.
const FIRST_CELLS: f64 = 8.0;
/// Up to this many points a linear search is faster than cells, most of which are empty.
const FEW: usize = 64;
/// Most cells.
const MOST_CELLS: usize = 1 << 22;

/// An index of points; each is named by its number in the order of insertion.
#[derive(Clone, Debug)]
pub(super) struct PointIndex {
    bounds: (Point2<f64>, Point2<f64>),
    side: f64,
    cols: i32,
    rows: i32,
    /// The last point of each cell.
    heads: Vec<u32>,
    /// The point before each one in the same cell.
    before: Vec<u32>,
    points: Vec<Point2<f64>>,
}

impl PointIndex {
    /// An empty index; points outside `bounds` are found more slowly.
    pub(super) fn new(bounds: (Point2<f64>, Point2<f64>)) -> Self {
        let side = ((bounds.1 - bounds.0).max() / FIRST_CELLS).max(1e-3);
        let mut index = Self {
            bounds,
            side,
            cols: 1,
            rows: 1,
            heads: vec![],
            before: vec![],
            points: vec![],
        };
        index.lay_out(side);
        index
    }

    pub(super) fn points(&self) -> &[Point2<f64>] {
        &self.points
    }

    pub(super) fn insert(&mut self, point: Point2<f64>) {
        self.points.push(point);
        self.before.push(NONE);
        self.register(self.points.len() - 1);
        let cells = self.heads.len();
        if self.points.len() > 2 * cells && 4 * cells <= MOST_CELLS {
            self.lay_out(0.5 * self.side);
        }
    }

    fn lay_out(&mut self, side: f64) {
        let extent = self.bounds.1 - self.bounds.0;
        let cells = |length: f64| (length / side).ceil().clamp(1.0, 4096.0) as i32;
        self.side = side;
        (self.cols, self.rows) = (cells(extent.x), cells(extent.y));
        self.heads = vec![NONE; (self.cols * self.rows) as usize];
        for point in 0..self.points.len() {
            self.register(point);
        }
    }

    fn register(&mut self, point: usize) {
        let (col, row) = self.cell_of(self.points[point]);
        let head = &mut self.heads[(row * self.cols + col) as usize];
        self.before[point] = std::mem::replace(head, point as u32);
    }

    /// The cell of a point; the nearest one if it lies outside.
    fn cell_of(&self, point: Point2<f64>) -> (i32, i32) {
        let at = (point - self.bounds.0) / self.side;
        let cell = |at: f64, count: i32| (at.floor() as i32).clamp(0, count - 1);
        (cell(at.x, self.cols), cell(at.y, self.rows))
    }

    #[inline]
    fn each_in(&self, col: i32, row: i32, mut visit: impl FnMut(usize, Point2<f64>)) {
        let mut at = self.heads[(row * self.cols + col) as usize];
        while at != NONE {
            visit(at as usize, self.points[at as usize]);
            at = self.before[at as usize];
        }
    }

    /// Passes on all points within `radius` of `point`, and their squared distances.
    pub(super) fn within(
        &self,
        point: Point2<f64>,
        radius: f64,
        mut visit: impl FnMut(usize, f64),
    ) {
        let spare = nalgebra::Vector2::new(radius, radius);
        let (low, high) = (self.cell_of(point - spare), self.cell_of(point + spare));
        for row in low.1..=high.1 {
            for col in low.0..=high.0 {
                self.each_in(col, row, |number, other| {
                    let squared = (other - point).norm_squared();
                    if squared <= radius * radius {
                        visit(number, squared);
                    }
                });
            }
        }
    }

    /// As [`PointIndex::nearest`], by a linear search.
    fn nearest_of_few(&self, point: Point2<f64>) -> Option<(usize, f64)> {
        let mut best = (0, f64::INFINITY);
        for (number, other) in self.points.iter().enumerate() {
            let squared = (other - point).norm_squared();
            if squared < best.1 {
                best = (number, squared);
            }
        }
        best.1.is_finite().then(|| (best.0, best.1.sqrt()))
    }

    /// Number and distance of the nearest point, of equal ones the oldest; `None` while there is
    /// none.
    pub(super) fn nearest(&self, point: Point2<f64>) -> Option<(usize, f64)> {
        if self.points.len() <= FEW {
            return self.nearest_of_few(point);
        }
        let (col, row) = self.cell_of(point);
        let at = (point - self.bounds.0) / self.side;
        let to_border = |at: f64, cell: i32| (at - f64::from(cell)).min(f64::from(cell + 1) - at);
        // Negative outside: every point that the rings so far do not contain lies at least this far
        // away.
        let inside = to_border(at.x, col).min(to_border(at.y, row)).min(0.5);
        let mut best: Option<(usize, f64)> = None;
        for ring in 0..self.cols.max(self.rows) {
            ring_around((col, row), ring, (self.cols, self.rows), |c, r| {
                self.each_in(c, r, |number, other| {
                    let squared = (other - point).norm_squared();
                    let is_nearer = best.is_none_or(|(n, least)| {
                        squared < least || (squared == least && number < n)
                    });
                    if is_nearer {
                        best = Some((number, squared));
                    }
                });
            });
            let covered = ((f64::from(ring) + inside) * self.side).max(0.0);
            if best.is_some_and(|(_, squared)| squared < covered * covered) {
                break;
            }
        }
        best.map(|(number, squared)| (number, squared.sqrt()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn finds_what_a_scan_of_all_points_finds(
            points in proptest::collection::vec((-1.0..11.0_f64, -1.0..7.0_f64), 1..900),
            queries in proptest::collection::vec((-3.0..13.0_f64, -3.0..9.0_f64, 0.0..4.0_f64), 20),
        ) {
            let mut index = PointIndex::new((Point2::origin(), Point2::new(10.0, 6.0)));
            prop_assert!(index.nearest(Point2::origin()).is_none());
            for &(x, y) in &points {
                index.insert(Point2::new(x, y));
            }
            for &(x, y, radius) in &queries {
                let at = Point2::new(x, y);
                let distances: Vec<f64> = points.iter().map(|&(x, y)| (Point2::new(x, y) - at).norm_squared()).collect();
                let least = distances.iter().copied().fold(f64::INFINITY, f64::min);
                let (number, distance) = index.nearest(at).unwrap();
                prop_assert_eq!(distances.iter().position(|&d| d == least), Some(number));
                prop_assert_eq!(distance, least.sqrt());
                let mut found = vec![];
                index.within(at, radius, |number, _| found.push(number));
                found.sort_unstable();
                let all: Vec<usize> = (0..points.len()).filter(|&i| distances[i] <= radius * radius).collect();
                prop_assert_eq!(found, all);
            }
        }
    }
}
