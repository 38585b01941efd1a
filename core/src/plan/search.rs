//! One way to ask all planners.
//!
//! In: a planner, a configuration space, a query, and iterations to spend, in as many steps as the caller likes. Out: how far
//! it has come, the best path so far, and what was tried, at any time; at the end a path, or the typed reason.
//!
//! 1. Start and goal must be free.
//! 2. The straight line is tried first, for all planners alike.
//! 3. Then the planner iterates: a point drawn by the trees, a cell expanded by searches over cells, a leg of the
//!    visibility graph.
//! 4. Where nothing is found the space is asked for a proof that there is nothing ([`ConfigSpace::are_apart`]).
//!
//! The caller may stop between two steps: a search holds nothing but its own memory, and borrows the space for a step.

use rand::Rng;

use super::a_star::AStar;
use super::cspace::ConfigSpace;
use super::lattice::Lattice;
use super::outline::{OutlineConfig, OutlineSearch};
use super::path::{NoPath, Path, Planner};
use super::query::{Answer, Progress, Query};
use super::rooms::{NoRooms, RoomSearch};
use super::rrt::{Rrt, RrtConfig};
use super::rrt_connect::RrtConnect;
use super::rrt_star::RrtStar;
use super::sampler::Sampler;
use super::theta_star::ThetaStar;
use super::visibility::Visibility;
use crate::geom::{Footprint, Segment};

/// A search that can be gone on with.
#[derive(Clone, Debug)]
pub struct Search {
    query: Query,
    planner: Planner,
    kind: Kind,
    iterations: usize,
    progress: Progress,
}

#[derive(Clone, Debug)]
enum Kind {
    Straight,
    Rrt(Box<Rrt>),
    Connect(Box<RrtConnect>),
    Star(Box<RrtStar>),
    AStar(Box<AStar>),
    ThetaStar(Box<ThetaStar>),
    Rooms(Box<RoomSearch>),
    Visibility(Box<Visibility>),
    Outline(Box<OutlineSearch>),
}

impl Search {
    /// Begins; draws points from what `sampler` makes, where the planner draws any.
    ///
    /// # Errors    [`NoPath::StartBlocked`], [`NoPath::GoalBlocked`]; [`NoPath::NotOffered`] where the planner cannot work in
    /// this space: [`Planner::Visibility`] needs walls, [`Planner::Outline`] an outline ([`Search::for_outline`]), and
    /// [`Planner::Wavefront`] is for routes alone.
    pub fn new<S: ConfigSpace + ?Sized>(
        planner: Planner,
        space: &S,
        query: Query,
        config: RrtConfig,
        sampler: impl FnOnce() -> Sampler,
    ) -> Result<Self, NoPath> {
        query.check(space)?;
        let lattice = || Lattice::over(space, &query);
        let is_straight = space.leg_is_free(&Segment::new(query.start, query.goal));
        let kind = match planner {
            _ if is_straight => Kind::Straight,
            Planner::Straight => Kind::Straight,
            Planner::Rrt => Kind::Rrt(Box::new(Rrt::new(space, query, config, sampler()))),
            Planner::RrtConnect => {
                Kind::Connect(Box::new(RrtConnect::new(space, query, config, sampler())))
            }
            Planner::RrtStar | Planner::InformedRrtStar => {
                let is_informed = planner == Planner::InformedRrtStar;
                let star = RrtStar::new(space, query, config, sampler(), is_informed);
                Kind::Star(Box::new(star))
            }
            Planner::AStar => Kind::AStar(Box::new(AStar::new(lattice(), &query))),
            Planner::ThetaStar => Kind::ThetaStar(Box::new(ThetaStar::new(lattice(), query))),
            Planner::Rooms => Kind::Rooms(Box::new(RoomSearch::new(lattice(), query))),
            Planner::Visibility => {
                let graph = Visibility::new(space, query);
                let graph = graph.ok_or(NoPath::NotOffered { planner })?;
                Kind::Visibility(Box::new(graph))
            }
            Planner::Wavefront | Planner::Outline => return Err(NoPath::NotOffered { planner }),
        };
        let progress = match (is_straight, &kind) {
            (true, _) => Progress::Finished,
            (false, Kind::Straight) => Progress::Failed(NoPath::Exhausted { iterations: 0 }),
            (false, _) => Progress::Searching,
        };
        Ok(Self {
            query,
            planner: if is_straight {
                Planner::Straight
            } else {
                planner
            },
            kind,
            iterations: 0,
            progress,
        })
    }

    /// Begins for an outline, from a heading in rad or from any; the space keeps what the disc within the outline needs.
    ///
    /// # Errors    [`NoPath::StartBlocked`], [`NoPath::GoalBlocked`].
    pub fn for_outline<S: ConfigSpace + ?Sized>(
        space: &S,
        outline: Footprint,
        query: Query,
        heading: Option<f64>,
    ) -> Result<Self, NoPath> {
        let config = OutlineConfig::default();
        let search = OutlineSearch::new(space, outline, query, heading, config)?;
        Ok(Self {
            query,
            planner: Planner::Outline,
            kind: Kind::Outline(Box::new(search)),
            iterations: 0,
            progress: Progress::Searching,
        })
    }

    /// Goes on for at most `budget` iterations, in the space it was begun in; sooner back when it is over, and, but for
    /// planners that improve their path, when there is one.
    pub fn step<S: ConfigSpace + ?Sized, R: Rng>(
        &mut self,
        space: &S,
        rng: &mut R,
        budget: usize,
    ) -> Progress {
        for _ in 0..budget {
            if self.progress.is_over() {
                break;
            }
            self.iterations += 1;
            self.progress = self.iterate(space, rng);
        }
        self.progress
    }

