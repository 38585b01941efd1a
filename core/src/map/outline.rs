//! The outlines of occupied areas in a raster, as polygons.
//!
//! In: a raster of cells, some of them occupied. Out: closed polygons along the borders of the
//! occupied cells, with free space on the left when going round, as for the known lines of
//! localisation.
//!
//! 1. Each side of an occupied cell with no occupied cell beyond it is an edge. Edges are followed
//!    from corner to corner; occupied cells that touch only at a corner belong together, because a
//!    thin diagonal wall is one wall.
//! 2. A diagonal wall is a staircase of cells. Its line runs through the midpoints of the cells'
//!    sides, so these are the points of the polygon. Points are dropped as long as the polygon
//!    stays within `tolerance` (Douglas & Peucker 1973), starting from the point farthest from the
//!    centre and the point farthest from that one. With a tolerance of one cell all staircases
//!    become straight, and a wall of one cell becomes the line in its middle.

use nalgebra::Point2;

use crate::geom::sides_of;

/// East, north, west, south: the step in each direction, in corners.
const STEPS: [(i64, i64); 4] = [(1, 0), (0, 1), (-1, 0), (0, -1)];

/// Polygons around the occupied cells; corner (0, 0) is the lower left one of the first cell.
///
/// # Units    `occupied`: row by row, the lowest first, `width` cells each; cells beyond its end
/// are not occupied. `tolerance`: cells; 0 keeps the corners of the cells unchanged. Returns
/// corners in cells. Anything thinner than the tolerance becomes a line there and back: two
/// corners.
#[must_use]
pub fn outlines(width: usize, occupied: &[bool], tolerance: f64) -> Vec<Vec<Point2<f64>>> {
    let rings = rings(width, occupied).into_iter();
    rings.map(|ring| simplified(&ring, tolerance)).collect()
}

/// All corners of all rings.
pub(super) fn rings(width: usize, occupied: &[bool]) -> Vec<Vec<Point2<f64>>> {
    let mut edges = Edges::of(width, occupied);
    let mut rings = vec![];
    for start in 0..edges.ways.len() {
        while let Some(ring) = edges.follow(start) {
            rings.push(ring);
        }
    }
    rings
}

/// For each corner of the raster, the directions in which edges leave it, a bit each in the order
/// of [`STEPS`].
struct Edges {
    columns: usize,
    ways: Vec<u8>,
}

impl Edges {
    fn of(width: usize, occupied: &[bool]) -> Self {
        let columns = width + 1;
        let rows = occupied.len().div_ceil(width.max(1));
        let mut ways = vec![0_u8; columns * (rows + 1)];
        let is_occupied = |col: usize, row: usize| {
            col < width && occupied.get(row * width + col).copied().unwrap_or(false)
        };
        for (index, _) in occupied.iter().enumerate().filter(|(_, o)| **o) {
            let (col, row) = (index % width, index / width);
            let mut edge = |col: usize, row: usize, way: u8| ways[row * columns + col] |= 1 << way;
            if col == 0 || !is_occupied(col - 1, row) {
                edge(col, row, 1);
            }
            if !is_occupied(col, row + 1) {
                edge(col, row + 1, 0);
            }
            if !is_occupied(col + 1, row) {
                edge(col + 1, row + 1, 3);
            }
            if row == 0 || !is_occupied(col, row - 1) {
                edge(col + 1, row, 2);
            }
        }
        Self { columns, ways }
    }

    /// The ring of corners that begins at a corner; its edges are removed. `None` if no edge
    /// remains.
    fn follow(&mut self, start: usize) -> Option<Vec<Point2<f64>>> {
        let first = (0..4).find(|way| self.ways[start] & (1 << way) != 0)?;
        let (mut at, mut way) = (start, first);
        let mut ring = vec![self.corner(at)];
        loop {
            self.ways[at] &= !(1 << way);
            let (dx, dy) = STEPS[way];
            at = (at as i64 + dx + dy * self.columns as i64) as usize;
            // To the left first: there stands the cell that touches only at this corner.
            let next = [1, 0, 3]
                .map(|turn| (way + turn) % 4)
                .into_iter()
                .find(|&next| self.ways[at] & (1 << next) != 0 || (at == start && next == first))?;
            if at == start && next == first {
                // If the ring does not turn at its beginning, that corner lies within a straight
                // piece.
                if next == way {
                    ring.remove(0);
                }
                return Some(ring);
            }
            if next != way {
                ring.push(self.corner(at));
            }
            way = next;
        }
    }

    fn corner(&self, at: usize) -> Point2<f64> {
        Point2::new((at % self.columns) as f64, (at / self.columns) as f64)
    }
}

/// The midpoints of the sides of cells along a ring.
fn middles(ring: &[Point2<f64>]) -> Vec<Point2<f64>> {
    let sides = sides_of(ring).flat_map(|(a, b)| {
        let along = b - a;
        let count = along.amax().round() as usize;
        (0..count).map(move |i| a + along * ((i as f64 + 0.5) / count as f64))
    });
    sides.collect()
}

/// The corners of a ring that are needed.
fn simplified(corners: &[Point2<f64>], tolerance: f64) -> Vec<Point2<f64>> {
    if tolerance <= 0.0 {
        return corners.to_vec();
    }
    let ring = middles(corners);
    let kept = needed(&ring, tolerance);
    kept.into_iter().map(|i| ring[i]).collect()
}

