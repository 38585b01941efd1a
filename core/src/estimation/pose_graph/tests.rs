//! Truths: consistent motions, composed covariance, a false closure, public graphs.

use proptest::prelude::*;

use super::*;

fn edge(from: usize, to: usize, motion: Pose2) -> Edge {
    Edge {
        from,
        to,
        motion,
        information: Matrix3::identity() * 100.0,
        cauchy: None,
    }
}

fn pose() -> impl Strategy<Value = Pose2> {
    (-5.0..5.0_f64, -5.0..5.0_f64, -3.1..3.1_f64).prop_map(|(x, y, t)| Pose2::new(x, y, t))
}

proptest! {
    #[test]
    fn jacobians_match_central_differences(a in pose(), b in pose(), z in pose()) {
        let e = edge(0, 1, z);
        prop_assume!(e.error(&a, &b).z.abs() < 3.0);
        let (by_a, by_b) = e.jacobians(&a, &b);
        let h = 1e-6;
        for axis in 0..3 {
            let nudge = |p: &Pose2, h: f64| {
                let mut d = [0.0; 3];
                d[axis] = h;
                Pose2::new(p.x() + d[0], p.y() + d[1], p.heading() + d[2])
            };
            let da = (e.error(&nudge(&a, h), &b) - e.error(&nudge(&a, -h), &b)) / (2.0 * h);
            let db = (e.error(&a, &nudge(&b, h)) - e.error(&a, &nudge(&b, -h))) / (2.0 * h);
            prop_assert!((da - by_a.column(axis)).norm() < 1e-6);
            prop_assert!((db - by_b.column(axis)).norm() < 1e-6);
        }
    }
}

/// Σ χ² of all edges, without kernels.
fn chi2(graph: &PoseGraph) -> f64 {
    graph.edges().iter().map(|edge| graph.chi2_of(edge)).sum()
}

/// A square walked twice around; motions exact, guesses not.
fn square() -> (PoseGraph, Vec<Pose2>) {
    let truth: Vec<_> = (0..40)
        .scan(Pose2::identity(), |at, i| {
            let turn = if i % 5 == 4 {
                std::f64::consts::FRAC_PI_2
            } else {
                0.0
            };
            let here = *at;
            *at = *at * Pose2::new(1.0, 0.0, turn);
            Some(here)
        })
        .collect();
    let mut graph = PoseGraph::default();
    for (i, pose) in truth.iter().enumerate() {
        let off = Pose2::new(0.01 * i as f64, -0.02 * i as f64, 0.01 * i as f64);
        graph.add_pose(*pose * off);
    }
    graph.poses[0] = truth[0];
    for i in 1..40 {
        assert!(graph.add_edge(edge(i - 1, i, truth[i - 1].delta_to(&truth[i]))));
    }
    for i in 20..40 {
        assert!(graph.add_edge(edge(i - 20, i, truth[i - 20].delta_to(&truth[i]))));
    }
    (graph, truth)
}

#[test]
fn consistent_motions_lead_to_the_truth() {
    let (mut graph, truth) = square();
    assert!(
        graph.optimize(50) && chi2(&graph) < 1e-12,
        "{}",
        chi2(&graph)
    );
    for (found, truth) in graph.poses().iter().zip(&truth) {
        assert!(!differs(found, truth, 1e-6, 1e-6));
    }
}

#[test]
fn a_false_closure_does_not_bend_a_map_of_robust_edges() {
    let (mut graph, truth) = square();
    let lie = Edge {
        cauchy: Some(1.0),
        ..edge(3, 33, Pose2::new(4.0, 1.0, 2.0))
    };
    assert!(graph.add_edge(lie));
    graph.optimize(100);
    for (found, truth) in graph.poses().iter().zip(&truth) {
        assert!(!differs(found, truth, 0.05, 0.05), "{found:?} {truth:?}");
    }
}

