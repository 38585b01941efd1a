//! Whether any path may lead from one place to another, or the proof that none can.
//!
//! In: a [`GridSpace`], start and goal, both free. Out: `false` if there is no path, which is a
//! proof; `true` if there may be one.
//!
//! Between the centres of four neighbouring cells the room is bilinear. So the places with room are
//! connected exactly as these centres are, without sampling between them:
//!
//! 1. From centre to centre along a row or a column the room is linear: two neighbours with room
//!    are joined.
//! 2. Two centres with room across a square, the two others without, are joined if there is room at
//!    the saddle between them: if a d ≥ b c.
//! 3. From any place a way on which the room never shrinks leads to one of the four surrounding
//!    centres: along the row to the side with more room, then along that side to its better end.
//!
//! A tree may nevertheless slip through where [`super::ConfigSpace::free_length`] steps over a spot
//! that is millimetres too narrow.
//!
//! If the robot keeps out of unknown cells as well, the room is the lesser of two such fields and
//! the rules do not hold. Then all cells are flooded of which any part may be free, which proves
//! less.
//!
//! Source: Nielson & Hamann (1991), "The asymptotic decider: resolving the ambiguity in marching
//! cubes", for the saddle.

use nalgebra::Point2;

use super::cspace::GridSpace;
use crate::map::cells_around;

/// Whether a continuous path from `start` to `goal`, both free, may exist. `false` is a proof.
pub(super) fn may_reach(space: &GridSpace, start: Point2<f64>, goal: Point2<f64>) -> bool {
    let (Some(at_start), Some(at_goal)) = (space.index_at(start), space.index_at(goal)) else {
        return false;
    };
    if space.has_barred_cells() {
        // The room changes by at most √2 per metre, and no point is farther than √½ cells from its
        // cell's centre.
        let flood = Flood::new(space, space.resolution());
        return flood.joins(at_start, at_goal, |_| true);
    }
    let flood = Flood::new(space, 0.0);
    let (from, to) = (flood.best_centre(start), flood.best_centre(goal));
    flood.joins(from, to, |[a, b, c, d]| a * d >= b * c)
}

/// The cells of a space; those with enough room are open.
struct Flood<'a> {
    space: &'a GridSpace,
    width: usize,
    height: usize,
    /// Lack of room up to which a cell still counts as open, m.
    slack: f64,
}

impl<'a> Flood<'a> {
    fn new(space: &'a GridSpace, slack: f64) -> Self {
        Self {
            space,
            width: space.rect().width(),
            height: space.rect().height(),
            slack,
        }
    }

    fn room(&self, cell: usize) -> f64 {
        self.space.room_of(cell) + self.slack
    }

    /// Whether the flood from one cell arrives at another. Two open cells diagonal in a square
    /// whose other two cells are closed are neighbours if `crosses` says so of the room at a, b, c,
    /// d; the open ones are a and d.
    fn joins(&self, from: usize, to: usize, crosses: impl Fn([f64; 4]) -> bool) -> bool {
        let mut seen = vec![false; self.width * self.height];
        let mut todo = vec![from];
        seen[from] = true;
        while let Some(at) = todo.pop() {
            if at == to {
                return true;
            }
            let (col, row) = (at % self.width, at / self.width);
            for next in cells_around(at, 1, self.width, self.height) {
                if seen[next] || self.room(next) < 0.0 {
                    continue;
                }
                let (c, r) = (next % self.width, next / self.width);
                let beside = [row * self.width + c, r * self.width + col];
                let [one, other] = beside.map(|cell| self.room(cell));
                let is_across = r != row && c != col && one < 0.0 && other < 0.0;
                if !is_across || crosses([self.room(at), one, other, self.room(next)]) {
                    seen[next] = true;
                    todo.push(next);
                }
            }
        }
        false
    }

    /// Rule 3: the centre to which a way with non-decreasing room leads.
    fn best_centre(&self, point: Point2<f64>) -> usize {
        let rect = self.space.rect();
        let place = |at: f64, low: i32, count: usize| {
            let at = at / self.space.resolution() - 0.5 - f64::from(low);
            let last = count.saturating_sub(1) as f64;
            let below = at.floor().clamp(0.0, last);
            let above = (below + 1.0).min(last);
            (below as usize, above as usize, (at - below).clamp(0.0, 1.0))
        };
        let (left, right, _) = place(point.x, rect.min.col, self.width);
        let (low, high, part) = place(point.y, rect.min.row, self.height);
        let ends = |col: usize| [low, high].map(|row| row * self.width + col);
        let beside = |col: usize| {
            let [below, above] = ends(col).map(|cell| self.room(cell));
            // Without walls the room is infinite everywhere, and any centre will do.
            (1.0 - part) * below + part * above
        };
        let [below, above] = ends(if beside(right) > beside(left) {
            right
        } else {
            left
        });
        if self.room(above) > self.room(below) {
            above
        } else {
            below
        }
    }
}
