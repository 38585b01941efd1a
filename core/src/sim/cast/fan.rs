//! All beams of a scan taken from one place, at once.
//!
//! In: a place, a heading and a [`Fan`] of regular bearings. Out: for each beam the first wall, as
//! [`Caster::cast`] finds it.
//!
//! 1. The cells around the place are visited ring by ring, so the walls come roughly from near to
//!    far.
//! 2. Each wall is tested once, against the beams between the bearings of its two ends and one more
//!    on either side. The test is that of a single ray, so the distances are the same to the bit.
//! 3. It ends when the next ring begins beyond the farthest beam's current end.
//!
//! Why this and not only [`Caster::cast`]: a single ray is a chain of steps that wait for one
//! another. Here the inner loop runs over beams side by side without a branch, in the vector
//! registers of any processor. It is for flashes and for predicted scans: a turning lidar on a
//! moving robot has no single place.

use std::f64::consts::TAU;
use std::ops::RangeInclusive;

use nalgebra::{Point2, Vector2};

use super::{CRACK, Caster, Item, greater};
use crate::geom::{sin_cos, wrap};

/// No wall met, in the column of walls.
const NONE: f64 = -1.0;
/// A wall whose ends are seen in opposite directions to within this angle counts as directly under
/// the sensor, rad.
const OPPOSITE: f64 = 1e-6;

/// Regular bearings, and what was found along them; reused from place to place, so nothing is
/// allocated.
#[derive(Clone, Debug)]
pub struct Fan {
    first: f64,
    step: f64,
    /// Cosine and sine of each bearing in the sensor frame.
    bearings: [Vec<f64>; 2],
    /// The same for the last cast.
    directions: [Vec<f64>; 2],
    distances: Vec<f64>,
    /// Index of the wall, or [`NONE`]. It is as wide as the distance, so the same mask selects
    /// both.
    surfaces: Vec<f64>,
    /// The last cast in which each wall was tested.
    offered: Vec<u32>,
    casts: u32,
}

impl Fan {
    /// `beams` bearings from `first` on, `step` apart (rad, more than 0), at most one full turn.
    ///
    /// `None` if these conditions do not hold.
    #[must_use]
    pub fn new(beams: usize, first: f64, step: f64) -> Option<Self> {
        let round = step * beams as f64;
        if !(first.is_finite() && step > 0.0 && round <= TAU * (1.0 + 1e-12)) {
            return None;
        }
        let column = |of: fn((f64, f64)) -> f64| {
            let bearing = |k: usize| first + step * k as f64;
            (0..beams).map(|k| of(sin_cos(bearing(k)))).collect()
        };
        Some(Self {
            first,
            step,
            bearings: [column(|sin_cos| sin_cos.1), column(|sin_cos| sin_cos.0)],
            directions: [vec![0.0; beams], vec![0.0; beams]],
            distances: vec![f64::INFINITY; beams],
            surfaces: vec![NONE; beams],
            offered: Vec::new(),
            casts: 0,
        })
    }

    /// Distance of the first wall along each beam, m; `INFINITY` if there is none within range.
    #[must_use]
    pub fn distances(&self) -> &[f64] {
        &self.distances
    }

    /// Index in [`Caster::walls`] of the wall that a beam met. If a beam runs exactly through a
    /// corner, it may be another of its walls than the one [`Caster::cast`] names.
    #[must_use]
    pub fn surface(&self, beam: usize) -> Option<usize> {
        let surface = *self.surfaces.get(beam)?;
        (surface >= 0.0).then_some(surface as usize)
    }

    /// Unit vector of a beam at the last cast, world frame.
    #[must_use]
    pub fn direction(&self, beam: usize) -> Option<Vector2<f64>> {
        let [x, y] = &self.directions;
        Some(Vector2::new(*x.get(beam)?, *y.get(beam)?))
    }