    fn iterate<S: ConfigSpace + ?Sized, R: Rng>(&mut self, space: &S, rng: &mut R) -> Progress {
        let found = |is_found: bool| {
            if is_found {
                Progress::Finished
            } else {
                Progress::Searching
            }
        };
        let (goes_on, is_found) = match &mut self.kind {
            Kind::Straight => return self.progress,
            Kind::Rrt(tree) => {
                tree.iterate(space, rng);
                return found(tree.path().is_some());
            }
            Kind::Connect(trees) => {
                trees.iterate(space, rng);
                return found(trees.path().is_some());
            }
            Kind::Star(tree) => {
                tree.iterate(space, rng);
                return if tree.length().is_finite() {
                    Progress::Improving
                } else {
                    Progress::Searching
                };
            }
            Kind::AStar(search) => (search.iterate(space), search.is_found()),
            Kind::ThetaStar(search) => (search.iterate(space), search.is_found()),
            Kind::Rooms(search) => (search.iterate(space), search.is_found()),
            Kind::Visibility(graph) => (graph.iterate(space), graph.is_found()),
            Kind::Outline(search) => (search.iterate(space), search.path().is_some()),
        };
        match (goes_on, is_found) {
            (true, _) => Progress::Searching,
            (false, true) => Progress::Finished,
            // If there is any path there is a taut one.
            (false, false) if self.planner == Planner::Visibility => {
                Progress::Failed(self.query.unreachable())
            }
            (false, false) => Progress::Failed(NoPath::Exhausted {
                iterations: self.iterations,
            }),
        }
    }

    /// The best path so far.
    #[must_use]
    pub fn path(&self) -> Option<Path> {
        match &self.kind {
            Kind::Straight => (self.progress == Progress::Finished).then(|| Path {
                points: vec![self.query.start, self.query.goal],
            }),
            Kind::Rrt(tree) => tree.path().cloned(),
            Kind::Connect(trees) => trees.path().cloned(),
            Kind::Star(tree) => tree.path(),
            Kind::AStar(search) => search.path(),
            Kind::ThetaStar(search) => search.path(),
            Kind::Rooms(search) => search.path(),
            Kind::Visibility(graph) => graph.path(),
            Kind::Outline(search) => search.path().cloned(),
        }
    }

    /// What was tried: legs of trees, steps over cells, legs of the visibility graph.
    #[must_use]
    pub fn tree(&self) -> Vec<Segment> {
        match &self.kind {
            Kind::Straight => vec![],
            Kind::Rrt(tree) => tree.edges(),
            Kind::Connect(trees) => trees.edges(),
            Kind::Star(tree) => tree.edges(),
            Kind::AStar(search) => search.edges(),
            Kind::ThetaStar(search) => search.edges(),
            Kind::Rooms(search) => search.edges(),
            Kind::Visibility(graph) => graph.edges(),
            Kind::Outline(search) => search.edges(),
        }
    }

    /// How many legs [`Self::tree`] has.
    #[must_use]
    pub fn tried(&self) -> usize {
        match &self.kind {
            Kind::Straight => 0,
            Kind::Rrt(tree) => tree.edge_count(),
            Kind::Connect(trees) => trees.edge_count(),
            Kind::Star(tree) => tree.edge_count(),
            Kind::AStar(search) => search.edge_count(),
            Kind::ThetaStar(search) => search.edge_count(),
            Kind::Rooms(search) => search.edge_count(),
            Kind::Visibility(graph) => graph.edge_count(),
            Kind::Outline(search) => search.edge_count(),
        }
    }

    /// How far it has come.
    #[must_use]
    pub fn progress(&self) -> Progress {
        self.progress
    }

    /// Why [`Planner::Rooms`] took all cells instead of those of the rooms crossed; `None` where it did not, and of all others.
    #[must_use]
    pub fn fallback(&self) -> Option<NoRooms> {
        match &self.kind {
            Kind::Rooms(search) => search.fallback(),
            _ => None,
        }
    }

    /// Iterations used.
    #[must_use]
    pub fn iterations(&self) -> usize {
        self.iterations
    }

    /// Who looks: the planner that was asked for, or [`Planner::Straight`] where nothing is in the way.
    #[must_use]
    pub fn planner(&self) -> Planner {
        self.planner
    }

    /// Step 4, and the end: the best path, or the strongest reason that can be given.
    #[must_use]
    pub fn answer<S: ConfigSpace + ?Sized>(&self, space: &S) -> Answer {
        let path = self.path().ok_or_else(|| match self.progress {
            Progress::Failed(reason @ NoPath::Unreachable { .. }) => reason,
            _ if space.are_apart(self.query.start, self.query.goal) => self.query.unreachable(),
            Progress::Failed(reason) => reason,
            _ => NoPath::BudgetSpent {
                iterations: self.iterations,
            },
        });
        Answer {
            path,
            by: self.planner,
            iterations: self.iterations,
            tree: self.tree(),
        }
    }
}

/// Asks a planner once, for `config.max_iterations` at most.
pub fn solve<S: ConfigSpace + ?Sized, R: Rng>(
    planner: Planner,
    space: &S,
    query: Query,
    config: &RrtConfig,
    rng: &mut R,
) -> Answer {
    let sampler = || Sampler::anywhere(space);
    match Search::new(planner, space, query, *config, sampler) {
        Ok(mut search) => {
            search.step(space, rng, config.max_iterations);
            search.answer(space)
        }
        Err(reason) => Answer {
            path: Err(reason),
            by: planner,
            iterations: 0,
            tree: vec![],
        },
    }
}
