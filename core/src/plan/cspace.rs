//! Configuration space: where the centre of the robot may be.
//!
//! In: obstacles (cells of a grid, or segments of walls) and how far the robot's centre keeps away from them. Out: for
//! any point the room that is left, and for any straight leg how far it can be driven.
//!
//! 1. The robot is the disc around its body, so walls grow by its radius and a margin (TDK 2016 §5.1).
//! 2. Over a grid the distance to the nearest occupied cell comes from an exact distance transform; half a cell is taken
//!    off, because the wall may be anywhere in its cell. The unknown is no obstacle, or one that only the centre of the
//!    robot keeps out of, as the caller chooses.
//! 3. Over segments the distance is that of a capsule, exact.
//! 4. A leg is marched along in steps of the room that is left: long ones in the open, short ones at walls.

use nalgebra::Point2;

use crate::geom::Segment;
use crate::map::{CellIndex, CellRect, CellState, DistanceField, Grid};

/// Where the centre of the robot may be.
pub trait ConfigSpace {
    /// How far the robot's centre may move from `point` in any direction, m; negative where it may not even be.
    fn room(&self, point: Point2<f64>) -> f64;

    /// Shortest step of a march, m.
    fn step(&self) -> f64;

    /// Lower left and upper right corner of where it is worth looking for a path.
    fn bounds(&self) -> (Point2<f64>, Point2<f64>);

    /// Whether the robot may be there.
    fn is_free(&self, point: Point2<f64>) -> bool {
        self.room(point) >= 0.0
    }

    /// How much of the leg is free, m; its whole length where nothing is in the way, 0 where the start is blocked.
    fn free_length(&self, leg: &Segment) -> f64 {
        let length = leg.length();
        if !(length > 0.0 && length.is_finite()) {
            return 0.0;
        }
        let along = leg.vector() / length;
        let mut at = 0.0;
        let mut free = 0.0;
        loop {
            let room = self.room(leg.a + along * at);
            if room.is_nan() || room < 0.0 {
                return free;
            }
            free = at;
            if at >= length {
                return length;
            }
            // Bilinear distances may change by √2 a metre.
            at = (at + (room * 0.7).max(self.step())).min(length);
        }
    }

    /// Whether the robot can drive the whole leg.
    fn leg_is_free(&self, leg: &Segment) -> bool {
        if leg.a == leg.b {
            return self.is_free(leg.a);
        }
        // The middle first: a leg that is not free is refused soonest there.
        self.is_free(Point2::from((leg.a.coords + leg.b.coords) * 0.5))
            && self.is_free(leg.a)
            && self.free_length(leg) >= leg.length()
    }
}

/// What to make of cells that were never seen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unknown {
    /// The robot's centre keeps out of them.
    Blocked,
    /// They are taken to be free: optimism, to be corrected by what the next scan shows.
    Free,
}

/// Configuration space over a snapshot of a [`Grid`].
#[derive(Clone, Debug)]
pub struct GridSpace {
    rect: CellRect,
    resolution: f64,
    states: Vec<CellState>,
    walls: DistanceField,
    unknown: Option<DistanceField>,
    keep: f64,
}

impl GridSpace {
    /// Looks at the cells of `rect`; the robot's centre keeps `keep` metres away from what is occupied.
    #[must_use]
    pub fn new(grid: &Grid, rect: CellRect, keep: f64, unknown: Unknown) -> Self {
        let states = states_of(grid, rect);
        let resolution = grid.resolution();
        let of = |state: CellState, states: &[CellState]| {
            let mask: Vec<bool> = states.iter().map(|&s| s == state).collect();
            DistanceField::new(rect, resolution, &mask)
        };
        let unknown = match unknown {
            Unknown::Free => None,
            Unknown::Blocked => Some(of(
                CellState::Unknown,
                &without_stripes(&states, rect.width()),
            )),
        };
        Self {
            rect,
            resolution,
            walls: of(CellState::Occupied, &states),
            states,
            unknown,
            keep,
        }
    }

    /// The same snapshot for a robot that keeps another distance.
    #[must_use]
    pub fn with_keep(mut self, keep: f64) -> Self {
        self.keep = keep;
        self
    }

