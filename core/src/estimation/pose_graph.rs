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

pub use self::edge::{Edge, Kernel, information_at_end};

/// Poses and motions between them.
#[derive(Clone, Debug, Default)]
pub struct PoseGraph {
    poses: Vec<Pose2>,
    edges: Vec<Edge>,
}

/// How an optimisation went.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GraphReport {
    /// Σ χ² of all edges before, without kernels.
    pub chi2_before: f64,
    /// The same afterwards.
    pub chi2: f64,
    /// Steps taken.
    pub iterations: usize,
    /// Whether the last step no longer mattered.
    pub converged: bool,
}

/// Why a graph cannot take an edge.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum GraphError {
    /// An end that does not exist, or both ends the same.
    #[error("edge from pose {from} to pose {to}: expected two different poses below {poses}")]
    Ends {
        /// Start.
        from: usize,
        /// End.
        to: usize,
        /// Number of poses.
        poses: usize,
    },
    /// A number that is not finite.
    #[error("edge from pose {from} to pose {to}: expected finite numbers")]
    NotFinite {
        /// Start.
        from: usize,
        /// End.
        to: usize,
    },
}

impl PoseGraph {
    /// Adds a pose and returns its number.
    pub fn add_pose(&mut self, pose: Pose2) -> usize {
        self.poses.push(pose);
        self.poses.len() - 1
    }

    /// Adds a measured motion.
    ///
    /// # Errors   [`GraphError`], naming the edge.
    pub fn add_edge(&mut self, edge: Edge) -> Result<(), GraphError> {
        let (from, to, poses) = (edge.from, edge.to, self.poses.len());
        if from == to || from >= poses || to >= poses {
            return Err(GraphError::Ends { from, to, poses });
        }
        if !edge.motion.is_finite() || edge.information.iter().any(|v| !v.is_finite()) {
            return Err(GraphError::NotFinite { from, to });
        }
        self.edges.push(edge);
        Ok(())
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
    #[must_use]
    pub fn chi2_of(&self, edge: &Edge) -> f64 {
        let (Some(from), Some(to)) = (self.poses.get(edge.from), self.poses.get(edge.to)) else {
            return 0.0;
        };
        let error = edge.error(from, to);
        error.dot(&(edge.information * error))
    }

    /// Σ χ² of all edges, without kernels.
    #[must_use]
    pub fn chi2(&self) -> f64 {
        self.edges.iter().map(|edge| self.chi2_of(edge)).sum()
    }

    /// Moves the poses to the least cost, in at most `max_iterations` steps.
    pub fn optimize(&mut self, max_iterations: usize) -> GraphReport {
        let chi2_before = self.chi2();
        let mut report = GraphReport {
            chi2_before,
            chi2: chi2_before,
            iterations: 0,
            converged: true,
        };
        if self.poses.len() < 2 || self.edges.is_empty() {
            return report;
        }
        let pattern = self.pattern();
        let mut cost = self.cost();
        let mut damping = 1e-8;
        report.converged = false;
        while report.iterations < max_iterations && damping < 1e8 {
            report.iterations += 1;
            let (matrix, gradient) = self.normal_equations(&pattern);
            let mut damped = matrix.clone();
            pattern.damp(&mut damped, damping);
            if !pattern.factor(&mut damped) {
                damping = (damping * 10.0).max(1e-6);
                continue;
            }
            let mut step = gradient;
            pattern.solve(&damped, &mut step);
            let before = self.poses.clone();
            let mut largest = 0.0_f64;
            for (pose, d) in self.poses.iter_mut().skip(1).zip(&step) {
                *pose = Pose2::new(pose.x() - d.x, pose.y() - d.y, pose.heading() - d.z);
                largest = largest.max(d.amax());
            }
            let after = self.cost();
            if after.is_finite() && after <= cost {
                damping = (damping * 0.1).max(1e-10);
                let gain = cost - after;
                cost = after;
                if gain <= 1e-9 * cost || largest < 1e-8 {
                    report.converged = true;
                    break;
                }
            } else {
                self.poses = before;
                if largest < 1e-8 {
                    report.converged = true;
                    break;
                }
                damping = (damping * 10.0).max(1e-6);
            }
        }
        report.chi2 = self.chi2();
        report
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
            .map(|edge| edge.kernel.of(self.chi2_of(edge)).0)
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
            let (_, weight) = edge.kernel.of(error.dot(&(edge.information * error)));
            let information = edge.information * weight;
            let (from, to) = (edge.from.checked_sub(1), edge.to.checked_sub(1));
            let by_error = information * error;
            if let Some(i) = from {
                pattern.add(
                    &mut matrix,
                    i,
                    i,
                    &(by_from.transpose() * information * by_from),
                );
                gradient[i] += by_from.transpose() * by_error;
            }
            if let Some(j) = to {
                pattern.add(
                    &mut matrix,
                    j,
                    j,
                    &(by_to.transpose() * information * by_to),
                );
                gradient[j] += by_to.transpose() * by_error;
            }
            if let (Some(i), Some(j)) = (from, to) {
                pattern.add(
                    &mut matrix,
                    i,
                    j,
                    &(by_from.transpose() * information * by_to),
                );
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
