//! All planners on one query, side by side.
//!
//! In: walls or a grid, a query, and how long each planner may take; after each step the time that
//! it took, because there is no clock here. Out: at any time, for each planner, the path or why
//! there is none, its length against the shortest, time, iterations, what it tried, and how the
//! length fell.
//!
//! 1. The planners take turns. A turn is as many iterations as fill a time slice, judged by the
//!    time of the last ones; so the caller stays in control, and a slow planner does not hold up
//!    others.
//! 2. A planner is done when it can do no more, or its time is spent. Each has a random generator
//!    of its own, so its result does not depend on who else takes part.
//! 3. Lengths are compared with that of the visibility graph, which is the shortest possible; over
//!    a grid, where there is no such graph, with the shortest found.
//! 4. For a robot that is not a disc one more takes part, [`Planner::Outline`], which plans for the
//!    outline; all others plan for the disc around it. Then no path is known to be the shortest.
//! 5. If a planner found nothing and the visibility graph has proved nothing, a flood may prove
//!    that there is no path.

mod entrant;
mod standing;

use self::entrant::Entrant;
use super::cspace::{ConfigSpace, GridSpace, SegmentSpace, SpaceError, Unknown, Within};
use super::path::{NoPath, Path, Planner};
use super::query::Query;
use super::rrt::RrtConfig;
use super::sampler::Sampler;
use super::search::Search;
use crate::bounds::config;
use crate::geom::{Footprint, Segment};
use crate::map::Grid;
pub use standing::{Shortest, Standing};

/// The planners of a contest for discs.
pub const CONTESTANTS: [Planner; 8] = [
    Planner::Rrt,
    Planner::RrtConnect,
    Planner::RrtStar,
    Planner::InformedRrtStar,
    Planner::AStar,
    Planner::ThetaStar,
    Planner::Visibility,
    Planner::Rooms,
];

/// Most iterations of one turn.
const MOST_ITERATIONS: usize = 1 << 16;

config! {
    /// How a contest is held.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct ContestConfig {
        /// Time of each planner, s. Default 1. Those that improve their path use all of it.
        pub seconds: f64 = 1.0,
        /// Time of one turn, s. Default 0.004; shorter: the caller is asked more often.
        pub slice: f64 = 0.004,
        /// How trees grow; iterations are not limited.
        pub rrt: RrtConfig = RrtConfig::default(),
        /// Of the points that trees draw.
        pub seed: u64 = 1,
    }
}

/// The robot for which a path is searched.
#[derive(Clone, Debug, PartialEq)]
pub struct ContestBody {
    /// Distance that its centre keeps from walls, taken as a disc, m.
    pub keep: f64,
    /// Its outline, if it is not a disc; at the start it may have any heading.
    pub outline: Option<Footprint>,
}

/// Why a contest cannot begin.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ContestError {
    /// Start or goal is not possible.
    #[error(transparent)]
    Query(#[from] NoPath),
    /// The walls are not valid.
    #[error(transparent)]
    Space(#[from] SpaceError),
}

/// Planners that search for the same path in the same space.
pub struct Contest {
    space: Box<dyn ConfigSpace>,
    /// The space of the disc within the outline, and the outline.
    outline: Option<(Box<dyn ConfigSpace>, Footprint)>,
    query: Query,
    config: ContestConfig,
    entrants: Vec<Entrant>,
    /// The planner that had the last turn.
    turn: usize,
    /// Whether start and goal are proved to be apart; `None` before the proof was tried.
    apart: Option<bool>,
}

impl std::fmt::Debug for Contest {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Contest")
            .field("query", &self.query)
            .field("config", &self.config)
            .finish_non_exhaustive()
    }
}

impl Contest {
    /// A contest among walls, for a robot whose centre keeps away from them and stays inside their
    /// bounding rectangle.
    ///
    /// # Errors    [`ContestError`]: walls or distance that are not valid, start or goal that is
    /// not free.
    pub fn among_walls(
        walls: Vec<Segment>,
        body: ContestBody,
        query: Query,
        config: ContestConfig,
    ) -> Result<Self, ContestError> {
        let ends = walls.iter().flat_map(|wall| [wall.a, wall.b]);
        let (low, high) = ends.fold((query.start, query.start), |(low, high), end| {
            (low.inf(&end), high.sup(&end))
        });
        let space = SegmentSpace::new(walls, body.keep, (low, high))?;
        let outline = body.outline;
        let outline = outline.map(|o| (space.with_keep(o.radius_within()), o));
        Ok(Self::held(space, outline, query, config)?)
    }

    /// A contest on a snapshot of a grid, for a robot whose centre keeps away from occupied cells.
    ///
    /// # Errors    [`ContestError::Query`]: start or goal that is not free, or is far off the grid.
    pub fn on_grid(
        grid: &Grid,
        body: ContestBody,
        unknown: Unknown,
        query: Query,
        config: ContestConfig,
    ) -> Result<Self, ContestError> {
        let space = GridSpace::of_query(grid, &query, body.keep, unknown, &Within::default())?;
        let outline = body.outline;
        let outline = outline.map(|o| (space.clone().with_keep(o.radius_within()), o));
        Ok(Self::held(space, outline, query, config)?)
    }

