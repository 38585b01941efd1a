//! Poses that agree best with measured motions between them.
//!
//! In: first guesses of poses, and edges: a measured motion from one to another with its information and a robust
//! kernel. Out: the poses of least cost. The first pose stays where it is.
//!
//! 1. The error of an edge is z⁻¹ x_i⁻¹ x_j as (x, y, θ), z the measured motion (g2o's SE2 edge).
//! 2. Levenberg-Marquardt: the normal equations are solved by [`BlockPattern`], damped until the cost falls.
//! 3. A robust kernel weighs each edge by its own χ (iteratively re-weighted least squares), so that one false loop
//!    closure does not bend the map.
//!
//! Source: Grisetti et al. (2010), "A tutorial on graph-based SLAM"; Kümmerle et al. (2011), "g2o".

use nalgebra::{Matrix3, Vector3};

use super::block_cholesky::{BlockMatrix, BlockPattern};
use crate::geom::{Pose2, symmetrize, wrap};

/// How much an edge of a large error is doubted; parameters in units of χ, the normalised error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kernel {
    /// Not at all.
    None,
    /// Quadratic up to `k`, linear beyond.
    Huber {
        /// Where it becomes linear.
        k: f64,
    },
    /// Logarithmic beyond about `c`.
    Cauchy {
        /// Where doubt begins.
        c: f64,
    },
}

/// A measured motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Edge {
    /// The pose it starts from.
    pub from: usize,
    /// The pose it leads to.
    pub to: usize,
    /// `from_from_to`, as measured.
    pub motion: Pose2,
    /// Inverse of the covariance of the error, in the frame of the measured `to`.
    pub information: Matrix3<f64>,
    /// How it is doubted.
    pub kernel: Kernel,
}

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

impl Kernel {
    /// ρ(χ²) and ρ'(χ²).
    fn of(self, chi2: f64) -> (f64, f64) {
        match self {
            Self::None => (chi2, 1.0),
            Self::Huber { k } => {
                let chi = chi2.sqrt();
                if chi <= k {
                    (chi2, 1.0)
                } else {
                    (2.0 * k * chi - k * k, k / chi)
                }
            }
            Self::Cauchy { c } => {
                let scaled = chi2 / (c * c);
                (c * c * libm::log(1.0 + scaled), 1.0 / (1.0 + scaled))
            }
        }
    }
}

impl Edge {
    fn error(&self, from: &Pose2, to: &Pose2) -> Vector3<f64> {
        let off = self.motion.delta_to(&from.delta_to(to));
        Vector3::new(off.x(), off.y(), off.heading())
    }

    /// Derivatives of the error by (x, y, θ) of the start and of the end.
    fn jacobians(&self, from: &Pose2, to: &Pose2) -> (Matrix3<f64>, Matrix3<f64>) {
        // Rzᵀ Rᵢᵀ is a turn by minus both headings.
        let (cos, sin) = (*from * self.motion).cos_sin();
        let (dx, dy) = (to.x() - from.x(), to.y() - from.y());
        let by_to = Matrix3::new(cos, sin, 0.0, -sin, cos, 0.0, 0.0, 0.0, 1.0);
        let mut by_from = -by_to;
        by_from[(0, 2)] = -sin * dx + cos * dy;
        by_from[(1, 2)] = -cos * dx - sin * dy;
        (by_from, by_to)
    }
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

