//! The normal equations of a graph, whose solution is one step of the optimisation.
//!
//! In: poses and edges. Out: cost, gradient and the matrix H = Σ Jᵀ Ω J.
//!
//! With R the rotation by the heading of the start and of the measured motion, d = x_j - x_i and
//!
//! ```text
//! W = Rᵀ Ω R    C = 1 + d⊥ e₃ᵀ    H_jj = W    H_ij = -Cᵀ W    H_ii = Cᵀ W C
//! ```
//!
//! the Jacobians of [`Edge`] need not be multiplied out. Headings are kept as numbers beside their
//! sine and cosine, so these are the only transcendental functions in a step.

use nalgebra::{Matrix3, Vector3};

use super::Edge;
use crate::estimation::block_cholesky::{BlockMatrix, BlockPattern, Slot};
use crate::geom::{Pose2, sin_cos, wrap};

/// A pose to be moved.
#[derive(Clone, Copy, Debug)]
pub(super) struct State {
    x: f64,
    y: f64,
    /// rad, not wrapped.
    heading: f64,
    sin: f64,
    cos: f64,
}

/// What stays constant of an edge from step to step and is not stored in it.
#[derive(Clone, Copy, Debug)]
struct Fixed {
    /// Heading of the measured motion, rad.
    heading: f64,
    /// Slots of the blocks at the start, at the end, and of both; none if the end is fixed.
    slots: [Option<Slot>; 3],
}

/// The edges of a graph, prepared for repeated evaluation.
#[derive(Clone, Debug)]
pub(super) struct Terms<'a> {
    edges: &'a [Edge],
    /// In the order of the edges.
    fixed: Vec<Fixed>,
}

/// The right side of H x = gradient.
#[derive(Clone, Debug, Default)]
pub(super) struct Gradient {
    /// Half of the gradient of the cost, for each pose but the first.
    pub(super) by_pose: Vec<Vector3<f64>>,
    /// Σ ρ(χ²).
    pub(super) cost: f64,
}

impl From<&Pose2> for State {
    fn from(pose: &Pose2) -> Self {
        let (cos, sin) = pose.cos_sin();
        Self {
            x: pose.x(),
            y: pose.y(),
            heading: pose.heading(),
            sin,
            cos,
        }
    }
}

impl State {
    /// The state minus a step (x, y, θ).
    pub(super) fn minus(&self, step: &Vector3<f64>) -> Self {
        let heading = self.heading - step.z;
        let (sin, cos) = sin_cos(heading);
        Self {
            x: self.x - step.x,
            y: self.y - step.y,
            heading,
            sin,
            cos,
        }
    }

    pub(super) fn pose(&self) -> Pose2 {
        Pose2::new(self.x, self.y, self.heading)
    }
}

/// The error of a term, and the rotation of its Jacobians.
struct Evaluated {
    error: Vector3<f64>,
    /// Sine and cosine of the heading expected at the end.
    sin: f64,
    cos: f64,
    shift: [f64; 2],
}

/// `heading` is that of the measured motion `z`.
#[inline(always)]
fn evaluate(z: &Pose2, heading: f64, from: &State, to: &State) -> Evaluated {
    let (cos, sin) = z.cos_sin();
    let [dx, dy] = [to.x - from.x, to.y - from.y];
    let ahead = from.cos * dx + from.sin * dy - z.x();
    let aside = from.cos * dy - from.sin * dx - z.y();
    let error = Vector3::new(
        cos * ahead + sin * aside,
        cos * aside - sin * ahead,
        wrap(to.heading - from.heading - heading),
    );
    Evaluated {
        error,
        sin: from.sin * cos + from.cos * sin,
        cos: from.cos * cos - from.sin * sin,
        shift: [dx, dy],
    }
}

impl<'a> Terms<'a> {
    pub(super) fn new(edges: &'a [Edge], pattern: &BlockPattern) -> Self {
        let slot = |a: usize, b: usize| pattern.slot(a.checked_sub(1)?, b.checked_sub(1)?);
        let fixed = |edge: &Edge| Fixed {
            heading: edge.motion.heading(),
            slots: [
                slot(edge.from, edge.from),
                slot(edge.to, edge.to),
                slot(edge.from, edge.to),
            ],
        };
        Self {
            edges,
            fixed: edges.iter().map(fixed).collect(),
        }
    }

