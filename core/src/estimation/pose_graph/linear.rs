//! The normal equations of a graph: in them a step of the optimisation is linear.
//!
//! In: poses and edges. Out: cost, gradient and the matrix H = Σ Jᵀ Ω J.
//!
//! With R the turn by the heading of the start and of the measured motion, d = x_j - x_i and
//!
//! ```text
//! W = Rᵀ Ω R    C = 1 + d⊥ e₃ᵀ    H_jj = W    H_ij = -Cᵀ W    H_ii = Cᵀ W C
//! ```
//!
//! the Jacobians of [`Edge`] need not be multiplied out. Headings are kept as numbers beside their
//! sine and cosine, which then are all the transcendental functions that a step costs.

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

/// An edge with all that does not change from step to step.
#[derive(Clone, Copy, Debug)]
struct Term {
    from: usize,
    to: usize,
    motion: State,
    information: Matrix3<f64>,
    cauchy: Option<f64>,
    /// Of the blocks at the start, at the end, and of both; none where the end is fixed.
    slots: [Option<Slot>; 3],
}

/// The edges of a graph, ready to be evaluated often.
#[derive(Clone, Debug)]
pub(super) struct Terms(Vec<Term>);

/// H x = gradient.
#[derive(Clone, Debug, Default)]
pub(super) struct NormalEquations {
    pub(super) matrix: BlockMatrix,
    /// Half of the cost's, by each pose but the first.
    pub(super) gradient: Vec<Vector3<f64>>,
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
    /// With (x, y, θ) taken off.
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

/// The error of a term, and the turn of its Jacobians.
struct Evaluated {
    error: Vector3<f64>,
    /// Sine and cosine of the heading that was expected at the end.
    sin: f64,
    cos: f64,
    shift: [f64; 2],
}

impl Term {
    #[inline(always)]
    fn evaluate(&self, from: &State, to: &State) -> Evaluated {
        let z = &self.motion;
        let [dx, dy] = [to.x - from.x, to.y - from.y];
        let ahead = from.cos * dx + from.sin * dy - z.x;
        let aside = from.cos * dy - from.sin * dx - z.y;
        let error = Vector3::new(
            z.cos * ahead + z.sin * aside,
            z.cos * aside - z.sin * ahead,
            wrap(to.heading - from.heading - z.heading),
        );
        Evaluated {
            error,
            sin: from.sin * z.cos + from.cos * z.sin,
            cos: from.cos * z.cos - from.sin * z.sin,
            shift: [dx, dy],
        }
    }
}

impl Terms {
    pub(super) fn new(edges: &[Edge], pattern: &BlockPattern) -> Self {
        let slot = |a: usize, b: usize| pattern.slot(a.checked_sub(1)?, b.checked_sub(1)?);
        let term = |edge: &Edge| Term {
            from: edge.from,
            to: edge.to,
            motion: State::from(&edge.motion),
            information: edge.information,
            cauchy: edge.cauchy,
            slots: [
                (edge.from, edge.from),
                (edge.to, edge.to),
                (edge.from, edge.to),
            ]
            .map(|(a, b)| slot(a, b)),
        };
        Self(edges.iter().map(term).collect())
    }

    /// Σ ρ(χ²).
    pub(super) fn cost(&self, states: &[State]) -> f64 {
        let cost = |term: &Term| {
            let error = term
                .evaluate(states.get(term.from)?, states.get(term.to)?)
                .error;
            Some(robust(error.dot(&(term.information * error)), term.cauchy).0)
        };
        self.0.iter().filter_map(cost).sum()
    }

    pub(super) fn linearise(
        &self,
        states: &[State],
        pattern: &BlockPattern,
        equations: &mut NormalEquations,
    ) {
        let NormalEquations {
            matrix,
            gradient,
            cost,
        } = equations;
        matrix.clear(pattern);
        gradient.clear();
        gradient.resize(pattern.size(), Vector3::zeros());
        *cost = 0.0;
        for term in &self.0 {
            let (Some(from), Some(to)) = (states.get(term.from), states.get(term.to)) else {
                continue;
            };
            let Evaluated {
                error,
                sin,
                cos,
                shift,
            } = term.evaluate(from, to);
            let by_error = term.information * error;
            let (own_cost, weight) = robust(error.dot(&by_error), term.cauchy);
            *cost += own_cost;
            let turn = Matrix3::new(cos, -sin, 0.0, sin, cos, 0.0, 0.0, 0.0, 1.0);
            let w = turn * (term.information * weight) * turn.transpose();
            let v = turn * (by_error * weight);
            let lever = |x: f64, y: f64| shift[0] * y - shift[1] * x;
            // Cᵀ W, and Cᵀ W C.
            let mut cw = w;
            for column in 0..3 {
                cw[(2, column)] += lever(w[(0, column)], w[(1, column)]);
            }
            let [at_start, at_end, at_both] = term.slots;
            if let Some(slot) = at_start {
                let mut cwc = cw;
                for row in 0..3 {
                    cwc[(row, 2)] += lever(cw[(row, 0)], cw[(row, 1)]);
                }
                matrix.add(slot, &cwc);
                gradient[term.from - 1] -= Vector3::new(v.x, v.y, v.z + lever(v.x, v.y));
            }
            if let Some(slot) = at_end {
                matrix.add(slot, &w);
                gradient[term.to - 1] += v;
            }
            if let Some(slot) = at_both {
                matrix.add(slot, &-cw);
            }
        }
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