    /// Distance that the robot's centre keeps from walls, m.
    #[must_use]
    pub fn keep(&self) -> f64 {
        self.keep
    }

    /// Whether the robot's centre keeps out of what was never seen.
    #[must_use]
    pub fn keeps_out_of_unknown(&self) -> bool {
        self.unknown.is_some()
    }

    /// The cells it covers.
    #[must_use]
    pub fn rect(&self) -> CellRect {
        self.rect
    }

    /// Side of a cell, m.
    #[must_use]
    pub fn resolution(&self) -> f64 {
        self.resolution
    }

    /// What the snapshot holds of its cells, in rows from the lower left one.
    #[must_use]
    pub fn states(&self) -> &[CellState] {
        &self.states
    }

    /// Distance from the nearest wall, m; the wall's cell counts as half a cell thick on the near side.
    #[must_use]
    pub fn clearance(&self, point: Point2<f64>) -> f64 {
        self.walls.at_point(point) - 0.5 * self.resolution
    }

    /// Number of a cell in [`GridSpace::states`]; `None` outside.
    #[inline]
    #[must_use]
    pub fn index_of(&self, cell: CellIndex) -> Option<usize> {
        let inside = cell.col >= self.rect.min.col
            && cell.col < self.rect.max.col
            && cell.row >= self.rect.min.row
            && cell.row < self.rect.max.row;
        inside.then(|| {
            let (col, row) = (cell.col - self.rect.min.col, cell.row - self.rect.min.row);
            row as usize * self.rect.width() + col as usize
        })
    }

    /// The cell with the given number.
    #[inline]
    #[must_use]
    pub fn cell_of(&self, index: usize) -> CellIndex {
        let width = self.rect.width().max(1);
        CellIndex {
            col: self.rect.min.col + (index % width) as i32,
            row: self.rect.min.row + (index / width) as i32,
        }
    }

    /// The cell under a point, if it is covered.
    #[must_use]
    pub fn index_at(&self, point: Point2<f64>) -> Option<usize> {
        let cell = CellIndex {
            col: (point.x / self.resolution).floor() as i32,
            row: (point.y / self.resolution).floor() as i32,
        };
        self.index_of(cell)
    }

    /// Centre of the cell with the given number.
    #[must_use]
    pub fn centre_of(&self, index: usize) -> Point2<f64> {
        let cell = self.cell_of(index);
        Point2::new(
            (f64::from(cell.col) + 0.5) * self.resolution,
            (f64::from(cell.row) + 0.5) * self.resolution,
        )
    }

    /// Distance of a cell's centre from the nearest wall, m, as [`GridSpace::clearance`].
    #[inline]
    #[must_use]
    pub fn clearance_of(&self, index: usize) -> f64 {
        self.walls.at(self.cell_of(index)) - 0.5 * self.resolution
    }

    /// Room at the centre of a cell, m: cheaper than at a point.
    #[inline]
    #[must_use]
    pub fn room_of(&self, index: usize) -> f64 {
        let cell = self.cell_of(index);
        let half = 0.5 * self.resolution;
        let walls = self.walls.at(cell) - half - self.keep;
        match &self.unknown {
            Some(unknown) => walls.min(unknown.at(cell) - half),
            None => walls,
        }
    }

    /// The free cell centre nearest to `point` within `reach` metres that a robot standing at `point`, perhaps already
    /// too near to a wall, can drive to without coming nearer to one than it is. `point` itself where it is free.
    #[must_use]
    pub fn escape(&self, point: Point2<f64>, reach: f64) -> Option<Point2<f64>> {
        if self.is_free(point) {
            return Some(point);
        }
        // A robot that touches (or, by an error of the map, overlaps) a wall may still leave it.
        let least = self.clearance(point).min(self.keep) - 0.5 * self.resolution;
        self.free_cells_near(point, reach).into_iter().find(|&to| {
            let leg = Segment::new(point, to);
            let steps = (leg.length() / (0.4 * self.resolution)).ceil().max(1.0) as usize;
            (0..=steps).all(|i| {
                let at = point + leg.vector() * (i as f64 / steps as f64);
                self.clearance(at) >= least
            })
        })
    }

