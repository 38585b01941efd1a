//! Floods over squares of a space that has no cells of its own.
//!
//! In: a configuration space, one or two places. Out: the proof that no path joins them, or the
//! squares that one of them reaches.
//!
//! 1. A square is open if any part of it may be free. The room changes by no more than the distance
//!    moved, so within a square by half a diagonal at most.
//! 2. Squares that touch, even at a corner, are connected if both are open.
//! 3. The floods from two places take turns: if either of them has nowhere to go before they meet,
//!    no path joins the places, and a place that is walled in is soon found out.

use std::collections::VecDeque;

use nalgebra::{Point2, Vector2};

use super::cspace::ConfigSpace;
use crate::map::cells_around;

/// Most squares; beyond that they become larger, and prove less.
const MOST_SQUARES: f64 = 1.6e7;

/// Whether floods over squares of the given side prove that no path joins two places. `false`
/// proves nothing: gaps that are too narrow by less than two squares may count as open.
pub(super) fn floods_apart(
    space: &dyn ConfigSpace,
    a: Point2<f64>,
    b: Point2<f64>,
    side: f64,
) -> bool {
    let mut squares = Squares::new(space, side);
    let mut floods = [squares.flood_from(a, A), squares.flood_from(b, B)];
    if squares.square_at(a) == squares.square_at(b) {
        return false;
    }
    loop {
        for flood in &mut floods {
            match squares.spread(space, flood) {
                Spread::Goes => {}
                Spread::Met => return false,
                Spread::Over => return true,
            }
        }
    }
}

/// The centres of the squares that such a flood from a place reaches, and their side, m: nothing
/// outside them can be reached. At most `most` squares are laid over the bounds.
pub(super) fn squares_within_reach(
    space: &dyn ConfigSpace,
    from: Point2<f64>,
    most: f64,
) -> (Vec<Point2<f64>>, f64) {
    let (low, high) = space.bounds();
    let extent = high - low;
    let mut squares = Squares::new(space, (extent.x * extent.y / most).sqrt());
    let mut flood = squares.flood_from(from, A);
    while squares.spread(space, &mut flood) == Spread::Goes {}
    let reached = (0..squares.seen.len()).filter(|&square| squares.seen[square] == A);
    let middles = reached.map(|square| squares.middle(square)).collect();
    (middles, squares.side)
}

/// Marks of squares: seen by one flood, by the other, or by neither.
const A: u8 = 1;
const B: u8 = 2;
const UNSEEN: u8 = 0;

/// Squares from which a flood has still to spread.
struct Flood {
    mark: u8,
    todo: VecDeque<usize>,
}

/// The result of spreading from one square.
#[derive(PartialEq)]
enum Spread {
    Goes,
    Met,
    Over,
}

/// Squares over the bounds of a space.
struct Squares {
    low: Point2<f64>,
    high: Point2<f64>,
    side: f64,
    cols: usize,
    rows: usize,
    seen: Vec<u8>,
}

impl Squares {
    fn new(space: &dyn ConfigSpace, side: f64) -> Self {
        let (low, high) = space.bounds();
        let extent = high - low;
        let side = side.max((extent.x * extent.y / MOST_SQUARES).sqrt());
        let count = |length: f64| (length / side).ceil().max(1.0) as usize;
        let (cols, rows) = (count(extent.x), count(extent.y));
        Self {
            low,
            high,
            side,
            cols,
            rows,
            seen: vec![UNSEEN; cols * rows],
        }
    }

    fn square_at(&self, point: Point2<f64>) -> usize {
        let at = (point - self.low) / self.side;
        let place = |at: f64, count: usize| (at.max(0.0) as usize).min(count - 1);
        place(at.y, self.rows) * self.cols + place(at.x, self.cols)
    }

    /// Centre of a square. Only the last square of a row may stick out; its centre is then moved to
    /// the border.
    fn middle(&self, square: usize) -> Point2<f64> {
        let at = |place: usize| (place as f64 + 0.5) * self.side;
        let middle = self.low + Vector2::new(at(square % self.cols), at(square / self.cols));
        middle.inf(&self.high)
    }

    fn flood_from(&mut self, place: Point2<f64>, mark: u8) -> Flood {
        let square = self.square_at(place);
        self.seen[square] = mark;
        Flood {
            mark,
            todo: VecDeque::from([square]),
        }
    }

    /// Spreads to the neighbours of the next square.
    fn spread(&mut self, space: &dyn ConfigSpace, flood: &mut Flood) -> Spread {
        let Some(at) = flood.todo.pop_front() else {
            return Spread::Over;
        };
        for next in cells_around(at, 1, self.cols, self.rows) {
            if self.seen[next] == UNSEEN {
                if space.room(self.middle(next)) + self.side >= 0.0 {
                    self.seen[next] = flood.mark;
                    flood.todo.push_back(next);
                }
            } else if self.seen[next] != flood.mark {
                return Spread::Met;
            }
        }
        Spread::Goes
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::Segment;
    use crate::plan::SegmentSpace;

    /// A hall of 20 x 20 m with a box of 1 x 1 m whose eastern wall has a gap.
    fn boxed(gap: f64) -> SegmentSpace {
        let at = |x: f64, y: f64| Point2::new(x, y);
        let corners = [at(5.0, 5.0), at(6.0, 5.0), at(6.0, 6.0), at(5.0, 6.0)];
        let mut walls: Vec<_> = [(0, 1), (2, 3), (3, 0)]
            .map(|(a, b)| Segment::new(corners[a], corners[b]))
            .into();
        walls.push(Segment::new(at(6.0, 5.0), at(6.0, 5.5 - 0.5 * gap)));
        walls.push(Segment::new(at(6.0, 5.5 + 0.5 * gap), at(6.0, 6.0)));
        SegmentSpace::new(walls, 0.1, (at(0.0, 0.0), at(20.0, 20.0))).unwrap()
    }

    #[test]
    fn a_box_is_shut_from_either_side_unless_its_gap_is_wide_enough() {
        let (inside, outside) = (Point2::new(5.5, 5.5), Point2::new(18.0, 3.0));
        for (gap, side, is_apart) in [
            (0.0, 0.05, true),
            (0.1, 0.02, true),
            (0.21, 0.05, false),
            // Too narrow by less than two squares: nothing is proved.
            (0.19, 0.05, false),
        ] {
            let space = boxed(gap);
            assert_eq!(
                floods_apart(&space, inside, outside, side),
                is_apart,
                "{gap} {side}"
            );
            assert_eq!(
                floods_apart(&space, outside, inside, side),
                is_apart,
                "{gap} {side}"
            );
        }
        assert!(!floods_apart(
            &boxed(0.0),
            outside,
            Point2::new(1.0, 19.0),
            0.05
        ));
        assert!(!floods_apart(&boxed(0.0), inside, inside, 0.05));
    }

    #[test]
    fn what_is_reached_from_inside_of_a_box_is_its_floor() {
        let space = boxed(0.0);
        let (middles, side) = squares_within_reach(&space, Point2::new(5.5, 5.5), 160_000.0);
        assert!((side - 0.05).abs() < 1e-12);
        // 0.8 x 0.8 m of room, and one more square on each side.
        let area = middles.len() as f64 * side * side;
        assert!((0.64..0.95 * 0.95).contains(&area), "{area}");
        assert!(
            middles
                .iter()
                .all(|m| (5.0..6.0).contains(&m.x) && (5.0..6.0).contains(&m.y))
        );
    }
}
