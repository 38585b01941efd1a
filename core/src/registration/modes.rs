//! All places of a map where points fit, the best first: branch and bound that continues after the
//! best.
//!
//! In: points, a [`LikelihoodPyramid`] of a map. Out: poses anywhere in it, at any heading, each
//! the best of its surroundings, and how well any other pose could fit. A room that exists twice
//! gives two.
//!
//! 1. Squares of shifts are laid over the whole map for each turn, and scored at the coarsest
//!    level, where the sum bounds all shifts inside from above.
//! 2. The square with the greatest bound of all is taken and cut in four, whichever turn it belongs
//!    to, so single cells come out in falling order of their score (best first, whereas
//!    [`super::search`] goes depth first).
//! 3. A cell that comes out is a mode, unless it lies in the surroundings of an earlier one;
//!    squares wholly within such surroundings are not cut any further.
//!
//! Source: Hess et al. (2016), "Real-time loop closure in 2D LIDAR SLAM", section V-B, for bounds;
//! the order is that of A* with the bound as its estimate.

use std::collections::BinaryHeap;
use std::f64::consts::TAU;

use nalgebra::Point2;

use super::Candidate;
use crate::bounds::config;
use crate::geom::{Length, Pose2, wrap};
use crate::map::LikelihoodPyramid;

config! {
    /// Which modes are searched for.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct ModesConfig {
        /// Most modes. Default 32; larger: fewer places are missed where many look alike, and more
        /// work.
        pub most: usize = 32,
        /// Least mean likelihood of a mode, 0 to 1. Default 0.25; larger: fewer false ones, less
        /// work.
        pub min_score: f64 = 0.25,
        /// Least score of a mode as a part of the best one's. Default 0.6; larger: as above.
        pub part_of_best: f64 = 0.6,
        /// Nearer than this, m, two poses are one mode if they also face the same way. Default 0.6.
        pub apart: f64 = 0.6,
        /// Nearer than this, rad, they face the same way. Default 0.35.
        pub apart_turn: f64 = 0.35,
        /// Points beyond this, m, do not make the turns any finer. Default 10; larger is slower.
        pub farthest: f64 = 10.0,
        /// Most squares that are scored; what is best so far then stands. Default 2 000 000;
        /// larger: buildings of hundreds of metres are searched whole, and more slowly.
        pub most_squares: usize = 2_000_000,
    }
}

/// Shifts from (`col`, `row`) on, as many as the level says, for one turn. Ordered by the bound;
/// ties in a fixed order, single cells first.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Square {
    bound: u32,
    fineness: usize,
    turn: usize,
    col: i32,
    row: i32,
}

/// What was found, and what may have been missed.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Modes {
    /// The modes, the best first.
    pub found: Vec<Candidate>,
    /// Nothing outside the surroundings of the modes found scores more than this. After a complete
    /// search it is far below their scores; after one that was cut off, near them or above.
    pub left: f64,
}

/// The modes of `points` anywhere in `map`.
#[must_use]
pub fn modes(points: &[Point2<f64>], map: &LikelihoodPyramid, config: &ModesConfig) -> Modes {
    if points.is_empty() {
        return Modes::default();
    }
    let search = Search::new(points, map, config);
    let mut waiting = search.coarsest();
    let mut scored = waiting.len();
    let mut found: Vec<Candidate> = vec![];
    let mut least = config.min_score;
    let left = loop {
        let Some(square) = waiting.pop() else {
            break least;
        };
        let bound = search.score(square.bound);
        if bound < least || found.len() == config.most {
            break bound.max(least);
        }
        let level = search.top - square.fineness;
        if search.is_taken(&square, level, &found) {
            continue;
        }
        if level == 0 {
            let (pose, score) = (search.pose(&square), search.score(square.bound));
            least = least.max(score * config.part_of_best);
            found.push(Candidate { pose, score });
            continue;
        }
        if scored > config.most_squares {
            break bound;
        }
        scored += 4;
        let half = 1_i32 << (level - 1);
        for (col, row) in [(0, 0), (half, 0), (0, half), (half, half)] {
            let (col, row) = (square.col + col, square.row + row);
            let part = search.square(square.turn, level - 1, col, row);
            if search.score(part.bound) >= least {
                waiting.push(part);
            }
        }
    };
    Modes { found, left }
}

