//! Cells of equal side over a configuration space, for searches over cells.
//!
//! In: a configuration space and a query. Out: which cells are open, and which steps between
//! neighbours are free.
//!
//! 1. A cell is open if its centre is free; the cells of start and goal stand for those points and
//!    are always open.
//! 2. Over a grid a step between open centres is free: the room is bilinear between them. Diagonal
//!    steps need both cells beside them.
//! 3. Over other spaces a step is free if both centres have three quarters of a cell's room;
//!    otherwise the leg is tested.

use nalgebra::{Point2, Vector2};

use super::cspace::ConfigSpace;
use super::path::way_to;
use super::query::Query;
use crate::geom::Segment;

/// Side of a cell if the space has no cells of its own, m.
const SIDE: f64 = 0.05;
/// Most cells; beyond that they become larger.
const MOST_CELLS: f64 = 4e6;

const CLOSED: u8 = 0;
/// The cell is open, but a step may not be free.
const TIGHT: u8 = 1;
/// The cell is open, and all steps to others of this kind are free.
const WIDE: u8 = 2;

/// The eight neighbours, straight ones first.
#[rustfmt::skip]
pub(super) const AROUND: [(i32, i32); 8] = [
    (1, 0), (-1, 0), (0, 1), (0, -1),
    (1, 1), (-1, 1), (1, -1), (-1, -1),
];

/// Which cells are open. Cells are numbered row by row; those at the border are never open.
#[derive(Clone, Debug)]
pub struct Lattice {
    low: Point2<f64>,
    side: f64,
    width: usize,
    kinds: Vec<u8>,
    offsets: [isize; 8],
    /// Cells that stand for a point other than their centre.
    ends: Option<[(usize, Point2<f64>); 2]>,
}

impl Lattice {
    /// Samples a space at the centres of cells all over its bounds.
    pub(super) fn over(space: &dyn ConfigSpace, query: &Query) -> Self {
        let (low, high) = space.bounds();
        let extent = high - low;
        let own = space.cell();
        let least = (extent.x * extent.y / MOST_CELLS).sqrt();
        let side = own.unwrap_or(SIDE.max(least));
        let cells = |length: f64| (length / side - 1e-9).ceil().max(1.0) as usize + 2;
        let (width, height) = (cells(extent.x), cells(extent.y));
        let mut lattice = Self::closed(low - Vector2::new(side, side), side, width, height);
        for row in 1..height - 1 {
            for col in 1..width - 1 {
                let room = space.room(lattice.centre(row * width + col));
                let wide = if own.is_some() { 0.0 } else { 0.75 * side };
                lattice.kinds[row * width + col] = match room {
                    room if room >= wide => WIDE,
                    room if room >= 0.0 => TIGHT,
                    _ => CLOSED,
                };
            }
        }
        lattice.stand_for(query);
        lattice
    }

    /// A lattice of cells that are open or not, row by row, with all steps between neighbours free.
    ///
    /// # Units    `low`: lower left corner of the first cell, `side`: of a cell, m. Cells beyond
    /// the end of `open` are closed.
    #[must_use]
    pub fn from_cells(low: Point2<f64>, side: f64, width: usize, open: &[bool]) -> Self {
        let width = width.max(1);
        let height = open.len().div_ceil(width);
        let corner = low - Vector2::new(side, side);
        let mut lattice = Self::closed(corner, side, width + 2, height + 2);
        for (row, cells) in open.chunks(width).enumerate() {
            for (col, _) in cells.iter().enumerate().filter(|(_, open)| **open) {
                lattice.kinds[(row + 1) * (width + 2) + col + 1] = WIDE;
            }
        }
        lattice
    }

    fn closed(low: Point2<f64>, side: f64, width: usize, height: usize) -> Self {
        Self {
            low,
            side,
            width,
            kinds: vec![CLOSED; width * height],
            offsets: AROUND.map(|(dx, dy)| dx as isize + dy as isize * width as isize),
            ends: None,
        }
    }

    fn stand_for(&mut self, query: &Query) {
        let Some((start, goal)) = self.ends(query) else {
            return;
        };
        (self.kinds[start], self.kinds[goal]) = (TIGHT, TIGHT);
        self.ends = Some([(start, query.start), (goal, query.goal)]);
    }

    /// The cells of start and goal; `None` if one lies outside, or both are the same: then the
    /// straight leg has been tried elsewhere.
    pub(super) fn ends(&self, query: &Query) -> Option<(usize, usize)> {
        let ends = self.cell_at(query.start).zip(self.cell_at(query.goal));
        ends.filter(|(start, goal)| start != goal)
    }

    /// Cells along x and along y, including those at the border.
    pub(super) fn size(&self) -> (usize, usize) {
        (self.width, self.kinds.len() / self.width)
    }