    /// `outline` comes with the space of the disc within it.
    fn held<Space: ConfigSpace + 'static>(
        space: Space,
        outline: Option<(Space, Footprint)>,
        query: Query,
        config: ContestConfig,
    ) -> Result<Self, NoPath> {
        // The outline may fit where the disc around it does not.
        query.check(outline.as_ref().map_or(&space, |(within, _)| within))?;
        let discs = CONTESTANTS.into_iter();
        let planners = discs.chain(outline.is_some().then_some(Planner::Outline));
        let entrants: Vec<Entrant> = planners.map(|p| Entrant::new(p, config.seed)).collect();
        Ok(Self {
            space: Box::new(space),
            outline: outline.map(|(within, outline)| (Box::new(within) as _, outline)),
            query,
            config,
            turn: entrants.len() - 1,
            entrants,
            apart: None,
        })
    }

    /// Does one turn of the next planner that is not done. Returns whether there was anything to
    /// do; if so, [`Self::took`] must be told how long it took.
    pub fn step(&mut self) -> bool {
        let count = self.entrants.len();
        let next = (1..=count).map(|i| (self.turn + i) % count);
        let Some(turn) = next.into_iter().find(|&i| !self.entrants[i].is_over) else {
            return self.prove();
        };
        self.turn = turn;
        let entrant = &mut self.entrants[turn];
        let of_outline = self.outline.as_ref();
        let outline = of_outline.filter(|_| entrant.planner == Planner::Outline);
        let space = outline.map_or(&*self.space, |(within, _)| &**within);
        let Some(search) = &mut entrant.search else {
            let query = self.query;
            let begun = match outline {
                Some((_, outline)) => Search::for_outline(space, outline.clone(), query, None),
                None => {
                    let sampler = || Sampler::anywhere(space);
                    Search::new(entrant.planner, space, query, self.config.rrt, sampler)
                }
            };
            entrant.begin(begun, space);
            return true;
        };
        let progress = search.step(space, &mut entrant.rng, entrant.budget);
        entrant.is_over = progress.is_over();
        true
    }

    /// Takes how long the last step took, s. A value that is not a time counts as 0.
    pub fn took(&mut self, seconds: f64) {
        let ContestConfig {
            seconds: most,
            slice,
            ..
        } = self.config;
        let Some(entrant) = self.entrants.get_mut(self.turn) else {
            return;
        };
        entrant.seconds += if seconds > 0.0 { seconds } else { 0.0 };
        entrant.is_over |= entrant.seconds >= most;
        if seconds < 0.5 * slice {
            entrant.budget = (2 * entrant.budget).min(MOST_ITERATIONS);
        } else if seconds > slice {
            entrant.budget = (entrant.budget / 2).max(1);
        }
        let length = entrant.search.as_ref().and_then(Search::path);
        let length = length.map(|path| path.length());
        let best = entrant.curve.last().map_or(f64::INFINITY, |last| last.1);
        if let Some(length) = length.filter(|&length| length < best) {
            entrant.curve.push((entrant.seconds, length));
        }
    }

    /// Tries once to prove that there is no path, if that is an open question. Returns whether it
    /// tried.
    fn prove(&mut self) -> bool {
        let has_path = |e: &Entrant| !e.curve.is_empty();
        if self.apart.is_some() || self.entrants.iter().all(has_path) {
            return false;
        }
        // An outline may pass where the disc around it does not, so its result says nothing about
        // the others.
        let mut discs = self.entrants.iter().take(CONTESTANTS.len());
        let is_joined = discs.clone().any(has_path);
        let is_proved = discs.any(Entrant::has_proof);
        let Query { start, goal } = self.query;
        // The time of the proof is not charged to any planner.
        self.turn = self.entrants.len();
        self.apart = Some(!is_joined && (is_proved || self.space.are_apart(start, goal)));
        true
    }

    /// Whether no planner has anything left to do.
    #[must_use]
    pub fn is_over(&self) -> bool {
        let has_path = |e: &Entrant| !e.curve.is_empty();
        let is_settled = self.apart.is_some() || self.entrants.iter().all(has_path);
        is_settled && self.entrants.iter().all(|e| e.is_over)
    }

    /// The planners that take part: [`CONTESTANTS`], and after them [`Planner::Outline`] for a
    /// robot that is not a disc.
    pub fn planners(&self) -> impl Iterator<Item = Planner> + '_ {
        self.entrants.iter().map(|entrant| entrant.planner)
    }

    /// The best path of a planner so far.
    #[must_use]
    pub fn path(&self, planner: Planner) -> Option<Path> {
        self.search(planner).and_then(Search::path)
    }

    /// The edges that a planner tried.
    #[must_use]
    pub fn tree(&self, planner: Planner) -> Vec<Segment> {
        self.search(planner).map(Search::tree).unwrap_or_default()
    }

    /// How a planner's path became shorter: time taken, s, and length, m.
    #[must_use]
    pub fn curve(&self, planner: Planner) -> &[(f64, f64)] {
        let entrant = self.entrants.iter().find(|e| e.planner == planner);
        entrant.map(|e| &e.curve[..]).unwrap_or_default()
    }

    fn search(&self, planner: Planner) -> Option<&Search> {
        let entrant = self.entrants.iter().find(|e| e.planner == planner)?;
        entrant.search.as_ref()
    }
}

#[cfg(test)]
mod tests;
