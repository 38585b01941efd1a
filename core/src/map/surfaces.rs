//! Where the surfaces are whose hits have made cells occupied: finer than the cells.
//!
//! In: a raster of cells, some of them occupied. Out: straight pieces of surface, with what is free
//! on the left.
//!
//! 1. A surface lies within cells, not at their border: its hits fall a little before it and a
//!    little behind, and one that runs along a border between cells makes both occupied. Of a wall
//!    that is one cell thick it is the middle; of a thicker one it lies half a cell behind the
//!    front at the least, and a cell where the hits of both sides of a border are in it. A wall
//!    taken at its front is too near by that, and so is the one opposite: a room then is narrower
//!    than the robot sees it.
//! 2. So the middles of the cells' sides are moved inwards by half of what is occupied behind them,
//!    at most by a cell.
//! 3. They are cut into straight pieces ([`super::outlines`] has it for polygons), and a line is
//!    fitted to each (total least squares): a front that is ragged by a cell is so to either side.

use nalgebra::{Point2, Vector2};

use super::outline::{needed, rings};
use crate::geom::{Segment, sides_of, unit_vector};

/// Farthest that a surface lies behind the border of its cells, in cells.
const DEEPEST: f64 = 1.0;

/// The surfaces of what is occupied; corner (0, 0) is the lower left one of the first cell.
///
/// # Units    `occupied`: row by row, the lowest first, `width` cells each. `tolerance`: how far
/// points may lie off a straight piece, cells. Returns segments in cells.
#[must_use]
pub fn surfaces(width: usize, occupied: &[bool], tolerance: f64) -> Vec<Segment> {
    let raster = Raster { width, occupied };
    let rings = rings(width, occupied);
    let found = rings.iter().flat_map(|ring| {
        let points = raster.surface_points(ring);
        let kept = needed(&points, tolerance);
        let pieces: Vec<Segment> = sides_of(&kept)
            .filter_map(|(&from, &to)| fitted(&points, from, to))
            .collect();
        pieces
    });
    found.collect()
}

struct Raster<'a> {
    width: usize,
    occupied: &'a [bool],
}

impl Raster<'_> {
    /// Step 2, for each side of a cell along a ring.
    fn surface_points(&self, ring: &[Point2<f64>]) -> Vec<Point2<f64>> {
        let sides = sides_of(ring).flat_map(|(a, b)| {
            let along = b - a;
            let count = along.amax().round();
            let step = along / count.max(1.0);
            let inwards = Vector2::new(step.y, -step.x);
            (0..count as usize).map(move |i| (a + step * (i as f64 + 0.5), inwards))
        });
        let inset = |(at, inwards)| at + inwards * (0.5 * self.depth(at, inwards)).min(DEEPEST);
        sides.map(inset).collect()
    }

    /// Occupied cells in a row, from a side of the first on, as far as they matter.
    fn depth(&self, side: Point2<f64>, inwards: Vector2<f64>) -> f64 {
        let most = (2.0 * DEEPEST).ceil() as usize;
        let cells = (0..most).map(|k| side + inwards * (k as f64 + 0.5));
        cells.take_while(|&cell| self.is_occupied(cell)).count() as f64
    }

    fn is_occupied(&self, at: Point2<f64>) -> bool {
        let is_inside = at.x >= 0.0 && at.y >= 0.0 && at.x < self.width as f64;
        let index = at.y as usize * self.width + at.x as usize;
        is_inside && self.occupied.get(index).copied().unwrap_or(false)
    }
}

/// Step 3: the line through the points of a ring from one to another; `None` where they are one
/// place.
fn fitted(ring: &[Point2<f64>], from: usize, to: usize) -> Option<Segment> {
    let count = (to + ring.len() - from) % ring.len();
    let points = (0..=count).filter_map(|i| ring.get((from + i) % ring.len()));
    let number = (count + 1) as f64;
    let sum: Vector2<f64> = points.clone().map(|p| p.coords).sum();
    let mean = sum / number;
    let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
    for point in points {
        let off = point.coords - mean;
        xx += off.x * off.x;
        xy += off.x * off.y;
        yy += off.y * off.y;
    }
    let direction = unit_vector(0.5 * libm::atan2(2.0 * xy, xx - yy));
    let (a, b) = (ring.get(from)?, ring.get(to)?);
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

    /// A raster that hits with this noise have made of a square room whose walls lie at `low` and
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

    proptest! {
        #[test]
        fn walls_lie_where_they_are_wherever_the_borders_of_the_cells_are(
            low in 10.0..11.0_f64, size in 60.0..61.0_f64, noise in 0.05..0.4_f64,
        ) {
            let (high, cells) = (low + size, room(low, low + size, noise));
            let middle = Point2::new(low + 0.5 * size, low + 0.5 * size);
            let inner: Vec<Segment> = surfaces(SIDE, &cells, 1.0)
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
                let walls = surfaces(SIDE, &cells, 1.0).into_iter();
                // The wall at the left, free to its right: from its upper end to its lower one.
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
        for wall in surfaces(width, &cells, 1.0)
            .iter()
            .filter(|s| s.length() > 20.0)
        {
            for at in [wall.a, wall.b] {
                assert!((at.y - 0.5 * at.x).abs() < 0.75, "{wall:?}");
            }
        }
        assert!(surfaces(3, &[false; 9], 1.0).is_empty() && surfaces(0, &[], 1.0).is_empty());
    }
}
