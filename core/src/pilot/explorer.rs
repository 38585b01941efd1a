//! Memory of an exploration: which frontier is looked at, and which were given up.

use nalgebra::Point2;

use crate::map::{CellIndex, CellState, Grid};
use crate::plan::Frontier;

/// Frontiers nearer than this to one another are the same place, m.
const SAME_PLACE: f64 = 0.4;
/// A target has vanished when less than this part of its cells is still a frontier.
const STILL_THERE: f64 = 0.25;

/// Chooses frontiers and remembers how that went.
#[derive(Clone, Debug, Default)]
pub(super) struct Explorer {
    /// All frontiers at the last look, best first.
    pub(super) frontiers: Vec<Frontier>,
    /// The one that is being looked at.
    pub(super) target: Option<Frontier>,
    given_up: Vec<Frontier>,
    visits: Vec<(Point2<f64>, usize)>,
}

impl Explorer {
    /// Takes what was found, and picks the best frontier that was not given up.
    pub(super) fn choose(
        &mut self,
        found: Vec<Frontier>,
        most_visits: usize,
    ) -> Option<Point2<f64>> {
        self.frontiers = found;
        self.target = None;
        for candidate in self.frontiers.clone() {
            let Some(goal) = candidate.goal.filter(|_| !self.is_given_up(&candidate)) else {
                continue;
            };
            if self.count_visit(candidate.centre) > most_visits {
                self.given_up.push(candidate);
                continue;
            }
            self.target = Some(candidate);
            return Some(goal);
        }
        None
    }

    /// The target cannot be reached, or did not vanish when looked at.
    pub(super) fn give_up(&mut self) {
        self.given_up.extend(self.target.take());
    }

    /// Whether the target is no frontier any more.
    pub(super) fn target_has_vanished(&self, grid: &Grid) -> bool {
        let Some(target) = &self.target else {
            return true;
        };
        let left = target.cells.iter().filter(|&&c| is_frontier(grid, c));
        (left.count() as f64) < STILL_THERE * target.cells.len() as f64
    }

    /// What is unknown and stays so.
    pub(super) fn unreached(&self) -> Vec<Point2<f64>> {
        self.frontiers.iter().map(|f| f.centre).collect()
    }

    /// One that grew is worth another look.
    fn is_given_up(&self, frontier: &Frontier) -> bool {
        self.given_up.iter().any(|old| {
            (old.centre - frontier.centre).norm() < SAME_PLACE && frontier.gain < 1.5 * old.gain
        })
    }

    fn count_visit(&mut self, place: Point2<f64>) -> usize {
        let known = self
            .visits
            .iter_mut()
            .find(|(at, _)| (at - place).norm() < SAME_PLACE);
        if let Some((_, count)) = known {
            *count += 1;
            return *count;
        }
        self.visits.push((place, 1));
        1
    }
}

fn is_frontier(grid: &Grid, cell: CellIndex) -> bool {
    let unknown = |dc: i32, dr: i32| {
        let neighbour = CellIndex {
            col: cell.col + dc,
            row: cell.row + dr,
        };
        grid.state(neighbour) == CellState::Unknown
    };
    grid.state(cell) == CellState::Free
        && (unknown(1, 0) || unknown(-1, 0) || unknown(0, 1) || unknown(0, -1))
}
