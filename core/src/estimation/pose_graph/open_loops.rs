//! Neighbouring places that a graph connects only by a long detour.
//!
//! In: a graph. Out: its open loops. A robot that comes back to where it was sees that in its map,
//! but until a closure is found, the errors of the whole detour lie in the gap between the two
//! places.
//!
//! A loop is open if two poses are near in space and far from each other along the edges, each as
//! long as its motion.
//!
//! Source: Stachniss, Hähnel & Burgard (2004), "Exploration with active loop-closing for FastSLAM",
//! III: "small distance in the grid map, large distance in the topological map".

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use super::PoseGraph;
use crate::geom::Length;

/// Poses farther apart than this are not neighbours, m: the robot may have come from one to within
/// sight of the other before the next one was due.
const NEAR: f64 = 6.0;
/// A detour shorter than this accumulates no error worth a drive, m.
const LEAST_ROUND: f64 = 15.0;
/// A detour is more than this many times as long as the straight line.
const ROUND: f64 = 4.0;

/// Two neighbouring poses that a graph connects only by a long detour.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OpenLoop {
    /// The pose that was added first.
    pub older: usize,
    /// The other one.
    pub newer: usize,
    /// How far they are apart, m.
    pub apart: f64,
    /// The shortest path from one to the other along edges, m; infinite if there is none.
    pub around: f64,
}

impl PoseGraph {
    /// All open loops, those whose ends are nearest relative to their detour first. One gap may be
    /// named by several pairs. O(p e log e) for p poses that have such neighbours and e edges.
    #[must_use]
    pub fn open_loops(&self) -> Vec<OpenLoop> {
        let neighbours = self.neighbours();
        let mut found = vec![];
        for newer in 0..self.poses.len() {
            let near: Vec<usize> = (0..newer)
                .filter(|&older| self.apart(older, newer) < NEAR)
                .collect();
            if near.is_empty() {
                continue;
            }
            let around = ways_from(newer, &neighbours);
            found.extend(near.into_iter().filter_map(|older| {
                let open = OpenLoop {
                    older,
                    newer,
                    apart: self.apart(older, newer),
                    around: around[older],
                };
                open.is_open().then_some(open)
            }));
        }
        found.sort_by(|a, b| (a.apart / a.around).total_cmp(&(b.apart / b.around)));
        found
    }

    /// Whether a loop is still open.
    #[must_use]
    pub fn is_loop_open(&self, open: &OpenLoop) -> bool {
        let (older, newer) = (open.older, open.newer);
        if older.max(newer) >= self.poses.len() {
            return false;
        }
        let now = OpenLoop {
            apart: self.apart(older, newer),
            around: ways_from(newer, &self.neighbours())[older],
            ..*open
        };
        now.is_open()
    }

    fn apart(&self, a: usize, b: usize) -> f64 {
        (self.poses[a].position() - self.poses[b].position()).length()
    }

    /// For each pose, the poses that edges lead to, and how far away they are.
    fn neighbours(&self) -> Vec<Vec<(usize, f64)>> {
        let mut neighbours = vec![vec![]; self.poses.len()];
        for edge in &self.edges {
            let length = edge.motion.position().coords.length();
            neighbours[edge.from].push((edge.to, length));
            neighbours[edge.to].push((edge.from, length));
        }
        neighbours
    }
}

impl OpenLoop {
    fn is_open(&self) -> bool {
        self.around > LEAST_ROUND.max(ROUND * self.apart)
    }
}

