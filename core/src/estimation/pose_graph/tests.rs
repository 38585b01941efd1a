//! Ground truths: consistent motions, composed covariance, a false closure, public graphs.

use nalgebra::{DMatrix, DVector};
use proptest::prelude::*;

use super::*;
use crate::geom::Length;

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
            prop_assert!((da - by_a.column(axis)).length() < 1e-6);
            prop_assert!((db - by_b.column(axis)).length() < 1e-6);
        }
    }
}

/// A square traversed twice; motions exact, initial poses not.
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
        let step = truth[i - 1].delta_to(&truth[i]);
        graph.add_edge(edge(i - 1, i, step)).unwrap();
    }
    for i in 20..40 {
        let step = truth[i - 20].delta_to(&truth[i]);
        graph.add_edge(edge(i - 20, i, step)).unwrap();
    }
    (graph, truth)
}

#[test]
fn consistent_motions_lead_to_the_truth() {
    let (mut graph, truth) = square();
    assert!(
        graph.optimize(50) && graph.chi2() < 1e-12,
        "{}",
        graph.chi2()
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
    graph.add_edge(lie).unwrap();
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
        graph.add_edge(edge(i, i + 1, step)).unwrap();
        // First order: the error of the start is propagated, that of the step is rotated into the
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
    assert!((marginal - cov).length() < 1e-9, "{marginal} {cov}");
    assert_eq!(graph.marginal(0), Some(Matrix3::zeros()));
}

#[test]
fn impossible_edges_are_refused() {
    let mut graph = PoseGraph::default();
    graph.add_pose(Pose2::identity());
    assert_eq!(graph.add_edge(edge(0, 3, Pose2::identity())), None);
    graph.add_pose(Pose2::identity());
    assert_eq!(
        graph.add_edge(edge(0, 1, Pose2::new(f64::NAN, 0.0, 0.0))),
        None
    );
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

/// Graphs of a walk with random closures; every pose is connected to the first.
fn graphs() -> impl Strategy<Value = PoseGraph> {
    let steps = proptest::collection::vec((pose(), 0.5..2.0_f64), 1..12);
    let closures =
        proptest::collection::vec((0..12_usize, 0..12_usize, pose(), 0.5..9.0_f64), 0..8);
    (steps, closures).prop_map(|(steps, closures)| {
        let mut graph = PoseGraph::default();
        graph.add_pose(Pose2::new(1.0, 2.0, 0.3));
        for (step, weight) in steps {
            let at = graph.poses().len() - 1;
            let next = graph.add_pose(graph.poses()[at] * step);
            let off = step * Pose2::new(0.01, -0.02, 0.03);
            graph.add_edge(Edge {
                information: information(weight),
                ..edge(at, next, off)
            });
        }
        let count = graph.poses().len();
        for (a, b, off, weight) in closures {
            let (a, b) = (a % count, b % count);
            let motion = graph.poses()[a].delta_to(&graph.poses()[b]) * off.fraction(0.02);
            let cauchy = (weight > 5.0).then_some(weight);
            graph.add_edge(Edge {
                information: information(weight),
                cauchy,
                ..edge(a, b, motion)
            });
        }
        graph
    })
}

/// Correlated, and different along the axes.
fn information(weight: f64) -> Matrix3<f64> {
    let l = Matrix3::new(3.0 * weight, 0.0, 0.0, 1.0, 2.0, 0.0, -0.5, weight, 4.0);
    l * l.transpose()
}

/// Gradient and matrix of the normal equations, from the Jacobians of each edge.
fn dense_equations(graph: &PoseGraph) -> (DMatrix<f64>, DVector<f64>) {
    let size = 3 * graph.poses().len();
    let mut matrix = DMatrix::zeros(size, size);
    let mut gradient = DVector::zeros(size);
    for edge in graph.edges() {
        let (from, to) = (&graph.poses()[edge.from], &graph.poses()[edge.to]);
        let error = edge.error(from, to);
        let chi2 = error.dot(&(edge.information * error));
        let weight = edge.cauchy.map_or(1.0, |c| 1.0 / (1.0 + chi2 / (c * c)));
        let mut jacobian = DMatrix::zeros(3, size);
        let (by_from, by_to) = edge.jacobians(from, to);
        jacobian
            .fixed_view_mut::<3, 3>(0, 3 * edge.from)
            .copy_from(&by_from);
        jacobian
            .fixed_view_mut::<3, 3>(0, 3 * edge.to)
            .copy_from(&by_to);
        let weighted = jacobian.transpose() * (edge.information * weight);
        matrix += &weighted * jacobian;
        gradient += weighted * error;
    }
    // The first pose is fixed.
    let rows = size - 3;
    (
        matrix.view((3, 3), (rows, rows)).into_owned(),
        gradient.rows(3, rows).into_owned(),
    )
}

proptest! {
    #[test]
    fn normal_equations_are_those_of_the_jacobians(graph in graphs()) {
        let pattern = graph.pattern();
        let states: Vec<_> = graph.poses.iter().map(linear::State::from).collect();
        let terms = linear::Terms::new(&graph.edges, &pattern);
        let mut found = linear::Gradient::default();
        let mut sparse = pattern.zeros(None);
        terms.linearise(&states, &mut found, Some(&mut sparse));
        let (matrix, gradient) = dense_equations(&graph);
        for (block, value) in found.by_pose.iter().enumerate() {
            let error = (value - gradient.fixed_rows::<3>(3 * block)).amax();
            prop_assert!(error < 1e-8 * (1.0 + gradient.amax()), "{error}");
        }
        let mut alone = linear::Gradient::default();
        terms.linearise(&states, &mut alone, None);
        prop_assert_eq!(&alone.by_pose, &found.by_pose, "with the matrix or without");
        prop_assert_eq!(alone.cost, found.cost);
        // The matrix, tested by what it solves.
        let factor = pattern.factor(sparse, 0.0);
        prop_assert!(factor.is_some());
        let factor = factor.unwrap();
        let mut step = found.by_pose.clone();
        pattern.solve(&factor, &mut step);
        let expected = matrix.cholesky().unwrap().solve(&gradient);
        for (block, value) in step.iter().enumerate() {
            let error = (value - expected.fixed_rows::<3>(3 * block)).amax();
            prop_assert!(error < 1e-7 * (1.0 + expected.amax()), "{error}");
        }
    }

    #[test]
    fn covariances_are_those_of_the_dense_inverse(graph in graphs()) {
        let (matrix, _) = dense_equations(&graph);
        let inverse = matrix.cholesky().unwrap().inverse();
        let count = graph.poses().len();
        let joint = |a: usize, b: usize| match (a, b) {
            (0, _) | (_, 0) => Matrix3::zeros(),
            _ => inverse.fixed_view::<3, 3>(3 * a - 3, 3 * b - 3).into_owned(),
        };
        let most = 1e-8 * (1.0 + inverse.amax());
        let marginals = graph.marginals().unwrap();
        let from = count / 2;
        let all = marginals.relative_covs(from);
        prop_assert_eq!(all.len(), count);
        for (to, found) in all.iter().enumerate() {
            prop_assert!((graph.marginal(to).unwrap() - joint(to, to)).amax() < most);
            // The motion's derivatives with respect to both poses, as differences.
            let motion = |a: &Pose2, b: &Pose2| a.delta_to(b);
            let (a, b) = (graph.poses()[from], graph.poses()[to]);
            let (mut by_a, mut by_b) = (Matrix3::zeros(), Matrix3::zeros());
            for axis in 0..3 {
                let mut h = nalgebra::Vector3::zeros();
                h[axis] = 1e-6;
                let moved = |up: Pose2, down: Pose2| up.minus(&down) / 2e-6;
                by_a.set_column(axis, &moved(motion(&a.plus(&h), &b), motion(&a.plus(&-h), &b)));
                by_b.set_column(axis, &moved(motion(&a, &b.plus(&h)), motion(&a, &b.plus(&-h))));
            }
            let both = by_a * joint(from, to) * by_b.transpose();
            let expected = by_a * joint(from, from) * by_a.transpose()
                + by_b * joint(to, to) * by_b.transpose() + both + both.transpose();
            let expected = if from == to { Matrix3::zeros() } else { expected };
            let most = 1e-6 * (1.0 + expected.amax());
            prop_assert!((found - expected).amax() < most, "{} {expected}", found);
            let alone = graph.relative_cov(from, to).unwrap();
            prop_assert!((alone - found).amax() < most);
        }
    }

    #[test]
    fn the_cost_never_rises(graph in graphs(), max_iterations in 0..20_usize) {
        let mut moved = graph.clone();
        let found = moved.optimize_with_figures(max_iterations);
        prop_assert!(found.cost[1] <= found.cost[0] && found.iterations <= max_iterations);
        prop_assert_eq!(moved.poses()[0], graph.poses()[0]);
    }

    #[test]
    fn where_it_ends_another_step_would_gain_next_to_nothing(graph in graphs()) {
        let mut moved = graph.clone();
        let found = moved.optimize_with_figures(100);
        prop_assume!(found.converged);
        let (matrix, gradient) = dense_equations(&moved);
        let step = matrix.cholesky().expect("every pose hangs on the first").solve(&gradient);
        let gain = gradient.dot(&step);
        prop_assert!(gain <= 1e-6 * found.cost[1] + 1e-12, "{gain} of {}", found.cost[1]);
    }
}

#[test]
fn relative_covariance_of_a_measured_motion_alone_is_its_own() {
    let mut graph = PoseGraph::default();
    let motion = Pose2::new(2.0, -1.0, 0.7);
    for _ in 0..3 {
        let last = graph.poses().last().copied().unwrap_or_default();
        graph.add_pose(last * motion);
    }
    let cov = Matrix3::new(0.04, 0.01, 0.0, 0.01, 0.09, 0.002, 0.0, 0.002, 0.01);
    let information = information_at_end(&motion, &cov.try_inverse().unwrap());
    for i in 0..2 {
        graph.add_edge(Edge {
            information,
            ..edge(i, i + 1, motion)
        });
    }
    let found = graph.relative_cov(1, 2).unwrap();
    assert!((found - cov).amax() < 1e-12, "{found}");
}

#[test]
fn a_removed_edge_is_forgotten_and_the_others_keep_their_names() {
    let (mut graph, truth) = square();
    let lie = edge(3, 33, Pose2::new(4.0, 1.0, 2.0));
    let id = graph.add_edge(lie).unwrap();
    let kept = graph
        .add_edge(edge(5, 25, truth[5].delta_to(&truth[25])))
        .unwrap();
    graph.optimize(50);
    assert!(graph.edge_chi2(id).unwrap() > 1.0, "bent by the lie");
    assert_eq!(graph.remove_edge(id), Some(lie));
    assert_eq!(
        (graph.remove_edge(id), graph.edge_chi2(id), graph.edge(id)),
        (None, None, None)
    );
    assert_eq!(
        graph.edge(kept).map(|edge| (edge.from, edge.to)),
        Some((5, 25))
    );
    assert_eq!(graph.edges().len(), graph.edge_ids().len());
    assert!(graph.optimize(50));
    for (found, truth) in graph.poses().iter().zip(&truth) {
        assert!(!differs(found, truth, 1e-6, 1e-6));
    }
    let again = graph.add_edge(lie).unwrap();
    assert!(again > kept && again != id, "names are not used twice");
}

/// A graph that grows and is solved repeatedly ends where one ends that is solved once.
#[test]
fn a_growing_graph_ends_where_a_whole_one_does() {
    let (whole, truth) = square();
    let mut grown = PoseGraph::default();
    grown.add_pose(truth[0]);
    for end in 1..whole.poses().len() {
        grown.add_pose(whole.poses()[end]);
        for edge in whole.edges().iter().filter(|e| e.to == end) {
            grown.add_edge(*edge).unwrap();
        }
        assert!(grown.optimize(20), "{end}");
    }
    for (found, truth) in grown.poses().iter().zip(&truth) {
        assert!(!differs(found, truth, 1e-6, 1e-6));
    }
}

/// The published graphs from the files' own poses, compared with the result of g2o (g2o-python
/// 0.0.12, 20 steps of Gauss-Newton).
#[test]
fn public_graphs_end_where_g2o_does() {
    for (name, expected) in [("intel.g2o", 215.830_235), ("m3500.g2o", 137.912_951)] {
        let Some(bytes) = crate::format::recorded(&format!("posegraphs/{name}")) else {
            continue;
        };
        let file = crate::format::g2o::parse(&bytes).unwrap();
        let mut graph = file.to_pose_graph().unwrap();
        let found = graph.optimize_with_figures(30);
        assert!(found.converged, "{name}: {found:?}");
        assert!(
            (graph.chi2() - expected).abs() < 1e-6 * expected,
            "{name}: {}",
            graph.chi2()
        );
        assert!(
            (found.cost[1] - graph.chi2()).abs() < 1e-6 * expected,
            "{name}: {found:?}"
        );
    }
}
