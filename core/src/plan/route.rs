//! From a goal to a path of straight legs, with everything that a planner may report.
//!
//! In: the grid, start, goal, the robot's radius, a seeded generator. Out: a [`Route`], or the
//! typed reason.
//!
//! 1. A wide distance to walls is preferred, and a narrow one accepted: the margins are tried in
//!    order, so a robot keeps to the middle of a hall and still passes a tight door.
//! 2. A wavefront from the start shows what can be reached. A goal too near to a wall is moved to
//!    the nearest reachable place; if no continuous path leads there, that is a proof
//!    ([`may_reach`]).
//! 3. The straight line if it is free; otherwise the configured planner; trees draw their points
//!    from the cells that the wavefront reached.
//! 4. If a planner spent its budget although the wavefront arrived, the wavefront's own path is
//!    taken, and the route says so ([`Planner::Wavefront`]).
//! 5. Shortening as configured: Dijkstra over the path's chords, first between its corners, then
//!    between points set densely on it; and pulling tight.
//! 6. Rounding, if it is asked for: arcs may use up half of the margin at corners.

use nalgebra::Point2;
use rand::Rng;

use super::cspace::{ConfigSpace, GridSpace, Unknown, Within};
use super::path::{NoPath, Path, Planner};
use super::pull_tight::pull_tight;
use super::query::Query;
use super::reach::may_reach;
use super::rrt::RrtConfig;
use super::sampler::Sampler;
use super::search::Search;
use super::shorten::{densify, shorten};
use super::smooth::{Piece, smooth};
use super::wavefront::Wavefront;
use crate::bounds::config;
use crate::geom::Segment;
use crate::map::Grid;

/// How far beyond its distance to keep a robot too near to a wall searches for a free place, m.
pub(crate) const ESCAPE_REACH: f64 = 0.3;

config! {
    /// How routes are planned.
    #[derive(Clone, Debug, PartialEq)]
    pub struct RouteConfig {
        /// Distances to keep between the robot's disc and walls, m, tried in order. Default 0.12,
        /// 0.06, 0.02.
        pub margins: Vec<f64> = vec![0.12, 0.06, 0.02],
        /// What to make of the unknown. Default free.
        pub unknown: Unknown = Unknown::Free,
        /// Where the robot's centre may be at all. Default everywhere.
        pub within: Within = Within::default(),
        /// Who looks for the path. Default [`Planner::RrtConnect`]; [`Planner::Rrt`] is the
        /// paper's. Where the planner finds none within its iterations the wavefront's own path is
        /// taken.
        pub planner: Planner = Planner::RrtConnect,
        /// What is done to make its path shorter. Default [`Shortening::Chords`].
        pub shortening: Shortening = Shortening::Chords,
        /// How trees grow, and for how many iterations.
        pub rrt: RrtConfig = RrtConfig::default(),
        /// Whether corners are rounded for continuous driving. Default false: the robot turns on
        /// the spot.
        pub is_rounded: bool = false,
        /// How far the goal may be moved off a wall, m. Default 0.3.
        pub goal_reach: f64 = 0.3,
    }
}

impl RouteConfig {
    /// The last margin to be tried, m: the least that a robot keeps.
    #[must_use]
    pub fn narrowest(&self) -> f64 {
        self.margins.last().copied().unwrap_or(0.0)
    }
}

/// How a path is made shorter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shortening {
    /// Not at all.
    Nothing,
    /// Dijkstra's algorithm over its chords (TDK 2016 §5.3), then over chords between points set
    /// densely on it.
    Chords,
    /// The same, then pulled tight: the shortest way through the same gaps, in more and shorter
    /// legs.
    Tight,
}

impl Shortening {
    /// All variants, with their names in settings and their names for people.
    pub const ALL: [(&'static str, Self, &'static str); 3] = [
        ("none", Self::Nothing, "none"),
        ("chords", Self::Chords, "chords (TDK 2016)"),
        ("tight", Self::Tight, "pulled tight"),
    ];

    /// The path, shortened.
    #[must_use]
    pub fn apply(self, path: &Path, space: &dyn ConfigSpace) -> Path {
        if self == Self::Nothing {
            return path.clone();
        }
        let corners = shorten(path, space);
        let dense = shorten(&densify(&corners, spacing_for(&corners)), space);
        match self {
            Self::Tight => pull_tight(&dense, space),
            _ => dense,
        }
    }
}

/// A path and where it came from.
#[derive(Clone, Debug)]
pub struct Route {
    /// Straight legs from where the robot stands.
    pub path: Path,
    /// The same path with its corners rounded; empty if that was not asked for.
    pub pieces: Vec<Piece>,
    /// The path before shortening.
    pub raw: Path,
    /// Edges of the trees.
    pub tree: Vec<Segment>,
    /// The planner that found it.
    pub by: Planner,
    /// Distance kept between the robot's disc and walls, m.
    pub margin: f64,
}

impl Route {
    /// The part of the margin that must hold along the way, including corners cut by rounding, m.
    #[must_use]
    pub fn least_margin(&self) -> f64 {
        LEAST_PART * self.margin
    }
}

/// Why there is no route, and what was tried.
#[derive(Clone, Debug)]
pub struct RouteFailure {
    /// The reason.
    pub reason: NoPath,
    /// Edges of the trees.
    pub tree: Vec<Segment>,
}

impl From<NoPath> for RouteFailure {
    fn from(reason: NoPath) -> Self {
        let tree = vec![];
        Self { reason, tree }
    }
}

/// Fraction of the margin that rounding leaves.
const LEAST_PART: f64 = 0.5;

