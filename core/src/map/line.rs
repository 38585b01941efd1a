//! A straight line over the cells of a grid, as slices along its longer axis.
//!
//! In: the two ends, in cells. Out: for each row (or for each column, if the line is longer along
//! y) the cells from where the line enters to where it leaves.
//!
//! 1. The axis along which the line is longer is called along, the other one across; the line is
//!    taken in the direction in which along grows.
//! 2. At border k between slices, counted from 0, the line is at u₁ + k s along, where s = |Δu /
//!    Δv| ≥ 1 is its slope and u₁ its place at the first border. Places are fixed-point numbers
//!    with [`FRACTION`] binary digits after the point: each slice costs one addition, and a shift
//!    that gives the cell.
//! 3. [`CellLine::crossed`]: both slices beside a border contain the cell at that place, so every
//!    cell is there that the line enters.
//! 4. [`CellLine::bresenham`]: along the longer axis every column (or row) has one cell, whose
//!    centre is nearest to the line between the centres of the first and the last cell; of two such
//!    cells the one farther on. With n columns and m rows, row k begins at column ⌈n (2k - 1) /
//!    2m⌉.
//!
//! Places are nudged by more than the rounding error, so that a border which a line meets exactly
//! always falls on the same side. In step 4 the nudge is less than the least distance from a
//! border, 1 / 2m; in step 3 it is next to nothing, and a line through a corner of four cells is
//! taken to pass where along is greater.
//!
//! Sources: Amanatides & Woo (1987), "A fast voxel traversal algorithm for ray tracing", for what
//! step 3 visits; Bresenham (1965), "Algorithm for computer control of a digital plotter", as in
//! Celej §4 (`BresenhamLine`), and for its slices Bresenham (1985), "Run length slice algorithm for
//! incremental lines".

use nalgebra::Point2;

use super::CellIndex;
use super::ray::are_in_reach;

/// Binary digits after the point of a fixed-point number.
pub(super) const FRACTION: u32 = 44;
/// Longest line along either axis, cells: 13 km at 5 cm.
const REACH: i64 = 1 << 18;
/// For step 3, in cells: the rounding error of a thousand slices.
const CORNER_NUDGE: f64 = 1.0 / (1_i64 << 34) as f64;
/// For step 4, in cells: between the rounding error over the longest line and 1 / 2m.
const MIDDLE_NUDGE: f64 = 1.0 / (1_i64 << 22) as f64;

/// A line in slices; along grows from slice to slice.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CellLine {
    /// Whether along is x and slices are of rows; otherwise along is y and slices are of columns.
    pub(super) is_flat: bool,
    /// Row (or column) of the first slice.
    pub(super) across: i32,
    /// Step from one slice to the next, 1 or -1.
    pub(super) step: i32,
    /// Number of slices after the first one.
    pub(super) more: u32,
    /// First cell of the first slice.
    pub(super) from: i32,
    /// Last cell of the last slice.
    pub(super) to: i32,
    /// Where the second slice begins, measured from the lower border of `from`; fixed-point.
    pub(super) border: i64,
    /// How much farther on each further slice begins; fixed-point.
    pub(super) slope: i64,
    /// Difference between the first cell of a slice and the last cell of the slice before: 0 or 1.
    pub(super) gap: usize,
}

/// Neighbouring cells of one row (or column), both ends included.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Slice {
    pub(super) across: i32,
    pub(super) from: i32,
    pub(super) to: i32,
}

impl CellLine {
    /// Every cell that the line from `start` to `end` enters. `None` if an end is not finite or
    /// they are too far apart.
    pub(crate) fn crossed(start: Point2<f64>, end: Point2<f64>) -> Option<Self> {
        let way = end - start;
        let is_flat = way.x.abs() >= way.y.abs();
        let ([a, b], _) = in_order([start, end], is_flat);
        let mut line = Self::between(cell_in(a), cell_in(b), is_flat, [a, b])?;
        if line.more > 0 {
            let slope = (b.x - a.x) / (b.y - a.y).abs();
            let border = f64::from(line.across) + if line.step > 0 { 1.0 } else { 0.0 };
            let place = (a.x - f64::from(line.from)) + (border - a.y).abs() * slope;
            (line.border, line.slope) = (fixed(place + CORNER_NUDGE), fixed(slope));
            // The nudge must not carry the line past its end.
            let last = line.border + i64::from(line.more - 1) * line.slope;
            let most = (i64::from(line.to - line.from + 1) << FRACTION) - 1;
            line.border -= (last - most).max(0);
        }
        Some(line)
    }

