//! Poses that agree best with measured motions between them.
//!
//! In: first guesses of poses, and edges: a measured motion from one to another with its
//! information and a robust kernel. Out: the poses of least cost. The first pose stays where it is.
//!
//! 1. The error of an edge is z⁻¹ x_i⁻¹ x_j as (x, y, θ), z the measured motion (g2o's SE2 edge).
//! 2. Levenberg-Marquardt: the normal equations are solved by [`BlockPattern`], damped until the
//!    cost falls.
//! 3. A robust kernel weighs each edge by its own χ (iteratively re-weighted least squares), so
//!    that one false loop closure does not bend the map.
//!
//! Source: Grisetti et al. (2010), "A tutorial on graph-based SLAM"; Kümmerle et al. (2011), "g2o".

mod edge;
#[cfg(test)]
mod tests;

use nalgebra::{Matrix3, Vector3};

use super::block_cholesky::{BlockMatrix, BlockPattern};
use crate::geom::{Pose2, symmetrize, wrap};

pub use self::edge::{Edge, information_at_end};

/// Poses and motions between them.
#[derive(Clone, Debug, Default)]
pub struct PoseGraph {
    poses: Vec<Pose2>,
    edges: Vec<Edge>,
}

/// Damping of the first step: next to none.
const FIRST_DAMPING: f64 = 1e-8;
/// Damping never falls below this.
const LEAST_DAMPING: f64 = 1e-10;
/// After a step that made it worse, damping grows tenfold and to at least this.
const RAISED_DAMPING: f64 = 1e-6;
/// With more damping than this no step leads anywhere.
const MOST_DAMPING: f64 = 1e8;
/// A step that gains less than this part of the cost is the last one.
const LEAST_GAIN: f64 = 1e-9;
/// A step that moves no pose by more than this, m and rad, is the last one.
const LEAST_STEP: f64 = 1e-8;

impl PoseGraph {
    /// Adds a pose and returns its number.
    pub fn add_pose(&mut self, pose: Pose2) -> usize {
        self.poses.push(pose);
        self.poses.len() - 1
    }

    /// Adds a measured motion; `false` where an end does not exist, both ends are the same, or a
    /// number is not finite.
    pub fn add_edge(&mut self, edge: Edge) -> bool {
        let poses = self.poses.len();
        let joins_two = edge.from != edge.to && edge.from.max(edge.to) < poses;
        let is_finite = edge.motion.is_finite() && edge.information.iter().all(|v| v.is_finite());
        if joins_two && is_finite {
            self.edges.push(edge);
        }
        joins_two && is_finite
    }

    /// The poses.
    #[must_use]
    pub fn poses(&self) -> &[Pose2] {
        &self.poses
    }

    /// The measured motions.
    #[must_use]
    pub fn edges(&self) -> &[Edge] {
        &self.edges
    }

    /// χ² of one edge.
    fn chi2_of(&self, edge: &Edge) -> f64 {
        let (Some(from), Some(to)) = (self.poses.get(edge.from), self.poses.get(edge.to)) else {
            return 0.0;
        };
        let error = edge.error(from, to);
        error.dot(&(edge.information * error))
    }

    /// Moves the poses to the least cost, in at most `max_iterations` steps. Returns whether the
    /// last step no longer mattered.
    pub fn optimize(&mut self, max_iterations: usize) -> bool {
        if self.poses.len() < 2 || self.edges.is_empty() {
            return true;
        }
        let pattern = self.pattern();
        let mut cost = self.cost();
        let mut damping = FIRST_DAMPING;
        let raised = |damping: f64| (damping * 10.0).max(RAISED_DAMPING);
        for _ in 0..max_iterations {
            if damping >= MOST_DAMPING {
                break;
            }
            let (matrix, gradient) = self.normal_equations(&pattern);
            let mut damped = matrix.clone();
            pattern.damp(&mut damped, damping);
            if !pattern.factor(&mut damped) {
                damping = raised(damping);
                continue;
            }
            let mut step = gradient;
            pattern.solve(&damped, &mut step);
            let before = self.poses.clone();
            let mut largest = 0.0_f64;
            for (pose, d) in self.poses.iter_mut().skip(1).zip(&step) {
                *pose = pose.plus(&-d);
                largest = largest.max(d.amax());
            }
            let after = self.cost();
            let is_better = after.is_finite() && after <= cost;
            let gain = cost - after;
            if is_better {
                damping = (damping * 0.1).max(LEAST_DAMPING);
                cost = after;
            } else {
                self.poses = before;
                damping = raised(damping);
            }
            if largest < LEAST_STEP || (is_better && gain <= LEAST_GAIN * cost) {
                return true;
            }
        }
        false
    }

    /// Covariance of (x, y, θ) of a pose against the first one; `None` where the graph does not
    /// hold it.
    #[must_use]
    pub fn marginal(&self, pose: usize) -> Option<Matrix3<f64>> {
        if pose >= self.poses.len() {
            return None;
        }
        if pose == 0 {
            return Some(Matrix3::zeros());
        }
        let pattern = self.pattern();
        let (mut matrix, _) = self.normal_equations(&pattern);
        if !pattern.factor(&mut matrix) {
            return None;
        }
        let mut cov = Matrix3::zeros();
        for axis in 0..3 {
            let mut unit = vec![Vector3::zeros(); self.poses.len() - 1];
            unit[pose - 1][axis] = 1.0;
            pattern.solve(&matrix, &mut unit);
            cov.set_column(axis, &unit[pose - 1]);
        }
        symmetrize(&mut cov);
        Some(cov)
    }

    /// Pose i is block i - 1: the first pose is fixed.
    fn pattern(&self) -> BlockPattern {
        let pairs = self
            .edges
            .iter()
            .filter_map(|e| Some((e.from.checked_sub(1)?, e.to.checked_sub(1)?)));
        BlockPattern::new(self.poses.len() - 1, pairs)
    }

    fn cost(&self) -> f64 {
        self.edges
            .iter()
            .map(|edge| edge.robust(self.chi2_of(edge)).0)
            .sum()
    }

    fn normal_equations(&self, pattern: &BlockPattern) -> (BlockMatrix, Vec<Vector3<f64>>) {
        let mut matrix = pattern.zeros();
        let mut gradient = vec![Vector3::zeros(); self.poses.len() - 1];
        for edge in &self.edges {
            let (Some(from), Some(to)) = (self.poses.get(edge.from), self.poses.get(edge.to))
            else {
                continue;
            };
            let error = edge.error(from, to);
            let (by_from, by_to) = edge.jacobians(from, to);
            let (_, weight) = edge.robust(error.dot(&(edge.information * error)));
            let information = edge.information * weight;
            let (from, to) = (edge.from.checked_sub(1), edge.to.checked_sub(1));
            let by_error = information * error;
            let (from_t, to_t) = (by_from.transpose(), by_to.transpose());
            if let Some(i) = from {
                pattern.add(&mut matrix, i, i, &(from_t * information * by_from));
                gradient[i] += from_t * by_error;
            }
            if let Some(j) = to {
                pattern.add(&mut matrix, j, j, &(to_t * information * by_to));
                gradient[j] += to_t * by_error;
            }
            if let (Some(i), Some(j)) = (from, to) {
                pattern.add(&mut matrix, i, j, &(from_t * information * by_to));
            }
        }
        (matrix, gradient)
    }
}

/// Whether two poses differ by more than the given shift or turn.
#[must_use]
pub(super) fn differs(a: &Pose2, b: &Pose2, shift: f64, turn: f64) -> bool {
    (a.position() - b.position()).norm() > shift || wrap(a.heading() - b.heading()).abs() > turn
}
