//! A route over a grid for a robot that is not a disc.
//!
//! In: the grid, start, goal, heading, the robot. Out: a [`Route`] of straight legs, or the typed
//! reason.
//!
//! The margins around the outline are tried in order. A margin at which not even the disc within
//! fits through is skipped at once, because the wavefront finds that out faster than a search over
//! headings.
//!
//! A cell is thicker than the wall in it, so a robot between two posts may seem to stand in them.
//! If it does, the outline is tried without a margin, and then half a cell smaller: safe mode then
//! takes care of what it comes near.

use super::OutlineSearch;
use crate::geom::Pose2;
use crate::map::Grid;
use crate::plan::cspace::{ConfigSpace, GridSpace};
use crate::plan::path::{NoPath, Planner};
use crate::plan::query::Query;
use crate::plan::route::{Route, RouteConfig, RouteFailure};
use crate::plan::search::Planning;
use crate::robot::RobotModel;

/// Most states to expand at one margin.
const MOST_STATES: usize = 60_000;

/// Plans from a pose to `query.goal` for the robot's outline.
///
/// # Errors    [`RouteFailure`] with the reason at the narrowest margin; [`NoPath::NotOffered`] for
/// a robot that is a disc.
pub fn plan_outline_route(
    grid: &Grid,
    from: &Pose2,
    goal: nalgebra::Point2<f64>,
    robot: &RobotModel,
    config: &RouteConfig,
) -> Result<Route, RouteFailure> {
    let planner = Planner::Outline;
    let start = from.position();
    let query = Query { start, goal };
    let mut failure = RouteFailure::from(NoPath::NotOffered { planner });
    let mut space = GridSpace::of_query(grid, &query, 0.0, config.unknown, &config.within)?;
    let mut iterations = 0;
    let where_it_stands = [0.0, -0.5 * grid.resolution()];
    for (at, &margin) in config.margins.iter().chain(&where_it_stands).enumerate() {
        let seems_to_touch = matches!(failure.reason, NoPath::StartBlocked(_));
        let outline = robot.outline(margin);
        let Some(outline) = outline.filter(|_| at < config.margins.len() || seems_to_touch) else {
            return Err(failure);
        };
        space = space.with_keep(outline.radius_within());
        let goal = space.nearest_free(goal, config.goal_reach).unwrap_or(goal);
        if space.is_free(start) && space.is_free(goal) && space.are_apart(start, goal) {
            failure.reason = NoPath::Unreachable(goal);
            continue;
        }
        let (query, heading) = (Query { start, goal }, Some(from.heading()));
        let mut search = match OutlineSearch::new(&space, outline, query, heading) {
            Ok(search) => search,
            Err(reason) => {
                failure.reason = reason;
                continue;
            }
        };
        let is_cut_off = !(0..MOST_STATES).any(|_| !search.expand_next(&space));
        iterations += search.iterations;
        let tree = search.edges();
        if let Some(path) = search.path() {
            return Ok(Route {
                raw: path.clone(),
                pieces: vec![],
                path,
                tree,
                by: planner,
                margin,
            });
        }
        let reason = match is_cut_off {
            true => NoPath::BudgetSpent { iterations },
            false => NoPath::Exhausted { iterations },
        };
        failure = RouteFailure { reason, tree };
    }
    Err(failure)
}