    /// The cells of Bresenham's line from the cell of `start` to that of `end`. `None` if an end is
    /// not finite or they are too far apart.
    pub(super) fn bresenham(start: Point2<f64>, end: Point2<f64>) -> Option<Self> {
        let cells = [start, end].map(CellIndex::holding);
        let cols = i64::from(cells[1].col) - i64::from(cells[0].col);
        let rows = i64::from(cells[1].row) - i64::from(cells[0].row);
        let is_flat = cols.abs() >= rows.abs();
        let ([a, b], is_turned) = in_order([start, end], is_flat);
        let mut line = Self::between(cell_in(a), cell_in(b), is_flat, [a, b])?;
        line.gap = 1;
        if line.more > 0 {
            let slope = f64::from(line.to - line.from) / f64::from(line.more);
            let nudge = if is_turned {
                MIDDLE_NUDGE
            } else {
                -MIDDLE_NUDGE
            };
            (line.border, line.slope) = (fixed(0.5 * slope + nudge), fixed(slope));
        }
        Some(line)
    }

    /// Everything except the slices between the first and the last cell, which are given as along
    /// and across.
    fn between(
        first: [i32; 2],
        last: [i32; 2],
        is_flat: bool,
        ends: [Point2<f64>; 2],
    ) -> Option<Self> {
        let across = i64::from(last[1]) - i64::from(first[1]);
        let along = i64::from(last[0]) - i64::from(first[0]);
        let is_short = along < REACH && across.abs() < REACH;
        (are_in_reach(ends[0], ends[1]) && is_short).then_some(Self {
            is_flat,
            across: first[1],
            step: across.signum() as i32,
            more: across.unsigned_abs() as u32,
            from: first[0],
            to: last[0],
            border: 0,
            slope: 0,
            gap: 0,
        })
    }

    /// The slices in order.
    pub(super) fn slices(self) -> impl Iterator<Item = Slice> {
        let last_of = move |slice: u32| {
            let place = self.border + i64::from(slice) * self.slope;
            self.from + (place >> FRACTION) as i32
        };
        (0..=self.more).map(move |slice| Slice {
            across: self.across + self.step * slice as i32,
            from: if slice == 0 {
                self.from
            } else {
                last_of(slice - 1) + self.gap as i32
            },
            to: if slice == self.more {
                self.to
            } else {
                last_of(slice)
            },
        })
    }

    /// The first and the last cell.
    pub(super) fn ends(&self) -> [CellIndex; 2] {
        [
            self.cell(self.from, self.across),
            self.cell(self.to, self.last_across()),
        ]
    }

    /// Row (or column) of the last slice.
    pub(super) fn last_across(&self) -> i32 {
        self.across + self.step * self.more as i32
    }

    /// The cell of a slice.
    pub(super) fn cell(&self, along: i32, across: i32) -> CellIndex {
        let (col, row) = if self.is_flat {
            (along, across)
        } else {
            (across, along)
        };
        CellIndex { col, row }
    }

    /// All cells, slice after slice.
    pub(super) fn cells(self) -> impl Iterator<Item = CellIndex> {
        self.slices().flat_map(move |slice| {
            (slice.from..=slice.to).map(move |along| self.cell(along, slice.across))
        })
    }
}

/// Step 1: the ends as along and across, and whether they were swapped.
fn in_order(ends: [Point2<f64>; 2], is_flat: bool) -> ([Point2<f64>; 2], bool) {
    let [a, b] = ends.map(|p| if is_flat { p } else { Point2::new(p.y, p.x) });
    if a.x <= b.x {
        ([a, b], false)
    } else {
        ([b, a], true)
    }
}

fn cell_in(place: Point2<f64>) -> [i32; 2] {
    let CellIndex { col, row } = CellIndex::holding(place);
    [col, row]
}

