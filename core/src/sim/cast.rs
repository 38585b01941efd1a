//! Rays and distances to walls, through a uniform grid in which rays leap over empty room.
//!
//! In: the walls. Out: the first wall along a ray, and the walls near a place.
//!
//! 1. A grid is laid over the walls, with about [`CELLS_PER_WALL`] cells for each. Every cell lists
//!    the walls that touch it, with their data side by side in one array, in the order of the
//!    cells.
//! 2. An empty cell stores for each of the four quadrants the size of the largest square of empty
//!    cells that begins at it.
//! 3. A ray walks from cell to cell. In empty room it leaps over the whole empty square of its
//!    quadrant at once, as in sphere tracing (Hart 1996), but with squares ahead instead of spheres
//!    all round: a ray that leaves a wall need not creep away from it. In a cell with walls, the
//!    ray is intersected with each, and stops once its nearest hit lies before the end of the cell.
//!
//! Why not a tree: rooms are thin lines around much empty room, so leaps cross a room in a few
//! steps whatever the number of walls, and no stack is needed. The bench `sim` compares it with
//! trying every wall.

mod fan;
#[cfg(test)]
mod tests;

use nalgebra::{Point2, Vector2};

use super::{Material, Wall};
use crate::geom::bounds;

pub use self::fan::Fan;

/// Cells for each wall. More cells mean fewer walls to test, but more cells to visit and more
/// memory. Nanoseconds for each beam of a scan:
///
/// | cells for each wall | 100 walls in 50 x 50 m | `campus` |
/// |---|---|---|
/// | 1 | 108 | 148 |
/// | 4 | 116 | 148 |
/// | 12 | 104 | 184 |
/// | 40 | 110 | 230 |
const CELLS_PER_WALL: f64 = 4.0;
/// Bound on the number of cells along one side.
const MOST_CELLS_ALONG: f64 = 2048.0;
/// Smallest cell, m.
const LEAST_CELL: f64 = 0.02;
/// Walls are also entered into cells that they miss by less than this, in cells.
const INFLATION: f64 = 1e-6;
/// A ray steps this far beyond a border, in cells; less than [`INFLATION`], so no wall slips
/// between.
const NUDGE: f64 = 1e-7;
/// A ray that passes a wall's end by less than this part of the wall still hits it, so corners have
/// no gaps.
const CRACK: f64 = 1e-12;

/// Finds which wall a ray meets first and which walls are near.
#[derive(Clone, Debug)]
pub struct Caster {
    walls: Vec<Wall>,
    low: Point2<f64>,
    per_metre: f64,
    cols: usize,
    rows: usize,
    cells: Vec<Cell>,
    items: Vec<Item>,
}

/// What a ray met.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Distance along the ray, m.
    pub distance: f64,
    /// What the surface is made of.
    pub material: Material,
    /// Index of the wall in [`Caster::walls`].
    pub surface: usize,
}

/// Eight bytes, so that a building's cells stay in the cache.
#[derive(Clone, Copy, Debug, Default)]
struct Cell {
    /// Number of its items.
    count: u32,
    /// With items: the index of the first. Without: for each quadrant a byte, the side of the empty
    /// square ahead.
    first_or_sides: u32,
}

/// Largest side of an empty square, in cells: the largest value of a byte.
const LARGEST_SQUARE: u32 = 255;

/// One wall in one cell: its start and its vector.
#[derive(Clone, Copy, Debug)]
struct Item {
    ax: f64,
    ay: f64,
    vx: f64,
    vy: f64,
    surface: u32,
    material: Material,
}

impl Caster {
    /// Builds the grid over `walls`, whose coordinates must be finite (see
    /// [`super::World::validate`]).
    #[must_use]
    pub fn new(walls: Vec<Wall>) -> Self {
        let ends = walls.iter().flat_map(|w| [w.segment.a, w.segment.b]);
        let (mut low, high) = bounds(ends).unwrap_or_default();
        let extent = high - low;
        let area = extent.x.max(1.0) * extent.y.max(1.0);
        let wanted = (area / (CELLS_PER_WALL * walls.len().max(8) as f64)).sqrt();
        let cell = wanted
            .max(LEAST_CELL)
            .max(extent.x.max(extent.y) / MOST_CELLS_ALONG);
        let along = |metres: f64| (metres / cell) as usize + 3;
        // One empty cell on every side makes rounding at the border harmless.
        low -= Vector2::new(cell, cell);
        let mut caster = Self {
            low,
            per_metre: 1.0 / cell,
            cols: along(extent.x),
            rows: along(extent.y),
            cells: Vec::new(),
            items: Vec::new(),
            walls,
        };
        caster.enter_walls();
        caster.measure_empty_room();
        caster
    }

