//! The search for the poses of least cost.
//!
//! 1. Gauss-Newton, undamped. Poses from odometry are far off, and the first steps often increase
//!    the cost before it falls; so the cost may rise for some steps, and the best poses are kept
//!    (Chamberlain et al. 1982, "watchdog").
//! 2. If nothing better was found, the search continues from the best poses with
//!    Levenberg-Marquardt, damped until the cost falls with each step.
//! 3. It ends when a step is expected to gain almost nothing: for an undamped step, gᵀ H⁻¹ g. To
//!    see this, and to take the step, the H of the previous step is good enough: no factor is made
//!    for the last.
//!
//! Marquardt's damping alone is not enough: it scales with the information of an edge, and if that
//! spans many decades, as in `intel.g2o`, even a little damping immobilises some poses.

use std::sync::Arc;

use nalgebra::Vector3;

use super::PoseGraph;
use super::linear::{Gradient, State, Terms};
use crate::estimation::block_cholesky::{BlockFactor, BlockMatrix, BlockPattern};

/// The result of an optimisation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Optimization {
    /// Whether the last step was negligible.
    pub converged: bool,
    /// Number of linear systems that were solved.
    pub iterations: usize,
    /// Σ ρ(χ²) of the poses before and after.
    pub cost: [f64; 2],
}

/// An undamped search may go on for this many steps without finding anything better.
const PATIENCE: usize = 4;
/// Damping never falls below this.
const LEAST_DAMPING: f64 = 1e-10;
/// The first damping, and the least after a step that increased the cost.
const RAISED_DAMPING: f64 = 1e-6;
/// With more damping than this, no step can make progress.
const MOST_DAMPING: f64 = 1e8;
/// An undamped step that is expected to gain less than this part of the cost is the last one.
const LEAST_EXPECTED: f64 = 1e-6;
/// If the last step was expected to gain less than this part of the cost, the next one may be the
/// last.
const NEAR: f64 = 1e-2;
/// A damped step that gains less than this part of the cost is the last one.
const LEAST_GAIN: f64 = 1e-9;
/// A step that moves no pose by more than this, m and rad, is the last one.
const LEAST_STEP: f64 = 1e-8;

impl PoseGraph {
    /// Moves the poses to the least cost, in at most `max_iterations` steps; the cost never rises.
    /// Returns whether the last step was negligible.
    pub fn optimize(&mut self, max_iterations: usize) -> bool {
        self.optimize_with_figures(max_iterations).converged
    }

    /// Like [`Self::optimize`], and returns the figures of the optimisation.
    pub fn optimize_with_figures(&mut self, max_iterations: usize) -> Optimization {
        if self.poses.len() < 2 || self.edges.is_empty() {
            return Optimization {
                converged: true,
                iterations: 0,
                cost: [0.0; 2],
            };
        }
        self.pattern = self.pattern();
        let pattern = Arc::clone(&self.pattern);
        let terms = Terms::new(&self.edges, &pattern);
        let mut states: Vec<State> = self.poses.iter().map(State::from).collect();
        let (mut damping, mut failures) = (0.0, 0);
        let (mut iterations, mut converged) = (0, false);
        let mut solver = Solver::new(&pattern, &terms);
        let before = solver.linearise(&states, damping);
        let (mut best, mut best_cost) = (states.clone(), before);
        while iterations < max_iterations && damping < MOST_DAMPING {
            iterations += 1;
            let mut back_to_best = !solver.solve(&states, damping);
            if !back_to_best {
                for (state, step) in states.iter_mut().skip(1).zip(&solver.step) {
                    *state = state.minus(step);
                }
                let is_free = damping <= RAISED_DAMPING;
                if solver.largest() < LEAST_STEP
                    || (is_free && solver.expected_part() <= LEAST_EXPECTED)
                {
                    let cost = terms.cost(&states);
                    if cost <= best_cost {
                        (best, best_cost) = (states, cost);
                        converged = true;
                        break;
                    }
                    // No better except for rounding; or, undamped, converged to another minimum.
                    if damping > 0.0 || cost <= best_cost * (1.0 + LEAST_GAIN) {
                        converged = true;
                        break;
                    }
                    back_to_best = true;
                }
            }
            if !back_to_best {
                let cost = solver.linearise(&states, damping);
                let gain = best_cost - cost;
                if gain >= 0.0 {
                    best.clone_from(&states);
                    best_cost = cost;
                    failures = 0;
                    if damping > 0.0 {
                        damping = (damping * 0.1).max(LEAST_DAMPING);
                        if gain <= LEAST_GAIN * best_cost {
                            converged = true;
                            break;
                        }
                    }
                } else {
                    failures += 1;
                    let is_lost = failures > PATIENCE || !cost.is_finite();
                    back_to_best = damping > 0.0 || is_lost;
                }
            }
            if back_to_best {
                damping = (damping * 10.0).max(RAISED_DAMPING);
                states.clone_from(&best);
                solver.linearise(&states, damping);
            }
        }
        for (pose, state) in self.poses.iter_mut().zip(&best).skip(1) {
            *pose = state.pose();
        }
        Optimization {
            converged,
            iterations,
            cost: [before, best_cost],
        }
    }
}

