//! Loop closures that later evidence contradicts.
//!
//! In: the pose graph after it was optimised, and its closures. Out: the closures to be removed
//! again.
//!
//! 1. Consecutive submaps share keyframes: their relative pose is known to centimetres. If the
//!    optimised graph has them apart all the same, closures tear the trajectory, and some of them
//!    are false.
//! 2. Candidates are tried in turn: the newest closures; those that hold a stretch between two
//!    tears elsewhere; those that pull hardest across a tear, with their neighbours. Without them
//!    the graph is optimised again.
//! 3. The result that leaves the least unexplained is believed: joins still torn, closures removed,
//!    and closures that the graph does not follow. Proof is counted once for each submap.
//!
//! Source of the idea: Latif, Cadena & Neira (2013), "Robust loop closing over time for pose graph
//! SLAM".

use std::collections::{BTreeMap, BTreeSet};

use super::super::pose_graph::{Edge, EdgeId, PoseGraph, differs};

/// An accepted closure, as an edge of the graph.
#[derive(Clone, Copy, Debug)]
pub(super) struct Believed {
    pub(super) edge: EdgeId,
    /// Its own evidence.
    pub(super) proof: f64,
}

/// The closures to be removed, and the submap after which the trajectory was torn.
#[derive(Clone, Debug)]
pub(super) struct Contradicted {
    pub(super) edges: Vec<EdgeId>,
    pub(super) torn: usize,
}

/// A join between neighbours is torn beyond this χ² of 3 degrees of freedom, which is exceeded by
/// chance once in 60 000 times, ...
const TORN_CHI2: f64 = 25.0;
/// ... if it is also off by this, m or rad.
const TORN_SHIFT: f64 = 0.1;
const TORN_TURN: f64 = 0.05;
/// A closure is not followed if the graph is this far from it, m or rad.
const UNFOLLOWED_SHIFT: f64 = 0.25;
const UNFOLLOWED_TURN: f64 = 0.1;
/// The weight of a torn join, in submaps that lie wholly on one another.
const WAY_PROOF: f64 = 5.0;
/// Closures both of whose ends are within this many submaps of each other count as one.
const NEIGHBOURS: usize = 3;
/// How many of those that pull hardest across a tear are tried.
const TRIED: usize = 4;

/// The closures to be removed from an optimised graph, and the graph without them; `None` if the
/// trajectory is whole, or if no removal improves it. `newest` are the closures accepted since the
/// last check; `is_loose` tells whether little is known of the motion to a submap.
pub(super) fn contradicted(
    graph: &PoseGraph,
    closures: impl Iterator<Item = Believed>,
    newest: &[EdgeId],
    is_loose: impl Fn(usize) -> bool,
    max_iterations: usize,
) -> Option<(Contradicted, PoseGraph)> {
    let tears = tears(graph, &is_loose);
    // Nearly always the trajectory is whole, and nothing is left to do.
    let torn = *tears.first()?;
    let state = State {
        proofs: closures.map(|c| (c.edge, c.proof)).collect(),
        is_loose,
    };
    let before = state.unexplained(graph, &[]);
    let mut best: Option<(f64, Vec<EdgeId>, PoseGraph)> = None;
    for edges in state.suspects(graph, &tears, newest) {
        let mut without = graph.clone();
        for edge in &edges {
            without.remove_edge(*edge);
        }
        without.optimize(max_iterations);
        let after = state.unexplained(&without, &state.proofs_of(graph, &edges));
        if after < best.as_ref().map_or(before, |(least, ..)| *least) {
            best = Some((after, edges, without));
        }
    }
    best.map(|(_, edges, without)| (Contradicted { edges, torn }, without))
}

/// Whether an optimised graph does not follow a closure: its robust kernel has suppressed it.
pub(super) fn is_overruled(graph: &PoseGraph, closure: EdgeId) -> bool {
    graph.edge(closure).is_some_and(|edge| {
        is_off(graph, edge, UNFOLLOWED_SHIFT, UNFOLLOWED_TURN) && graph.chi2_of(edge) > TORN_CHI2
    })
}

/// The submaps after which the trajectory is torn, in ascending order.
fn tears(graph: &PoseGraph, is_loose: impl Fn(usize) -> bool) -> Vec<usize> {
    let ways = graph.edges().iter().filter(|e| e.cauchy.is_none());
    let tears: BTreeSet<usize> = ways
        .filter(|e| !is_loose(e.to))
        .filter(|e| is_off(graph, e, TORN_SHIFT, TORN_TURN) && graph.chi2_of(e) > TORN_CHI2)
        .map(|e| e.from)
        .collect();
    tears.into_iter().collect()
}

struct State<F> {
    proofs: BTreeMap<EdgeId, f64>,
    is_loose: F,
}

