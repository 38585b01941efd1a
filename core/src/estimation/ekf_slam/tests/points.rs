//! Points in the state: each step against the dense matrices of the textbook, and whether the
//! covariance is honest over whole runs.

use nalgebra::{DMatrix, Vector2, Vector3};

use super::super::point_model::place;
use super::super::robot_state::Step;
use super::super::*;
use super::run::{Corners, Run, ring};
use super::{ONCE, dense, feature, odometry, plain, point, some_state};
use crate::features::PointKind;
use crate::geom::{Length, chi2_quantile, wrap};
use crate::robot::OdometryNoise;

const POST: PointKind = PointKind::Circle {
    radius: 0.1,
    var_radius: 1e-4,
};

fn with(landmarks: LandmarkKinds) -> EkfConfig {
    EkfConfig {
        landmarks,
        point_sigma: 0.0,
        ..plain()
    }
}

/// A filter that knows three walls and two points, and has moved since.
fn mixed_state() -> EkfSlam {
    let mut slam = some_state();
    slam.config.landmarks = LandmarkKinds::Both;
    slam.config.point_sigma = 0.0;
    let points = [
        point(Point2::new(2.0, 0.5), POST),
        PointFeature {
            beams: [60, 70],
            ..point(Point2::new(-1.0, 3.0), PointKind::Corner)
        },
    ];
    slam.update_with_points(&[], &points, &ONCE).unwrap();
    let noise = Matrix3::from_diagonal(&Vector3::new(4e-3, 2e-3, 1e-3));
    slam.advance(&odometry(Pose2::new(0.2, 0.1, 0.2), noise));
    assert_eq!(slam.points.len(), 2);
    slam
}

#[test]
fn update_by_a_point_is_the_dense_joseph_form() {
    for index in 0..2 {
        let mut slam = mixed_state();
        let before = dense(&slam);
        let n = before.nrows();
        let expected = slam.expect_point(&slam.points[index]);
        // H by central differences, at the newest estimates, as in the textbook.
        let (pose, at) = (slam.pose, slam.points[index].position);
        let z = |p: [f64; 5]| {
            let pose = Pose2::new(p[0], p[1], p[2]);
            pose.inverse() * Point2::new(p[3], p[4])
        };
        let state = [pose.x(), pose.y(), pose.heading(), at.x, at.y];
        let mut h = DMatrix::zeros(2, n);
        for (axis, column) in [0, 1, 2, expected.jacobian.row, expected.jacobian.row + 1]
            .into_iter()
            .enumerate()
        {
            let nudged = |by: f64| {
                let mut p = state;
                p[axis] += by;
                z(p)
            };
            let slope = (nudged(1e-6) - nudged(-1e-6)) / 2e-6;
            h.view_mut((0, column), (2, 1)).copy_from(&slope);
        }
        let off = Vector2::new(0.02, -0.01);
        let seen = point(expected.position + off, slam.points[index].kind);
        let r = DMatrix::from_fn(2, 2, |i, j| seen.cov[(i, j)]);
        let inverse = (&h * &before * h.transpose() + &r).try_inverse().unwrap();
        let k = &before * h.transpose() * &inverse;
        let rest = DMatrix::identity(n, n) - &k * &h;
        let joseph = &rest * &before * rest.transpose() + &k * r * k.transpose();
        let shift = &k * DMatrix::from_column_slice(2, 1, off.as_slice());
        let numbers = |s: &EkfSlam| {
            let pose = [s.pose.x(), s.pose.y(), s.pose.heading()];
            let errors = [s.errors.curvature, s.errors.turn_scale];
            let walls = s.landmarks.iter().flat_map(|e| e.line);
            let points = s.points.iter().flat_map(|e| [e.position.x, e.position.y]);
            let all = pose.into_iter().chain(errors).chain(walls).chain(points);
            all.collect::<Vec<_>>()
        };
        let (old, d2) = (numbers(&slam), (off.transpose() * inverse * off)[0]);
        slam.scans += 1;
        let decision = slam.take_in_point(0, &seen, None);
        assert_eq!(decision, Decision::Matched(slam.points[index].id));
        assert!((dense(&slam) - &joseph).length() < 1e-9, "{index}");
        for (i, (new, old)) in numbers(&slam).iter().zip(&old).enumerate() {
            assert!((wrap(new - old) - shift[i]).abs() < 1e-9, "state {i}");
        }
        let found = slam.report.point_matches.last().unwrap();
        assert!((found.d2 - d2).abs() < 1e-6 * d2, "{} {d2}", found.d2);
    }
}

