//! Drives that close loops: through places that are next to each other in the map without the map
//! knowing yet that they are connected.
//!
//! In: the pose graph of a map in which nothing unknown is left, and its grid. Out: goals, one
//! after another.
//!
//! A loop is closed by a submap that shows both of its ends. The robot often has no such submap: it
//! stops as soon as nothing unknown is in sight, and the accumulated error of its whole way stays
//! in the gap.
//!
//! 1. An open loop of the graph ([`PoseGraph::open_loops`]) counts if a short way in the grid joins
//!    its ends: two corridors with a wall between them are no loop.
//! 2. The robot drives to the nearer end, on to the other end, and further along what it knows
//!    there, until the loop is closed, or [`FOLLOWS`] metres were driven.
//! 3. Each gap is tried once. What the map then shows as unknown is explored as before.
//!
//! Source: Stachniss, Hähnel & Burgard (2004), "Exploration with active loop-closing for FastSLAM".

use nalgebra::Point2;

use super::errand::PLAN_ATTEMPTS;
use super::{Pilot, Situation, Status};
use crate::estimation::{OpenLoop, PoseGraph};
use crate::geom::Length;
use crate::map::CellRect;
use crate::plan::{ESCAPE_REACH, GridSpace, NoPath, Unknown, Wavefront};

/// How far it drives through known places beyond the gap, m: two submaps.
const FOLLOWS: f64 = 10.0;
/// Poses farther apart than this do not follow each other in a drive, m.
const STEP: f64 = 6.0;
/// A way between the ends is at most this many times longer than the straight line, ...
const DETOUR: f64 = 2.0;
/// ... plus this, m.
const SPARE: f64 = 2.0;
/// Places nearer than this count as reached, m.
const IS_THERE: f64 = 0.5;
/// Gaps nearer than this to each other are the same gap, m.
const SAME_GAP: f64 = 4.0;

/// A drive that closes a loop.
#[derive(Clone, Debug)]
pub(super) struct Closing {
    open: OpenLoop,
    /// Poses of the graph still to be reached, the next one last.
    places: Vec<usize>,
}

impl Closing {
    /// A drive from `here` to the nearer end, to the other, and on.
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
    /// Whether everything is explored, and the robot drives through known places to close a loop.
    #[must_use]
    pub fn is_closing_loop(&self) -> bool {
        self.errand.closing.is_some()
    }

    /// Begins to close a loop; `false` if no untried loop is left.
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

    /// Plans to the next place of the drive; `false` if the robot has to stand.
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

    /// Called when the place has been reached.
    pub(super) fn close_further(&mut self) {
        if let Some(closing) = &mut self.errand.closing {
            closing.places.pop();
        }
    }

    /// Returns to exploring.
    pub(super) fn end_closing(&mut self) {
        self.errand.closing = None;
        self.errand.empty_scans = 0;
        self.status = Status::Scanning;
    }

    /// Whether a short way leads between the two points.
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