impl<F: Fn(usize) -> bool> State<F> {
    fn closures<'g>(&self, graph: &'g PoseGraph) -> impl Iterator<Item = (EdgeId, &'g Edge)> {
        let all = graph.edge_ids().iter().copied().zip(graph.edges());
        all.filter(|(id, _)| self.proofs.contains_key(id))
    }

    /// Each newer submap, with its best proof.
    fn proofs_of(&self, graph: &PoseGraph, edges: &[EdgeId]) -> Vec<(usize, f64)> {
        let proof = |id: &EdgeId| Some((graph.edge(*id)?.to, *self.proofs.get(id)?));
        edges.iter().filter_map(proof).collect()
    }

    /// What a graph leaves unexplained, including what was `taken` out of it.
    fn unexplained(&self, graph: &PoseGraph, taken: &[(usize, f64)]) -> f64 {
        let mut best: BTreeMap<usize, f64> = BTreeMap::new();
        let unfollowed: Vec<EdgeId> = self
            .closures(graph)
            .filter(|(_, e)| is_off(graph, e, UNFOLLOWED_SHIFT, UNFOLLOWED_TURN))
            .map(|(id, _)| id)
            .collect();
        for (submap, proof) in self.proofs_of(graph, &unfollowed).iter().chain(taken) {
            let most = best.entry(*submap).or_insert(0.0);
            *most = most.max(*proof);
        }
        WAY_PROOF * tears(graph, &self.is_loose).len() as f64 + best.values().sum::<f64>()
    }

    /// Sets of closures that may be the false ones.
    fn suspects(&self, graph: &PoseGraph, tears: &[usize], newest: &[EdgeId]) -> Vec<Vec<EdgeId>> {
        let followed: Vec<(EdgeId, &Edge)> = self
            .closures(graph)
            .filter(|(_, e)| !is_off(graph, e, UNFOLLOWED_SHIFT, UNFOLLOWED_TURN))
            .collect();
        let mut sets: BTreeSet<Vec<EdgeId>> = BTreeSet::from([newest.to_vec()]);
        // Stretches between two tears.
        let ends = tears.iter().map(|tear| tear + 1);
        let begins = std::iter::once(0).chain(ends.clone());
        for (begin, end) in begins.zip(ends.chain([usize::MAX])) {
            let inside = |submap: usize| begin <= submap && submap < end;
            let leaves = followed
                .iter()
                .filter(|(_, e)| inside(e.from) != inside(e.to));
            sets.insert(leaves.map(|(id, _)| *id).collect());
        }
        for &tear in tears {
            let crosses = followed
                .iter()
                .filter(|(_, e)| e.from <= tear && tear < e.to);
            let mut pulls: Vec<(f64, &Edge)> = crosses.map(|(_, e)| (pull(graph, e), *e)).collect();
            pulls.sort_by(|a, b| b.0.total_cmp(&a.0));
            for (_, hardest) in pulls.iter().take(TRIED) {
                let is_near = |e: &Edge| {
                    e.from.abs_diff(hardest.from) <= NEIGHBOURS
                        && e.to.abs_diff(hardest.to) <= NEIGHBOURS
                };
                let near = followed.iter().filter(|(_, e)| is_near(e));
                sets.insert(near.map(|(id, _)| *id).collect());
            }
        }
        sets.into_iter().filter(|set| !set.is_empty()).collect()
    }
}

/// How hard a closure pulls: the slope of its robust cost, in standard deviations.
fn pull(graph: &PoseGraph, edge: &Edge) -> f64 {
    let chi2 = graph.chi2_of(edge);
    let weight = edge
        .cauchy
        .map_or(1.0, |scale| 1.0 / (1.0 + chi2 / (scale * scale)));
    weight * chi2.sqrt()
}

fn is_off(graph: &PoseGraph, edge: &Edge, shift: f64, turn: f64) -> bool {
    let poses = graph.poses();
    let present = poses[edge.from].delta_to(&poses[edge.to]);
    differs(&edge.motion, &present, shift, turn)
}

#[cfg(test)]
mod tests {
    use nalgebra::{Matrix3, Vector3};

    use super::*;
    use crate::geom::Pose2;

    /// Ten submaps along a corridor, 5 m apart, and ten on the way back beside them.
    fn there_and_back() -> (PoseGraph, Vec<Pose2>) {
        let out = (0..10).map(|i| Pose2::new(5.0 * f64::from(i), 0.0, 0.0));
        let back = (0..10).map(|i| Pose2::new(45.0 - 5.0 * f64::from(i), 1.0, 0.0));
        let truth: Vec<Pose2> = out.chain(back).collect();
        let mut graph = PoseGraph::default();
        for pose in &truth {
            graph.add_pose(*pose);
        }
        for from in 0..truth.len() - 1 {
            graph.add_edge(Edge {
                from,
                to: from + 1,
                motion: truth[from].delta_to(&truth[from + 1]),
                information: known_to([0.03, 0.03, 0.005]),
                cauchy: None,
            });
        }
        (graph, truth)
    }

