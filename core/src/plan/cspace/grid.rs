//! Configuration space over a grid.
//!
//! In: a [`Grid`], how far the robot's centre keeps from occupied cells, how to treat unknown
//! cells. Out: the room at any point, from an exact distance transform.

use std::collections::BTreeSet;

use nalgebra::Point2;

use super::{ConfigSpace, Within};
use crate::geom::{Length, Segment, sides_of};
use crate::map::{
    CellIndex, CellRect, CellState, DistanceField, Grid, cells_around, without_stripes,
};
use crate::plan::reach::may_reach;

/// How to treat cells that were never seen.
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
    /// Distances from the cells that the robot's centre keeps out of although nothing stands in
    /// them.
    barred: Option<DistanceField>,
    keep: f64,
}

impl GridSpace {
    /// Takes a snapshot of the cells of `rect`; the robot's centre keeps `keep` metres away from
    /// occupied cells.
    #[must_use]
    pub fn new(grid: &Grid, rect: CellRect, keep: f64, unknown: Unknown) -> Self {
        Self::within(grid, rect, keep, unknown, &Within::default())
    }

    /// The same for a robot whose centre also stays within a geofence.
    #[must_use]
    pub fn within(
        grid: &Grid,
        rect: CellRect,
        keep: f64,
        unknown: Unknown,
        within: &Within,
    ) -> Self {
        let states = grid.states(rect);
        let resolution = grid.resolution();
        let is = |state: CellState, states: &[CellState]| -> Vec<bool> {
            states.iter().map(|&s| s == state).collect()
        };
        let unseen = (unknown == Unknown::Blocked).then(|| {
            let whole = without_stripes(&states, rect.width());
            is(CellState::Unknown, &whole)
        });
        let outside = (!within.fence.is_empty()).then(|| within.outside(rect, resolution));
        let barred = match (unseen, outside) {
            (Some(unseen), Some(outside)) => {
                let both = unseen.iter().zip(&outside);
                Some(both.map(|(&unseen, &outside)| unseen || outside).collect())
            }
            (unseen, outside) => unseen.or(outside),
        };
        let field = |mask: Vec<bool>| DistanceField::new(rect, resolution, &mask);
        Self {
            rect,
            resolution,
            walls: field(is(CellState::Occupied, &states)),
            states,
            barred: barred.map(field),
            keep,
        }
    }

    /// The same snapshot for a robot that keeps a different distance.
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

