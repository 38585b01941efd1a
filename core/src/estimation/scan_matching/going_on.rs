//! A run that goes on in a map of earlier runs.
//!
//! In: a restored map, and what is known of where the robot is. Out: a matcher that takes scans,
//! and whose map grows where there was nothing.
//!
//! 1. Submaps that newer ones cover are removed from the map (`pruning`). The submap of the last
//!    run is closed and the next one begun: at the robot's place, if that is known. If the robot
//!    stands where it was left, that submap is seeded with what was seen last, and the first scan
//!    has to confirm it (`as_left`).
//! 2. Otherwise the robot maps a piece of its own in a separate frame. The piece is tied to the map
//!    by an edge that says only that it lies somewhere in it. So each submap of the piece is
//!    searched for in the whole map and in all directions, and a place is accepted with the proof
//!    required at such a doubt (`closures`).
//! 3. Once a place is proved, the piece is moved there as a whole, rigidly, and the closures become
//!    edges: from then on it is one map. The optimisation alone would not turn a piece round.
//!
//! Until then the grid shows the piece alone, and the estimate is given in its frame: a pilot can
//! go on, and the map is not corrupted. A piece that was never placed is dropped when the next run
//! begins.

use std::borrow::Cow;
use std::f64::consts::PI;

use nalgebra::{Matrix3, Point2};

use super::super::free_space::FreeSpace;
use super::super::pose_graph::{Edge, information_at_end};
use super::super::submap::Doubt;
use super::closures::{Candidate, places_proof};
use super::{Gathering, ScanMatcher};
use crate::geom::{Pose2, PoseEstimate, pose_cov};
use crate::map::{Grid, SurfelMap};
use crate::points::Points;
use crate::robot::Stamp;

/// Where the robot is when a run goes on in a map.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Start {
    /// The run was paused: it goes on as if it had not been.
    Paused,
    /// Where it was left; if it sees something else there, anywhere.
    #[default]
    Left,
    /// Near this pose (`map_from_robot`): to half a metre and 17°, one standard deviation.
    At(Pose2),
    /// Nothing is known.
    Anywhere,
}

/// What was mapped since the run began, while its place in the map is unknown.
#[derive(Clone, Debug)]
pub(super) struct Piece {
    /// Its first submap; all later ones belong to it too.
    pub(super) first: usize,
    /// The grid of the map, while that of the piece is shown; `None` if it has to be redrawn.
    pub(super) aside: Option<Grid>,
}

/// Uncertainty of a start given by a person, m and rad.
const START_SIGMA: f64 = 0.5;
const START_TURN_SIGMA: f64 = 0.3;
/// Uncertainty of a robot that stands where it was left, m and rad.
const LEFT_SIGMA: f64 = 0.1;
const LEFT_TURN_SIGMA: f64 = 0.1;
/// The time between runs, µs.
pub(super) const BETWEEN_RUNS: u64 = 1_000_000;
/// A map is never assumed to be smaller than this, m.
const LEAST_EXTENT: f64 = 5.0;

impl ScanMatcher {
    /// Goes on in the existing map.
    pub fn go_on(&mut self, start: Start) {
        if start == Start::Paused {
            return;
        }
        self.drop_piece();
        self.finish();
        if self.keyframes.is_empty() {
            return;
        }
        self.prune();
        self.begin_run();
        match start {
            Start::Paused => {}
            Start::Left => {
                self.is_new_run = true;
                self.is_blind = true;
                self.local.cov = pose_cov(LEFT_SIGMA, LEFT_TURN_SIGMA);
            }
            Start::At(map_from_robot) => {
                let cov = pose_cov(START_SIGMA, START_TURN_SIGMA);
                self.begin_apart(map_from_robot, cov);
            }
            Start::Anywhere => self.begin_piece(),
        }
    }

    /// Whether it is known where in the map the robot is. This is not so while a run that goes on
    /// in a saved map has not found its place.
    #[must_use]
    pub fn is_placed(&self) -> bool {
        self.unplaced.is_none()
    }