#[test]
fn augmentation_by_a_point_is_the_dense_one() {
    let mut slam = mixed_state();
    let (before, pose) = (dense(&slam), slam.pose);
    let seen = point(Point2::new(4.0, -2.0), PointKind::Corner);
    slam.augment_point(&seen);
    let n = before.nrows();
    let g =
        |p: [f64; 3], z: Point2<f64>| place(&Pose2::new(p[0], p[1], p[2]), z, Point2::origin()).0;
    let p = [pose.x(), pose.y(), pose.heading()];
    let mut by_state = DMatrix::zeros(n + 2, n);
    by_state.view_mut((0, 0), (n, n)).fill_with_identity();
    let mut by_seen = DMatrix::zeros(n + 2, 2);
    for axis in 0..3 {
        let nudged = |by: f64| {
            let mut p = p;
            p[axis] += by;
            g(p, seen.position)
        };
        let slope = (nudged(1e-6) - nudged(-1e-6)) / 2e-6;
        by_state.view_mut((n, axis), (2, 1)).copy_from(&slope);
    }
    for axis in 0..2 {
        let mut step = Vector2::zeros();
        step[axis] = 1e-6;
        let slope = (g(p, seen.position + step) - g(p, seen.position - step)) / 2e-6;
        by_seen.view_mut((n, axis), (2, 1)).copy_from(&slope);
    }
    let r = DMatrix::from_fn(2, 2, |i, j| seen.cov[(i, j)]);
    let expect = &by_state * before * by_state.transpose() + &by_seen * r * by_seen.transpose();
    assert!((dense(&slam) - expect).length() < 1e-8);
}

#[test]
fn forgetting_walls_and_points_leaves_the_marginal_of_the_rest() {
    let mut slam = mixed_state();
    let before = dense(&slam);
    let gone = [slam.landmarks[1].id, slam.points[0].id];
    slam.landmarks[0].sightings = 5;
    slam.landmarks[2].sightings = 5;
    slam.points[1].sightings = 5;
    slam.scans += slam.config.patience + 1;
    let report = slam.update(&[], &ONCE).unwrap();
    assert_eq!(report.forgotten, gone);
    // Rows of the second wall, and of the first point, which was the fourth landmark.
    let rest = before
        .remove_rows(ROBOT + 6, 2)
        .remove_rows(ROBOT + 2, 2)
        .remove_columns(ROBOT + 6, 2)
        .remove_columns(ROBOT + 2, 2);
    assert_eq!(dense(&slam), rest);
    assert_eq!(slam.points[0].row, ROBOT + 4);
    assert_eq!(
        slam.point_landmarks().next().unwrap().cov,
        slam.block(ROBOT + 4)
    );
}

#[test]
fn two_landmarks_of_one_post_become_one() {
    let mut slam = EkfSlam::new(with(LandmarkKinds::Points)).unwrap();
    let post = point(Point2::new(2.0, 1.0), POST);
    for _ in 0..4 {
        slam.update_with_points(&[], &[post], &ONCE).unwrap();
    }
    // The same point again, as if it had not been recognised.
    slam.augment_point(&point(Point2::new(2.01, 1.0), POST));
    slam.points[1].sightings = 4;
    let (before, sure) = (slam.points[0].position.x, dense(&slam)[(ROBOT, ROBOT)]);
    let report = slam.update_with_points(&[], &[post], &ONCE).unwrap();
    assert_eq!(report.merged.len(), 1);
    let kept = slam.point_landmarks().next().unwrap();
    assert_eq!(
        (slam.points.len(), kept.id, kept.sightings),
        (1, LandmarkId(0), 9)
    );
    assert!(kept.position.x > before && kept.cov[(0, 0)] < sure);
    assert_eq!(dense(&slam).nrows(), ROBOT + 2);
    // Two that are apart stay two.
    let beside = point(Point2::new(2.0, 1.3), POST);
    for _ in 0..9 {
        let both = [
            post,
            PointFeature {
                beams: [80, 90],
                ..beside
            },
        ];
        slam.update_with_points(&[], &both, &ONCE).unwrap();
    }
    assert_eq!(slam.points.len(), 2);
}