    /// A point of the map from the lattice's lower left corner, m.
    pub(super) fn in_lattice(&self, point: Point2<f64>) -> Point2<f64> {
        Point2::from(point - self.low)
    }

    /// Closes all cells except those to keep, start and goal.
    pub(super) fn close_but(&mut self, is_kept: impl Fn(usize) -> bool) {
        let ends = self.ends.map(|ends| ends.map(|(cell, _)| cell));
        for (cell, kind) in self.kinds.iter_mut().enumerate() {
            if !is_kept(cell) && !ends.is_some_and(|ends| ends.contains(&cell)) {
                *kind = CLOSED;
            }
        }
    }

    /// Number of cells.
    pub(super) fn len(&self) -> usize {
        self.kinds.len()
    }

    /// Side of a cell, m.
    pub(super) fn side(&self) -> f64 {
        self.side
    }

    /// The cell of a point; `None` at the border and outside.
    pub(super) fn cell_at(&self, point: Point2<f64>) -> Option<usize> {
        let at = (point - self.low) / self.side;
        let height = self.kinds.len() / self.width;
        let inside = |at: f64, count: usize| at >= 1.0 && at < (count - 1) as f64;
        (inside(at.x, self.width) && inside(at.y, height))
            .then(|| at.y as usize * self.width + at.x as usize)
    }

    /// Column and row of a cell.
    #[inline]
    pub(super) fn place(&self, cell: usize) -> (i32, i32) {
        ((cell % self.width) as i32, (cell / self.width) as i32)
    }

    fn centre(&self, cell: usize) -> Point2<f64> {
        let (col, row) = self.place(cell);
        self.low + Vector2::new(f64::from(col) + 0.5, f64::from(row) + 0.5) * self.side
    }

    /// The point that a cell stands for: its centre, except for start and goal.
    pub(super) fn point(&self, cell: usize) -> Point2<f64> {
        let own = self.ends.iter().flatten().find(|(end, _)| *end == cell);
        own.map_or_else(|| self.centre(cell), |(_, point)| *point)
    }

    /// Whether the robot can be there.
    #[inline]
    pub(super) fn is_open(&self, cell: usize) -> bool {
        self.kinds[cell] != CLOSED
    }

    /// Passes on the open neighbours of an open cell to which a step is free: the cell, and whether
    /// the step is diagonal.
    #[inline]
    pub(super) fn each_step(
        &self,
        space: &dyn ConfigSpace,
        from: usize,
        mut visit: impl FnMut(usize, bool),
    ) {
        let to = self.offsets.map(|offset| from.wrapping_add_signed(offset));
        let kinds = to.map(|cell| self.kinds[cell]);
        let [east, west, north, south] = [0, 1, 2, 3].map(|i: usize| kinds[i] != CLOSED);
        let beside = [
            true,
            true,
            true,
            true,
            north && east,
            north && west,
            south && east,
            south && west,
        ];
        for i in 0..8 {
            if kinds[i] == CLOSED || !beside[i] {
                continue;
            }
            let is_known = kinds[i] == WIDE && self.kinds[from] == WIDE;
            if is_known || space.leg_is_free(&Segment::new(self.point(from), self.point(to[i]))) {
                visit(to[i], i >= 4);
            }
        }
    }
}

/// The state of a search over cells: the cells that it expanded, and from which cell each was
/// reached.
#[derive(Debug)]
pub(super) struct Trail {
    pub(super) lattice: Lattice,
    /// The cells of start and goal; `None` if there is nothing to search.
    pub(super) ends: Option<(usize, usize)>,
    pub(super) from: Vec<u32>,
    pub(super) expanded: Vec<u32>,
    pub(super) is_found: bool,
}

impl Trail {
    pub(super) fn new(lattice: Lattice, query: &Query) -> Self {
        let ends = lattice.ends(query);
        Self {
            ends: ends.filter(|&(start, _)| lattice.is_open(start)),
            from: vec![0; lattice.len()],
            lattice,
            expanded: vec![],
            is_found: false,
        }
    }

    /// The cells of the way from the start to the goal, once it is found.
    pub(super) fn way(&self) -> Option<Vec<usize>> {
        let (start, goal) = self.ends.filter(|_| self.is_found)?;
        let before = |&at: &usize| (at != start).then(|| self.from[at] as usize);
        Some(way_to(goal, before))
    }

    /// The legs over which cells were reached.
    pub(super) fn edges(&self) -> Vec<Segment> {
        let leg = |&cell: &u32| {
            let from = self.from[cell as usize] as usize;
            Segment::new(self.lattice.point(from), self.lattice.point(cell as usize))
        };
        self.expanded.iter().map(leg).collect()
    }
}
