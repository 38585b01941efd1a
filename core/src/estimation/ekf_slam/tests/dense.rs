//! Each step of the filter against the dense matrices of the textbook, Jacobians by central
//! differences.

use nalgebra::{DMatrix, SVector, Vector2, Vector3};

use super::super::super::line_model::place;
use super::super::robot_state::Step;
use super::super::*;
use super::{ONCE, dense, feature, odometry, some_state};
use crate::geom::{Length, wrap};

#[test]
fn prediction_is_the_dense_one() {
    let mut slam = some_state();
    let (before, pose, errors) = (dense(&slam), slam.pose, slam.errors);
    let motion = odometry(
        Pose2::new(0.7, 0.2, 0.5),
        Matrix3::new(2e-3, 1e-4, 2e-4, 1e-4, 1e-3, 3e-4, 2e-4, 3e-4, 5e-3),
    );
    slam.advance(&motion);
    // Full Jacobians, by central differences.
    let n = before.nrows();
    let after = |p: SVector<f64, ROBOT>, u: Vector3<f64>| {
        let errors = OdometryErrors {
            curvature: p[3],
            turn_scale: p[4],
        };
        let read = odometry(motion.motion, Matrix3::zeros());
        let start = Pose2::new(p[0], p[1], p[2]);
        let exact = Step::new(&Pose2::identity(), &errors, &read, Point2::origin()).pose;
        let noisy = Pose2::new(exact.x() + u.x, exact.y() + u.y, exact.heading() + u.z);
        let moved = start * noisy;
        Vector3::new(moved.x(), moved.y(), moved.heading())
    };
    let p = SVector::from([
        pose.x(),
        pose.y(),
        pose.heading(),
        errors.curvature,
        errors.turn_scale,
    ]);
    let (mut fx, mut fu) = (DMatrix::identity(n, n), DMatrix::zeros(n, 3));
    let none = Vector3::zeros();
    for axis in 0..ROBOT {
        let mut h = SVector::<f64, ROBOT>::zeros();
        h[axis] = 1e-6;
        let by_robot = (after(p + h, none) - after(p - h, none)) / 2e-6;
        fx.view_mut((0, axis), (3, 1)).copy_from(&by_robot);
    }
    for axis in 0..3 {
        let mut h = Vector3::zeros();
        h[axis] = 1e-6;
        let by_motion = (after(p, h) - after(p, -h)) / 2e-6;
        fu.view_mut((0, axis), (3, 1)).copy_from(&by_motion);
    }
    let q = DMatrix::from_fn(3, 3, |i, j| motion.cov[(i, j)]);
    let expect = &fx * before * fx.transpose() + &fu * q * fu.transpose();
    assert!((dense(&slam) - expect).length() < 1e-9);
}

#[test]
fn update_is_the_dense_joseph_form() {
    for landmark in 0..3 {
        let mut slam = some_state();
        let before = dense(&slam);
        let n = before.nrows();
        let expected = slam.expect(landmark);
        let seen = feature(expected.line.alpha + 0.01, expected.line.r - 0.02);
        let mut h = DMatrix::zeros(2, n);
        h.view_mut((0, 0), (2, 3))
            .copy_from(&expected.jacobian.by_pose);
        h.view_mut((0, ROBOT + 2 * landmark), (2, 2))
            .copy_from(&expected.jacobian.by_own);
        let r = DMatrix::from_fn(2, 2, |i, j| seen.cov[(i, j)]);
        let z = &h * &before * h.transpose() + &r;
        let k = &before * h.transpose() * z.try_inverse().unwrap();
        let rest = DMatrix::identity(n, n) - &k * &h;
        let joseph = &rest * &before * rest.transpose() + &k * r * k.transpose();
        let shift = &k * DMatrix::from_column_slice(2, 1, &[0.01, -0.02]);
        let state = |s: &EkfSlam| {
            let pose = [
                s.pose.x(),
                s.pose.y(),
                s.pose.heading(),
                s.errors.curvature,
                s.errors.turn_scale,
            ];
            let lines = s.landmarks.iter().flat_map(|e| e.line);
            pose.into_iter().chain(lines).collect::<Vec<_>>()
        };
        let old = state(&slam);
        slam.correct(landmark, &seen);
        assert!((dense(&slam) - &joseph).length() < 1e-12, "{landmark}");
        for (i, (new, old)) in state(&slam).iter().zip(&old).enumerate() {
            assert!((new - old - shift[i]).abs() < 1e-9, "state {i}");
        }
    }
}