    fn known_to(sigmas: [f64; 3]) -> Matrix3<f64> {
        Matrix3::from_diagonal(&Vector3::from(sigmas).map(|sigma| 1.0 / (sigma * sigma)))
    }

    /// A closure that places the submap beside submap `from` ahead of its true place by `ahead`, m.
    fn close(graph: &mut PoseGraph, truth: &[Pose2], from: usize, ahead: f64) -> Believed {
        let to = 19 - from;
        let closure = Edge {
            from,
            to,
            motion: Pose2::new(ahead, 0.0, 0.0) * truth[from].delta_to(&truth[to]),
            information: known_to([0.015, 0.015, 0.003]),
            cauchy: Some(3.0),
        };
        Believed {
            edge: graph.add_edge(closure).unwrap(),
            proof: 0.7,
        }
    }

    fn out_of(graph: &mut PoseGraph, closures: &[Believed], newest: &[EdgeId]) -> Vec<EdgeId> {
        graph.optimize(50);
        let found = contradicted(graph, closures.iter().copied(), newest, |_| false, 50);
        found.map_or(vec![], |(found, without)| {
            *graph = without;
            found.edges
        })
    }

    fn is_true(graph: &PoseGraph, truth: &[Pose2]) -> bool {
        let mut pairs = graph.poses().iter().zip(truth);
        pairs.all(|(pose, truth)| pose.minus(truth).amax() < 1e-3)
    }

    #[test]
    fn closures_that_agree_with_the_way_stay() {
        let (mut graph, truth) = there_and_back();
        let close = |i| close(&mut graph, &truth, i, 0.02);
        let closures: Vec<Believed> = (0..10).map(close).collect();
        assert_eq!(out_of(&mut graph, &closures, &[]), []);
    }

    #[test]
    fn the_newest_that_tear_the_way_go_out() {
        let (mut graph, truth) = there_and_back();
        let mut closures: Vec<Believed> =
            (5..10).map(|i| close(&mut graph, &truth, i, 0.0)).collect();
        // A corridor looks the same 2 m further on, and the optimiser is made to believe it.
        let newest = [3, 4].map(|i| believed_blindly(&mut graph, &truth, i));
        closures.extend(newest);
        let newest = newest.map(|closure| closure.edge);
        assert_eq!(out_of(&mut graph, &closures, &newest), newest);
        assert!(is_true(&graph, &truth));
    }

    #[test]
    fn what_the_graph_does_not_follow_is_overruled() {
        let (mut graph, truth) = there_and_back();
        let close = |(i, ahead)| close(&mut graph, &truth, i, ahead);
        let at = [(5, 0.0), (6, 0.0), (7, 2.0), (8, 0.0), (9, 0.0)];
        let closures = at.map(close);
        graph.optimize(50);
        let overruled = closures.map(|closure| is_overruled(&graph, closure.edge));
        assert_eq!(overruled, [false, false, true, false, false]);
        assert!(is_true(&graph, &truth) || tears(&graph, |_| false).is_empty());
    }

    /// A closure that is 2 m off and pulls with its full weight.
    fn believed_blindly(graph: &mut PoseGraph, truth: &[Pose2], from: usize) -> Believed {
        let closure = close(graph, truth, from, 2.0);
        let edge = graph.remove_edge(closure.edge).unwrap();
        let blind = Edge {
            cauchy: Some(1e4),
            ..edge
        };
        let edge = graph.add_edge(blind).unwrap();
        Believed { edge, ..closure }
    }

    #[test]
    fn an_old_one_goes_out_when_later_ones_speak_against_it() {
        let (mut graph, truth) = there_and_back();
        let wrong = believed_blindly(&mut graph, &truth, 5);
        let later = [3, 4, 6, 7].map(|i| close(&mut graph, &truth, i, 0.0));
        let closures: Vec<Believed> = std::iter::once(wrong).chain(later).collect();
        let newest: Vec<EdgeId> = later.iter().map(|closure| closure.edge).collect();
        assert_eq!(out_of(&mut graph, &closures, &newest), [wrong.edge]);
        assert!(is_true(&graph, &truth));
    }

    #[test]
    fn a_way_of_which_little_is_known_is_not_torn() {
        let (mut graph, truth) = there_and_back();
        let close = |i| close(&mut graph, &truth, i, 2.0);
        let closures: Vec<Believed> = (0..10).map(close).collect();
        graph.optimize(50);
        let found = |loose: usize| {
            let is_loose = |submap| submap == loose;
            contradicted(&graph, closures.iter().copied(), &[], is_loose, 50).is_some()
        };
        assert!(!found(10));
    }
}
