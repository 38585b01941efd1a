//! Poses that agree best with measured motions between them.
//!
//! In: initial poses, and edges: a measured motion from one pose to another with its information
//! and a robust kernel. Out: the poses of least cost, and their covariances. The first pose is
//! fixed.
//!
//! 1. The error of an edge is z⁻¹ x_i⁻¹ x_j as (x, y, θ), where z is the measured motion (g2o's SE2
//!    edge).
//! 2. Gauss-Newton from the present poses, Levenberg-Marquardt if that fails (`optimize`). The
//!    normal equations (`linear`) are solved by [`BlockPattern`], whose order is kept while the
//!    graph grows.
//! 3. A robust kernel weights each edge by its own χ (iteratively re-weighted least squares), so
//!    that one false loop closure does not bend the map.
//! 4. Covariances of poses and of motions between them are computed on request (`marginals`).
//!
//! Edges can be removed again: a loop closure that later ones contradict is revoked.
//!
//! Source: Grisetti et al. (2010), "A tutorial on graph-based SLAM"; Kümmerle et al. (2011), "g2o".

mod edge;
mod linear;
mod marginals;
mod open_loops;
mod optimize;
mod saved;
#[cfg(test)]
mod tests;

use std::sync::Arc;

use nalgebra::Matrix3;

use super::block_cholesky::BlockPattern;
use crate::geom::{Length, Pose2, wrap};

pub use self::edge::{Edge, information_at_end};
pub use self::marginals::Marginals;
pub use self::open_loops::OpenLoop;
pub use self::optimize::Optimization;

/// Poses and motions between them.
#[derive(Clone, Debug, Default)]
pub struct PoseGraph {
    poses: Vec<Pose2>,
    edges: Vec<Edge>,
    /// In the order of `edges`, ascending.
    ids: Vec<EdgeId>,
    next_id: usize,
    /// The pattern of the last time that the graph was solved.
    pattern: Arc<BlockPattern>,
}

/// The name of an edge in a graph: permanent, also after others were removed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct EdgeId(usize);

impl EdgeId {
    /// The name of an edge after its graph was appended to one that has used `by` names.
    pub(super) fn shifted(self, by: usize) -> Self {
        Self(self.0 + by)
    }
}

impl PoseGraph {
    /// Adds a pose and returns its number.
    pub fn add_pose(&mut self, pose: Pose2) -> usize {
        self.poses.push(pose);
        self.poses.len() - 1
    }

    /// Adds a measured motion; `None` if an end does not exist, both ends are the same, or a number
    /// is not finite.
    pub fn add_edge(&mut self, edge: Edge) -> Option<EdgeId> {
        let poses = self.poses.len();
        let joins_two = edge.from != edge.to && edge.from.max(edge.to) < poses;
        let is_finite = edge.motion.is_finite() && edge.information.iter().all(|v| v.is_finite());
        if !joins_two || !is_finite {
            return None;
        }
        let id = EdgeId(self.next_id);
        self.next_id += 1;
        self.edges.push(edge);
        self.ids.push(id);
        Some(id)
    }

    /// Removes an edge; `None` if it is no longer there. The poses stay unchanged until the next
    /// [`Self::optimize`].
    pub fn remove_edge(&mut self, id: EdgeId) -> Option<Edge> {
        let at = self.ids.binary_search(&id).ok()?;
        self.ids.remove(at);
        Some(self.edges.remove(at))
    }

    /// Puts an edge back under its old name. `None` if that name is in use, or in the cases of
    /// [`Self::add_edge`].
    pub(super) fn put_back(&mut self, id: EdgeId, edge: Edge) -> Option<EdgeId> {
        let at = self.ids.binary_search(&id).err()?;
        self.add_edge(edge)?;
        // Names ascend: move the edge from the end to its old place.
        self.ids.pop();
        self.edges.pop();
        self.ids.insert(at, id);
        self.edges.insert(at, edge);
        Some(id)
    }

    /// The graph of the poses that have a new number, under that number, and of the edges between
    /// them, which keep their names. The numbers must ascend.
    pub(super) fn kept(&self, numbers: &[Option<usize>]) -> Self {
        let number = |pose: usize| numbers.get(pose).copied().flatten();
        let poses = self.poses.iter().enumerate();
        let mut kept = Self {
            poses: poses
                .filter_map(|(at, pose)| number(at).map(|_| *pose))
                .collect(),
            next_id: self.next_id,
            ..Self::default()
        };
        for (edge, id) in self.edges.iter().zip(&self.ids) {
            if let (Some(from), Some(to)) = (number(edge.from), number(edge.to)) {
                kept.edges.push(Edge { from, to, ..*edge });
                kept.ids.push(*id);
            }
        }
        kept
    }