    /// The free cell centre nearest to `point` within `reach` metres; `point` itself where it is free.
    #[must_use]
    pub fn nearest_free(&self, point: Point2<f64>, reach: f64) -> Option<Point2<f64>> {
        if self.is_free(point) {
            return Some(point);
        }
        self.free_cells_near(point, reach).into_iter().next()
    }

    /// Free cell centres within `reach`, nearest first.
    #[must_use]
    pub fn free_cells_near(&self, point: Point2<f64>, reach: f64) -> Vec<Point2<f64>> {
        let cells = (reach / self.resolution).ceil() as i32;
        let (col, row) = (
            (point.x / self.resolution).floor() as i32,
            (point.y / self.resolution).floor() as i32,
        );
        let mut found = vec![];
        for dr in -cells..=cells {
            for dc in -cells..=cells {
                let cell = CellIndex {
                    col: col.saturating_add(dc),
                    row: row.saturating_add(dr),
                };
                let Some(index) = self.index_of(cell).filter(|&i| self.room_of(i) >= 0.0) else {
                    continue;
                };
                let centre = self.centre_of(index);
                let distance = (centre - point).norm();
                if distance <= reach {
                    found.push((distance, centre));
                }
            }
        }
        // Stable: equal distances keep the order of the cells.
        found.sort_by(|a, b| a.0.total_cmp(&b.0));
        found.into_iter().map(|(_, centre)| centre).collect()
    }
}

impl ConfigSpace for GridSpace {
    fn room(&self, point: Point2<f64>) -> f64 {
        if self.index_at(point).is_none() {
            return -self.resolution;
        }
        let walls = self.clearance(point) - self.keep;
        match &self.unknown {
            Some(unknown) => walls.min(unknown.at_point(point) - 0.5 * self.resolution),
            None => walls,
        }
    }

    fn step(&self) -> f64 {
        0.2 * self.resolution
    }

    fn bounds(&self) -> (Point2<f64>, Point2<f64>) {
        let corner = |cell: CellIndex| {
            Point2::new(
                f64::from(cell.col) * self.resolution,
                f64::from(cell.row) * self.resolution,
            )
        };
        (corner(self.rect.min), corner(self.rect.max))
    }
}

/// The rectangle of everything the grid holds and of all `points`, with `spare` cells around; `None` where a point is
/// not finite or lies more than `farthest` cells off.
#[must_use]
pub fn rect_around(
    grid: &Grid,
    points: &[Point2<f64>],
    spare: i32,
    farthest: i32,
) -> Option<CellRect> {
    let first = grid.cell_at(*points.first()?);
    let mut rect = grid.bounds().unwrap_or(CellRect {
        min: first,
        max: first,
    });
    let held = rect;
    for &point in points {
        if !(point.x.is_finite() && point.y.is_finite()) {
            return None;
        }
        let cell = grid.cell_at(point);
        let off = |at: i32, low: i32, high: i32| {
            at.saturating_sub(high).max(low.saturating_sub(at)) > farthest
        };
        if off(cell.col, held.min.col, held.max.col) || off(cell.row, held.min.row, held.max.row) {
            return None;
        }
        rect.min.col = rect.min.col.min(cell.col);
        rect.min.row = rect.min.row.min(cell.row);
        rect.max.col = rect.max.col.max(cell.col.saturating_add(1));
        rect.max.row = rect.max.row.max(cell.row.saturating_add(1));
    }
    Some(CellRect {
        min: CellIndex {
            col: rect.min.col.saturating_sub(spare),
            row: rect.min.row.saturating_sub(spare),
        },
        max: CellIndex {
            col: rect.max.col.saturating_add(spare),
            row: rect.max.row.saturating_add(spare),
        },
    })
}

