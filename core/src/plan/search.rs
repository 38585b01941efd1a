//! A common interface to all planners.
//!
//! In: a planner, a configuration space, a query, and iterations to spend, in as many steps as the
//! caller likes. Out: at any time the state of the search, the best path so far, and the edges
//! tried; at the end a path, or the typed reason.
//!
//! 1. Start and goal must be free.
//! 2. The straight line is tried first, for all planners alike.
//! 3. Then the planner iterates: trees draw a point, searches over cells expand a cell, the
//!    visibility graph examines a leg.
//!
//! The caller may stop between two steps: a search holds only its own memory, and borrows the space
//! for each step.

use std::fmt;

use rand::Rng;

use super::a_star::AStar;
use super::cspace::ConfigSpace;
use super::lattice::Lattice;
use super::outline::OutlineSearch;
use super::path::{NoPath, Path, Planner};
use super::query::{Progress, Query};
use super::rooms::{NoRooms, RoomSearch};
use super::rrt::{Rrt, RrtConfig};
use super::rrt_connect::RrtConnect;
use super::rrt_star::RrtStar;
use super::sampler::Sampler;
use super::theta_star::ThetaStar;
use super::visibility::Visibility;
use crate::geom::{Footprint, Segment};

/// One planner at work on one query, always in the space in which it was begun.
pub(super) trait Planning: fmt::Debug {
    /// Does one iteration; returns whether there is more to do.
    fn iterate(&mut self, space: &dyn ConfigSpace, rng: &mut dyn Rng) -> bool;

    /// Whether there is a path.
    fn is_found(&self) -> bool;

    /// The best path so far.
    fn path(&self) -> Option<Path>;

    /// The edges tried, for display.
    fn edges(&self) -> Vec<Segment>;

    /// How many [`Self::edges`] there are.
    fn edge_count(&self) -> usize;

    /// See [`Search::fallback`].
    fn fallback(&self) -> Option<NoRooms> {
        None
    }
}

/// A search that can be continued.
#[derive(Debug)]
pub struct Search {
    query: Query,
    planner: Planner,
    /// `None` if only the straight line is tried.
    planning: Option<Box<dyn Planning>>,
    iterations: usize,
    progress: Progress,
}

impl Search {
    /// Begins a search; planners that draw points take them from what `sampler` makes.
    ///
    /// # Errors    [`NoPath::StartBlocked`], [`NoPath::GoalBlocked`]; [`NoPath::NotOffered`] if the
    /// planner cannot work in this space: [`Planner::Visibility`] needs walls, [`Planner::Outline`]
    /// an outline ([`Search::for_outline`]), and [`Planner::Wavefront`] is for routes only.
    pub fn new(
        planner: Planner,
        space: &dyn ConfigSpace,
        query: Query,
        config: RrtConfig,
        sampler: impl FnOnce() -> Sampler,
    ) -> Result<Self, NoPath> {
        query.check(space)?;
        if space.leg_is_free(&Segment::new(query.start, query.goal)) {
            return Ok(Self::begun(
                Planner::Straight,
                query,
                None,
                Progress::Finished,
            ));
        }
        let lattice = || Lattice::over(space, &query);
        let not_offered = NoPath::NotOffered { planner };
        let planning: Box<dyn Planning> = match planner {
            Planner::Straight => {
                let progress = Progress::Failed(NoPath::Exhausted { iterations: 0 });
                return Ok(Self::begun(planner, query, None, progress));
            }
            Planner::Rrt => Box::new(Rrt::new(space, query, config, sampler())),
            Planner::RrtConnect => Box::new(RrtConnect::new(space, query, config, sampler())),
            Planner::RrtStar | Planner::InformedRrtStar => {
                let is_informed = planner == Planner::InformedRrtStar;
                Box::new(RrtStar::new(space, query, config, sampler(), is_informed))
            }
            Planner::AStar => Box::new(AStar::new(lattice(), &query)),
            Planner::ThetaStar => Box::new(ThetaStar::new(lattice(), &query)),
            Planner::Rooms => Box::new(RoomSearch::new(lattice(), query)),
            Planner::Visibility => Box::new(Visibility::new(space, query).ok_or(not_offered)?),
            Planner::Wavefront | Planner::Outline => return Err(not_offered),
        };
        Ok(Self::begun(
            planner,
            query,
            Some(planning),
            Progress::Searching,
        ))
    }

    /// Begins a search for an outline, from a heading in rad or from any; the space keeps the
    /// distance that the disc within the outline needs.
    ///
    /// # Errors    [`NoPath::StartBlocked`], [`NoPath::GoalBlocked`].
    pub fn for_outline(
        space: &dyn ConfigSpace,
        outline: Footprint,
        query: Query,
        heading: Option<f64>,
    ) -> Result<Self, NoPath> {
        let search: Box<dyn Planning> =
            Box::new(OutlineSearch::new(space, outline, query, heading)?);
        Ok(Self::begun(
            Planner::Outline,
            query,
            Some(search),
            Progress::Searching,
        ))
    }

    fn begun(
        planner: Planner,
        query: Query,
        planning: Option<Box<dyn Planning>>,
        progress: Progress,
    ) -> Self {
        Self {
            query,
            planner,
            planning,
            iterations: 0,
            progress,
        }
    }

    /// Continues for at most `budget` iterations, in the space in which it was begun. It returns
    /// sooner when it is over, and, for planners that do not improve their path, when there is one.
    pub fn step(&mut self, space: &dyn ConfigSpace, rng: &mut dyn Rng, budget: usize) -> Progress {
        for _ in 0..budget {
            let Some(planning) = &mut self.planning else {
                break;
            };
            if self.progress.is_over() {
                break;
            }
            self.iterations += 1;
            let iterations = self.iterations;
            self.progress = match (planning.iterate(space, rng), planning.is_found()) {
                (true, false) => Progress::Searching,
                (true, true) => Progress::Improving,
                (false, true) => Progress::Finished,
                // If there is any path, there is a taut one.
                (false, false) if self.planner == Planner::Visibility => {
                    Progress::Failed(NoPath::Unreachable(self.query.goal))
                }
                (false, false) => Progress::Failed(NoPath::Exhausted { iterations }),
            };
        }
        self.progress
    }

    /// The best path so far.
    #[must_use]
    pub fn path(&self) -> Option<Path> {
        match &self.planning {
            Some(planning) => planning.path(),
            None => (self.progress == Progress::Finished).then(|| Path {
                points: vec![self.query.start, self.query.goal],
            }),
        }
    }

    /// The edges tried: of trees, steps over cells, or legs of the visibility graph.
    #[must_use]
    pub fn tree(&self) -> Vec<Segment> {
        self.planning.as_ref().map_or(vec![], |p| p.edges())
    }

    /// How many edges [`Self::tree`] has.
    #[must_use]
    pub fn tried(&self) -> usize {
        self.planning.as_ref().map_or(0, |p| p.edge_count())
    }

    /// The state of the search.
    #[must_use]
    pub fn progress(&self) -> Progress {
        self.progress
    }

    /// Why [`Planner::Rooms`] took all cells instead of those of the crossed rooms; `None` if it
    /// did not, and for all other planners.
    #[must_use]
    pub fn fallback(&self) -> Option<NoRooms> {
        self.planning.as_ref()?.fallback()
    }

    /// Iterations used.
    #[must_use]
    pub fn iterations(&self) -> usize {
        self.iterations
    }

    /// The planner that was asked for, or [`Planner::Straight`] if the straight line is free.
    #[must_use]
    pub fn planner(&self) -> Planner {
        self.planner
    }
}
