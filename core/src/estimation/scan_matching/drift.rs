//! How well submaps are known relative to one another, and how much of what is feared of the way
//! it has shown.
//!
//! In: the pose graph, and each loop as it is closed. Out: a [`Doubt`] between any two submaps, and
//! how far a placement is from where it was expected.
//!
//! 1. A way through the graph is known as badly as its edges, and worse: beyond what matching says
//!    of itself, a submap may err as the one before it did ([`ClosureConfig::drift`] and
//!    [`ClosureConfig::drift_turn`]).
//! 2. Where to look for a loop follows from the variances alone. Whether what is found there can be
//!    believed follows from the whole covariance: who comes back with the right heading cannot have
//!    turned much on the way either, and is not far off to the side.
//! 3. The figures of step 1 are for the worst of robots and buildings. Each loop that is closed
//!    tells how far its way was off: covariances are scaled by `(PRIOR + Σχ²) / (PRIOR + Σν)`, the
//!    mean of the posterior of a scale whose prior is worth [`PRIOR`] degrees of freedom, and never
//!    by more than 1. So a place that looks like one 3 m away is not taken for it by a robot that
//!    has come back to within a decimetre all day. Windows are not scaled: the next way may be
//!    worse.

use std::collections::BTreeMap;

use nalgebra::{Matrix3, Vector3};

use super::super::submap::Doubt;
use super::ScanMatcher;
use super::closures::Candidate;
use crate::geom::{Pose2, wrap};
use crate::snapshot::snapshot;

/// What the figures of the configuration are worth, in degrees of freedom.
const PRIOR: f64 = 3.0;
/// Covariances are scaled by this at least.
const LEAST: f64 = 0.1;
/// A way tells of drift when it leads through this many submaps that follow one another, at least:
/// neighbours lie well in any case.
const LONG: usize = 5;

/// How much of the feared drift loops have shown.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Drift {
    /// Sum of χ² of the ways that were closed.
    squares: f64,
    /// Sum of their degrees of freedom.
    freedom: f64,
}

impl Drift {
    /// By what covariances are to be multiplied.
    fn scale(&self) -> f64 {
        ((PRIOR + self.squares) / (PRIOR + self.freedom)).clamp(LEAST, 1.0)
    }
}

snapshot!(
    Drift { squares, freedom },
    |drift| (0.0..1e12).contains(&drift.squares) && (0.0..1e12).contains(&drift.freedom),
    "no sum of squares"
);

/// What is known of the way between two submaps.
#[derive(Clone, Copy, Debug)]
pub(super) struct Known {
    /// Variances of shift and turn, m² and rad².
    variances: [f64; 2],
    /// Covariance of where the first submap lies as the other sees it, in the axes of the map.
    cov: Matrix3<f64>,
    /// How many submaps the way leads through that follow one another.
    length: usize,
}

impl Known {
    const NOTHING: Self = Self {
        variances: [f64::INFINITY; 2],
        ..Self::EXACT
    };
    const EXACT: Self = Self {
        variances: [0.0; 2],
        cov: Matrix3::new(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
        length: 0,
    };

    pub(super) fn doubt(&self) -> Doubt {
        let [shift, turn] = self.variances.map(f64::sqrt);
        Doubt { shift, turn }
    }

    /// χ² of an error of the way, 3 degrees of freedom; 0 where nothing is known.
    fn chi2(&self, off: &Vector3<f64>) -> f64 {
        let inverse = self.cov.try_inverse();
        inverse.map_or(0.0, |information| off.dot(&(information * off)))
    }
}

impl ScanMatcher {
    /// How well each submap's pose is known relative to submap `from`.
    pub(super) fn doubts(&self, from: usize) -> Vec<Doubt> {
        self.known_ways(from).iter().map(Known::doubt).collect()
    }

    /// χ² of a placement before it is believed, by what loops have shown of drift. `known` is the
    /// way from its new submap to its old one.
    pub(super) fn surprise(&self, known: &Known, placed: &Candidate) -> f64 {
        known.chi2(&self.off(placed)) / self.drift.scale()
    }