/// The equations, and the step that solves them.
struct Solver<'a> {
    pattern: &'a BlockPattern,
    terms: &'a Terms<'a>,
    gradient: Gradient,
    /// At the same poses as the gradient, if it was computed.
    matrix: Option<BlockMatrix>,
    /// At these poses or at earlier ones.
    factor: Option<BlockFactor>,
    step: Vec<Vector3<f64>>,
    /// Whether the factor is that of an undamped step that was expected to gain little.
    is_near: bool,
}

impl<'a> Solver<'a> {
    fn new(pattern: &'a BlockPattern, terms: &'a Terms<'a>) -> Self {
        Self {
            pattern,
            terms,
            gradient: Gradient::default(),
            matrix: None,
            factor: None,
            step: vec![],
            is_near: false,
        }
    }

    /// Computes the equations at these poses, without their matrix if the present factor may be
    /// good enough. Returns the cost.
    fn linearise(&mut self, states: &[State], damping: f64) -> f64 {
        if self.is_near && damping == 0.0 {
            self.terms.linearise(states, &mut self.gradient, None);
        } else {
            self.assemble(states);
        }
        self.gradient.cost
    }

    fn assemble(&mut self, states: &[State]) {
        let mut matrix = self.pattern.zeros(self.factor.take());
        self.terms
            .linearise(states, &mut self.gradient, Some(&mut matrix));
        self.matrix = Some(matrix);
        self.is_near = false;
    }

    /// Computes the step; `false` if there is none.
    fn solve(&mut self, states: &[State], damping: f64) -> bool {
        if self.matrix.is_none() {
            self.substitute();
            if self.expected_part() <= LEAST_EXPECTED {
                return true;
            }
            self.assemble(states);
        }
        let pattern = self.pattern;
        let matrix = self.matrix.take();
        self.factor = matrix.and_then(|matrix| pattern.factor(matrix, damping));
        if self.factor.is_none() {
            return false;
        }
        self.substitute();
        self.is_near = damping == 0.0 && self.expected_part() <= NEAR;
        true
    }

    fn substitute(&mut self) {
        self.step.clone_from(&self.gradient.by_pose);
        if let Some(factor) = &self.factor {
            self.pattern.solve(factor, &mut self.step);
        }
    }

    /// The part of the cost that the step is expected to gain, if it is undamped.
    fn expected_part(&self) -> f64 {
        let pairs = self.step.iter().zip(&self.gradient.by_pose);
        let expected: f64 = pairs.map(|(step, gradient)| step.dot(gradient)).sum();
        expected / self.gradient.cost
    }

    /// The largest change of a pose by the step, m and rad.
    fn largest(&self) -> f64 {
        self.step.iter().map(Vector3::amax).fold(0.0, f64::max)
    }
}