    fn begin(&mut self, heading: f64, max_range: f64, walls: usize) {
        let (sin, cos) = sin_cos(heading);
        let [xs, ys] = &mut self.directions;
        let bearings = self.bearings[0].iter().zip(&self.bearings[1]);
        for ((x, y), (&bx, &by)) in xs.iter_mut().zip(ys).zip(bearings) {
            (*x, *y) = (bx * cos - by * sin, bx * sin + by * cos);
        }
        self.distances.fill(max_range);
        self.surfaces.fill(NONE);
        self.casts = self.casts.wrapping_add(1);
        // Another caster, or four thousand million casts: the record of tested walls is no longer
        // valid.
        if self.offered.len() != walls || self.casts == 0 {
            self.offered.clear();
            self.offered.resize(walls, 0);
            self.casts = 1;
        }
    }

    fn end(&mut self) {
        for (distance, surface) in self.distances.iter_mut().zip(&self.surfaces) {
            if *surface < 0.0 {
                *distance = f64::INFINITY;
            }
        }
    }

    /// How far the farthest beam currently reaches.
    fn farthest(&self) -> f64 {
        self.distances.iter().copied().fold(0.0, greater)
    }

    fn is_new(&mut self, item: &Item) -> bool {
        let Some(offered) = self.offered.get_mut(item.surface as usize) else {
            return false;
        };
        std::mem::replace(offered, self.casts) != self.casts
    }

    /// Tests a wall against the beams that may meet it. `zero`: where the first beam points, rad.
    fn offer(&mut self, item: &Item, origin: Point2<f64>, zero: f64) {
        let from = Vector2::new(item.ax - origin.x, item.ay - origin.y);
        let to = from + Vector2::new(item.vx, item.vy);
        let bearing = |end: &Vector2<f64>| libm::atan2(end.y, end.x);
        let (start, turn) = (bearing(&from), wrap(bearing(&to) - bearing(&from)));
        let last = self.distances.len() as f64 - 1.0;
        if turn.abs() > std::f64::consts::PI - OPPOSITE
            || from == Vector2::zeros()
            || to == Vector2::zeros()
        {
            self.try_beams(0.0, last, item, from);
            return;
        }
        let start = if turn < 0.0 { start + turn } else { start };
        let round = TAU / self.step;
        let first = (wrap(start - zero) / self.step).floor() - 1.0;
        let end = first + (turn.abs() / self.step).ceil() + 3.0;
        // Bearings repeat after a full turn.
        for shift in [0.0, round, -round] {
            self.try_beams(first + shift.floor(), end + shift.ceil(), item, from);
        }
    }

    /// Tries the beams from `first` to `last`, as far as they exist.
    fn try_beams(&mut self, first: f64, last: f64, item: &Item, to_wall: Vector2<f64>) {
        let count = self.distances.len();
        if last < 0.0 || first >= count as f64 {
            return;
        }
        // Both are in range, so `as` is exact; below 0 it gives 0.
        let beams = first as usize..=(last as usize).min(count.saturating_sub(1));
        let [xs, ys] = &self.directions;
        let (Some(xs), Some(ys), Some(distances), Some(surfaces)) = (
            xs.get(beams.clone()),
            ys.get(beams.clone()),
            self.distances.get_mut(beams.clone()),
            self.surfaces.get_mut(beams),
        ) else {
            return;
        };
        let surface = f64::from(item.surface);
        let across = to_wall.x * item.vy - to_wall.y * item.vx;
        let directions = xs.iter().zip(ys);
        for ((&x, &y), (best, met)) in directions.zip(distances.iter_mut().zip(surfaces)) {
            // As in `Item::meet`, but selecting by masks.
            let denominator = x * item.vy - y * item.vx;
            let size = denominator.abs();
            let along = (to_wall.x * y - to_wall.y * x) * 1.0_f64.copysign(denominator);
            let meets =
                (along >= -CRACK * size) & (along <= size * (1.0 + CRACK)) & (size >= 1e-12);
            let distance = across / denominator;
            let nearer = (distance < *best) | ((distance <= *best) & (*met < 0.0));
            let is_hit = meets & (distance >= 0.0) & nearer;
            *best = if is_hit { distance } else { *best };
            *met = if is_hit { surface } else { *met };
        }
    }
}

