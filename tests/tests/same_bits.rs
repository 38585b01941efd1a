//! The same computation gives the same bits natively and in the browser: this file runs in both.
#![allow(missing_docs)] // a test binary has no public interface

use nalgebra::Matrix3;
use slamlab_core::estimation::{Edge, PoseGraph};
use slamlab_core::geom::{Pose2, wrap};
use slamlab_tests::numbers;
#[cfg(target_family = "wasm")]
use wasm_bindgen_test::wasm_bindgen_test as test;

#[cfg(target_family = "wasm")]
wasm_bindgen_test::wasm_bindgen_test_configure!(run_in_dedicated_worker);

/// FNV-1a, 64 bits, over the bits of each number.
struct Hash(u64);

impl Hash {
    fn add(&mut self, value: f64) {
        for byte in value.to_bits().to_le_bytes() {
            self.0 = (self.0 ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
        }
    }
}

fn hash(values: impl IntoIterator<Item = f64>) -> u64 {
    let mut hash = Hash(0xcbf2_9ce4_8422_2325);
    values.into_iter().for_each(|value| hash.add(value));
    hash.0
}

#[test]
fn a_long_chain_of_poses_has_the_same_bits_everywhere() {
    let mut numbers = numbers();
    let mut next = || numbers.next().unwrap_or(0.0);
    let mut pose = Pose2::identity();
    let mut seen = Vec::new();
    for _ in 0..20_000 {
        let step = Pose2::new(0.2 * next(), 0.02 * next() - 0.01, 0.6 * next() - 0.3);
        pose = pose * step.fraction(next());
        let back = pose.inverse() * step;
        seen.extend([pose.x(), pose.y(), pose.heading(), back.x(), back.heading()]);
    }
    assert!(pose.is_finite());
    assert_eq!(hash(seen), POSES);
}

#[test]
fn a_growing_pose_graph_and_its_covariances_have_the_same_bits_everywhere() {
    let mut numbers = numbers();
    let mut next = || numbers.next().unwrap_or(0.0);
    let mut graph = PoseGraph::default();
    graph.add_pose(Pose2::identity());
    for index in 1..400 {
        let step = Pose2::new(1.0 + 0.1 * next(), 0.1 * next(), 0.4 * next() - 0.1);
        let pose = graph.poses()[index - 1] * step;
        graph.add_pose(pose);
        let earlier = (next() * index as f64) as usize;
        for from in [index - 1, earlier] {
            let off = Pose2::new(0.05 * next(), 0.05 * next(), 0.02 * next());
            graph.add_edge(Edge {
                from,
                to: index,
                motion: graph.poses()[from].delta_to(&pose) * off,
                information: Matrix3::new(90.0, 5.0, 1.0, 5.0, 80.0, 2.0, 1.0, 2.0, 300.0),
                cauchy: (from == earlier).then_some(2.0),
            });
        }
        if index % 100 == 50 {
            graph.optimize(20);
        }
    }
    assert!(graph.optimize(50));
    let marginals = graph.marginals();
    let covs = marginals.map(|marginals| marginals.relative_covs(399));
    let covs = covs.unwrap_or_default();
    assert_eq!(covs.len(), 400);
    let poses = graph.poses().iter();
    let poses = poses.flat_map(|pose| [pose.x(), pose.y(), pose.heading()]);
    let covs = covs.iter().flat_map(|cov| cov.iter().copied());
    assert_eq!(hash(poses.chain(covs)), GRAPH);
}

#[test]
fn transcendental_functions_have_the_same_bits_everywhere() {
    let values = numbers().take(50_000).flat_map(|u| {
        let x = 40.0 * u - 20.0;
        [
            libm::sin(x),
            libm::cos(x),
            libm::tan(x),
            libm::atan2(x, 1.0 - u),
            libm::exp(x),
            libm::log(u + 1e-9),
            libm::pow(u + 0.5, x),
            libm::hypot(x, u),
            u.sqrt(),
            wrap(x),
            f64::from(libm::sinf(x as f32)),
            f64::from(libm::expf(x as f32)),
        ]
    });
    assert_eq!(hash(values), FUNCTIONS);
}

/// Computed natively on x86-64; the browser must agree.
const POSES: u64 = 5_761_884_782_168_253_456;
const GRAPH: u64 = 8_162_562_416_672_630_227;
const FUNCTIONS: u64 = 2_941_073_592_640_755_027;