/// States of a rectangle, block by block.
fn states_of(grid: &Grid, rect: CellRect) -> Vec<CellState> {
    let block_cells = crate::map::BLOCK_CELLS as i32;
    let width = rect.width();
    let mut states = vec![CellState::Unknown; width * rect.height()];
    for (block, cells) in grid.blocks_since(0) {
        let (col0, row0) = (block.col * block_cells, block.row * block_cells);
        let cols = rect.min.col.max(col0)..rect.max.col.min(col0 + block_cells);
        if cols.is_empty() {
            continue;
        }
        for row in rect.min.row.max(row0)..rect.max.row.min(row0 + block_cells) {
            let from = ((row - row0) * block_cells + cols.start - col0) as usize;
            let to = (row - rect.min.row) as usize * width + (cols.start - rect.min.col) as usize;
            let count = cols.len();
            for (state, &log_odds) in states[to..to + count]
                .iter_mut()
                .zip(&cells[from..from + count])
            {
                *state = grid.state_of(log_odds);
            }
        }
    }
    states
}

/// Unknown cells with at least five free neighbours and no occupied one count as free: they are the gaps between the
/// far ends of neighbouring beams.
fn without_stripes(states: &[CellState], width: usize) -> Vec<CellState> {
    let mut filled = states.to_vec();
    if width < 3 {
        return filled;
    }
    for at in width + 1..states.len().saturating_sub(width + 1) {
        if states[at] != CellState::Unknown {
            continue;
        }
        let around = [
            at - width - 1,
            at - width,
            at - width + 1,
            at - 1,
            at + 1,
            at + width - 1,
            at + width,
            at + width + 1,
        ];
        let count = |state| around.iter().filter(|&&i| states[i] == state).count();
        if count(CellState::Free) >= 5 && count(CellState::Occupied) == 0 {
            filled[at] = CellState::Free;
        }
    }
    filled
}

/// Configuration space over wall segments, exact.
#[derive(Clone, Debug)]
pub struct SegmentSpace {
    segments: Vec<Segment>,
    keep: f64,
    bounds: (Point2<f64>, Point2<f64>),
}

impl SegmentSpace {
    /// The robot's centre keeps `keep` metres away from every segment and stays within `bounds` (lower left, upper
    /// right).
    #[must_use]
    pub fn new(segments: Vec<Segment>, keep: f64, bounds: (Point2<f64>, Point2<f64>)) -> Self {
        Self {
            segments,
            keep,
            bounds,
        }
    }
}

impl ConfigSpace for SegmentSpace {
    fn room(&self, point: Point2<f64>) -> f64 {
        let (low, high) = self.bounds;
        let border = (point - low).min().min((high - point).min());
        if border < 0.0 {
            return border;
        }
        let walls = self.segments.iter().map(|s| s.distance(point));
        walls.fold(f64::INFINITY, f64::min) - self.keep
    }

    fn step(&self) -> f64 {
        1e-3
    }

    fn bounds(&self) -> (Point2<f64>, Point2<f64>) {
        self.bounds
    }

    /// Exact: the leg is the axis of a capsule that no wall may enter.
    fn leg_is_free(&self, leg: &Segment) -> bool {
        let (low, high) = self.bounds;
        let inside = |p: Point2<f64>| (p - low).min() >= 0.0 && (high - p).min() >= 0.0;
        inside(leg.a)
            && inside(leg.b)
            && self
                .segments
                .iter()
                .all(|s| s.distance_to(leg) >= self.keep)
    }
}

/// Two spaces at once: free is what is free in both (the grid and the vector map).
#[derive(Clone, Debug)]
pub struct Both<A, B>(pub A, pub B);

impl<A: ConfigSpace, B: ConfigSpace> ConfigSpace for Both<A, B> {
    fn room(&self, point: Point2<f64>) -> f64 {
        self.0.room(point).min(self.1.room(point))
    }

    fn step(&self) -> f64 {
        self.0.step().min(self.1.step())
    }

    fn bounds(&self) -> (Point2<f64>, Point2<f64>) {
        let ((a, b), (c, d)) = (self.0.bounds(), self.1.bounds());
        (a.sup(&c), b.inf(&d))
    }

    fn leg_is_free(&self, leg: &Segment) -> bool {
        self.0.leg_is_free(leg) && self.1.leg_is_free(leg)
    }
}