impl Caster {
    /// The first wall along each beam of `fan` from `origin`, not farther than `max_range` (m); the
    /// fan's bearings count from `heading` (rad, world frame). The results are stored in the fan.
    ///
    /// Nothing is met if place or heading is not finite.
    pub fn cast_fan(&self, origin: Point2<f64>, heading: f64, max_range: f64, fan: &mut Fan) {
        fan.begin(heading, max_range, self.walls.len());
        if (origin.x + origin.y + heading).is_finite() && max_range >= 0.0 {
            let at = (origin - self.low) * self.per_metre;
            let zero = heading + fan.first;
            for (ring, inner) in self.rings(at) {
                if inner > fan.farthest() * self.per_metre {
                    break;
                }
                self.offer_ring(at, ring, |item| {
                    if fan.is_new(item) {
                        fan.offer(item, origin, zero);
                    }
                });
            }
        }
        fan.end();
    }

    /// The rings of cells around the one at `at` that touch the grid: number, and distance of the
    /// ring's inner side in cells.
    fn rings(&self, at: Vector2<f64>) -> impl Iterator<Item = (f64, f64)> + use<> {
        let gap = |at: f64, count: usize| {
            let (cell, count) = (at.floor(), count as f64);
            let least = greater(greater(-cell, cell - (count - 1.0)), 0.0);
            let most = greater(cell.abs(), (count - 1.0 - cell).abs());
            let to_border = at - cell;
            (least, most, to_border.min(1.0 - to_border))
        };
        let (x, y) = (gap(at.x, self.cols), gap(at.y, self.rows));
        let (least, most) = (greater(x.0, y.0), greater(x.1, y.1));
        let border = x.2.min(y.2);
        // So far away that a cell is smaller than the rounding, nothing is within any range.
        let far = most > 1e9;
        let rings = if far { 0 } else { (most - least) as usize + 1 };
        (0..rings).map(move |k| {
            let ring = least + k as f64;
            (ring, ring - 1.0 + border)
        })
    }

    /// Visits the items in the cells of one ring, as far as the ring lies in the grid.
    fn offer_ring(&self, at: Vector2<f64>, ring: f64, mut visit: impl FnMut(&Item)) {
        let (col, row) = (at.x.floor(), at.y.floor());
        let Some(rows) = clip(row - ring, row + ring, self.rows) else {
            return;
        };
        for index in rows {
            let is_end = (index as f64 - row).abs() >= ring;
            if is_end {
                // The whole lower or upper side.
                let cols = clip(col - ring, col + ring, self.cols);
                cols.into_iter()
                    .flatten()
                    .for_each(|col| self.offer_cell(index, col, &mut visit));
            } else {
                let sides = [col - ring, col + ring].into_iter();
                sides
                    .filter_map(|col| clip(col, col, self.cols))
                    .flatten()
                    .for_each(|col| self.offer_cell(index, col, &mut visit));
            }
        }
    }

    fn offer_cell(&self, row: usize, col: usize, visit: &mut impl FnMut(&Item)) {
        let cell = self.cells.get(row * self.cols + col);
        if let Some(cell) = cell.filter(|cell| cell.count > 0) {
            self.items_of(cell).iter().for_each(visit);
        }
    }
}

/// The integers from `low` to `high` that are indices below `count`.
fn clip(low: f64, high: f64, count: usize) -> Option<RangeInclusive<usize>> {
    let most = count as f64 - 1.0;
    (high >= 0.0 && low <= most).then(|| greater(low, 0.0) as usize..=high.min(most) as usize)
}
