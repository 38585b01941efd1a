//! How well submaps are known relative to one another, and how much of the assumed drift has
//! actually occurred.
//!
//! In: the pose graph, and each loop as it is closed. Out: a [`Doubt`] between any two submaps, and
//! how far a placement is from where it was expected.
//!
//! 1. A path through the graph is at least as uncertain as its edges: beyond what matching reports,
//!    a submap may err in the same way as the one before it ([`ClosureConfig::drift`] and
//!    [`ClosureConfig::drift_turn`]).
//! 2. The variances alone decide where to look for a loop. Whether what is found there is credible
//!    depends on the whole covariance: a robot that comes back with the right heading cannot have
//!    turned much on the way either, and is not far off to the side.
//! 3. The figures of step 1 are for the worst robots and buildings. Each closed loop shows how far
//!    its path was off: covariances are scaled by `(PRIOR + Σχ²) / (PRIOR + Σν)`, the posterior
//!    mean of a scale whose prior is worth [`PRIOR`] degrees of freedom, and never by more than 1.
//!    So a robot that has come back to within a decimetre all day does not take a place for one 3 m
//!    away that looks like it. Search windows are not scaled: the next path may be worse.

use std::cell::RefCell;
use std::collections::BTreeMap;

use nalgebra::{Matrix3, Vector3};

use super::super::pose_graph::Edge;
use super::super::submap::Doubt;
use super::closures::{Candidate, FREEDOM, Surprise, Ways};
use super::{ScanMatcher, carried};
use crate::geom::{Length, Pose2};
use crate::snapshot::snapshot;

/// The weight of the configured figures, in degrees of freedom.
const PRIOR: f64 = 3.0;
/// The smallest scale of covariances.
const LEAST: f64 = 0.1;
/// A path shows drift only if it leads through at least this many consecutive submaps: neighbours
/// lie well in any case.
const LONG: usize = 5;

/// How much of the assumed drift loops have shown.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Drift {
    /// Sum of χ² of the paths that were closed.
    squares: f64,
    /// Sum of their degrees of freedom.
    freedom: f64,
}

impl Drift {
    /// The factor by which covariances are multiplied.
    fn scale(&self) -> f64 {
        ((PRIOR + self.squares) / (PRIOR + self.freedom)).clamp(LEAST, 1.0)
    }
}

snapshot!(
    Drift { squares, freedom },
    |drift| (0.0..1e12).contains(&drift.squares) && (0.0..1e12).contains(&drift.freedom),
    "no sum of squares"
);

/// The best paths through the graph from one submap to all others.
struct BestWays {
    from: usize,
    doubts: Vec<Doubt>,
    /// For each submap, the edge by which the path reaches it.
    last: Vec<Option<usize>>,
}

/// What is known of the path from one submap to another.
#[derive(Clone, Copy, Debug)]
struct Known {
    /// Covariance of where the first submap lies as seen from the other, in the axes of the map.
    cov: Matrix3<f64>,
    /// The number of consecutive submaps that the path leads through.
    length: usize,
}

impl BestWays {
    /// How well the pose of a submap is known.
    fn doubt(&self, to: usize) -> Doubt {
        self.doubts[to]
    }
}

impl Known {
    /// χ² of an error of the path, 3 degrees of freedom; 0 where nothing is known.
    fn chi2(&self, off: &Vector3<f64>) -> f64 {
        let inverse = self.cov.try_inverse();
        inverse.map_or(0.0, |information| off.dot(&(information * off)))
    }
}

/// The paths through the pose graph as it is.
pub(super) struct KnownWays<'a> {
    matcher: &'a ScanMatcher,
    ways: RefCell<BTreeMap<usize, BestWays>>,
}

impl<'a> KnownWays<'a> {
    pub(super) fn of(matcher: &'a ScanMatcher) -> Self {
        Self {
            matcher,
            ways: RefCell::default(),
        }
    }

    /// Queries the paths from a submap, which are searched only once.
    fn ask<T>(&self, from: usize, what: impl Fn(&BestWays) -> T) -> T {
        let mut ways = self.ways.borrow_mut();
        let ways = ways.entry(from);
        what(ways.or_insert_with(|| self.matcher.best_ways(from)))
    }

    /// Called before loops are closed: how far off were their paths? Placements that are proved
    /// together close one path: the longest counts.
    pub(super) fn drift_after(&self, proved: &[Candidate]) -> Drift {
        let way = |c: &Candidate| {
            let known = self.ask(c.new, |ways| self.matcher.known(ways, c.old));
            (known.length >= LONG).then(|| (known.length, known.chi2(&self.matcher.off(c))))
        };
        let searched = proved.iter().filter(|c| c.closure.is_searched);
        let longest = searched.filter_map(way).max_by_key(|(length, _)| *length);
        let mut drift = self.matcher.drift;
        if let Some((_, chi2)) = longest {
            drift.squares += chi2;
            drift.freedom += FREEDOM;
        }
        drift
    }
}