fn fixed(place: f64) -> i64 {
    (place * (1_i64 << FRACTION) as f64) as i64
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use proptest::prelude::*;

    use super::*;
    use crate::map::cells_on_ray;

    /// Cells in order of their slices, each once.
    fn cells_of(line: CellLine) -> Vec<(i32, i32)> {
        line.cells().map(|cell| (cell.col, cell.row)).collect()
    }

    fn set(cells: &[(i32, i32)]) -> BTreeSet<(i32, i32)> {
        cells.iter().copied().collect()
    }

    fn bresenham((ax, ay): (i32, i32), (bx, by): (i32, i32)) -> Vec<(i32, i32)> {
        let centre = |x: i32, y: i32| Point2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
        cells_of(CellLine::bresenham(centre(ax, ay), centre(bx, by)).unwrap())
    }

    fn crossed(start: (f64, f64), end: (f64, f64)) -> Vec<(i32, i32)> {
        cells_of(CellLine::crossed([start.0, start.1].into(), [end.0, end.1].into()).unwrap())
    }

    /// By the definition: along the longer axis, the shorter coordinate rounded, halves onwards.
    fn rounded((ax, ay): (i32, i32), (bx, by): (i32, i32)) -> BTreeSet<(i32, i32)> {
        let (dx, dy) = (i64::from(bx - ax), i64::from(by - ay));
        let n = dx.abs().max(dy.abs()).max(1);
        let at = |d: i64, i: i64| (d.signum() * (2 * d.abs() * i + n).div_euclid(2 * n)) as i32;
        (0..=dx.abs().max(dy.abs()))
            .map(|i| (ax + at(dx, i), ay + at(dy, i)))
            .collect()
    }

    fn check_bresenham(a: (i32, i32), b: (i32, i32)) {
        let cells = bresenham(a, b);
        assert_eq!(set(&cells), rounded(a, b), "{a:?} {b:?}");
        assert_eq!(cells.len(), set(&cells).len(), "{a:?} {b:?}");
    }

    /// A path of neighbours from the first cell to the last.
    fn check_path(start: (f64, f64), end: (f64, f64)) -> Vec<(i32, i32)> {
        let cell = |p: (f64, f64)| (p.0.floor() as i32, p.1.floor() as i32);
        let (a, b) = (cell(start), cell(end));
        let cells = crossed(start, end);
        let once = set(&cells);
        assert_eq!(cells.len(), once.len(), "{start:?} {end:?}");
        assert_eq!(
            cells.len() as i32,
            (b.0 - a.0).abs() + (b.1 - a.1).abs() + 1
        );
        assert!(once.contains(&a) && once.contains(&b));
        let has_next = |&&(x, y): &&(i32, i32)| {
            let sides = [(x + 1, y), (x - 1, y), (x, y + 1), (x, y - 1)];
            sides.iter().filter(|side| once.contains(side)).count() < 2
        };
        assert!(
            once.iter().filter(has_next).count() <= 2,
            "{start:?} {end:?}"
        );
        cells
    }

    #[test]
    fn short_lines() {
        assert_eq!(bresenham((0, 0), (3, 1)), [(0, 0), (1, 0), (2, 1), (3, 1)]);
        assert_eq!(
            set(&bresenham((0, 0), (-1, 2))),
            set(&[(0, 0), (-1, 1), (-1, 2)])
        );
        assert_eq!(bresenham((4, 4), (4, 4)), [(4, 4)]);
        assert_eq!(
            crossed((0.5, 0.5), (3.5, 0.5)),
            [(0, 0), (1, 0), (2, 0), (3, 0)]
        );
        assert_eq!(
            set(&crossed((0.5, 0.5), (0.5, -1.5))),
            set(&[(0, 0), (0, -1), (0, -2)])
        );
        assert_eq!(crossed((0.5, 0.5), (0.6, 0.6)), [(0, 0)]);
    }

    #[test]
    fn ends_that_are_nowhere_or_too_far_apart_give_no_line() {
        for end in [
            (0.5, f64::NAN),
            (f64::INFINITY, 0.0),
            (3e5, 0.0),
            (0.0, -3e5),
            (1e300, 0.0),
        ] {
            let end = Point2::from([end.0, end.1]);
            assert!(CellLine::crossed(Point2::origin(), end).is_none(), "{end}");
            assert!(
                CellLine::bresenham(Point2::origin(), end).is_none(),
                "{end}"
            );
        }
    }

    #[test]
    fn every_line_within_a_square_is_the_rounded_one() {
        for x in -20..=20 {
            for y in -20..=20 {
                check_bresenham((3, -2), (x, y));
            }
        }
    }

    /// Cases that rounding decides, and what it decides: the same cells in both directions.
    #[test]
    fn ways_through_corners_of_cells_are_paths_and_the_same_back() {
        let corners = [-7.0, -2.0, -1.5, -1.0, -0.0, 0.0, 0.5, 1.0, 3.0, 9.0];
        let points = || corners.iter().flat_map(|&x| corners.map(|y| (x, y)));
        for start in points() {
            for end in points() {
                let there = check_path(start, end);
                assert_eq!(there, check_path(end, start));
            }
        }
        assert_eq!(
            crossed((0.0, 0.0), (2.5, 2.5)),
            [(0, 0), (1, 0), (1, 1), (2, 1), (2, 2)]
        );
    }

    proptest! {
        #[test]
        fn long_lines_are_the_rounded_ones(ax in -900..900, ay in -900..900, bx in -900..900, by in -900..900) {
            check_bresenham((ax, ay), (bx, by));
        }

        #[test]
        fn every_cell_that_a_way_enters_is_there_once(
            ax in -200.0..200.0_f64, ay in -200.0..200.0_f64, bx in -200.0..200.0_f64, by in -200.0..200.0_f64,
        ) {
            let mut entered = BTreeSet::new();
            cells_on_ray(Point2::new(ax, ay), Point2::new(bx, by), |c| { entered.insert((c.col, c.row)); });
            prop_assert_eq!(set(&check_path((ax, ay), (bx, by))), entered);
        }
    }

    #[test]
    fn the_longest_lines_are_the_rounded_ones() {
        let far = (REACH - 1) as i32;
        for (x, y) in [
            (far, far - 1),
            (far, -far),
            (-far, far / 2),
            (7, far),
            (-far, 1),
            (far, -100_003),
        ] {
            check_bresenham((0, 0), (x, y));
        }
    }
}