    /// The walls, indexed as in [`Hit::surface`].
    #[must_use]
    pub fn walls(&self) -> &[Wall] {
        &self.walls
    }

    /// The first wall along the ray from `origin` in the unit `direction`, not farther than
    /// `max_range` (m).
    ///
    /// `None` also if the ray is not finite.
    #[must_use]
    pub fn cast(
        &self,
        origin: Point2<f64>,
        direction: Vector2<f64>,
        max_range: f64,
    ) -> Option<Hit> {
        if !(origin.x + origin.y + direction.x + direction.y).is_finite() {
            return None;
        }
        // In cells from here on; one slab test brings the ray into the grid.
        let start = (origin - self.low) * self.per_metre;
        let x = Axis::new(start.x, direction.x, self.cols);
        let y = Axis::new(start.y, direction.y, self.rows);
        let quadrant = Quadrant::of(x.per_step, y.per_step);
        let cols = self.cols as u32;
        let mut t = x.enter.max(y.enter).max(0.0);
        let end = x.leave.min(y.leave).min(max_range * self.per_metre);
        let mut best = (max_range, None);
        // Every turn of the loop enters another cell, so the bound is reached only if the origin is
        // so far away that a cell is smaller than the rounding of `t`.
        for _ in 0..2 * (self.cols + self.rows) {
            if t > end {
                break;
            }
            let ((left, col), (below, row)) = (x.cell_at(t), y.cell_at(t));
            let cell = self.cells.get((row * cols + col) as usize)?;
            if cell.count == 0 {
                let reach = f64::from(cell.side(quadrant) as i32 - 1);
                let leave = lesser(x.leave_at(left, reach), y.leave_at(below, reach));
                t = greater(leave, t) + NUDGE;
                continue;
            }
            for item in self.items_of(cell) {
                item.meet(origin, direction, &mut best);
            }
            let leave = lesser(x.leave_at(left, 0.0), y.leave_at(below, 0.0));
            if best.0 * self.per_metre <= leave {
                break;
            }
            t = greater(leave, t) + NUDGE;
        }
        let (distance, item) = best;
        item.map(|item: &Item| Hit {
            distance,
            material: item.material,
            surface: item.surface as usize,
        })
    }

    #[inline]
    fn items_of(&self, cell: &Cell) -> &[Item] {
        let first = cell.first_or_sides as usize;
        let items = self.items.get(first..first + cell.count as usize);
        items.unwrap_or_default()
    }

    /// Visits the walls that may lie within `reach` (m) of `point`, some of them more than once.
    pub fn near(&self, point: Point2<f64>, reach: f64, mut visit: impl FnMut(usize, &Wall)) {
        let index = |metres: f64, low: f64, count: usize| {
            // A float-to-integer `as` saturates and maps NaN to 0.
            (((metres - low) * self.per_metre) as usize).min(count - 1)
        };
        let span = |at: f64, low: f64, count: usize| {
            index(at - reach, low, count)..=index(at + reach, low, count)
        };
        let cols = span(point.x, self.low.x, self.cols);
        for row in span(point.y, self.low.y, self.rows) {
            for col in cols.clone() {
                let cell = self.cells.get(row * self.cols + col);
                for item in cell.map_or(&[][..], |cell| self.items_of(cell)) {
                    let surface = item.surface as usize;
                    if let Some(wall) = self.walls.get(surface) {
                        visit(surface, wall);
                    }
                }
            }
        }
    }

    /// Distance of `point` from the nearest wall, m, if that is less than `reach`; otherwise
    /// `reach`.
    #[must_use]
    pub fn clearance(&self, point: Point2<f64>, reach: f64) -> f64 {
        let mut least = reach;
        self.near(point, reach, |_, wall| {
            least = least.min(wall.segment.distance(point))
        });
        least
    }

