//! Positions of the surfaces whose hits made cells occupied, finer than the cells.
//!
//! In: a raster of cells, some of them occupied, some free. Out: straight pieces of surface, with
//! free space on the left.
//!
//! 1. A surface lies within cells, not at their border: its hits fall a little before it and a
//!    little behind it, and a surface along a border between cells makes the cells on both sides
//!    occupied. In a wall one cell thick it is the middle; in a thicker one it lies at least half a
//!    cell behind the front, and a whole cell if hits fell on both sides of a border. A wall taken
//!    at its front is too near by that much, and so is the opposite wall: the room would be
//!    narrower than the robot measures it.
//! 2. So the midpoints of the cells' sides are moved inwards by half the depth of the occupied
//!    cells behind them, at most by a cell.
//! 3. They are cut into straight pieces (as in [`super::outlines`] for polygons).
//! 4. A surface was seen only where a piece faces known free space. A wall that was seen from both
//!    sides is two rows of cells with unknown cells between them: the back of one row looks like a
//!    front, a wall's thickness behind the other front, and would attract what was seen there.
//! 5. A line is fitted to each piece (total least squares): a front that is ragged by a cell is
//!    ragged to both sides equally.

use nalgebra::{Point2, Vector2};

use super::outline::{needed, rings};
use crate::geom::{Segment, sides_of, unit_vector};

/// Greatest depth of a surface behind the border of its cells, in cells.
const DEEPEST: f64 = 1.0;

/// A surface continues across at most this many sides of cells that face the unknown, such as a
/// cell before a wall that no beam has crossed.
const WIDEST_GAP: usize = 2;

/// The surfaces of the occupied cells that face free space; corner (0, 0) is the lower left one of
/// the first cell.
///
/// # Units    `occupied` and `free`: row by row, the lowest first, `width` cells each. `tolerance`:
/// how far points may lie off a straight piece, cells. Returns segments in cells.
#[must_use]
pub fn surfaces(width: usize, occupied: &[bool], free: &[bool], tolerance: f64) -> Vec<Segment> {
    let raster = Raster {
        width,
        occupied,
        free,
    };
    let rings = rings(width, occupied);
    let found = rings.iter().flat_map(|ring| {
        let points = raster.surface_points(ring);
        let places: Vec<Point2<f64>> = points.iter().map(|point| point.place).collect();
        let kept = needed(&places, tolerance);
        let pieces: Vec<Segment> = sides_of(&kept)
            .flat_map(|(&from, &to)| seen_runs(&points, from, to))
            .filter_map(|run| fitted(&run))
            .collect();
        pieces
    });
    found.collect()
}

struct Raster<'a> {
    width: usize,
    occupied: &'a [bool],
    free: &'a [bool],
}

/// The surface point behind one side of a cell.
#[derive(Clone, Copy, Debug)]
struct SurfacePoint {
    place: Point2<f64>,
    /// Whether the cell in front is known to be free.
    faces_free: bool,
}

impl Raster<'_> {
    /// Step 2, for each side of a cell along a ring.
    fn surface_points(&self, ring: &[Point2<f64>]) -> Vec<SurfacePoint> {
        let sides = sides_of(ring).flat_map(|(a, b)| {
            let along = b - a;
            let count = along.amax().round();
            let step = along / count.max(1.0);
            let inwards = Vector2::new(step.y, -step.x);
            (0..count as usize).map(move |i| (a + step * (i as f64 + 0.5), inwards))
        });
        let inset = |(at, inwards)| SurfacePoint {
            place: at + inwards * (0.5 * self.depth(at, inwards)).min(DEEPEST),
            faces_free: self.is_in(self.free, at - inwards * 0.5),
        };
        sides.map(inset).collect()
    }

    /// Number of occupied cells in a row inwards from a side, as far as it matters.
    fn depth(&self, side: Point2<f64>, inwards: Vector2<f64>) -> f64 {
        let most = (2.0 * DEEPEST).ceil() as usize;
        let cells = (0..most).map(|k| side + inwards * (k as f64 + 0.5));
        cells
            .take_while(|&cell| self.is_in(self.occupied, cell))
            .count() as f64
    }

    fn is_in(&self, cells: &[bool], at: Point2<f64>) -> bool {
        let is_inside = at.x >= 0.0 && at.y >= 0.0 && at.x < self.width as f64;
        let index = at.y as usize * self.width + at.x as usize;
        is_inside && cells.get(index).copied().unwrap_or(false)
    }
}