struct Search<'a> {
    map: &'a LikelihoodPyramid,
    config: &'a ModesConfig,
    top: usize,
    /// For each turn, the heading and the cells of the points around the map's first cell.
    turns: Vec<(f64, Vec<(i32, i32)>)>,
    full: f64,
}

impl<'a> Search<'a> {
    fn new(points: &[Point2<f64>], map: &'a LikelihoodPyramid, config: &'a ModesConfig) -> Self {
        let farthest = points.iter().map(|p| p.coords.length());
        let farthest = farthest.fold(map.cell(), f64::max).min(config.farthest);
        let count = (TAU * farthest / map.cell()).ceil().max(8.0);
        let middle = map.middle_of((0, 0));
        let turn = |k: usize| {
            let heading = wrap(TAU * k as f64 / count);
            let pose = Pose2::new(middle.x, middle.y, heading);
            let cells = points.iter().map(|&p| map.cell_of(pose * p)).collect();
            (heading, cells)
        };
        Self {
            map,
            config,
            top: map.levels() - 1,
            turns: (0..count as usize).map(turn).collect(),
            full: 255.0 * points.len() as f64,
        }
    }

    fn coarsest(&self) -> BinaryHeap<Square> {
        let (cols, rows) = self.map.size();
        let side = 1_usize << self.top;
        let mut squares = vec![];
        for turn in 0..self.turns.len() {
            for row in (0..rows).step_by(side) {
                for col in (0..cols).step_by(side) {
                    squares.push(self.square(turn, self.top, col, row));
                }
            }
        }
        squares.retain(|square| self.score(square.bound) >= self.config.min_score);
        squares.into()
    }

    fn square(&self, turn: usize, level: usize, col: i32, row: i32) -> Square {
        Square {
            bound: self.map.sum(level, &self.turns[turn].1, (col, row)),
            fineness: self.top - level,
            turn,
            col,
            row,
        }
    }

    fn score(&self, bound: u32) -> f64 {
        f64::from(bound) / self.full
    }

    /// Of the square's first cell.
    fn pose(&self, square: &Square) -> Pose2 {
        let at = self.map.middle_of((square.col, square.row));
        Pose2::new(at.x, at.y, self.turns[square.turn].0)
    }

    /// Whether a square lies wholly in the surroundings of a mode that was found.
    fn is_taken(&self, square: &Square, level: usize, found: &[Candidate]) -> bool {
        let at = self.pose(square);
        let reach = f64::from((1_i32 << level) - 1) * self.map.cell();
        found.iter().any(|mode| {
            let (dx, dy) = (mode.pose.x() - at.x(), mode.pose.y() - at.y());
            let (x, y) = (
                dx.abs().max((dx - reach).abs()),
                dy.abs().max((dy - reach).abs()),
            );
            x * x + y * y < self.config.apart * self.config.apart
                && wrap(mode.pose.heading() - at.heading()).abs() < self.config.apart_turn
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// A room of 4 x 3 m with a corner cut off, its lower left corner at `(x, y)`.
    fn room(x: f64, y: f64) -> Vec<Point2<f64>> {
        let corners = [[0.0, 0.0], [4.0, 0.0], [4.0, 2.0], [2.5, 3.0], [0.0, 3.0]];
        let mut points = vec![];
        for i in 0..corners.len() {
            let ([ax, ay], [bx, by]) = (corners[i], corners[(i + 1) % corners.len()]);
            for k in 0..40 {
                let t = f64::from(k) / 40.0;
                points.push(Point2::new(x + ax + t * (bx - ax), y + ay + t * (by - ay)));
            }
        }
        points
    }

    fn seen_from(pose: &Pose2) -> Vec<Point2<f64>> {
        room(0.0, 0.0).iter().map(|&p| pose.inverse() * p).collect()
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 12, ..ProptestConfig::default() })]
        #[test]
        fn a_room_that_there_is_twice_has_two_modes(
            x in 1.0..2.0_f64, y in 0.8..2.0_f64, h in -3.1..3.1_f64,
        ) {
            let places: Vec<_> = [room(0.0, 0.0), room(9.0, -3.0)].concat();
            let map = LikelihoodPyramid::new(places.into_iter(), 0.1, 0.1, 6).unwrap();
            let truth = Pose2::new(x, y, h);
            let found = modes(&seen_from(&truth), &map, &ModesConfig::default()).found;
            prop_assert!(found.len() >= 2);
            for there in [[0.0, 0.0], [9.0, -3.0]] {
                let near = found.iter().take(2).any(|mode| {
                    let off = [mode.pose.x() - x - there[0], mode.pose.y() - y - there[1]];
                    off[0].abs() < 0.15 && off[1].abs() < 0.15
                        && wrap(mode.pose.heading() - h).abs() < 0.06
                });
                prop_assert!(near, "{found:?}");
            }
            // Another place is clearly worse.
            prop_assert!(found.get(2).is_none_or(|third| third.score < 0.9 * found[1].score));
        }
    }