impl Ways for KnownWays<'_> {
    fn way(&self, from: usize, to: usize) -> (Pose2, Doubt) {
        let [from_pose, to_pose] = [from, to].map(|at| self.matcher.submaps[at].map_from_submap);
        let doubt = self.ask(from, |ways| ways.doubt(to));
        (from_pose.delta_to(&to_pose), doubt)
    }

    fn surprise(&self, placed: &Candidate) -> Surprise {
        self.ask(placed.new, |ways| self.matcher.surprise(ways, placed))
    }
}

impl ScanMatcher {
    /// How well each submap's pose is known relative to submap `from`.
    pub(super) fn doubts(&self, from: usize) -> Vec<Doubt> {
        self.best_ways(from).doubts
    }

    /// χ² of a placement before it is accepted; `ways` start at its new submap.
    fn surprise(&self, ways: &BestWays, placed: &Candidate) -> Surprise {
        let by_fear = self.known(ways, placed.old).chi2(&self.off(placed));
        Surprise {
            by_fear,
            by_loops: by_fear / self.drift.scale(),
        }
    }

    /// How far a placement moves its new submap from where it lies so far, in the axes of the map.
    fn off(&self, placed: &Candidate) -> Vector3<f64> {
        let poses = self.graph.poses();
        let (old, new) = (poses[placed.old], poses[placed.new]);
        (old * placed.closure.motion).minus(&new)
    }

    /// The paths from submap `from` with the least assumed drift.
    fn best_ways(&self, from: usize) -> BestWays {
        let poses = self.graph.poses();
        let mut edges: Vec<Vec<(usize, usize, [f64; 2])>> = vec![vec![]; poses.len()];
        for (number, edge) in self.graph.edges().iter().enumerate() {
            let Some(cov) = edge.information.try_inverse() else {
                continue;
            };
            let [drift, drift_turn] = self.feared(edge);
            let shift = 0.5 * (cov[(0, 0)] + cov[(1, 1)]) + drift;
            let variances = [shift, cov[(2, 2)] + drift_turn];
            edges[edge.from].push((edge.to, number, variances));
            edges[edge.to].push((edge.from, number, variances));
        }
        let mut known = vec![[f64::INFINITY; 2]; poses.len()];
        let mut last = vec![None; poses.len()];
        let mut done = vec![false; poses.len()];
        let here = poses[from].position();
        known[from] = [0.0; 2];
        // Dijkstra without a heap: there are only a few hundred submaps.
        while let Some(at) = (0..poses.len())
            .filter(|&i| !done[i] && known[i][0].is_finite())
            .min_by(|&a, &b| known[a][0].total_cmp(&known[b][0]))
        {
            done[at] = true;
            // A heading error here moves everything at a distance.
            let lever = (poses[at].position() - here).norm_squared();
            for &(next, number, [shift, turn]) in &edges[at] {
                let way = known[at][0] + shift + turn * lever;
                if way < known[next][0] {
                    known[next] = [way, known[at][1] + turn];
                    last[next] = Some(number);
                }
            }
        }
        let doubt = |[shift, turn]: [f64; 2]| Doubt {
            shift: shift.sqrt(),
            turn: turn.sqrt(),
        };
        BestWays {
            from,
            doubts: known.into_iter().map(doubt).collect(),
            last,
        }
    }

    /// The assumed drift on an edge: variances of shift and turn, m² and rad².
    fn feared(&self, edge: &Edge) -> [f64; 2] {
        if edge.cauchy.is_some() {
            return [0.0; 2];
        }
        let config = &self.config.closure;
        // Errors of the distance add up if a submap errs in the same way as the one before it.
        let way = config.drift * edge.motion.position().coords.length();
        [way * way, config.drift_turn * config.drift_turn]
    }

    /// What is known of the whole of one of these paths.
    fn known(&self, ways: &BestWays, to: usize) -> Known {
        let (poses, edges) = (self.graph.poses(), self.graph.edges());
        let here = poses[ways.from].position();
        let (mut cov, mut length) = (Matrix3::zeros(), 0);
        let mut at = to;
        while let Some(edge) = ways.last[at].and_then(|number| edges.get(number)) {
            at = if edge.to == at { edge.from } else { edge.to };
            let turned = poses[edge.to].rotation();
            let measured = edge.information.try_inverse().unwrap_or_default();
            let [shift, turn] = self.feared(edge);
            let feared = Matrix3::from_diagonal(&Vector3::new(shift, shift, turn));
            let arm = here - poses[at].position();
            let of_edge = turned * measured * turned.transpose() + feared;
            cov = carried(&of_edge, arm, cov);
            length += usize::from(edge.cauchy.is_none());
        }
        Known { cov, length }
    }
}

#[cfg(test)]
mod tests;
