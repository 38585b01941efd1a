//! The global optimum of a pose within a window: branch and bound over (x, y, θ).
//!
//! In: points, a [`LikelihoodPyramid`] of a map, a window. Out: the pose with the highest mean
//! likelihood, to within a cell and a turn that moves the farthest point by a cell.
//!
//! 1. For each turn the points are rotated once and rounded to cells.
//! 2. Squares of shifts are scored at the coarsest level, where the sum bounds all shifts inside
//!    from above.
//! 3. The most promising square is cut in four, and so on down to single cells; squares that cannot
//!    beat the best pose found so far are skipped.
//!
//! Source: Hess et al. (2016), "Real-time loop closure in 2D LIDAR SLAM", algorithm 3.

use nalgebra::Point2;

use crate::geom::{Length, Pose2};
use crate::map::LikelihoodPyramid;

/// Where to search.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SearchWindow {
    /// How far to either side of the start, m.
    pub shift: f64,
    /// How far to turn to either side, rad.
    pub turn: f64,
}

/// What was found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Candidate {
    /// `map_from_points`.
    pub pose: Pose2,
    /// Mean likelihood of the points, 0 to 1.
    pub score: f64,
}

/// Most turns of the points to either side in one search.
const MAX_TURNS: i32 = 720;

/// The best pose of `points` around `start` whose score is above `min_score`; `None` if there is
/// none.
#[must_use]
pub fn search(
    points: &[Point2<f64>],
    map: &LikelihoodPyramid,
    start: &Pose2,
    window: &SearchWindow,
    min_score: f64,
) -> Option<Candidate> {
    search_turned(points, map, start, window, min_score, |_| true)
}

/// The same, only among the turns from `start`, rad, that `admits` accepts.
#[must_use]
pub fn search_turned(
    points: &[Point2<f64>],
    map: &LikelihoodPyramid,
    start: &Pose2,
    window: &SearchWindow,
    min_score: f64,
    admits: impl Fn(f64) -> bool,
) -> Option<Candidate> {
    if points.is_empty() || !start.is_finite() {
        return None;
    }
    let cell = map.cell();
    let farthest = points
        .iter()
        .map(|p| p.coords.length())
        .fold(cell, f64::max);
    // The turn that moves the farthest point by one cell; the arc cosine of Hess et al. agrees to 1
    // %. It is wider if that would make too many turns: a coarse search of the whole window finds
    // what a fine search of its middle misses.
    let step = (cell / farthest).max(window.turn / f64::from(MAX_TURNS));
    let turns = ((window.turn / step).ceil() as i32).clamp(0, MAX_TURNS);
    let reach = (window.shift / cell).ceil().clamp(0.0, 1e4) as i32;
    let rotated: Vec<(Pose2, Vec<(i32, i32)>)> = (-turns..=turns)
        .filter(|&k| admits(f64::from(k) * step))
        .map(|k| {
            let pose = Pose2::new(start.x(), start.y(), start.heading() + f64::from(k) * step);
            let cells = points.iter().map(|&p| map.cell_of(pose * p)).collect();
            (pose, cells)
        })
        .collect();
    let top = map.levels() - 1;
    let side = 1_i32 << top;
    let mut best = Best {
        bound: (min_score * 255.0 * points.len() as f64) as u32,
        found: None,
    };
    let mut squares = vec![];
    for (turn, (_, cells)) in rotated.iter().enumerate() {
        let mut col = -reach;
        while col <= reach {
            let mut row = -reach;
            while row <= reach {
                let bound = map.sum_above(top, cells, (col, row), best.bound);
                if bound > best.bound {
                    squares.push(Square {
                        bound,
                        turn,
                        col,
                        row,
                    });
                }
                row += side;
            }
            col += side;
        }
    }
    sort(&mut squares);
    branch(map, &rotated, top, &squares, reach, &mut best);
    let found = best.found?;
    let (pose, _) = rotated.get(found.turn)?;
    Some(Candidate {
        pose: Pose2::new(
            pose.x() + f64::from(found.col) * cell,
            pose.y() + f64::from(found.row) * cell,
            pose.heading(),
        ),
        score: f64::from(found.bound) / (255.0 * points.len() as f64),
    })
}

/// Shifts from (`col`, `row`) on, as many as the level says, for one turn.
#[derive(Clone, Copy)]
struct Square {
    bound: u32,
    turn: usize,
    col: i32,
    row: i32,
}

struct Best {
    bound: u32,
    found: Option<Square>,
}

/// The most promising first; ties in a fixed order.
fn sort(squares: &mut [Square]) {
    squares.sort_by_key(|s| (std::cmp::Reverse(s.bound), s.turn, s.col, s.row));
}