#[test]
fn augmentation_is_the_dense_one() {
    let mut slam = some_state();
    let (before, pose) = (dense(&slam), slam.pose);
    let seen = feature(2.9, 4.0);
    slam.augment(&seen);
    let anchor = slam.landmarks[3].anchor;
    // y' = g(y, z), its Jacobians by central differences.
    let n = before.nrows();
    let g = |p: [f64; 3], z: [f64; 2]| {
        let pose = Pose2::new(p[0] - anchor.x, p[1] - anchor.y, p[2]);
        place(&pose, z, Point2::origin()).0
    };
    let (p, z) = ([pose.x(), pose.y(), pose.heading()], [2.9, 4.0]);
    let mut by_state = DMatrix::zeros(n + 2, n);
    by_state.view_mut((0, 0), (n, n)).fill_with_identity();
    let mut by_seen = DMatrix::zeros(n + 2, 2);
    let column = |plus: [f64; 2], minus: [f64; 2]| {
        [wrap(plus[0] - minus[0]) / 2e-6, (plus[1] - minus[1]) / 2e-6]
    };
    for axis in 0..3 {
        let (mut plus, mut minus) = (p, p);
        (plus[axis], minus[axis]) = (p[axis] + 1e-6, p[axis] - 1e-6);
        let c = column(g(plus, z), g(minus, z));
        (by_state[(n, axis)], by_state[(n + 1, axis)]) = (c[0], c[1]);
    }
    for axis in 0..2 {
        let (mut plus, mut minus) = (z, z);
        (plus[axis], minus[axis]) = (z[axis] + 1e-6, z[axis] - 1e-6);
        let c = column(g(p, plus), g(p, minus));
        (by_seen[(n, axis)], by_seen[(n + 1, axis)]) = (c[0], c[1]);
    }
    let r = DMatrix::from_fn(2, 2, |i, j| seen.cov[(i, j)]);
    let expect = &by_state * before * by_state.transpose() + &by_seen * r * by_seen.transpose();
    assert!((dense(&slam) - expect).length() < 1e-8);
}

#[test]
fn landmark_in_the_map_has_the_covariance_of_numeric_propagation() {
    let slam = some_state();
    for (index, landmark) in slam.landmarks().enumerate() {
        let entry = &slam.landmarks[index];
        let in_map = |da: f64, dr: f64| {
            let mut moved = entry.clone();
            moved.line = [entry.line[0] + da, entry.line[1] + dr];
            moved.in_map(&Matrix2::zeros()).0
        };
        let h = 1e-6;
        let column = |da: f64, dr: f64| {
            let (plus, minus) = (in_map(da, dr), in_map(-da, -dr));
            Vector2::new(wrap(plus.alpha() - minus.alpha()), plus.r() - minus.r()) / (2.0 * h)
        };
        let jacobian = Matrix2::from_columns(&[column(h, 0.0), column(0.0, h)]);
        let expect = jacobian * slam.block(ROBOT + 2 * index) * jacobian.transpose();
        assert!((landmark.cov - expect).length() < 1e-9);
        assert!(
            landmark
                .ends
                .iter()
                .all(|end| landmark.line.signed_distance(*end).abs() < 1e-9)
        );
    }
}

#[test]
fn forgetting_leaves_the_marginal_of_the_rest() {
    let mut slam = some_state();
    let before = dense(&slam);
    let ids: Vec<_> = slam.landmarks().map(|l| l.id).collect();
    slam.landmarks[0].sightings = 5;
    slam.landmarks[2].sightings = 5;
    slam.scans += slam.config.patience + 1;
    let report = slam.update(&[], &ONCE).unwrap();
    assert_eq!(report.forgotten, [ids[1]]);
    assert_eq!(
        dense(&slam),
        before
            .remove_rows(ROBOT + 2, 2)
            .remove_columns(ROBOT + 2, 2)
    );
    assert_eq!(
        slam.landmarks().map(|l| l.id).collect::<Vec<_>>(),
        [ids[0], ids[2]]
    );
}

#[test]
fn correlations_are_those_of_the_dense_matrix() {
    let slam = some_state();
    let (p, found) = (
        dense(&slam),
        Correlations::of(slam.covariance(), slam.landmarks().map(|l| l.id)),
    );
    assert_eq!((found.n, found.landmarks.len()), (p.nrows(), 3));
    assert_eq!(found.first_landmark + 2 * found.landmarks.len(), found.n);
    for i in 0..found.n {
        for j in 0..found.n {
            let expect = p[(i, j)] / (p[(i, i)] * p[(j, j)]).sqrt();
            assert!((f64::from(found.coefficients[i * found.n + j]) - expect).abs() < 1e-6);
        }
    }
}

#[test]
fn singular_innovation_is_told_and_changes_nothing() {
    let mut slam = some_state();
    let before = (slam.pose, slam.landmarks.clone(), dense(&slam));
    let columns = [(0, [1.0, 1.0]), (1, [0.0, 0.0])];
    let v = Vector2::new(0.1, 0.1);
    for z in [
        Matrix2::zeros(),
        Matrix2::new(1.0, 1.0, 1.0, 1.0),
        Matrix2::new(-1.0, 0.0, 0.0, 1.0),
        Matrix2::new(f64::NAN, 0.0, 0.0, 1.0),
    ] {
        assert!(!slam.absorb(&v, &z, &columns), "{z}");
    }
    let infinite = Vector2::new(f64::INFINITY, 0.0);
    let fine = Matrix2::identity();
    assert!(!slam.absorb(&infinite, &fine, &columns));
    assert_eq!(before, (slam.pose, slam.landmarks.clone(), dense(&slam)));
}