    /// Loops are about to be closed: how far were the ways off that they close? Those that are
    /// proved together close one way: the longest counts.
    pub(super) fn learn_drift(&mut self, proved: &[Candidate]) {
        let mut known: BTreeMap<usize, Vec<Known>> = BTreeMap::new();
        let way = |c: &Candidate| {
            let from_new = known.entry(c.new).or_insert_with(|| self.known_ways(c.new));
            let known = from_new.get(c.old)?;
            (known.length >= LONG).then(|| (known.length, known.chi2(&self.off(c))))
        };
        let searched = proved.iter().filter(|c| c.closure.is_searched);
        let longest = searched.filter_map(way).max_by_key(|(length, _)| *length);
        if let Some((_, chi2)) = longest {
            self.drift.squares += chi2;
            self.drift.freedom += 3.0;
        }
    }

    /// How far the new submap of a placement is from where it lies so far, in the axes of the map.
    fn off(&self, placed: &Candidate) -> Vector3<f64> {
        let poses = self.graph.poses();
        let (old, new) = (poses[placed.old], poses[placed.new]);
        let found: Pose2 = old * placed.closure.motion;
        let shift = found.position() - new.position();
        Vector3::new(shift.x, shift.y, wrap(found.heading() - new.heading()))
    }

    /// What is known of the way from submap `from` to each: along the best one through the graph.
    pub(super) fn known_ways(&self, from: usize) -> Vec<Known> {
        let poses = self.graph.poses();
        let config = &self.config.closure;
        let mut edges: Vec<Vec<(usize, Known)>> = vec![vec![]; poses.len()];
        for edge in self.graph.edges() {
            let Some(cov) = edge.information.try_inverse() else {
                continue;
            };
            let (mut shift, mut turn) = (0.5 * (cov[(0, 0)] + cov[(1, 1)]), cov[(2, 2)]);
            let turned = poses[edge.to].rotation();
            let mut cov = turned * cov * turned.transpose();
            let mut length = 0;
            if edge.cauchy.is_none() {
                // Errors of the way add up where a submap errs as the one before it did.
                let way = config.drift * edge.motion.position().coords.norm();
                let drift = [way * way, config.drift_turn * config.drift_turn];
                shift += drift[0];
                turn += drift[1];
                cov += Matrix3::from_diagonal(&Vector3::new(drift[0], drift[0], drift[1]));
                length = 1;
            }
            let known = Known {
                variances: [shift, turn],
                cov,
                length,
            };
            edges[edge.from].push((edge.to, known));
            edges[edge.to].push((edge.from, known));
        }
        let mut ways = vec![Known::NOTHING; poses.len()];
        let mut done = vec![false; poses.len()];
        let here = poses[from].position();
        ways[from] = Known::EXACT;
        let doubt = |way: &Known| way.variances[0];
        // Dijkstra without a heap: a few hundred submaps.
        while let Some(at) = (0..poses.len())
            .filter(|&i| !done[i] && doubt(&ways[i]).is_finite())
            .min_by(|&a, &b| doubt(&ways[a]).total_cmp(&doubt(&ways[b])))
        {
            done[at] = true;
            let arm = here - poses[at].position();
            for &(next, edge) in &edges[at] {
                let [shift, turn] = edge.variances;
                // An error of the heading here moves all that lies at a distance.
                let way = ways[at].variances[0] + shift + turn * arm.norm_squared();
                if way < doubt(&ways[next]) {
                    let moved = Matrix3::new(1.0, 0.0, -arm.y, 0.0, 1.0, arm.x, 0.0, 0.0, 1.0);
                    ways[next] = Known {
                        variances: [way, ways[at].variances[1] + turn],
                        cov: ways[at].cov + moved * edge.cov * moved.transpose(),
                        length: ways[at].length + edge.length,
                    };
                }
            }
        }
        ways
    }
}

#[cfg(test)]
mod tests;