#[test]
fn confidence_counts_how_often_a_landmark_was_found_again() {
    let mut slam = EkfSlam::new(with(LandmarkKinds::Both)).unwrap();
    let (wall, post) = (feature(0.1, 3.0), point(Point2::new(2.0, 1.0), POST));
    for again in 0..5 {
        slam.update_with_points(&[wall], &[post], &ONCE).unwrap();
        assert_eq!(slam.landmarks().next().unwrap().confidence(), again);
        assert_eq!(slam.point_landmarks().next().unwrap().confidence(), again);
    }
    // If it is not seen, its count neither grows nor falls.
    slam.update_with_points(&[wall], &[], &ONCE).unwrap();
    assert_eq!(slam.point_landmarks().next().unwrap().confidence(), 4);
}

#[test]
fn only_what_is_asked_for_becomes_a_landmark() {
    let wall = feature(0.1, 3.0);
    let seen = [
        point(Point2::new(2.0, 1.0), POST),
        PointFeature {
            beams: [60, 70],
            ..point(Point2::new(1.0, -2.0), PointKind::Corner)
        },
        PointFeature {
            beams: [80, 90],
            ..point(Point2::new(-2.0, -2.0), PointKind::Spike)
        },
        PointFeature {
            beams: [100, 110],
            ..point(Point2::new(-3.0, 2.0), PointKind::Crossing)
        },
    ];
    for (kinds, expect) in [
        (LandmarkKinds::Lines, (1, 0)),
        (LandmarkKinds::Points, (0, 2)),
        (LandmarkKinds::Both, (1, 2)),
    ] {
        let mut slam = EkfSlam::new(with(kinds)).unwrap();
        slam.update_with_points(&[wall], &seen, &ONCE).unwrap();
        assert_eq!((slam.landmarks.len(), slam.points.len()), expect);
        assert_eq!(slam.covariance().n(), ROBOT + 2 * (expect.0 + expect.1));
    }
}

#[test]
fn corner_on_a_wall_is_rejected_where_it_gets_no_part() {
    let config = EkfConfig {
        shared_part: 0.0,
        ..with(LandmarkKinds::Both)
    };
    let mut slam = EkfSlam::new(config).unwrap();
    let on_it = PointFeature {
        beams: [15, 30],
        ..point(Point2::new(3.0, 1.0), PointKind::Corner)
    };
    let report = slam
        .update_with_points(&[feature(0.0, 3.0)], &[on_it], &ONCE)
        .unwrap();
    let decisions: Vec<_> = report.point_explanations().map(|e| e.decision).collect();
    assert_eq!(decisions, [Decision::Rejected(Rejection::OnAWall)]);
    assert!(slam.points.is_empty());
}

#[test]
fn bad_points_are_named_and_change_nothing() {
    let mut slam = mixed_state();
    let before = (slam.pose, slam.points.clone(), dense(&slam), slam.scans);
    let fine = point(Point2::new(2.0, 1.0), POST);
    let negative = PointKind::Circle {
        radius: 0.1,
        var_radius: -1.0,
    };
    let endless = PointKind::Circle {
        radius: f64::INFINITY,
        var_radius: 1.0,
    };
    let flat = PointFeature {
        cov: Matrix2::new(1.0, 2.0, 2.0, 1.0),
        ..fine
    };
    for (bad, words) in [
        (point(Point2::new(f64::NAN, 1.0), POST), "not finite"),
        (point(fine.position, endless), "not finite"),
        (point(fine.position, negative), "negative"),
        (flat, "positive definite"),
    ] {
        let error = slam.update_with_points(&[], &[fine, bad], &ONCE);
        let error = error.unwrap_err().to_string();
        assert!(
            error.starts_with("point 1: ") && error.contains(words),
            "{error}"
        );
    }
    assert_eq!(
        before,
        (slam.pose, slam.points.clone(), dense(&slam), slam.scans)
    );
}