    /// Σ ρ(χ²).
    pub(super) fn cost(&self, states: &[State]) -> f64 {
        let cost = |(edge, fixed): (&Edge, &Fixed)| {
            let (from, to) = (states.get(edge.from)?, states.get(edge.to)?);
            let error = evaluate(&edge.motion, fixed.heading, from, to).error;
            Some(robust(error.dot(&(edge.information * error)), edge.cauchy).0)
        };
        self.edges.iter().zip(&self.fixed).filter_map(cost).sum()
    }

    /// The gradient at these poses, and H, which is added to `matrix` if there is one.
    pub(super) fn linearise(
        &self,
        states: &[State],
        gradient: &mut Gradient,
        matrix: Option<&mut BlockMatrix>,
    ) {
        gradient.by_pose.clear();
        let moved = states.len().saturating_sub(1);
        gradient.by_pose.resize(moved, Vector3::zeros());
        gradient.cost = 0.0;
        match matrix {
            Some(matrix) => self.add_all(states, gradient, |fixed, by_edge| {
                for (slot, block) in fixed.slots.iter().zip(by_edge.blocks()) {
                    if let Some(slot) = *slot {
                        matrix.add(slot, &block);
                    }
                }
            }),
            None => self.add_all(states, gradient, |_, _| ()),
        }
    }

    #[inline(always)]
    fn add_all(
        &self,
        states: &[State],
        gradient: &mut Gradient,
        mut also: impl FnMut(&Fixed, &ByEdge),
    ) {
        let Gradient { by_pose, cost } = gradient;
        for (edge, fixed) in self.edges.iter().zip(&self.fixed) {
            let (Some(from), Some(to)) = (states.get(edge.from), states.get(edge.to)) else {
                continue;
            };
            let evaluated = evaluate(&edge.motion, fixed.heading, from, to);
            let by_error = edge.information * evaluated.error;
            let (own_cost, weight) = robust(evaluated.error.dot(&by_error), edge.cauchy);
            *cost += own_cost;
            let Evaluated {
                sin, cos, shift, ..
            } = evaluated;
            let turn = Matrix3::new(cos, -sin, 0.0, sin, cos, 0.0, 0.0, 0.0, 1.0);
            let by_edge = ByEdge {
                turn,
                information: edge.information * weight,
                shift,
            };
            let v = turn * (by_error * weight);
            // The first pose is fixed.
            if let Some(by_from) = edge.from.checked_sub(1).and_then(|at| by_pose.get_mut(at)) {
                *by_from -= Vector3::new(v.x, v.y, v.z + by_edge.lever(v.x, v.y));
            }
            if let Some(by_to) = edge.to.checked_sub(1).and_then(|at| by_pose.get_mut(at)) {
                *by_to += v;
            }
            also(fixed, &by_edge);
        }
    }
}

/// The contribution of an edge to H.
struct ByEdge {
    turn: Matrix3<f64>,
    /// Weighted by its kernel.
    information: Matrix3<f64>,
    shift: [f64; 2],
}

impl ByEdge {
    #[inline(always)]
    fn lever(&self, x: f64, y: f64) -> f64 {
        self.shift[0] * y - self.shift[1] * x
    }

    /// The blocks at the start, at the end, and of both.
    #[inline(always)]
    fn blocks(&self) -> [Matrix3<f64>; 3] {
        let w = self.turn * self.information * self.turn.transpose();
        // Cᵀ W, and Cᵀ W C.
        let mut cw = w;
        for column in 0..3 {
            cw[(2, column)] += self.lever(w[(0, column)], w[(1, column)]);
        }
        let mut cwc = cw;
        for row in 0..3 {
            cwc[(row, 2)] += self.lever(cw[(row, 0)], cw[(row, 1)]);
        }
        [cwc, w, -cw]
    }
}

/// ρ(χ²) and ρ'(χ²) of the Cauchy kernel: the cost of an error, and its weight.
#[inline(always)]
fn robust(chi2: f64, cauchy: Option<f64>) -> (f64, f64) {
    let Some(c) = cauchy else {
        return (chi2, 1.0);
    };
    let scaled = chi2 / (c * c);
    (c * c * libm::log(1.0 + scaled), 1.0 / (1.0 + scaled))
}