    /// Lists the walls of every cell in three passes: count, sum up, fill.
    fn enter_walls(&mut self) {
        self.cells = vec![Cell::default(); self.cols * self.rows];
        let mut touched = Vec::new();
        for surface in 0..self.walls.len() {
            self.touched_cells(surface, &mut touched);
        }
        // Sorted by cell, then by surface, so the walls of a cell stay in their own order.
        touched.sort_unstable();
        self.items.reserve_exact(touched.len());
        for &(cell, surface) in &touched {
            let (Some(cell), Some(wall)) = (
                self.cells.get_mut(cell as usize),
                self.walls.get(surface as usize),
            ) else {
                continue;
            };
            if cell.count == 0 {
                cell.first_or_sides = self.items.len() as u32;
            }
            cell.count += 1;
            let along = wall.segment.vector();
            self.items.push(Item {
                ax: wall.segment.a.x,
                ay: wall.segment.a.y,
                vx: along.x,
                vy: along.y,
                surface,
                material: wall.material,
            });
        }
    }

    /// Appends (cell, surface) for every cell that a wall touches, row by row.
    fn touched_cells(&self, surface: usize, touched: &mut Vec<(u32, u32)>) {
        let Some(wall) = self.walls.get(surface) else {
            return;
        };
        let a = (wall.segment.a - self.low) * self.per_metre;
        let b = (wall.segment.b - self.low) * self.per_metre;
        let (a, b) = if a.y <= b.y { (a, b) } else { (b, a) };
        let clamp = |value: f64, count: usize| (value.max(0.0) as usize).min(count - 1);
        let slope = (b.x - a.x) / (b.y - a.y);
        for row in clamp(a.y - INFLATION, self.rows)..=clamp(b.y + INFLATION, self.rows) {
            // The part of the wall between the borders of this row.
            let x_at = |y: f64| {
                if y <= a.y {
                    a.x
                } else if y >= b.y {
                    b.x
                } else {
                    a.x + (y - a.y) * slope
                }
            };
            let x0 = x_at(row as f64 - INFLATION);
            let x1 = x_at(row as f64 + 1.0 + INFLATION);
            let first = clamp(x0.min(x1) - INFLATION, self.cols);
            let last = clamp(x0.max(x1) + INFLATION, self.cols);
            touched
                .extend((first..=last).map(|col| ((row * self.cols + col) as u32, surface as u32)));
        }
    }

    /// The largest empty square ahead of every empty cell, for each quadrant: one more than the
    /// smallest of the three neighbours ahead. The rim of the grid counts as a wall.
    fn measure_empty_room(&mut self) {
        for (is_left, is_down) in [(false, false), (true, false), (false, true), (true, true)] {
            for row in order(self.rows, is_down) {
                for col in order(self.cols, is_left) {
                    self.measure_square(row, col, Quadrant { is_left, is_down });
                }
            }
        }
    }

    fn measure_square(&mut self, row: usize, col: usize, quadrant: Quadrant) {
        let ahead = |at: usize, back: bool| if back { at.wrapping_sub(1) } else { at + 1 };
        let (next_row, next_col) = (ahead(row, quadrant.is_down), ahead(col, quadrant.is_left));
        let side_at = |row: usize, col: usize| {
            let inside = row < self.rows && col < self.cols;
            let cell = inside.then(|| self.cells.get(row * self.cols + col));
            cell.flatten().map_or(0, |cell| cell.side(quadrant))
        };
        let least = side_at(next_row, col)
            .min(side_at(row, next_col))
            .min(side_at(next_row, next_col));
        if let Some(cell) = self.cells.get_mut(row * self.cols + col)
            && cell.count == 0
        {
            cell.first_or_sides |= (least + 1).min(LARGEST_SQUARE) << quadrant.shift();
        }
    }
}

/// Indices in an order in which the cells ahead come first.
fn order(count: usize, is_back: bool) -> impl Iterator<Item = usize> {
    (0..count).map(move |i| if is_back { i } else { count - 1 - i })
}

/// The direction of a ray.
#[derive(Clone, Copy, Debug)]
struct Quadrant {
    is_left: bool,
    is_down: bool,
}

impl Quadrant {
    #[inline]
    fn of(x: f64, y: f64) -> Self {
        Self {
            is_left: x < 0.0,
            is_down: y < 0.0,
        }
    }