    /// Inserts another pose under this number; the numbers from there on increase by one.
    pub(super) fn let_in(&mut self, number: usize, pose: Pose2) {
        self.poses.insert(number.min(self.poses.len()), pose);
        for edge in &mut self.edges {
            edge.from += usize::from(edge.from >= number);
            edge.to += usize::from(edge.to >= number);
        }
        self.pattern = Arc::default();
    }

    /// Appends another graph; its edges are named from the returned number on.
    pub(super) fn append(&mut self, other: &Self) -> usize {
        let (poses, names) = (self.poses.len(), self.next_id);
        self.poses.extend(&other.poses);
        self.edges.extend(other.edges.iter().map(|edge| Edge {
            from: edge.from + poses,
            to: edge.to + poses,
            ..*edge
        }));
        self.ids
            .extend(other.ids.iter().map(|id| id.shifted(names)));
        self.next_id += other.next_id;
        names
    }

    /// Sets a pose; the edges stay unchanged.
    pub(super) fn set_pose(&mut self, number: usize, pose: Pose2) {
        if let Some(kept) = self.poses.get_mut(number) {
            *kept = pose;
        }
    }

    /// An edge; `None` if it is no longer there.
    #[must_use]
    pub fn edge(&self, id: EdgeId) -> Option<&Edge> {
        self.edges.get(self.ids.binary_search(&id).ok()?)
    }

    /// The poses.
    #[must_use]
    pub fn poses(&self) -> &[Pose2] {
        &self.poses
    }

    /// The measured motions, in the order in which they were added.
    #[must_use]
    pub fn edges(&self) -> &[Edge] {
        &self.edges
    }

    /// The names of the edges, in the order of [`Self::edges`].
    #[must_use]
    pub fn edge_ids(&self) -> &[EdgeId] {
        &self.ids
    }

    /// χ² of an edge at the present poses, without its kernel: with 3 degrees of freedom if its
    /// information is honest. `None` if the edge is no longer there.
    #[must_use]
    pub fn edge_chi2(&self, id: EdgeId) -> Option<f64> {
        self.edge(id).map(|edge| self.chi2_of(edge))
    }

    /// Σ χ² of all edges at the present poses, without their kernels.
    #[must_use]
    pub fn chi2(&self) -> f64 {
        self.edges.iter().map(|edge| self.chi2_of(edge)).sum()
    }

    /// χ² of any edge, in the graph or not, at the present poses.
    pub(super) fn chi2_of(&self, edge: &Edge) -> f64 {
        let (Some(from), Some(to)) = (self.poses.get(edge.from), self.poses.get(edge.to)) else {
            return 0.0;
        };
        let error = edge.error(from, to);
        error.dot(&(edge.information * error))
    }

    /// Covariances for any number of queries; `None` if not every pose is connected to the first
    /// one.
    ///
    /// Costs as much as a step of [`Self::optimize`].
    #[must_use]
    pub fn marginals(&self) -> Option<Marginals> {
        Marginals::of(self)
    }

    /// Covariance of (x, y, θ) of a pose relative to the first one; `None` if the graph does not
    /// determine it. [`Self::marginals`] answers several such queries at once.
    #[must_use]
    pub fn marginal(&self, pose: usize) -> Option<Matrix3<f64>> {
        if pose == 0 && !self.poses.is_empty() {
            return Some(Matrix3::zeros());
        }
        self.marginals()?.cov(pose)
    }

    /// Covariance of (x, y, θ) of the motion `from_from_to`, in the frame of `from`; `None` if the
    /// graph does not determine both. [`Self::marginals`] answers several such queries at once.
    #[must_use]
    pub fn relative_cov(&self, from: usize, to: usize) -> Option<Matrix3<f64>> {
        self.marginals()?.relative_cov(from, to)
    }

    /// The pattern of the normal equations, the previous one if it can still be used. Pose i is
    /// block i - 1: the first pose is fixed.
    fn pattern(&self) -> Arc<BlockPattern> {
        let pairs = self
            .edges
            .iter()
            .filter_map(|e| Some((e.from.checked_sub(1)?, e.to.checked_sub(1)?)));
        let size = self.poses.len().saturating_sub(1);
        let kept = &self.pattern;
        if kept.size() == size && pairs.clone().all(|(a, b)| kept.slot(a, b).is_some()) {
            Arc::clone(kept)
        } else {
            Arc::new(kept.grown(size, pairs))
        }
    }
}

/// Whether two poses differ by more than the given shift or turn.
#[must_use]
pub(super) fn differs(a: &Pose2, b: &Pose2, shift: f64, turn: f64) -> bool {
    (a.position() - b.position()).length() > shift || wrap(a.heading() - b.heading()).abs() > turn
}