    /// Forgets what only the last run could know.
    fn begin_run(&mut self) {
        self.pending = None;
        self.gathering = Gathering::default();
        let model = std::mem::take(&mut self.motion).model;
        self.motion.model = model;
        self.last_keyframe = None;
        self.is_blind = false;
        self.local = PoseEstimate::exact(self.local.pose);
        // Set when the first scan tells the shift.
        self.stamp_shift = None;
    }

    /// The points with a stamp later than those of earlier runs.
    pub(super) fn in_order<'a>(&mut self, points: &'a Points) -> Cow<'a, Points> {
        let trajectory = &self.trajectory;
        let shift = self.stamp_shift.get_or_insert_with(|| {
            let last = trajectory.iter().map(|t| t.stamp.0).max();
            let is_later = last.is_none_or(|last| points.stamp.0 > last);
            let least = last.map_or(0, |last| last.saturating_add(BETWEEN_RUNS));
            if is_later { 0 } else { least - points.stamp.0 }
        });
        match *shift {
            0 => Cow::Borrowed(points),
            shift => Cow::Owned(Points {
                stamp: Stamp(points.stamp.0.saturating_add(shift)),
                ..points.clone()
            }),
        }
    }

    /// Makes the last submap, in which nothing is mapped yet, the first of a separate piece.
    pub(super) fn begin_piece(&mut self) {
        let cov = pose_cov(self.extent(), PI);
        self.begin_apart(Pose2::identity(), cov);
        let piece = Piece {
            first: self.submaps.len() - 1,
            aside: None,
        };
        let Ok(grid) = Grid::new(self.config.grid) else {
            return;
        };
        self.redraw = None;
        self.unplaced = Some(Piece {
            aside: Some(std::mem::replace(&mut self.grid, grid)),
            ..piece
        });
        self.grid_version += 1;
        self.submap_cov = Matrix3::zeros();
    }

    /// Begins the last submap, in which nothing is mapped yet, at `map_from_submap` with covariance
    /// `cov`; it takes nothing over.
    fn begin_apart(&mut self, map_from_submap: Pose2, cov: Matrix3<f64>) {
        let last = self.submaps.len() - 1;
        self.running = SurfelMap::new(self.config.surfels);
        self.running_free = FreeSpace::default();
        self.recent.clear();
        self.is_blind = false;
        self.local = PoseEstimate::exact(Pose2::identity());
        self.way_cov = Matrix3::zeros();
        self.submap_cov = cov;
        if let Some(submap) = self.submaps.last_mut() {
            submap.map_from_submap = map_from_submap;
            submap.drawn_at = map_from_submap;
            submap.is_loose = true;
        }
        self.graph.set_pose(last, map_from_submap);
        self.join_loosely(last, cov);
    }

    /// Joins a submap to the one before it at their current relative pose, with covariance `cov`.
    pub(super) fn join_loosely(&mut self, submap: usize, cov: Matrix3<f64>) {
        let joins = |edge: &Edge| edge.cauchy.is_none() && edge.from.max(edge.to) == submap;
        let edges = self.graph.edge_ids().iter().zip(self.graph.edges());
        let old: Vec<_> = edges.filter(|(_, e)| joins(e)).map(|(id, _)| *id).collect();
        for id in old {
            self.graph.remove_edge(id);
        }
        let Some(before) = submap.checked_sub(1) else {
            return;
        };
        let poses = self.graph.poses();
        let motion = poses[before].delta_to(&poses[submap]);
        let information = cov.try_inverse().unwrap_or_else(Matrix3::zeros);
        self.graph.add_edge(Edge {
            from: before,
            to: submap,
            motion,
            information: information_at_end(&motion, &information),
            cauchy: None,
        });
    }

    /// How far the submaps of the map extend from their centre, m.
    pub(super) fn extent(&self) -> f64 {
        let middles: Vec<Point2<f64>> = (self.submaps.iter())
            .filter(|submap| submap.own_keyframes > 0)
            .map(|submap| submap.map_from_submap * submap.closed.centre)
            .collect();
        let count = middles.len().max(1) as f64;
        let sum = middles
            .iter()
            .fold(Point2::origin(), |sum, m| sum + m.coords);
        let middle = sum / count;
        let squares: f64 = middles.iter().map(|m| (m - middle).norm_squared()).sum();
        let largest = self.submaps.iter().map(|s| s.closed.radius);
        (squares / count).sqrt() + largest.fold(LEAST_EXTENT, f64::max)
    }

    /// The evidence required for a place of which nothing is known.
    pub(super) fn asked_for_anywhere(&self) -> f64 {
        let doubt = Doubt {
            shift: self.extent(),
            turn: PI,
        };
        self.config.closure.proof * places_proof(&doubt)
    }

    /// Moves the piece to where the proved placements have it.
    pub(super) fn place_piece(&mut self, proved: &[Candidate]) {
        let Some(first) = self.unplaced.as_ref().map(|piece| piece.first) else {
            return;
        };
        let leads = (proved.iter()).filter(|c| c.old < first && c.new >= first);
        let best = leads.max_by(|a, b| a.closure.proof().total_cmp(&b.closure.proof()));
        let Some(Candidate {
            old, new, closure, ..
        }) = best
        else {
            return;
        };
        let poses = self.graph.poses();
        let map_from_piece = poses[*old] * closure.motion * poses[*new].inverse();
        let cov = pose_cov(self.extent(), PI);
        for (number, submap) in self.submaps.iter_mut().enumerate().skip(first) {
            submap.map_from_submap = map_from_piece * submap.map_from_submap;
            submap.drawn_at = submap.map_from_submap;
            self.graph.set_pose(number, submap.map_from_submap);
        }
        self.join_loosely(first, cov);
        self.show_as_one(first);
    }

    /// Shows the grid of the map together with what the piece has seen.
    fn show_as_one(&mut self, first: usize) {
        let aside = self.unplaced.take().and_then(|piece| piece.aside);
        let Some(mut grid) = aside else {
            self.redraw_at_once();
            return;
        };
        for keyframe in self.keyframes.iter().filter(|k| k.submap >= first) {
            let drawn_at = self.submaps[keyframe.submap].drawn_at;
            keyframe.draw(&mut grid, &(drawn_at * keyframe.submap_from_robot));
        }
        self.redraw = None;
        self.grid = grid;
        self.grid_version += 1;
        self.lay_walls();
    }

    /// Drops a piece that was never placed.
    pub(super) fn drop_piece(&mut self) {
        let Some(Piece { first, aside }) = self.unplaced.take() else {
            return;
        };
        let kept: Vec<bool> = (0..self.submaps.len()).map(|at| at < first).collect();
        self.edits.retain(|edit| edit.submap < first);
        self.keep_submaps(&kept);
        self.begin_anew_behind();
        match aside {
            Some(grid) => {
                self.redraw = None;
                self.grid = grid;
                self.grid_version += 1;
            }
            None => self.redraw_at_once(),
        }
    }

    /// The number of the first keyframe that is drawn.
    pub(super) fn first_drawn(&self) -> usize {
        let first = self.unplaced.as_ref().map_or(0, |piece| piece.first);
        self.keyframes.partition_point(|k| k.submap < first)
    }

    /// The covariance of the running submap relative to submap `origin`.
    pub(super) fn cov_of_running(&self, origin: usize) -> Option<Matrix3<f64>> {
        let last = self.submaps.len() - 1;
        match origin {
            0 => self.graph.marginal(last),
            _ if origin == last => Some(Matrix3::zeros()),
            _ => {
                let turned = self.submaps[origin].map_from_submap.rotation();
                let cov = self.graph.relative_cov(origin, last)?;
                Some(turned * cov * turned.transpose())
            }
        }
    }
}

#[cfg(test)]
mod tests;