    /// Keeps only the edges that `keep` wants.
    pub fn retain_edges(&mut self, keep: impl FnMut(&Edge) -> bool) {
        self.edges.retain(keep);
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

    /// Covariance of (x, y, θ) of a pose against the first one; `None` where the graph does not hold it.
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

/// The information of an error in the frame of the measured `to`, from one of (x, y, θ) of the motion itself.
#[must_use]
pub fn information_at_end(motion: &Pose2, information: &Matrix3<f64>) -> Matrix3<f64> {
    let (cos, sin) = motion.cos_sin();
    let turn = Matrix3::new(cos, -sin, 0.0, sin, cos, 0.0, 0.0, 0.0, 1.0);
    let mut turned = turn.transpose() * information * turn;
    symmetrize(&mut turned);
    turned
}

/// Whether two poses differ by more than the given shift or turn.
#[must_use]
pub(super) fn differs(a: &Pose2, b: &Pose2, shift: f64, turn: f64) -> bool {
    (a.position() - b.position()).norm() > shift || wrap(a.heading() - b.heading()).abs() > turn
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn edge(from: usize, to: usize, motion: Pose2) -> Edge {
        Edge {
            from,
            to,
            motion,
            information: Matrix3::identity() * 100.0,
            kernel: Kernel::None,
        }
    }

    fn pose() -> impl Strategy<Value = Pose2> {
        (-5.0..5.0_f64, -5.0..5.0_f64, -3.1..3.1_f64).prop_map(|(x, y, t)| Pose2::new(x, y, t))
    }

    proptest! {
        #[test]
        fn jacobians_match_central_differences(a in pose(), b in pose(), z in pose()) {
            let e = edge(0, 1, z);
            prop_assume!(e.error(&a, &b).z.abs() < 3.0);
            let (by_a, by_b) = e.jacobians(&a, &b);
            let h = 1e-6;
            for axis in 0..3 {
                let nudge = |p: &Pose2, h: f64| {
                    let mut d = [0.0; 3];
                    d[axis] = h;
                    Pose2::new(p.x() + d[0], p.y() + d[1], p.heading() + d[2])
                };
                let da = (e.error(&nudge(&a, h), &b) - e.error(&nudge(&a, -h), &b)) / (2.0 * h);
                let db = (e.error(&a, &nudge(&b, h)) - e.error(&a, &nudge(&b, -h))) / (2.0 * h);
                prop_assert!((da - by_a.column(axis)).norm() < 1e-6);
                prop_assert!((db - by_b.column(axis)).norm() < 1e-6);
            }
        }
    }

    /// A square walked twice around; motions exact, guesses not.
    fn square() -> (PoseGraph, Vec<Pose2>) {
        let truth: Vec<_> = (0..40)
            .scan(Pose2::identity(), |at, i| {
                let turn = if i % 5 == 4 {
                    std::f64::consts::FRAC_PI_2
                } else {
                    0.0
                };
                let here = *at;
                *at = *at * Pose2::new(1.0, 0.0, turn);
                Some(here)
            })
            .collect();
        let mut graph = PoseGraph::default();
        for (i, pose) in truth.iter().enumerate() {
            let off = Pose2::new(0.01 * i as f64, -0.02 * i as f64, 0.01 * i as f64);
            graph.add_pose(*pose * off);
        }
        graph.poses[0] = truth[0];
        for i in 1..40 {
            graph
                .add_edge(edge(i - 1, i, truth[i - 1].delta_to(&truth[i])))
                .unwrap();
        }
        for i in 20..40 {
            graph
                .add_edge(edge(i - 20, i, truth[i - 20].delta_to(&truth[i])))
                .unwrap();
        }
        (graph, truth)
    }

    #[test]
    fn consistent_motions_lead_to_the_truth() {
        let (mut graph, truth) = square();
        let report = graph.optimize(50);
        assert!(report.converged && report.chi2 < 1e-12, "{report:?}");
        for (found, truth) in graph.poses().iter().zip(&truth) {
            assert!(!differs(found, truth, 1e-6, 1e-6));
        }
    }

    #[test]
    fn a_false_closure_does_not_bend_a_map_of_robust_edges() {
        let (mut graph, truth) = square();
        let lie = Edge {
            kernel: Kernel::Cauchy { c: 1.0 },
            ..edge(3, 33, Pose2::new(4.0, 1.0, 2.0))
        };
        graph.add_edge(lie).unwrap();
        graph.optimize(100);
        for (found, truth) in graph.poses().iter().zip(&truth) {
            assert!(!differs(found, truth, 0.05, 0.05), "{found:?} {truth:?}");
        }
    }

    #[test]
    fn marginal_of_a_chain_is_the_composed_covariance() {
        let mut graph = PoseGraph::default();
        let step = Pose2::new(1.0, 0.2, 0.5);
        let mut at = Pose2::identity();
        let mut cov = Matrix3::zeros();
        graph.add_pose(at);
        for i in 0..4 {
            graph.add_pose(at * step);
            graph.add_edge(edge(i, i + 1, step)).unwrap();
            // First order: the error of the start is carried over, that of the step is turned into the map.
            let end = at * step;
            let (dx, dy) = (end.x() - at.x(), end.y() - at.y());
            let carry = Matrix3::new(1.0, 0.0, -dy, 0.0, 1.0, dx, 0.0, 0.0, 1.0);
            let (cos, sin) = end.cos_sin();
            let turn = Matrix3::new(cos, -sin, 0.0, sin, cos, 0.0, 0.0, 0.0, 1.0);
            cov = carry * cov * carry.transpose()
                + turn * (Matrix3::identity() / 100.0) * turn.transpose();
            at = end;
        }
        let marginal = graph.marginal(4).unwrap();
        assert!((marginal - cov).norm() < 1e-9, "{marginal} {cov}");
        assert_eq!(graph.marginal(0), Some(Matrix3::zeros()));
    }

    #[test]
    fn impossible_edges_are_refused() {
        let mut graph = PoseGraph::default();
        graph.add_pose(Pose2::identity());
        let message = graph
            .add_edge(edge(0, 3, Pose2::identity()))
            .unwrap_err()
            .to_string();
        assert_eq!(
            message,
            "edge from pose 0 to pose 3: expected two different poses below 1"
        );
        graph.add_pose(Pose2::identity());
        assert!(
            graph
                .add_edge(edge(0, 1, Pose2::new(f64::NAN, 0.0, 0.0)))
                .is_err()
        );
        assert_eq!(graph.optimize(5).iterations, 0);
    }

    #[test]
    fn what_is_not_in_the_graph_has_no_covariance() {
        for pose in 0..2 {
            assert_eq!(PoseGraph::default().marginal(pose), None);
        }
        let mut graph = PoseGraph::default();
        graph.add_pose(Pose2::identity());
        graph.add_pose(Pose2::identity());
        assert_eq!(graph.marginal(1), None, "no edge holds it");
        assert_eq!(graph.marginal(2), None);
    }

    fn start_from_tree(graph: &mut PoseGraph) {
        let mut done = vec![false; graph.poses.len()];
        let mut queue = std::collections::VecDeque::from([0]);
        done[0] = true;
        while let Some(at) = queue.pop_front() {
            for edge in &graph.edges {
                let (next, pose) = if edge.from == at {
                    (edge.to, graph.poses[at] * edge.motion)
                } else if edge.to == at {
                    (edge.from, graph.poses[at] * edge.motion.inverse())
                } else {
                    continue;
                };
                if !done[next] {
                    done[next] = true;
                    graph.poses[next] = pose;
                    queue.push_back(next);
                }
            }
        }
    }

    /// Published graphs: the cost that good solvers end at is a stationary point that no restart improves.
    #[test]
    fn public_graphs_converge_to_a_stationary_point() {
        for name in ["intel.g2o", "m3500.g2o"] {
            let Some(text) = crate::format::recorded(&format!("posegraphs/{name}")) else {
                continue;
            };
            let text = String::from_utf8(text).unwrap();
            let mut graph = PoseGraph::default();
            for line in text.lines() {
                let words: Vec<_> = line.split_ascii_whitespace().collect();
                let v: Vec<f64> = words[1..].iter().map(|w| w.parse().unwrap()).collect();
                match words[0] {
                    "VERTEX_SE2" => {
                        graph.add_pose(Pose2::new(v[1], v[2], v[3]));
                    }
                    "EDGE_SE2" => graph
                        .add_edge(Edge {
                            from: v[0] as usize,
                            to: v[1] as usize,
                            motion: Pose2::new(v[2], v[3], v[4]),
                            information: Matrix3::new(
                                v[5], v[6], v[7], v[6], v[8], v[9], v[7], v[9], v[10],
                            ),
                            kernel: Kernel::None,
                        })
                        .unwrap(),
                    _ => {}
                }
            }
            // The files start from raw odometry, which is turned by half a circle: start from the tree of fewest edges.
            start_from_tree(&mut graph);
            let report = graph.optimize(100);
            eprintln!("{name}: {report:?}");
            assert!(
                report.converged && report.chi2 < report.chi2_before,
                "{name} {report:?}"
            );
            let again = graph.optimize(20);
            assert!(
                report.chi2 - again.chi2 < 1e-6 * report.chi2,
                "{name}: {again:?}"
            );
        }
    }
}