    /// Position of its byte.
    #[inline]
    fn shift(self) -> u32 {
        8 * u32::from(self.is_left) + 16 * u32::from(self.is_down)
    }
}

impl Cell {
    /// Side of the empty square ahead, in cells; 0 for a cell with items.
    #[inline]
    fn side(&self, quadrant: Quadrant) -> u32 {
        if self.count > 0 {
            0
        } else {
            (self.first_or_sides >> quadrant.shift()) & LARGEST_SQUARE
        }
    }
}

/// One coordinate of a ray, in cells.
struct Axis {
    origin: f64,
    step: f64,
    per_step: f64,
    /// Where the ray leaves cell 0, in the same unit as `enter` and `leave`.
    leave_first: f64,
    most: u32,
    enter: f64,
    leave: f64,
}

/// 1.5 · 2⁵²: adding this to a number leaves the nearest integer in the low bits of the sum. The
/// conversion `as` saturates, which takes three times as long, and a walk from cell to cell is
/// nothing but a chain of such steps.
const ROUND: f64 = 6_755_399_441_055_744.0;

impl Axis {
    #[inline]
    fn new(origin: f64, step: f64, count: usize) -> Self {
        // A ray along the other axis stays in its row for good: its step must be exactly 0, or
        // rounding would carry it over a border that it never crosses. A huge quotient expresses
        // this without dividing by 0.
        let is_parallel = step.abs() < 1e-13;
        let (step, per_step) = if is_parallel {
            (0.0, 1e30)
        } else {
            (step, 1.0 / step)
        };
        let (at_low, at_high) = (-origin * per_step, (count as f64 - origin) * per_step);
        // Cells are left on the upper side by a ray that goes up, on the lower by one that goes
        // down, and never by a ray along the other axis, even one that runs exactly on a border.
        let upper = if per_step > 0.0 { 1.0 } else { 0.0 };
        let leave_first = if is_parallel {
            1e300
        } else {
            (upper - origin) * per_step
        };
        Self {
            origin,
            step,
            per_step,
            leave_first,
            most: count as u32 - 1,
            enter: at_low.min(at_high),
            leave: at_low.max(at_high),
        }
    }

    /// The cell at `t`, as a number and as an index; exactly on a border it may be either of the
    /// two.
    #[inline]
    fn cell_at(&self, t: f64) -> (f64, u32) {
        let rounded = (self.origin - 0.5 + t * self.step) + ROUND;
        let index = rounded.to_bits() as i32;
        (rounded - ROUND, (index.max(0) as u32).min(self.most))
    }

    /// Where the ray leaves the square that reaches `reach` cells ahead of `cell`.
    #[inline]
    fn leave_at(&self, cell: f64, reach: f64) -> f64 {
        cell * self.per_step + self.leave_first + reach * self.per_step.abs()
    }
}

/// Like `f64::min` for numbers, but without its check for NaN, which costs as much again.
#[inline]
fn lesser(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

/// Like `f64::max` for numbers.
#[inline]
fn greater(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

impl Item {
    /// Takes this wall if it is the nearest so far; the arithmetic is that of
    /// [`crate::geom::Segment::hit_by_ray`].
    #[inline]
    fn meet<'a>(
        &'a self,
        origin: Point2<f64>,
        direction: Vector2<f64>,
        best: &mut (f64, Option<&'a Self>),
    ) {
        let (tx, ty) = (self.ax - origin.x, self.ay - origin.y);
        let denominator = direction.x * self.vy - direction.y * self.vx;
        let along = tx * direction.y - ty * direction.x;
        // 0 ≤ along / denominator ≤ 1, without the division: most walls are missed. One branch for
        // all ways to miss, because which one applies is unpredictable.
        let size = denominator.abs();
        let along = along * 1.0_f64.copysign(denominator);
        let meets = (along >= -CRACK * size) & (along <= size * (1.0 + CRACK)) & (size >= 1e-12);
        if !meets {
            return;
        }
        let distance = (tx * self.vy - ty * self.vx) / denominator;
        if distance >= 0.0 && distance <= best.0 && (distance < best.0 || best.1.is_none()) {
            *best = (distance, Some(self));
        }
    }
}