    /// Whether the robot's centre keeps out of cells in which nothing stands: those never seen,
    /// or those beyond a geofence.
    #[must_use]
    pub fn has_barred_cells(&self) -> bool {
        self.barred.is_some()
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

    /// The states of its cells, in rows from the lower left one.
    #[must_use]
    pub fn states(&self) -> &[CellState] {
        &self.states
    }

    /// Distance from the nearest wall, m; the wall's cell counts as half a cell thick on the near
    /// side.
    #[must_use]
    pub fn clearance(&self, point: Point2<f64>) -> f64 {
        self.walls.at_point(point) - 0.5 * self.resolution
    }

    /// Number of a cell in [`GridSpace::states`]; `None` outside.
    #[inline]
    #[must_use]
    pub fn index_of(&self, cell: CellIndex) -> Option<usize> {
        self.rect.index_of(cell)
    }

    /// The cell with the given number.
    #[inline]
    #[must_use]
    pub fn cell_of(&self, index: usize) -> CellIndex {
        let width = self.rect.width().max(1);
        CellIndex::new(
            self.rect.min.col + (index % width) as i32,
            self.rect.min.row + (index / width) as i32,
        )
    }

    /// The cell under a point, if it is covered.
    #[must_use]
    pub fn index_at(&self, point: Point2<f64>) -> Option<usize> {
        self.index_of(CellIndex::holding(point / self.resolution))
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
        match &self.barred {
            Some(barred) => walls.min(barred.at(cell) - half),
            None => walls,
        }
    }

    /// The free cell centre nearest to `point` within `reach` metres to which a robot at `point`,
    /// perhaps already too near to a wall, can drive without getting nearer to one than it is.
    /// `point` itself if it is free.
    ///
    /// Places from which a way leads farther than `reach` come first: between walls that have moved
    /// closer by a cell since the robot went in, a few free cells may remain from which nothing
    /// else can be reached.
    #[must_use]
    pub fn escape(&self, point: Point2<f64>, reach: f64) -> Option<Point2<f64>> {
        let mut pockets = BTreeSet::new();
        let is_free = self.is_free(point);
        let here = self.index_at(point).filter(|_| is_free);
        if here.is_some_and(|cell| self.leads_out(cell, point, reach, &mut pockets)) {
            return Some(point);
        }
        // A robot that touches (or, by an error of the map, overlaps) a wall may still leave it.
        let least = self.clearance(point).min(self.keep) - 0.5 * self.resolution;
        let is_drivable = |to: Point2<f64>| {
            let leg = Segment::new(point, to);
            let steps = (leg.length() / (0.4 * self.resolution)).ceil().max(1.0) as usize;
            (0..=steps).all(|i| {
                let at = point + leg.vector() * (i as f64 / steps as f64);
                self.clearance(at) >= least
            })
        };
        let mut nearest = is_free.then_some(point);
        for to in self.free_cells_near(point, reach) {
            let Some(cell) = self.index_at(to) else {
                continue;
            };
            if pockets.contains(&cell) && nearest.is_some() || !is_drivable(to) {
                continue;
            }
            nearest = nearest.or(Some(to));
            if self.leads_out(cell, point, reach, &mut pockets) {
                return Some(to);
            }
        }
        nearest
    }

    /// Whether free cells connect this one to one farther than `reach` from `point`. If not, all
    /// connected cells are put into `pockets` and not examined again.
    fn leads_out(
        &self,
        cell: usize,
        point: Point2<f64>,
        reach: f64,
        pockets: &mut BTreeSet<usize>,
    ) -> bool {
        if pockets.contains(&cell) {
            return false;
        }
        let width = self.rect.width();
        let height = self.states.len() / width.max(1);
        let mut seen = BTreeSet::from([cell]);
        let mut next = vec![cell];
        while let Some(at) = next.pop() {
            if (self.centre_of(at) - point).length() > reach {
                return true;
            }
            for to in cells_around(at, 1, width, height) {
                // As in a wavefront: a diagonal step needs the cells beside it.
                let is_beside = to % width == at % width || to / width == at / width;
                if is_beside && self.room_of(to) >= 0.0 && seen.insert(to) {
                    next.push(to);
                }
            }
        }
        pockets.extend(seen);
        false
    }

    /// The free cell centre nearest to `point` within `reach` metres; `point` itself if it is free.
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
        let CellIndex { col, row } = CellIndex::holding(point / self.resolution);
        let mut found = vec![];
        for dr in -cells..=cells {
            for dc in -cells..=cells {
                let cell = CellIndex::new(col.saturating_add(dc), row.saturating_add(dr));
                let Some(index) = self.index_of(cell).filter(|&i| self.room_of(i) >= 0.0) else {
                    continue;
                };
                let centre = self.centre_of(index);
                let distance = (centre - point).length();
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
        match &self.barred {
            Some(barred) => walls.min(barred.at_point(point) - 0.5 * self.resolution),
            None => walls,
        }
    }

    fn step(&self) -> f64 {
        0.2 * self.resolution
    }

    fn cell(&self) -> Option<f64> {
        Some(self.resolution)
    }

    /// The sides of occupied cells, except those between two of them.
    fn walls_near(&self, point: Point2<f64>, reach: f64) -> Vec<Segment> {
        let at = |x: f64| (x / self.resolution).floor() as i32;
        let is_occupied = |col: i32, row: i32| {
            let state = self.index_of(CellIndex { col, row });
            state.is_some_and(|index| self.states[index] == CellState::Occupied)
        };
        let corner =
            |col: i32, row: i32| Point2::new(f64::from(col), f64::from(row)) * self.resolution;
        let (min, max) = (self.rect.min, self.rect.max);
        let mut sides = vec![];
        for row in at(point.y - reach).max(min.row)..=at(point.y + reach).min(max.row - 1) {
            for col in at(point.x - reach).max(min.col)..=at(point.x + reach).min(max.col - 1) {
                if !is_occupied(col, row) {
                    continue;
                }
                let ring = [(0, 0, 0, -1), (1, 0, 1, 0), (1, 1, 0, 1), (0, 1, -1, 0)];
                for (&(dx, dy, beside, above), &(ex, ey, ..)) in sides_of(&ring) {
                    if !is_occupied(col + beside, row + above) {
                        sides.push(Segment::new(
                            corner(col + dx, row + dy),
                            corner(col + ex, row + ey),
                        ));
                    }
                }
            }
        }
        sides
    }

    fn are_apart(&self, a: Point2<f64>, b: Point2<f64>) -> bool {
        !may_reach(self, a, b)
    }

    fn bounds(&self) -> (Point2<f64>, Point2<f64>) {
        let corner = |cell: CellIndex| {
            Point2::new(f64::from(cell.col), f64::from(cell.row)) * self.resolution
        };
        (corner(self.rect.min), corner(self.rect.max))
    }
}