/// Plans from `start` to `goal` for a robot of the given radius.
///
/// # Errors    [`RouteFailure`] with the reason at the narrowest margin.
pub fn plan_route(
    grid: &Grid,
    start: Point2<f64>,
    goal: Point2<f64>,
    radius: f64,
    config: &RouteConfig,
    rng: &mut dyn Rng,
) -> Result<Route, RouteFailure> {
    let query = Query { start, goal };
    let mut failure = RouteFailure::from(NoPath::GoalBlocked(goal));
    let mut space = GridSpace::of_query(grid, &query, radius, config.unknown, &config.within)?;
    for (at, &margin) in config.margins.iter().enumerate() {
        space = space.with_keep(radius + margin);
        let is_last = at + 1 == config.margins.len();
        match plan_in(&space, &query, is_last, config, rng) {
            Ok(mut route) => {
                route.margin = margin;
                if config.is_rounded {
                    let space = space.with_keep(radius + route.least_margin());
                    route.pieces = smooth(&route.path, &space);
                }
                return Ok(route);
            }
            Err(narrower) => failure = narrower,
        }
    }
    Err(failure)
}

/// Plans at one margin.
fn plan_in(
    space: &GridSpace,
    &Query { start, goal }: &Query,
    is_last: bool,
    config: &RouteConfig,
    rng: &mut dyn Rng,
) -> Result<Route, RouteFailure> {
    let escape = space.escape(start, space.keep() + ESCAPE_REACH);
    let free_start = escape.ok_or(NoPath::StartBlocked(start))?;
    let wave = Wavefront::new(space, free_start);
    let (aim, cell) = aim_at(space, &wave, free_start, goal, config.goal_reach)?;
    if cell.is_none() && !is_last {
        // There is neither a way over cells nor a proof that there is none. A tree has a better
        // chance at the margin where walls are thinnest.
        return Err(NoPath::BudgetSpent { iterations: 0 }.into());
    }
    let query = Query {
        start: free_start,
        goal: aim,
    };
    let search = find(space, &wave, query, config, rng);
    let iterations = search.as_ref().map_or(0, Search::iterations);
    let tree = search.as_ref().map_or(vec![], Search::tree);
    let found = search.and_then(|search| Some((search.path()?, search.planner())));
    let by_wave = || {
        let mut path = wave.path_to(space, cell?)?;
        join_ends(&mut path, space, free_start, aim);
        Some((path, Planner::Wavefront))
    };
    let Some((mut raw, by)) = found.or_else(by_wave) else {
        let reason = NoPath::BudgetSpent { iterations };
        return Err(RouteFailure { reason, tree });
    };
    let mut path = config.shortening.apply(&raw, space);
    if free_start != start {
        path.points.insert(0, start);
        raw.points.insert(0, start);
    }
    Ok(Route {
        path,
        pieces: vec![],
        raw,
        tree,
        by,
        margin: 0.0,
    })
}

/// Point spacing that keeps the graph of chords small however long the path is.
fn spacing_for(path: &Path) -> f64 {
    (path.length() / 60.0).max(0.15)
}

/// The place to go to, and its cell, which the wavefront reached.
fn aim_at(
    space: &GridSpace,
    wave: &Wavefront,
    start: Point2<f64>,
    goal: Point2<f64>,
    reach: f64,
) -> Result<(Point2<f64>, Option<usize>), NoPath> {
    let reached = |point: &Point2<f64>| {
        let cell = space.index_at(*point);
        cell.filter(|&cell| wave.cost(cell).is_some())
    };
    let is_free = space.is_free(goal);
    if is_free && let Some(cell) = reached(&goal) {
        return Ok((goal, Some(cell)));
    }
    let near = space.free_cells_near(goal, reach);
    if let Some(aim) = near.iter().find_map(|p| Some((*p, Some(reached(p)?)))) {
        return Ok(aim);
    }
    let nearest = *near.first().ok_or(NoPath::GoalBlocked(goal))?;
    let point = if is_free { goal } else { nearest };
    match may_reach(space, start, point) {
        true => Ok((point, None)),
        false => Err(NoPath::Unreachable(goal)),
    }
}

/// The result of the configured planner; trees draw from the cells that the wavefront reached.
/// `None` if the planner is not offered here.
fn find(
    space: &GridSpace,
    wave: &Wavefront,
    query: Query,
    config: &RouteConfig,
    rng: &mut dyn Rng,
) -> Option<Search> {
    let sampler = || {
        let reached = wave.reached();
        let mut centres: Vec<_> = reached.iter().map(|&c| space.centre_of(c)).collect();
        if centres.is_empty() {
            centres.push(query.goal);
        }
        Sampler::Squares {
            centres,
            side: space.resolution(),
        }
    };
    let mut search = Search::new(config.planner, space, query, config.rrt, sampler).ok()?;
    let budget = match config.planner {
        // They end by themselves, once all cells are expanded.
        Planner::AStar | Planner::ThetaStar | Planner::Rooms => usize::MAX,
        _ => config.rrt.max_iterations,
    };
    search.step(space, rng, budget);
    Some(search)
}

/// Replaces the ends of a path over cell centres by the true ends.
fn join_ends(path: &mut Path, space: &GridSpace, start: Point2<f64>, goal: Point2<f64>) {
    if path.points.first().is_some_and(|first| *first != start) {
        path.points.insert(0, start);
    }
    // Within one cell; if a wall corner is in between, the centre of the cell is near enough to the
    // goal.
    let is_open = |last: &Point2<f64>| space.leg_is_free(&Segment::new(*last, goal));
    if path
        .points
        .last()
        .is_some_and(|last| *last != goal && is_open(last))
    {
        path.points.push(goal);
    }
}