fn branch(
    map: &LikelihoodPyramid,
    rotated: &[(Pose2, Vec<(i32, i32)>)],
    level: usize,
    squares: &[Square],
    reach: i32,
    best: &mut Best,
) {
    for square in squares {
        if square.bound <= best.bound {
            return;
        }
        if level == 0 {
            *best = Best {
                bound: square.bound,
                found: Some(*square),
            };
            continue;
        }
        let (_, cells) = &rotated[square.turn];
        let half = 1_i32 << (level - 1);
        let mut parts = Vec::with_capacity(4);
        for (col, row) in [(0, 0), (half, 0), (0, half), (half, half)] {
            let (col, row) = (square.col + col, square.row + row);
            if col <= reach && row <= reach {
                let bound = map.sum_above(level - 1, cells, (col, row), best.bound);
                if bound > best.bound {
                    parts.push(Square {
                        bound,
                        turn: square.turn,
                        col,
                        row,
                    });
                }
            }
        }
        sort(&mut parts);
        branch(map, rotated, level - 1, &parts, reach, best);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::wrap;
    use proptest::prelude::*;

    fn room() -> Vec<Point2<f64>> {
        let mut points = vec![];
        for i in 0..60 {
            let s = f64::from(i) * 0.1;
            points.push(Point2::new(s - 3.0, -2.0));
            points.push(Point2::new(-3.0, s * 0.66 - 2.0));
            if i < 25 {
                points.push(Point2::new(s - 3.0, 1.96));
            }
            if i < 15 {
                points.push(Point2::new(1.0, s - 2.0));
            }
        }
        points
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 24, ..ProptestConfig::default() })]
        #[test]
        fn finds_the_true_pose_from_far_away(
            x in -2.0..2.0_f64, y in -2.0..2.0_f64, turn in -0.6..0.6_f64, h in -3.0..3.0_f64,
        ) {
            let map = LikelihoodPyramid::new(room().into_iter(), 0.1, 0.1, 6).unwrap();
            let truth = Pose2::new(0.3, -0.4, h);
            let seen: Vec<_> = room().iter().map(|&p| truth.inverse() * p).collect();
            let start = Pose2::new(truth.x() + x, truth.y() + y, h + turn);
            let window = SearchWindow { shift: 2.2, turn: 0.65 };
            let found = search(&seen, &map, &start, &window, 0.3).unwrap();
            prop_assert!((found.pose.position() - truth.position()).length() < 0.15);
            prop_assert!(wrap(found.pose.heading() - h).abs() < 0.04);
        }

        #[test]
        fn nothing_in_the_window_beats_what_was_found(x in -0.5..0.5_f64, y in -0.5..0.5_f64) {
            let map = LikelihoodPyramid::new(room().into_iter(), 0.1, 0.1, 4).unwrap();
            let start = Pose2::new(x, y, 0.0);
            let points = room();
            let window = SearchWindow { shift: 0.7, turn: 0.0 };
            let found = search(&points, &map, &start, &window, 0.0).unwrap();
            let cells: Vec<_> = points.iter().map(|&p| map.cell_of(start * p)).collect();
            let mut brute = 0;
            for col in -7..=7 { for row in -7..=7 { brute = brute.max(map.sum(0, &cells, (col, row))); } }
            prop_assert!((found.score * 255.0 * points.len() as f64 - f64::from(brute)).abs() < 1e-6);
        }
    }

    #[test]
    fn the_whole_window_is_searched_however_far_a_point_lies() {
        let map = LikelihoodPyramid::new(room().into_iter(), 0.1, 0.1, 5).unwrap();
        let mut points = room();
        points.push(Point2::new(500.0, 0.0));
        let window = SearchWindow {
            shift: 0.1,
            turn: 0.6,
        };
        let start = Pose2::new(0.0, 0.0, 0.55);
        let found = search(&points, &map, &start, &window, 0.3).unwrap();
        assert!(found.pose.heading().abs() < 0.03, "{found:?}");
    }

    #[test]
    fn no_fit_is_no_answer() {
        let map = LikelihoodPyramid::new(room().into_iter(), 0.1, 0.1, 5).unwrap();
        let far: Vec<_> = (0..50)
            .map(|i| Point2::new(f64::from(i) * 3.7, 100.0))
            .collect();
        let window = SearchWindow {
            shift: 1.0,
            turn: 0.1,
        };
        assert!(search(&far, &map, &Pose2::identity(), &window, 0.5).is_none());
        assert!(search(&[], &map, &Pose2::identity(), &window, 0.5).is_none());
    }
}