/// Step 4: the points of a ring from one to another that face free space, in runs without a wide
/// gap.
fn seen_runs(ring: &[SurfacePoint], from: usize, to: usize) -> Vec<Vec<Point2<f64>>> {
    let count = (to + ring.len() - from) % ring.len();
    let points = (0..=count).filter_map(|i| ring.get((from + i) % ring.len()));
    let mut runs: Vec<Vec<Point2<f64>>> = vec![];
    let mut unseen = usize::MAX;
    for point in points {
        if !point.faces_free {
            unseen = unseen.saturating_add(1);
            continue;
        }
        match runs.last_mut() {
            Some(run) if unseen <= WIDEST_GAP => run.push(point.place),
            _ => runs.push(vec![point.place]),
        }
        unseen = 0;
    }
    runs
}

/// Step 5: the line through points; `None` if they coincide.
fn fitted(points: &[Point2<f64>]) -> Option<Segment> {
    let (a, b) = (points.first()?, points.last()?);
    let sum: Vector2<f64> = points.iter().map(|p| p.coords).sum();
    let mean = sum / points.len() as f64;
    let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
    for point in points {
        let off = point.coords - mean;
        xx += off.x * off.x;
        xy += off.x * off.y;
        yy += off.y * off.y;
    }
    let direction = unit_vector(0.5 * libm::atan2(2.0 * xy, xx - yy));
    let on_line =
        |p: &Point2<f64>| Point2::from(mean + direction * direction.dot(&(p.coords - mean)));
    let piece = Segment::new(on_line(a), on_line(b));
    (piece.length() > 1e-9).then_some(piece)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const SIDE: usize = 120;

    /// The raster that hits with this noise give of a square room whose walls lie at `low` and
    /// `high`, cells: each cell in which a beam ever ended.
    fn room(low: f64, high: f64, noise: f64) -> Vec<bool> {
        let mut cells = vec![false; SIDE * SIDE];
        let mut hit = |x: f64, y: f64| cells[y as usize * SIDE + x as usize] = true;
        for k in 0..4000 {
            let along = low + (high - low) * f64::from(k) / 4000.0;
            // Evenly spread over ± the noise.
            let off = noise * (f64::from(k * 7 % 100) / 49.5 - 1.0);
            hit(low + off, along);
            hit(high + off, along);
            hit(along, low + off);
            hit(along, high + off);
        }
        cells
    }

    /// The cells that are not occupied are free.
    fn rest(occupied: &[bool]) -> Vec<bool> {
        occupied.iter().map(|is_wall| !is_wall).collect()
    }

    proptest! {
        #[test]
        fn walls_lie_where_they_are_wherever_the_borders_of_the_cells_are(
            low in 10.0..11.0_f64, size in 60.0..61.0_f64, noise in 0.05..0.4_f64,
        ) {
            let (high, cells) = (low + size, room(low, low + size, noise));
            let middle = Point2::new(low + 0.5 * size, low + 0.5 * size);
            let inner: Vec<Segment> = surfaces(SIDE, &cells, &rest(&cells), 1.0)
                .into_iter()
                // Those that face the room and are long.
                .filter(|s| s.length() > 20.0 && s.vector().perp(&(middle - s.a)) > 0.0)
                .collect();
            prop_assert!(inner.len() >= 4, "{inner:?}");
            for wall in inner {
                let at = nalgebra::center(&wall.a, &wall.b);
                let off = [at.x - low, at.x - high, at.y - low, at.y - high]
                    .map(f64::abs)
                    .into_iter()
                    .fold(f64::INFINITY, f64::min);
                prop_assert!(off <= 0.51, "{wall:?} is off by {off} cells");
            }
        }
    }

    #[test]
    fn on_average_a_wall_is_neither_too_near_nor_too_far() {
        let count = 40;
        let sum: f64 = (0..count)
            .map(|k| {
                let low = 10.0 + f64::from(k) / f64::from(count);
                let cells = room(low, low + 60.5, 0.3);
                let walls = surfaces(SIDE, &cells, &rest(&cells), 1.0).into_iter();
                // The left wall, free to its right: from its upper end to its lower one.
                let left = walls.filter(|s| s.a.y - s.b.y > 20.0 && s.a.x < 20.0 && s.b.x < 20.0);
                let offs: Vec<f64> = left.map(|s| 0.5 * (s.a.x + s.b.x) - low).collect();
                offs.iter().copied().fold(f64::NEG_INFINITY, f64::max)
            })
            .sum();
        // Taken at the front of its cells it would be 0.8 cells too near.
        assert!(
            (sum / f64::from(count)).abs() < 0.15,
            "{}",
            sum / f64::from(count)
        );
    }

    #[test]
    fn an_askew_wall_becomes_straight_and_lies_in_the_middle_of_its_staircase() {
        let width = 200;
        let cells: Vec<bool> = (0..200 * 100).map(|i| (i % 200) / 2 == i / 200).collect();
        for wall in surfaces(width, &cells, &rest(&cells), 1.0)
            .iter()
            .filter(|s| s.length() > 20.0)
        {
            for at in [wall.a, wall.b] {
                assert!((at.y - 0.5 * at.x).abs() < 0.75, "{wall:?}");
            }
        }
        assert!(surfaces(3, &[false; 9], &[true; 9], 1.0).is_empty());
        assert!(surfaces(0, &[], &[], 1.0).is_empty());
    }

    #[test]
    fn a_wall_seen_from_both_sides_has_no_surface_between_them() {
        // Free, a front, two cells that nobody saw, the other front, free.
        let row = [0, 0, 0, 1, 2, 2, 1, 0, 0, 0];
        let cells = |what: u8| -> Vec<bool> {
            let row = row.map(|cell| cell == what);
            row.iter().copied().cycle().take(10 * 40).collect()
        };
        let (free, occupied) = (cells(0), cells(1));
        let mut found = surfaces(10, &occupied, &free, 1.0);
        found.sort_by(|a, b| a.a.x.total_cmp(&b.a.x));
        let [left, right] = found[..] else {
            panic!("{found:?}");
        };
        assert!((left.a.x - 3.5).abs() < 1e-9 && (left.b.x - 3.5).abs() < 1e-9);
        assert!((right.a.x - 6.5).abs() < 1e-9 && (right.b.x - 6.5).abs() < 1e-9);
        // Free space is to the left: for the left wall when going up.
        assert!(left.b.y > left.a.y && right.b.y < right.a.y, "{found:?}");
        // If everything but the walls is free, each wall has its back too.
        assert_eq!(surfaces(10, &occupied, &rest(&occupied), 1.0).len(), 4);
    }

    #[test]
    fn a_surface_goes_on_past_a_cell_that_nobody_saw_and_ends_at_a_wide_gap() {
        let (width, height) = (60, 3);
        let occupied: Vec<bool> = (0..width * height).map(|i| i < width).collect();
        let unseen = [20, 21, 40, 41, 42, 43];
        let free: Vec<bool> = (0..width * height)
            .map(|i| i >= width && !unseen.contains(&(i % width)))
            .collect();
        let mut lengths: Vec<f64> = surfaces(width, &occupied, &free, 1.0)
            .iter()
            .map(Segment::length)
            .collect();
        lengths.sort_by(f64::total_cmp);
        assert_eq!(lengths.len(), 2, "{lengths:?}");
        assert!((lengths[0] - 15.0).abs() < 1e-9 && (lengths[1] - 39.0).abs() < 1e-9);
    }
}
