//! Rays and distances to walls, through a uniform grid that leaps over empty room.
//!
//! In: the walls. Out: the first wall along a ray, and the walls near a place.
//!
//! 1. A grid is laid over the walls, about [`CELLS_PER_WALL`] cells for each; every cell lists the walls that touch
//!    it, their figures side by side in one array in the order of the cells.
//! 2. An empty cell knows its chessboard distance to the nearest cell that is not empty.
//! 3. A ray walks from cell to cell; through empty room it leaps over the whole empty square at once, as sphere
//!    tracing does (Hart 1996), with squares instead of spheres. Where a cell holds walls the ray is intersected
//!    with each, and stops once its nearest hit lies before the end of the cell.
//!
//! Why not a tree: rooms are thin lines around much empty room, so a leap crosses a room in a few steps whatever the
//! number of walls, and there is no stack. The bench `sim` compares it with trying every wall.

use nalgebra::{Point2, Vector2};

use super::{Material, Wall};

/// Cells for each wall. More of them trade walls tried for cells visited, and memory; counted over 20 000 rays:
///
/// | cells for each wall | `office`: cells, walls for each ray | 20 000 walls: cells, walls for each ray |
/// |---|---|---|
/// | 1 | 3.3, 6.6 | 3.3, 5.8 |
/// | 4 | 4.9, 4.2 | 5.5, 3.5 |
/// | 16 | 5.6, 3.0 | 7.5, 2.5 |
/// | 64 | 6.2, 2.1 | 8.4, 2.0 |
const CELLS_PER_WALL: f64 = 4.0;
/// Bound on the number of cells along one side.
const MOST_CELLS_ALONG: f64 = 2048.0;
/// Smallest cell, m.
const LEAST_CELL: f64 = 0.02;
/// Walls are entered into cells that they miss by less than this, in cells.
const INFLATION: f64 = 1e-6;
/// A ray steps this far beyond a border, in cells; less than [`INFLATION`], so that no wall slips between.
const NUDGE: f64 = 1e-7;
/// A ray that passes a wall's end by less than this part of the wall hits it, so that corners have no crack.
const CRACK: f64 = 1e-12;

/// Answers which wall a ray meets first and which walls are near.
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
    /// Number of the wall in [`Caster::walls`].
    pub surface: usize,
}

#[derive(Clone, Copy, Debug, Default)]
struct Cell {
    /// First of its items.
    first: u32,
    /// Number of its items.
    count: u16,
    /// Chessboard distance to the nearest cell with items, 0 for those themselves; saturates.
    empty: u16,
}

/// One wall in one cell: where it starts and where it goes.
#[derive(Clone, Copy, Debug)]
struct Item {
    ax: f64,
    ay: f64,
    vx: f64,
    vy: f64,
    surface: u32,
}