/// As with walls; but in a textbook filter over points only the heading is lost: H with respect to
/// the robot's position and to the point's differs only in sign, wherever it is evaluated.
#[test]
fn observability_matrix_over_points_lacks_three_ranks_with_first_estimates() {
    for (consistency, unobservable) in [(Consistency::FirstEstimates, 3), (Consistency::Plain, 2)] {
        let mut slam = EkfSlam::new(EkfConfig {
            consistency,
            ..with(LandmarkKinds::Points)
        })
        .unwrap();
        let places = [(3.0, 1.0), (-2.0, 4.0), (1.0, -3.0)];
        let posts = places.map(|(x, y)| point(Point2::new(x, y), POST));
        slam.update_with_points(&[], &posts, &ONCE).unwrap();
        let n = POSE + 2 * posts.len();
        let mut transition = DMatrix::<f64>::identity(n, n);
        let mut rows = vec![];
        for round in 0..10 {
            let noise = Matrix3::from_diagonal(&Vector3::new(1e-3, 1e-3, 1e-3));
            let motion = odometry(Pose2::new(0.3, 0.1, 0.2), noise);
            let step = Step::new(&slam.pose, &slam.errors, &motion, slam.linearised_at());
            slam.advance(&motion);
            let mut f = DMatrix::identity(n, n);
            f.view_mut((0, 0), (POSE, POSE))
                .copy_from(&step.by_robot.fixed_columns::<POSE>(0));
            transition = f * transition;
            slam.scans += 1;
            for index in 0..posts.len() {
                let expected = slam.expect_point(&slam.points[index]);
                let mut h = DMatrix::zeros(2, n);
                h.view_mut((0, 0), (2, POSE))
                    .copy_from(&expected.jacobian.by_pose);
                h.view_mut((0, POSE + 2 * index), (2, 2))
                    .copy_from(&expected.jacobian.by_own);
                rows.push(h * &transition);
                let off = 0.03 * f64::from((round * 3 + index as i32) % 5 - 2);
                let seen = point(expected.position + Vector2::new(off, -off), POST);
                let decision = slam.take_in_point(
                    index,
                    &seen,
                    Some(Paired::Landmark(slam.points[index].row)),
                );
                assert!(matches!(decision, Decision::Matched(_)));
            }
        }
        let matrix = DMatrix::from_fn(2 * rows.len(), n, |i, j| rows[i / 2][(i % 2, j)]);
        let singular = matrix.singular_values();
        let nothing = singular.iter().filter(|s| **s < 1e-9 * singular[0]).count();
        assert_eq!(nothing, unobservable, "{consistency:?}: {singular}");
    }
}

/// The honesty of the filter over many runs.
struct Honesty {
    /// Mean NEES of the pose at the ends of the runs, 3 is honest.
    pose: f64,
    /// Mean NEES of the confirmed points there, 2 is honest.
    points: f64,
    /// Mean of NIS by its number of matches, 2 is honest.
    nis: f64,
    wrong: u32,
}

const RUNS: u64 = 60;