/// Which points of a ring are needed, in ring order from one of them on.
pub(super) fn needed(ring: &[Point2<f64>], tolerance: f64) -> Vec<usize> {
    let count = ring.len();
    let farthest_from = |from: Point2<f64>| {
        let off = |i: usize| (ring[i] - from).norm_squared();
        (0..count).max_by(|&a, &b| off(a).total_cmp(&off(b)))
    };
    let sum: nalgebra::Vector2<f64> = ring.iter().map(|p| p.coords).sum();
    let Some(first) = farthest_from(Point2::from(sum / count.max(1) as f64)) else {
        return vec![];
    };
    let at = |i: usize| ring[(first + i) % count];
    let second = farthest_from(at(0)).unwrap_or(first);
    let far = (second + count - first) % count;
    let mut kept = vec![false; count];
    let mut pieces = vec![(0, far), (far, count)];
    while let Some((from, to)) = pieces.pop() {
        if to <= from {
            continue;
        }
        kept[from] = true;
        let (a, b) = (at(from), at(to));
        let chord = crate::geom::Segment::new(a, b);
        let farthest = (from + 1..to)
            .map(|i| (chord.distance(at(i)), i))
            .max_by(|a, b| a.0.total_cmp(&b.0));
        if let Some((_, middle)) = farthest.filter(|(off, _)| *off > tolerance) {
            pieces.push((from, middle));
            pieces.push((middle, to));
        }
    }
    let kept = (0..count).filter(|&i| kept[i]);
    kept.map(|i| (first + i) % count).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::Length;
    use crate::geom::sides_of;
    use proptest::prelude::*;

    fn area(polygon: &[Point2<f64>]) -> f64 {
        0.5 * sides_of(polygon)
            .map(|(a, b)| a.coords.perp(&b.coords))
            .sum::<f64>()
    }

    fn picture(rows: &[&str]) -> (usize, Vec<bool>) {
        let cells = rows
            .iter()
            .rev()
            .flat_map(|row| row.bytes().map(|b| b == b'#'));
        (rows[0].len(), cells.collect())
    }

    #[test]
    fn a_room_has_an_outer_and_an_inner_outline() {
        let (width, cells) = picture(&["#####", "#...#", "#...#", "#####"]);
        let found = outlines(width, &cells, 0.0);
        assert_eq!(found.len(), 2);
        // Free on the left: clockwise around obstacles, counter-clockwise around free space.
        assert_eq!(
            found.iter().map(|p| area(p)).collect::<Vec<_>>(),
            [-20.0, 6.0]
        );
        assert!(found.iter().all(|polygon| polygon.len() == 4));
    }

    #[test]
    fn cells_that_touch_at_a_corner_are_one_wall() {
        let (width, cells) = picture(&["..#", ".#.", "#.."]);
        let found = outlines(width, &cells, 0.0);
        assert_eq!(found.len(), 1);
        assert!((area(&found[0]) + 3.0).abs() < 1e-12);
    }

    #[test]
    fn a_wall_of_one_cell_becomes_the_line_in_its_middle() {
        let found = outlines(
            30,
            &[vec![false; 30], vec![true; 30], vec![false; 30]].concat(),
            1.0,
        );
        let mut ends = found[0].clone();
        ends.sort_by(|a, b| a.x.total_cmp(&b.x));
        assert_eq!(
            (found.len(), ends),
            (1, vec![Point2::new(0.0, 1.5), Point2::new(30.0, 1.5)])
        );
    }

    #[test]
    fn an_askew_wall_becomes_straight() {
        let width = 200;
        let cells: Vec<bool> = (0..200 * 100).map(|i| (i % 200) / 2 == i / 200).collect();
        let found = outlines(width, &cells, 1.0);
        assert_eq!(found.len(), 1);
        assert!(found[0].len() <= 4, "{:?}", found[0]);
    }

    proptest! {
        /// Independent of how edges are followed: every border between an occupied and another cell
        /// is passed once, and the areas add up.
        #[test]
        fn without_tolerance_nothing_is_lost(width in 1_usize..12, cells in proptest::collection::vec(any::<bool>(), 1..120)) {
            let cells = &cells[..(cells.len() / width) * width];
            let found = outlines(width, cells, 0.0);
            let count = cells.iter().filter(|c| **c).count() as f64;
            prop_assert!((found.iter().map(|p| area(p)).sum::<f64>() + count).abs() < 1e-9);
            let at = |c: i64, r: i64| c >= 0 && r >= 0 && c < width as i64 && cells.get(r as usize * width + c as usize) == Some(&true);
            let mut borders = 0;
            for r in -1..=(cells.len() / width) as i64 {
                for c in -1..=width as i64 {
                    borders += i32::from(at(c, r) != at(c + 1, r)) + i32::from(at(c, r) != at(c, r + 1));
                }
            }
            let length: f64 = found.iter().map(|p| sides_of(p).map(|(a, b)| (b - a).length()).sum::<f64>()).sum();
            prop_assert!((length - f64::from(borders)).abs() < 1e-9);
        }

        #[test]
        fn no_corner_is_farther_off_than_allowed(width in 2_usize..14, cells in proptest::collection::vec(any::<bool>(), 4..140), tolerance in 0.3..2.0_f64) {
            let cells = &cells[..(cells.len() / width) * width];
            let kept = outlines(width, cells, tolerance);
            let segments: Vec<_> = kept.iter().flat_map(|p| sides_of(p).map(|(a, b)| crate::geom::Segment::new(*a, *b))).collect();
            for corner in outlines(width, cells, 0.0).iter().filter(|p| area(p).abs() > 40.0).flatten() {
                let off = segments.iter().map(|s| s.distance(*corner)).fold(f64::INFINITY, f64::min);
                // Half a side from a corner to the next middle.
                prop_assert!(off <= tolerance + 0.5 + 1e-9, "{corner}");
            }
        }
    }
}