/// The shortest paths from one pose to all (Dijkstra).
fn ways_from(start: usize, neighbours: &[Vec<(usize, f64)>]) -> Vec<f64> {
    let mut ways = vec![f64::INFINITY; neighbours.len()];
    ways[start] = 0.0;
    // Lengths as bits, which for non-negative numbers sort like the numbers themselves.
    let mut open = BinaryHeap::from([Reverse((0_u64, start))]);
    while let Some(Reverse((way, at))) = open.pop() {
        let way = f64::from_bits(way);
        if way > ways[at] {
            continue;
        }
        for &(to, length) in &neighbours[at] {
            if way + length < ways[to] {
                ways[to] = way + length;
                open.push(Reverse((ways[to].to_bits(), to)));
            }
        }
    }
    ways
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use nalgebra::Matrix3;
    use proptest::prelude::*;

    use super::super::Edge;
    use super::*;
    use crate::geom::{Pose2, unit_vector};

    fn graph(places: &[(f64, f64)], edges: &[(usize, usize)]) -> PoseGraph {
        let mut graph = PoseGraph::default();
        for &(x, y) in places {
            graph.add_pose(Pose2::new(x, y, 0.0));
        }
        for &(from, to) in edges {
            graph.add_edge(Edge {
                from,
                to,
                motion: graph.poses[from].delta_to(&graph.poses[to]),
                information: Matrix3::identity(),
                cauchy: None,
            });
        }
        graph
    }

    /// A ring of 40 m, driven from its first pose to 2 m before it.
    fn ring() -> PoseGraph {
        let on_ring = |at: usize| {
            let at = unit_vector(TAU * at as f64 / 20.0) * 40.0 / TAU;
            (at.x, at.y)
        };
        let places: Vec<_> = (0..20).map(on_ring).collect();
        let edges: Vec<_> = (1..20).map(|to| (to - 1, to)).collect();
        graph(&places, &edges)
    }

    #[test]
    fn a_ring_is_open_until_its_ends_are_joined() {
        let mut ring = ring();
        let found = ring.open_loops();
        // Its ends are 2 m apart, as are their neighbours from them; all within 6 m count.
        let pairs: Vec<_> = found.iter().map(|open| (open.older, open.newer)).collect();
        assert_eq!(
            pairs,
            [(0, 19), (0, 18), (1, 19), (0, 17), (1, 18), (2, 19)]
        );
        let chord = 2.0 * 40.0 / TAU * libm::sin(TAU / 40.0);
        assert!((found[0].apart - chord).abs() < 1e-12);
        assert!((found[0].around - 19.0 * chord).abs() < 1e-9, "{found:?}");
        assert!(ring.is_loop_open(&found[0]));
        ring.add_edge(Edge {
            from: 1,
            to: 18,
            motion: ring.poses[1].delta_to(&ring.poses[18]),
            information: Matrix3::identity(),
            cauchy: Some(1.0),
        });
        assert!(!ring.is_loop_open(&found[0]));
        assert_eq!(ring.open_loops(), []);
    }

    #[test]
    fn what_is_not_joined_at_all_is_open_and_what_is_gone_is_not() {
        let found = graph(&[(0.0, 0.0), (1.0, 0.0)], &[]).open_loops();
        assert!(
            found.len() == 1 && found[0].around.is_infinite(),
            "{found:?}"
        );
        assert!(!PoseGraph::default().is_loop_open(&found[0]));
        assert_eq!(PoseGraph::default().open_loops(), []);
    }

    #[test]
    fn passes_of_one_room_that_were_joined_are_no_loop() {
        let room: Vec<_> = (0..24)
            .map(|at| (f64::from(at % 4), f64::from(at / 4)))
            .collect();
        let way = || (1..24).map(|to| (to - 1, to));
        let beside = (4..24).map(|to| (to - 4, to));
        assert!(
            !graph(&room, &way().collect::<Vec<_>>())
                .open_loops()
                .is_empty()
        );
        assert_eq!(
            graph(&room, &way().chain(beside).collect::<Vec<_>>()).open_loops(),
            []
        );
    }

    proptest! {
        /// Against Floyd and Warshall over all pairs.
        #[test]
        fn ways_are_the_shortest(
            places in prop::collection::vec((-9.0..9.0, -9.0..9.0), 2..12),
            edges in prop::collection::vec((0_usize..12, 0_usize..12), 0..30),
        ) {
            let count = places.len();
            let edges: Vec<_> = edges.into_iter().map(|(a, b)| (a % count, b % count)).collect();
            let graph = graph(&places, &edges);
            let mut ways = vec![vec![f64::INFINITY; count]; count];
            for (a, row) in ways.iter_mut().enumerate() {
                row[a] = 0.0;
            }
            for edge in graph.edges() {
                let length = edge.motion.position().coords.length();
                ways[edge.from][edge.to] = ways[edge.from][edge.to].min(length);
                ways[edge.to][edge.from] = ways[edge.from][edge.to];
            }
            for by in 0..count {
                for a in 0..count {
                    for b in 0..count {
                        ways[a][b] = ways[a][b].min(ways[a][by] + ways[by][b]);
                    }
                }
            }
            let neighbours = graph.neighbours();
            for (start, expected) in ways.iter().enumerate() {
                for (found, expected) in ways_from(start, &neighbours).iter().zip(expected) {
                    prop_assert!(found == expected || (found - expected).abs() < 1e-9);
                }
            }
        }
    }
}
