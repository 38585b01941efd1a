//! How the planners of a contest stand.

use super::Contest;
use super::entrant::Entrant;
use crate::plan::path::{NoPath, Planner};
use crate::plan::rooms::NoRooms;
use crate::plan::search::Search;

/// How one planner stands.
#[derive(Clone, Debug, PartialEq)]
pub struct Standing {
    /// Who.
    pub planner: Planner,
    /// Whether it is done.
    pub is_over: bool,
    /// Whether nothing is in the way: then nobody had to look.
    pub is_straight: bool,
    /// Length of its best path, m; `None` while there is none.
    pub length: Option<f64>,
    /// The length in units of [`Contest::shortest`].
    pub ratio: Option<f64>,
    /// Why there is no path; `None` while it looks for one, and when it has one.
    pub reason: Option<NoPath>,
    /// Why it did not keep to the rooms that lie on the way; `None` where it did, and of all that
    /// know no rooms.
    pub fallback: Option<NoRooms>,
    /// Time taken, s.
    pub seconds: f64,
    /// Points drawn, cells expanded, legs of the graph looked at.
    pub iterations: usize,
    /// Legs of trees, steps over cells, legs of the graph that were tried.
    pub tried: usize,
}

/// What the lengths are held against.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shortest {
    /// m.
    pub length: f64,
    /// The visibility graph's: there is no shorter one. Otherwise the shortest found so far.
    pub is_optimum: bool,
}

impl Contest {
    /// How all stand, in the order of [`Self::planners`].
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

    /// What the lengths are held against; `None` while nobody has a path.
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
