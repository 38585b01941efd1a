//! Drives that close loops: through places that the map has next to each other, and of which it
//! does not know yet that they are.
//!
//! In: the pose graph of a map in which nothing unknown is left, and its grid. Out: goals, one
//! after the other.
//!
//! A loop is closed by a submap that shows both of its ends. The robot often has none: it stops as
//! soon as nothing unknown is in sight, and the errors of its whole way stay in the gap.
//!
//! 1. Of the graph's open loops ([`PoseGraph::open_loops`]) those count whose ends have a short way
//!    between them in the grid: two corridors with a wall between are no loop.
//! 2. The robot drives to the end that is nearer, on to the other one, and further along what it
//!    knows there, until the loop is closed, or [`FOLLOWS`] metres were driven.
//! 3. Each gap is tried once. What the map shows as unknown then is explored as before.
//!
//! Source: Stachniss, Hähnel & Burgard (2004), "Exploration with active loop-closing for FastSLAM".

use nalgebra::Point2;

use super::errand::PLAN_ATTEMPTS;
use super::{Pilot, Situation, Status};
use crate::estimation::{OpenLoop, PoseGraph};
use crate::geom::Length;
use crate::map::CellRect;
use crate::plan::{ESCAPE_REACH, GridSpace, NoPath, Unknown, Wavefront};

/// How much of what is known is driven through beyond the gap, m: two submaps.
const FOLLOWS: f64 = 10.0;
/// Poses farther apart than this do not follow each other, m.
const STEP: f64 = 6.0;
/// A way between the ends is at most so many times longer than the straight one, ...
const DETOUR: f64 = 2.0;
/// ... and so much longer, m.
const SPARE: f64 = 2.0;
/// Places nearer than this need not be driven to, m.
const IS_THERE: f64 = 0.5;
/// Gaps nearer than this to each other are the same one, m.
const SAME_GAP: f64 = 4.0;

/// A drive that closes a loop.
#[derive(Clone, Debug)]
pub(super) struct Closing {
    open: OpenLoop,
    /// Poses of the graph that are still to be driven to, the next one last.
    places: Vec<usize>,
}

impl Closing {
    /// From `here` to the nearer end, to the other, and on.
    fn of(open: OpenLoop, graph: &PoseGraph, here: Point2<f64>) -> Self {
        let at = |pose: usize| graph.poses()[pose].position();
        let mut ends = [open.older, open.newer];
        ends.sort_by(|&a, &b| (at(a) - here).length().total_cmp(&(at(b) - here).length()));
        let [start, other] = ends;
        let follows = |from: usize, to: usize| (at(to) - at(from)).length() < STEP;
        let before = other.checked_sub(1).filter(|&pose| follows(other, pose));
        let behind = Some(other + 1).filter(|&p| p < graph.poses().len() && follows(other, p));
        let away = |pose: usize| (at(pose) - at(start)).length();
        let is_forward = match (before, behind) {
            (Some(before), Some(behind)) => away(behind) > away(before),
            (None, _) => true,
            (_, None) => false,
        };
        let mut places = vec![start, other];
        let (mut last, mut driven) = (other, 0.0);
        while driven < FOLLOWS {
            let next = match is_forward {
                true => Some(last + 1).filter(|&pose| pose < graph.poses().len()),
                false => last.checked_sub(1),
            };
            let Some(next) = next.filter(|&next| next != start && follows(last, next)) else {
                break;
            };
            driven += (at(next) - at(last)).length();
            places.push(next);
            last = next;
        }
        places.reverse();
        Self { open, places }
    }
}

impl Pilot {
    /// Whether all is explored, and the robot drives through what it knows to close a loop.
    #[must_use]
    pub fn is_closing_loop(&self) -> bool {
        self.errand.closing.is_some()
    }

    /// Begins to close a loop; `false` where none is left that was not tried.
    pub(super) fn begin_closing(&mut self, now: &Situation) -> bool {
        let Some(graph) = now.graph.filter(|_| self.config.close_loops) else {
            return false;
        };
        for open in graph.open_loops() {
            let [a, b] = [open.older, open.newer].map(|end| graph.poses()[end].position());
            let gap = nalgebra::center(&a, &b);
            let is_same = |tried: &Point2<f64>| (gap - tried).length() < SAME_GAP;
            if self.errand.tried_gaps.iter().any(is_same) {
                continue;
            }
            if self.are_passable([a, b], now) {
                self.errand.tried_gaps.push(gap);
                let here = now.estimate.pose.position();
                self.errand.closing = Some(Closing::of(open, graph, here));
                (self.errand.failed_plans, self.errand.stuck) = (0, 0);
                return true;
            }
        }
        false
    }

    /// Plans to the next place of the drive; `false` where the robot has to stand.
    pub(super) fn plan_closing(&mut self, now: &Situation) -> bool {
        let here = now.estimate.pose.position();
        loop {
            let Some((closing, graph)) = self.errand.closing.as_mut().zip(now.graph) else {
                self.end_closing();
                return false;
            };
            let next = closing.places.last().and_then(|&at| graph.poses().get(at));
            let Some(goal) = next.filter(|_| graph.is_loop_open(&closing.open)) else {
                self.end_closing();
                return false;
            };
            let goal = goal.position();
            if (goal - here).length() < IS_THERE {
                closing.places.pop();
                continue;
            }
            return match self.route_to(goal, Unknown::Blocked, now) {
                Ok(()) => true,
                Err(reason @ NoPath::StartBlocked { .. })
                    if self.errand.failed_plans < PLAN_ATTEMPTS =>
                {
                    self.wriggle_free(reason, now);
                    false
                }
                Err(_) => {
                    self.end_closing();
                    false
                }
            };
        }
    }

    /// The place has been driven to.
    pub(super) fn close_further(&mut self) {
        if let Some(closing) = &mut self.errand.closing {
            closing.places.pop();
        }
    }

    /// Explores as before.
    pub(super) fn end_closing(&mut self) {
        self.errand.closing = None;
        self.errand.empty_scans = 0;
        self.status = Status::Scanning;
    }

    /// Whether a short way leads from one to the other.
    fn are_passable(&self, [a, b]: [Point2<f64>; 2], now: &Situation) -> bool {
        let most = DETOUR * (a - b).length() + SPARE;
        let around = (0.5 * most / now.grid.resolution()) as i32 + 1;
        let [first, second] = [a, b].map(|end| CellRect::of(now.grid.cell_at(end)));
        let rect = first.around(second).grown(around);
        let keep = self.model.radius() + self.config.route.narrowest();
        let space = GridSpace::within(now.grid, rect, keep, Unknown::Blocked, &self.within(now));
        let [from, to] = [a, b].map(|end| space.escape(end, keep + ESCAPE_REACH));
        let Some((from, to)) = from.zip(to) else {
            return false;
        };
        let way = space.index_at(to).and_then(|to| {
            let wave = Wavefront::new(&space, from);
            wave.path_to(&space, to)
        });
        way.is_some_and(|way| way.length() <= most)
    }
}