impl Caster {
    /// Builds the grid over `walls`, whose coordinates must be finite (see [`super::World::validate`]).
    #[must_use]
    pub fn new(walls: Vec<Wall>) -> Self {
        let ends = walls.iter().flat_map(|w| [w.segment.a, w.segment.b]);
        let nothing = (
            Point2::new(f64::MAX, f64::MAX),
            Point2::new(f64::MIN, f64::MIN),
        );
        let (mut low, mut high) = ends.fold(nothing, |(low, high), p| (low.inf(&p), high.sup(&p)));
        if walls.is_empty() {
            (low, high) = (Point2::origin(), Point2::origin());
        }
        let extent = high - low;
        let area = extent.x.max(1.0) * extent.y.max(1.0);
        let wanted = (area / (CELLS_PER_WALL * walls.len().max(8) as f64)).sqrt();
        let cell = wanted
            .max(LEAST_CELL)
            .max(extent.x.max(extent.y) / MOST_CELLS_ALONG);
        let along = |metres: f64| (metres / cell) as usize + 3;
        // One empty cell on every side keeps rounding at the border harmless.
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

    /// The walls, numbered as in [`Hit::surface`].
    #[must_use]
    pub fn walls(&self) -> &[Wall] {
        &self.walls
    }

    /// The first wall along the ray from `origin` in the unit `direction`, not farther than `max_range` (m).
    ///
    /// `None` also where the ray is not finite.
    #[must_use]
    pub fn cast(
        &self,
        origin: Point2<f64>,
        direction: Vector2<f64>,
        max_range: f64,
    ) -> Option<Hit> {
        let (distance, surface) = self.first_item(origin, direction, max_range)?;
        let surface = surface as usize;
        let material = self.walls.get(surface)?.material;
        Some(Hit {
            distance,
            material,
            surface,
        })
    }

    fn first_item(
        &self,
        origin: Point2<f64>,
        direction: Vector2<f64>,
        max_range: f64,
    ) -> Option<(f64, u32)> {
        if !(origin.x + origin.y + direction.x + direction.y).is_finite() {
            return None;
        }
        // In cells from here on; one slab test brings the ray into the grid.
        let (ox, oy) = (
            (origin.x - self.low.x) * self.per_metre,
            (origin.y - self.low.y) * self.per_metre,
        );
        let x = Axis::new(ox, direction.x, self.cols);
        let y = Axis::new(oy, direction.y, self.rows);
        let mut t = x.enter.max(y.enter).max(0.0);
        let end = x.leave.min(y.leave).min(max_range * self.per_metre);
        let mut best = (max_range, u32::MAX);
        // Every turn enters another cell, so the bound is reached only where the origin is so far away that a
        // cell is less than the rounding of `t`.
        for _ in 0..2 * (self.cols + self.rows) {
            if t > end {
                break;
            }
            let (col, row) = (x.cell_at(t), y.cell_at(t));
            let cell = self.cells.get(row * self.cols + col)?;
            let reach = f64::from(cell.empty.max(1) - 1);
            let leave = x.leave_at(col, reach).min(y.leave_at(row, reach));
            if cell.count > 0 {
                let first = cell.first as usize;
                let items = self.items.get(first..first + usize::from(cell.count))?;
                for item in items {
                    item.meet(origin, direction, &mut best);
                }
                if best.0 * self.per_metre <= leave {
                    break;
                }
            }
            t = leave.max(t) + NUDGE;
        }
        (best.1 != u32::MAX).then_some(best)
    }

    /// Visits the walls that may lie within `reach` (m) of `point`, some of them more than once.
    pub fn near(&self, point: Point2<f64>, reach: f64, mut visit: impl FnMut(usize, &Wall)) {
        let index = |metres: f64, low: f64, count: usize| {
            // A float-to-integer `as` saturates and takes NaN to 0.
            (((metres - low) * self.per_metre) as usize).min(count - 1)
        };
        let cols = index(point.x - reach, self.low.x, self.cols)
            ..=index(point.x + reach, self.low.x, self.cols);
        let rows = index(point.y - reach, self.low.y, self.rows)
            ..=index(point.y + reach, self.low.y, self.rows);
        for row in rows {
            for cell in cols
                .clone()
                .filter_map(|col| self.cells.get(row * self.cols + col))
            {
                let first = cell.first as usize;
                let items = self.items.get(first..first + usize::from(cell.count));
                for item in items.into_iter().flatten() {
                    let surface = item.surface as usize;
                    if let Some(wall) = self.walls.get(surface) {
                        visit(surface, wall);
                    }
                }
            }
        }
    }

    /// Distance of `point` from the nearest wall, m, if that is less than `reach`; otherwise `reach`.
    #[must_use]
    pub fn clearance(&self, point: Point2<f64>, reach: f64) -> f64 {
        let mut least = reach;
        self.near(point, reach, |_, wall| {
            least = least.min(wall.segment.distance(point))
        });
        least
    }

    /// Lists the walls of every cell: count, sum up, fill.
    fn enter_walls(&mut self) {
        self.cells = vec![Cell::default(); self.cols * self.rows];
        let mut touched = Vec::new();
        for surface in 0..self.walls.len() {
            self.touched_cells(surface, &mut touched);
        }
        // Stable by cell, so the walls of a cell stay in their own order.
        touched.sort_unstable();
        self.items.reserve_exact(touched.len());
        for &(cell, surface) in &touched {
            let (Some(cell), Some(wall)) = (
                self.cells.get_mut(cell as usize),
                self.walls.get(surface as usize),
            ) else {
                continue;
            };
            // The 65 536th wall in one cell would be a world of nothing but coincident walls.
            if cell.count == u16::MAX {
                continue;
            }
            if cell.count == 0 {
                cell.first = self.items.len() as u32;
            }
            cell.count += 1;
            let along = wall.segment.vector();
            self.items.push(Item {
                ax: wall.segment.a.x,
                ay: wall.segment.a.y,
                vx: along.x,
                vy: along.y,
                surface,
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

    /// Chessboard distance transform in two passes (Rosenfeld & Pfaltz 1968), exact for this metric.
    fn measure_empty_room(&mut self) {
        let (cols, rows) = (self.cols as isize, self.rows as isize);
        for cell in &mut self.cells {
            cell.empty = if cell.count > 0 { 0 } else { u16::MAX };
        }
        let mut pass = |order: &mut dyn Iterator<Item = isize>, before: [(isize, isize); 4]| {
            for index in order {
                let (row, col) = (index / cols, index % cols);
                let mut least = u16::MAX;
                for (dr, dc) in before {
                    let (r, c) = (row + dr, col + dc);
                    if (0..rows).contains(&r) && (0..cols).contains(&c) {
                        let neighbour = self.cells.get((r * cols + c) as usize);
                        least = least.min(neighbour.map_or(u16::MAX, |n| n.empty));
                    }
                }
                if let Some(cell) = self.cells.get_mut(index as usize) {
                    cell.empty = cell.empty.min(least.saturating_add(1));
                }
            }
        };
        pass(&mut (0..rows * cols), [(0, -1), (-1, -1), (-1, 0), (-1, 1)]);
        pass(
            &mut (0..rows * cols).rev(),
            [(0, 1), (1, 1), (1, 0), (1, -1)],
        );
    }
}

/// One coordinate of a ray, in cells.
struct Axis {
    origin: f64,
    step: f64,
    per_step: f64,
    /// 1 where the ray leaves cells on their upper side, 0 on their lower.
    upper: f64,
    /// -1 or 1: the way in which the empty square reaches.
    sign: f64,
    most: usize,
    enter: f64,
    leave: f64,
}

impl Axis {
    #[inline]
    fn new(origin: f64, step: f64, count: usize) -> Self {
        // A ray along the other axis stays in its row for good: its step is 0 exactly, or rounding would carry it over
        // a border that it never leaves by. A huge quotient says so without dividing by 0.
        let (step, per_step) = if step.abs() < 1e-13 {
            (0.0, 1e30)
        } else {
            (step, 1.0 / step)
        };
        let (at_low, at_high) = (-origin * per_step, (count as f64 - origin) * per_step);
        let forward = per_step > 0.0;
        Self {
            origin,
            step,
            per_step,
            upper: if forward { 1.0 } else { 0.0 },
            sign: if forward { 1.0 } else { -1.0 },
            most: count - 1,
            enter: at_low.min(at_high),
            leave: at_low.max(at_high),
        }
    }

    #[inline]
    fn cell_at(&self, t: f64) -> usize {
        ((self.origin + t * self.step) as usize).min(self.most)
    }

    /// Where the ray leaves the square of `reach` cells around `cell`.
    #[inline]
    fn leave_at(&self, cell: usize, reach: f64) -> f64 {
        (cell as f64 + self.upper + self.sign * reach - self.origin) * self.per_step
    }
}

impl Item {
    /// Takes this wall as the nearest if it is; the arithmetic of [`crate::geom::Segment::hit_by_ray`].
    #[inline]
    fn meet(&self, origin: Point2<f64>, direction: Vector2<f64>, best: &mut (f64, u32)) {
        let (tx, ty) = (self.ax - origin.x, self.ay - origin.y);
        let denominator = direction.x * self.vy - direction.y * self.vx;
        let along = tx * direction.y - ty * direction.x;
        // 0 ≤ along / denominator ≤ 1, without the division: most walls are missed.
        let (size, along) = if denominator < 0.0 {
            (-denominator, -along)
        } else {
            (denominator, along)
        };
        if along < -CRACK * size || along > size * (1.0 + CRACK) || size < 1e-12 {
            return;
        }
        let distance = (tx * self.vy - ty * self.vx) / denominator;
        if distance >= 0.0 && distance <= best.0 && (distance < best.0 || best.1 == u32::MAX) {
            *best = (distance, self.surface);
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::geom::Segment;

    fn wall(ax: f64, ay: f64, bx: f64, by: f64) -> Wall {
        Wall {
            segment: Segment::new(Point2::new(ax, ay), Point2::new(bx, by)),
            material: Material::Opaque,
        }
    }

    fn brute_force(
        walls: &[Wall],
        origin: Point2<f64>,
        direction: Vector2<f64>,
        max_range: f64,
    ) -> Option<f64> {
        walls
            .iter()
            .filter_map(|w| w.segment.hit_by_ray(origin, direction))
            .filter(|d| *d <= max_range)
            .min_by(f64::total_cmp)
    }

    fn check(walls: &[Wall], origin: Point2<f64>, angle: f64, max_range: f64) {
        let direction = Vector2::new(libm::cos(angle), libm::sin(angle));
        let caster = Caster::new(walls.to_vec());
        let hit = caster.cast(origin, direction, max_range);
        let expect = brute_force(walls, origin, direction, max_range);
        match (hit, expect) {
            (Some(hit), Some(expect)) => {
                assert!(
                    (hit.distance - expect).abs() < 1e-9,
                    "{hit:?} against {expect}"
                );
                let surface = walls[hit.surface].segment;
                assert!(surface.distance(origin + direction * hit.distance) < 1e-6);
            }
            (None, None) => {}
            (hit, expect) => panic!("{hit:?} against {expect:?} from {origin} at {angle}"),
        }
    }

    fn walls(most: usize) -> impl Strategy<Value = Vec<Wall>> {
        let one = (
            -20.0..20.0_f64,
            -20.0..20.0_f64,
            -6.0..6.0_f64,
            -6.0..6.0_f64,
        )
            .prop_map(|(x, y, dx, dy)| wall(x, y, x + dx, y + dy));
        proptest::collection::vec(one, 0..most)
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(2000))]

        #[test]
        fn first_hit_is_the_nearest_of_all_walls(
            walls in walls(60), x in -30.0..30.0_f64, y in -30.0..30.0_f64, angle in -3.2..3.2_f64, range in 0.1..60.0_f64,
        ) {
            check(&walls, Point2::new(x, y), angle, range);
        }

        #[test]
        fn axis_aligned_rays_and_walls_on_cell_borders_are_no_exception(
            corners in proptest::collection::vec((-8..8_i32, -8..8_i32, 1..5_i32, any::<bool>()), 1..40),
            x in -9..9_i32, y in -9..9_i32, quarter in 0..4_i32,
        ) {
            let walls: Vec<Wall> = corners.iter().map(|&(x, y, length, upright)| {
                let (x, y, length) = (f64::from(x), f64::from(y), f64::from(length));
                if upright { wall(x, y, x, y + length) } else { wall(x, y, x + length, y) }
            }).collect();
            // Half a metre off the lattice, so that the ray does not run along a wall or through its end.
            let origin = Point2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
            check(&walls, origin, f64::from(quarter) * std::f64::consts::FRAC_PI_2, 50.0);
        }

        #[test]
        fn clearance_is_the_least_distance(walls in walls(40), x in -30.0..30.0_f64, y in -30.0..30.0_f64, reach in 0.1..9.0_f64) {
            let point = Point2::new(x, y);
            let expect = walls.iter().map(|w| w.segment.distance(point)).fold(reach, f64::min);
            prop_assert_eq!(Caster::new(walls).clearance(point, reach), expect);
        }
    }

    #[test]
    fn corners_of_closed_rooms_have_no_crack() {
        // Through the very corner in floating point: every ray must end.
        let shape = super::super::Shape::Circle {
            centre: Point2::new(0.3, 0.1),
            radius: 3.0,
        };
        let walls: Vec<Wall> = shape
            .segments()
            .iter()
            .map(|s| Wall {
                segment: *s,
                material: Material::Opaque,
            })
            .collect();
        let caster = Caster::new(walls.clone());
        for origin in [
            Point2::new(0.3, 0.1),
            Point2::new(1.0, -1.0),
            Point2::new(-0.7, 0.33),
        ] {
            for wall in &walls {
                let direction = (wall.segment.a - origin).normalize();
                assert!(caster.cast(origin, direction, 10.0).is_some());
            }
        }
    }

    #[test]
    fn rays_that_are_not_finite_hit_nothing() {
        let caster = Caster::new(vec![wall(1.0, -1.0, 1.0, 1.0)]);
        let ahead = Vector2::new(1.0, 0.0);
        assert_eq!(
            caster
                .cast(Point2::origin(), ahead, 5.0)
                .map(|h| h.distance),
            Some(1.0)
        );
        assert_eq!(caster.cast(Point2::origin(), ahead, 0.5), None);
        assert_eq!(caster.cast(Point2::new(f64::NAN, 0.0), ahead, 5.0), None);
        assert_eq!(
            caster.cast(Point2::origin(), Vector2::new(f64::NAN, 0.0), 5.0),
            None
        );
        assert_eq!(
            caster.cast(Point2::new(f64::INFINITY, 0.0), ahead, 5.0),
            None
        );
        assert_eq!(Caster::new(vec![]).cast(Point2::origin(), ahead, 5.0), None);
    }
}