/// One lap of a ring with posts beside the path, for each seed.
fn honesty(config: EkfConfig, corners: Corners, has_posts: bool) -> Honesty {
    let (w, h) = (8.0, 6.0);
    let start = Pose2::new(-0.5 * w, -0.5 * h, 0.0);
    let posts = [
        (-2.5, -2.4),
        (0.5, -3.6),
        (2.5, -2.4),
        (4.6, -1.5),
        (3.4, 1.0),
        (2.5, 3.6),
        (-0.5, 2.4),
        (-3.0, 3.7),
        (-4.6, 0.5),
        (-3.4, -1.2),
    ];
    let mut sum = Honesty {
        pose: 0.0,
        points: 0.0,
        nis: 0.0,
        wrong: 0,
    };
    let mut n_points = 0;
    for seed in 0..RUNS {
        let mut run = Run::new(config, &ring(w, h), start, 8.0, seed);
        if has_posts {
            let places = posts
                .iter()
                .map(|&(x, y)| start.inverse() * Point2::new(x, y));
            run.posts = places.collect();
        }
        run.corners = corners;
        // Small enough that nonlinearity does not matter: a heading noise of 2° per root metre.
        run.noise = OdometryNoise {
            per_metre: 2.5e-5,
            lateral_per_metre: 1e-5,
            heading_per_radian: 2e-4,
        };
        run.drive_ring(w, h, 1);
        sum.pose += run.end_nees() / RUNS as f64;
        sum.nis += run.nis.0 / run.nis.1 as f64 / RUNS as f64;
        sum.wrong += run.wrong;
        for known in run.slam.point_landmarks().filter(|p| p.is_confirmed) {
            let truth = run.true_points.iter().find(|(id, _)| *id == known.id);
            let off = truth.unwrap().1 - known.position;
            sum.points += off.dot(&known.cov.cholesky().unwrap().solve(&off));
            n_points += 1;
        }
    }
    sum.points /= f64::from(n_points.max(1));
    println!(
        "pose {:.2}, {n_points} points {:.2}, NIS {:.2}, {} wrong",
        sum.pose, sum.points, sum.nis, sum.wrong
    );
    sum
}

/// 99 % interval of the mean over the runs of an honest filter.
fn bounds(degrees: f64) -> [f64; 2] {
    let n = degrees * RUNS as f64;
    [-2.576, 2.576].map(|sigmas| chi2_quantile(n, sigmas) / RUNS as f64)
}

fn is_within(value: f64, [low, high]: [f64; 2]) -> bool {
    (low..=high).contains(&value)
}

/// Asserts that the mean of an NEES with this many degrees of freedom is that of an honest filter.
#[track_caller]
fn assert_honest(nees: f64, degrees: f64) {
    let honest = bounds(degrees);
    assert!(is_within(nees, honest), "{nees} of {honest:?}");
}

#[test]
fn posts_alone_are_honest_over_runs() {
    let config = EkfConfig {
        consistency: Consistency::FirstEstimates,
        ..with(LandmarkKinds::Points)
    };
    let found = honesty(config, Corners::None, true);
    assert_honest(found.pose, 3.0);
    // Points of a run err together, so their mean has the spread of a single one.
    assert_honest(found.points, 2.0);
    assert!(is_within(found.nis, [1.9, 2.1]), "{}", found.nis);
}

#[test]
fn walls_and_posts_in_one_state_are_honest_over_runs() {
    let config = EkfConfig {
        consistency: Consistency::FirstEstimates,
        ..with(LandmarkKinds::Both)
    };
    let found = honesty(config, Corners::None, true);
    assert_honest(found.pose, 3.0);
    assert_honest(found.points, 2.0);
    assert!(is_within(found.nis, [1.8, 2.1]), "{}", found.nis);
}

#[test]
fn corners_of_walls_that_are_known_too_are_not_believed_twice() {
    let config = EkfConfig {
        consistency: Consistency::FirstEstimates,
        ..with(LandmarkKinds::Both)
    };
    let honest = honesty(config, Corners::Honest, false);
    // As if they had been found by beams of their own.
    let posing = honesty(config, Corners::Posing, false);
    let [pose, points] = [3.0, 2.0].map(|degrees| bounds(degrees)[1]);
    assert!(honest.pose <= pose, "{} of {pose}", honest.pose);
    assert!(honest.points <= points, "{} of {points}", honest.points);
    assert!(
        posing.points > points && posing.pose > 1.2 * honest.pose,
        "pose {}, points {} of {points}",
        posing.pose,
        posing.points
    );
}
