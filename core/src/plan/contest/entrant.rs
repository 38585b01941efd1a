//! One planner of a contest: its search, its time, and how its path became shorter.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use crate::plan::cspace::ConfigSpace;
use crate::plan::path::{NoPath, Planner};
use crate::plan::query::Progress;
use crate::plan::search::Search;

pub(super) struct Entrant {
    pub(super) planner: Planner,
    pub(super) search: Option<Search>,
    pub(super) refused: Option<NoPath>,
    pub(super) rng: ChaCha8Rng,
    /// Iterations of the next turn.
    pub(super) budget: usize,
    pub(super) seconds: f64,
    pub(super) is_over: bool,
    /// Time taken, s, and length, m, whenever the path became shorter.
    pub(super) curve: Vec<(f64, f64)>,
}

impl Entrant {
    pub(super) fn new(planner: Planner, seed: u64) -> Self {
        Self {
            planner,
            search: None,
            refused: None,
            rng: ChaCha8Rng::seed_from_u64(seed),
            budget: 1,
            seconds: 0.0,
            is_over: false,
            curve: vec![],
        }
    }

    pub(super) fn begin(&mut self, begun: Result<Search, NoPath>, space: &dyn ConfigSpace) {
        match begun {
            Ok(mut search) => {
                // A straight line is found at once.
                self.is_over = search.step(space, &mut self.rng, 0).is_over();
                self.search = Some(search);
            }
            Err(reason) => {
                self.is_over = true;
                self.refused = Some(reason);
            }
        }
    }

    pub(super) fn failure(&self) -> Option<NoPath> {
        match self.search.as_ref()?.progress() {
            Progress::Failed(reason) => Some(reason),
            _ => None,
        }
    }

    pub(super) fn has_proof(&self) -> bool {
        matches!(self.failure(), Some(NoPath::Unreachable { .. }))
    }
}
