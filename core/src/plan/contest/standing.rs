//! The standing of the planners of a contest.

use super::Contest;
use super::entrant::Entrant;
use crate::plan::path::{NoPath, Planner};
use crate::plan::rooms::NoRooms;
use crate::plan::search::Search;

/// The standing of one planner.
#[derive(Clone, Debug, PartialEq)]
pub struct Standing {
    /// The planner.
    pub planner: Planner,
    /// Whether it is done.
    pub is_over: bool,
    /// Whether the straight line is free: then no search was needed.
    pub is_straight: bool,
    /// Length of its best path, m; `None` while there is none.
    pub length: Option<f64>,
    /// The length in units of [`Contest::shortest`].
    pub ratio: Option<f64>,
    /// Why there is no path; `None` while it searches, and when it has a path.
    pub reason: Option<NoPath>,
    /// Why it did not keep to the rooms on the way; `None` if it did, and for planners that do not
    /// use rooms.
    pub fallback: Option<NoRooms>,
    /// Time taken, s.
    pub seconds: f64,
    /// Points drawn, cells expanded, or legs of the graph examined.
    pub iterations: usize,
    /// Edges of trees, steps over cells, or legs of the graph that were tried.
    pub tried: usize,
}

/// The length with which the others are compared.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shortest {
    /// The length, m.
    pub length: f64,
    /// Whether it is the visibility graph's, which is the shortest possible; otherwise it is the
    /// shortest found so far.
    pub is_optimum: bool,
}

impl Contest {
    /// The standing of all planners, in the order of [`Self::planners`].
    #[must_use]
    pub fn standings(&self) -> Vec<Standing> {
        let shortest = self.shortest();
        let stand = |entrant: &Entrant| {
            let length = entrant.curve.last().map(|last| last.1);
            let search = entrant.search.as_ref();
            Standing {
                planner: entrant.planner,
                is_over: entrant.is_over,
                is_straight: search.is_some_and(|s| s.planner() == Planner::Straight),
                length,
                ratio: length
                    .zip(shortest)
                    .map(|(length, shortest)| length / shortest.length.max(1e-9)),
                reason: self.reason(entrant),
                fallback: search.and_then(Search::fallback),
                seconds: entrant.seconds,
                iterations: search.map_or(0, Search::iterations),
                tried: search.map_or(0, Search::tried),
            }
        };
        self.entrants.iter().map(stand).collect()
    }

    /// The length with which the others are compared; `None` while no planner has a path.
    #[must_use]
    pub fn shortest(&self) -> Option<Shortest> {
        let length = |e: &Entrant| e.curve.last().map(|last| last.1);
        let graph = self.entrants.iter().filter(|_| self.outline.is_none());
        let mut graph = graph.filter(|e| e.planner == Planner::Visibility && e.is_over);
        if let Some(length) = graph.find_map(length) {
            return Some(Shortest {
                length,
                is_optimum: true,
            });
        }
        let lengths = self.entrants.iter().filter_map(length);
        lengths.min_by(f64::total_cmp).map(|length| Shortest {
            length,
            is_optimum: false,
        })
    }

    fn reason(&self, entrant: &Entrant) -> Option<NoPath> {
        if !entrant.is_over || !entrant.curve.is_empty() {
            return None;
        }
        let iterations = entrant.search.as_ref().map_or(0, Search::iterations);
        let own = entrant.failure().or(entrant.refused);
        match own {
            Some(
                NoPath::NotOffered { .. }
                | NoPath::StartBlocked { .. }
                | NoPath::GoalBlocked { .. },
            ) => own,
            _ if entrant.planner != Planner::Outline && self.apart == Some(true) => {
                Some(NoPath::Unreachable(self.query.goal))
            }
            _ => own.or(Some(NoPath::BudgetSpent { iterations })),
        }
    }
}