#[test]
fn marginal_of_a_chain_is_the_composed_covariance() {
    let mut graph = PoseGraph::default();
    let step = Pose2::new(1.0, 0.2, 0.5);
    let mut at = Pose2::identity();
    let mut cov = Matrix3::zeros();
    graph.add_pose(at);
    for i in 0..4 {
        graph.add_pose(at * step);
        assert!(graph.add_edge(edge(i, i + 1, step)));
        // First order: the error of the start is carried over, that of the step is turned into the
        // map.
        let end = at * step;
        let (dx, dy) = (end.x() - at.x(), end.y() - at.y());
        let carry = Matrix3::new(1.0, 0.0, -dy, 0.0, 1.0, dx, 0.0, 0.0, 1.0);
        let (cos, sin) = end.cos_sin();
        let turn = Matrix3::new(cos, -sin, 0.0, sin, cos, 0.0, 0.0, 0.0, 1.0);
        cov = carry * cov * carry.transpose()
            + turn * (Matrix3::identity() / 100.0) * turn.transpose();
        at = end;
    }
    let marginal = graph.marginal(4).unwrap();
    assert!((marginal - cov).norm() < 1e-9, "{marginal} {cov}");
    assert_eq!(graph.marginal(0), Some(Matrix3::zeros()));
}

#[test]
fn impossible_edges_are_refused() {
    let mut graph = PoseGraph::default();
    graph.add_pose(Pose2::identity());
    assert!(!graph.add_edge(edge(0, 3, Pose2::identity())));
    graph.add_pose(Pose2::identity());
    assert!(!graph.add_edge(edge(0, 1, Pose2::new(f64::NAN, 0.0, 0.0))));
    assert!(graph.optimize(5));
}

#[test]
fn what_is_not_in_the_graph_has_no_covariance() {
    for pose in 0..2 {
        assert_eq!(PoseGraph::default().marginal(pose), None);
    }
    let mut graph = PoseGraph::default();
    graph.add_pose(Pose2::identity());
    graph.add_pose(Pose2::identity());
    assert_eq!(graph.marginal(1), None, "no edge holds it");
    assert_eq!(graph.marginal(2), None);
}

fn start_from_tree(graph: &mut PoseGraph) {
    let mut done = vec![false; graph.poses.len()];
    let mut queue = std::collections::VecDeque::from([0]);
    done[0] = true;
    while let Some(at) = queue.pop_front() {
        for edge in &graph.edges {
            let (next, pose) = if edge.from == at {
                (edge.to, graph.poses[at] * edge.motion)
            } else if edge.to == at {
                (edge.from, graph.poses[at] * edge.motion.inverse())
            } else {
                continue;
            };
            if !done[next] {
                done[next] = true;
                graph.poses[next] = pose;
                queue.push_back(next);
            }
        }
    }
}

/// Published graphs: the cost that good solvers end at is a stationary point that no restart
/// improves.
#[test]
fn public_graphs_converge_to_a_stationary_point() {
    for name in ["intel.g2o", "m3500.g2o"] {
        let Some(text) = crate::format::recorded(&format!("posegraphs/{name}")) else {
            continue;
        };
        let text = String::from_utf8(text).unwrap();
        let mut graph = PoseGraph::default();
        for line in text.lines() {
            let words: Vec<_> = line.split_ascii_whitespace().collect();
            let v: Vec<f64> = words[1..].iter().map(|w| w.parse().unwrap()).collect();
            match words[0] {
                "VERTEX_SE2" => {
                    graph.add_pose(Pose2::new(v[1], v[2], v[3]));
                }
                "EDGE_SE2" => assert!(graph.add_edge(Edge {
                    from: v[0] as usize,
                    to: v[1] as usize,
                    motion: Pose2::new(v[2], v[3], v[4]),
                    information: Matrix3::new(
                        v[5], v[6], v[7], v[6], v[8], v[9], v[7], v[9], v[10],
                    ),
                    cauchy: None,
                })),
                _ => {}
            }
        }
        // The files start from raw odometry, which is turned by half a circle: start from the tree
        // of fewest edges.
        start_from_tree(&mut graph);
        let before = chi2(&graph);
        let converged = graph.optimize(100);
        let after = chi2(&graph);
        eprintln!("{name}: χ² {before} before, {after} after");
        assert!(converged && after < before, "{name}");
        graph.optimize(20);
        let gain = after - chi2(&graph);
        assert!(gain < 1e-6 * after, "{name}: {gain}");
    }
}
