//! Covariances of poses, and of the motions between them.
//!
//! In: a graph. Out: covariances, from one factor of its normal equations.
//!
//! The motion from a to b is treated like an edge without a measurement: its covariance is [Jₐ J_b]
//! Σ [Jₐ J_b]ᵀ, with Σ the joint covariance of both. From one pose to all others, Σ needs three
//! solutions, which give a column of the inverse, and the inverse's diagonal blocks.

use std::sync::{Arc, OnceLock};

use nalgebra::{Matrix3, Vector3};

use super::linear::{Gradient, State, Terms};
use super::{Edge, PoseGraph};
use crate::estimation::block_cholesky::{BlockFactor, BlockPattern};
use crate::geom::{Pose2, symmetrize};

/// Covariances of the poses of a graph as it was at the time of the query; the first pose is exact.
#[derive(Clone, Debug)]
pub struct Marginals {
    pattern: Arc<BlockPattern>,
    factor: BlockFactor,
    poses: Vec<Pose2>,
    /// For each pose but the first, once all are needed.
    own: OnceLock<Vec<Matrix3<f64>>>,
}

impl Marginals {
    pub(super) fn of(graph: &PoseGraph) -> Option<Self> {
        let pattern = graph.pattern();
        let terms = Terms::new(&graph.edges, &pattern);
        let states: Vec<State> = graph.poses.iter().map(State::from).collect();
        let mut matrix = pattern.zeros(None);
        terms.linearise(&states, &mut Gradient::default(), Some(&mut matrix));
        let factor = pattern.factor(matrix, 0.0)?;
        Some(Self {
            pattern,
            factor,
            poses: graph.poses.clone(),
            own: OnceLock::new(),
        })
    }

    /// Covariance of (x, y, θ) of a pose, in the frame of the graph; `None` if there is no such
    /// pose.
    ///
    /// # Units    m², m·rad, rad².
    #[must_use]
    pub fn cov(&self, pose: usize) -> Option<Matrix3<f64>> {
        if pose >= self.poses.len() {
            return None;
        }
        let Some(block) = pose.checked_sub(1) else {
            return Some(Matrix3::zeros());
        };
        if let Some(own) = self.own.get() {
            return own.get(block).copied();
        }
        let mut cov = row(&self.columns(&[(Some(block), Matrix3::identity())]), block);
        symmetrize(&mut cov);
        Some(cov)
    }

    /// Covariance of (x, y, θ) of the motion `from_from_to`, in the frame of `from`; `None` if one
    /// of them does not exist.
    ///
    /// [`information_at_end`](super::information_at_end) of its inverse is the information of an
    /// equivalent [`Edge`].
    ///
    /// # Units    m², m·rad, rad².
    #[must_use]
    pub fn relative_cov(&self, from: usize, to: usize) -> Option<Matrix3<f64>> {
        let (at_from, at_to) = (self.poses.get(from)?, self.poses.get(to)?);
        if from == to {
            return Some(Matrix3::zeros());
        }
        let (by_from, by_to) = unmeasured(from, to).jacobians(at_from, at_to);
        let ends = [(from.checked_sub(1), by_from), (to.checked_sub(1), by_to)];
        // Σ Jᵀ needs three solutions; the blocks of Σ would need nine.
        let columns = self.columns(&ends);
        let by_end = ends.map(|(block, by)| {
            block.map_or_else(Matrix3::zeros, |block| by * row(&columns, block))
        });
        let mut cov = by_end[0] + by_end[1];
        symmetrize(&mut cov);
        Some(cov)
    }

    /// [`Self::relative_cov`] from one pose to each, itself included; empty if there is no such
    /// pose. All of them cost little more than two.
    #[must_use]
    pub fn relative_covs(&self, from: usize) -> Vec<Matrix3<f64>> {
        let invert = || self.pattern.inverse_diagonal(&self.factor);
        self.own.get_or_init(invert);
        let Some(own_from) = self.cov(from) else {
            return vec![];
        };
        let columns = self.columns(&[(from.checked_sub(1), Matrix3::identity())]);
        let relative = |to: usize| {
            let block = to.checked_sub(1);
            let cross = block.map(|block| row(&columns, block).transpose());
            let own_to = self.cov(to)?;
            Some(self.relative(from, to, own_from, own_to, &cross.unwrap_or_default()))
        };
        (0..self.poses.len()).filter_map(relative).collect()
    }

    fn relative(
        &self,
        from: usize,
        to: usize,
        own_from: Matrix3<f64>,
        own_to: Matrix3<f64>,
        cross: &Matrix3<f64>,
    ) -> Matrix3<f64> {
        if from == to {
            return Matrix3::zeros();
        }
        let (by_from, by_to) = unmeasured(from, to).jacobians(&self.poses[from], &self.poses[to]);
        let both = by_from * cross * by_to.transpose();
        let mut cov = by_from * own_from * by_from.transpose()
            + by_to * own_to * by_to.transpose()
            + both
            + both.transpose();
        symmetrize(&mut cov);
        cov
    }

    /// Σ Jᵀ, a column for each row of J, which is zero except for these blocks; the first pose is
    /// fixed and has none.
    fn columns(&self, blocks: &[(Option<usize>, Matrix3<f64>)]) -> [Vec<Vector3<f64>>; 3] {
        [0, 1, 2].map(|axis| {
            let mut column = vec![Vector3::zeros(); self.pattern.size()];
            for (block, by) in blocks {
                if let Some(block) = block.and_then(|block| column.get_mut(block)) {
                    *block = by.row(axis).transpose();
                }
            }
            self.pattern.solve(&self.factor, &mut column);
            column
        })
    }
}

/// An edge of which only the two ends matter.
fn unmeasured(from: usize, to: usize) -> Edge {
    Edge {
        from,
        to,
        motion: Pose2::identity(),
        information: Matrix3::identity(),
        cauchy: None,
    }
}

/// The block of some columns at a row of blocks.
fn row(columns: &[Vec<Vector3<f64>>; 3], block: usize) -> Matrix3<f64> {
    Matrix3::from_columns(&[0, 1, 2].map(|axis: usize| columns[axis][block]))
}