    #[test]
    fn all_poses_tried_one_by_one_score_no_more_than_what_is_said() {
        let map = LikelihoodPyramid::new(room(0.0, 0.0).into_iter(), 0.2, 0.2, 4).unwrap();
        let points = seen_from(&Pose2::new(1.3, 1.1, 0.7));
        let config = ModesConfig::default();
        let search = Search::new(&points, &map, &config);
        let (cols, rows) = map.size();
        // The best of all, and the best outside all surroundings.
        let best = |found: &[Candidate]| {
            let mut best = 0;
            for turn in 0..search.turns.len() {
                for row in 0..rows {
                    for col in 0..cols {
                        let square = search.square(turn, 0, col, row);
                        if !search.is_taken(&square, 0, found) {
                            best = best.max(square.bound);
                        }
                    }
                }
            }
            search.score(best)
        };
        let whole = modes(&points, &map, &config);
        let first = whole.found[0].score;
        assert!((first - best(&[])).abs() < 1e-12);
        assert!(best(&whole.found) <= whole.left);
        // Only what is too poor to be a mode remains undecided.
        let poorest = (config.part_of_best * first).max(config.min_score);
        assert!((whole.left - poorest).abs() < 1e-12);

        // A search that is cut off does not claim that there is nothing else.
        for most_squares in (0..2_000).step_by(100) {
            let cut = ModesConfig {
                most_squares,
                ..config
            };
            let cut = modes(&points, &map, &cut);
            assert!(best(&cut.found) <= cut.left, "{most_squares}");
            assert!(most_squares > 0 || cut.found.is_empty() && cut.left >= first);
        }
    }

    #[test]
    fn modes_come_in_order_and_keep_apart() {
        let map = LikelihoodPyramid::new(room(0.0, 0.0).into_iter(), 0.1, 0.1, 5).unwrap();
        // A single wall fits every wall, anywhere along it.
        let wall: Vec<_> = (0..30)
            .map(|i| Point2::new(0.05 * f64::from(i), 0.8))
            .collect();
        let config = ModesConfig::default();
        let found = modes(&wall, &map, &config).found;
        assert!(found.len() > 4, "{}", found.len());
        for (i, a) in found.iter().enumerate() {
            for b in found.iter().skip(i + 1) {
                assert!(a.score >= b.score);
                let apart = (a.pose.position() - b.pose.position()).length() >= config.apart - 1e-9;
                assert!(apart || wrap(a.pose.heading() - b.pose.heading()).abs() >= 0.34);
            }
        }
        assert!(modes(&[], &map, &config).found.is_empty());
    }
}
