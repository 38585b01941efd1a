//! The pose graph of a walk through a grid of streets, with a closure wherever it meets itself.
#![allow(missing_docs, reason = "criterion's macros")]

use std::collections::BTreeMap;
use std::f64::consts::FRAC_PI_2;
use std::hint::black_box;

use criterion::{BatchSize, Criterion, criterion_group, criterion_main};
use nalgebra::Matrix3;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use slamlab_core::estimation::{Edge, PoseGraph};
use slamlab_core::geom::Pose2;

const POSES: usize = 3500;
/// Streets to either side of the middle.
const STREETS: i32 = 25;

/// The graph with poses by dead reckoning, and the edges of one more pose.
fn walk() -> (PoseGraph, Pose2, Vec<Edge>) {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let mut noise = |spread: f64| rng.random_range(-spread..spread);
    let mut draws = ChaCha8Rng::seed_from_u64(2);
    let mut graph = PoseGraph::default();
    let mut seen: BTreeMap<(i32, i32), usize> = BTreeMap::new();
    let mut truths = vec![Pose2::identity()];
    let mut reckoned = Pose2::identity();
    graph.add_pose(reckoned);
    let mut last = vec![];
    for index in 1..=POSES {
        let turn = match draws.random_range(0..6) {
            0 => FRAC_PI_2,
            1 => -FRAC_PI_2,
            _ => 0.0,
        };
        let from = truths[index - 1];
        let mut to = from * Pose2::new(1.0, 0.0, turn);
        let inside = |pose: &Pose2| pose.position().coords.amax() < f64::from(STREETS);
        if !inside(&(to * Pose2::new(1.0, 0.0, 0.0))) {
            to = from * Pose2::new(1.0, 0.0, 2.0 * FRAC_PI_2);
        }
        truths.push(to);
        let mut edge = |a: usize, b: usize| Edge {
            from: a,
            to: b,
            motion: truths[a].delta_to(&truths[b])
                * Pose2::new(noise(0.05), noise(0.05), noise(0.02)),
            information: Matrix3::from_diagonal_element(1000.0),
            cauchy: None,
        };
        let mut edges = vec![edge(index - 1, index)];
        let cell = (to.x().round() as i32, to.y().round() as i32);
        if let Some(earlier) = seen.insert(cell, index).filter(|e| e + 10 < index) {
            edges.push(edge(earlier, index));
        }
        reckoned = reckoned * edges[0].motion;
        if index == POSES {
            last = edges;
            break;
        }
        graph.add_pose(reckoned);
        for edge in edges {
            graph.add_edge(edge);
        }
    }
    (graph, reckoned, last)
}

fn bench(c: &mut Criterion) {
    let (graph, _, last) = walk();
    let mut solved = graph.clone();
    solved.optimize(100);
    let mut grown = solved.clone();
    let next = solved.poses()[last[0].from] * last[0].motion;
    grown.add_pose(next);
    for edge in last {
        grown.add_edge(edge);
    }
    let mut group = c.benchmark_group("pose_graph_3500");
    group.sample_size(20);
    for (name, graph) in [("from_odometry", &graph), ("one_pose_more", &grown)] {
        group.bench_function(name, |b| {
            b.iter_batched_ref(
                || graph.clone(),
                |graph| graph.optimize(100),
                BatchSize::LargeInput,
            );
        });
    }
    group.bench_function("covariances_to_all", |b| {
        b.iter(|| black_box(&solved).marginals().map(|m| m.relative_covs(100)));
    });
    group.finish();
}

criterion_group!(benches, bench);
criterion_main!(benches);
