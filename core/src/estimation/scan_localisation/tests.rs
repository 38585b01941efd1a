//! A room with a pillar, seen exactly; and the update compared with the textbook's, written out.

use nalgebra::{Matrix5, SMatrix, Vector2, Vector5};

use super::*;
use crate::estimation::OdometryErrors;
use crate::geom::{Length, Pose2};
use crate::robot::{Odometry, Stamp};

/// Faces of a room of 6 x 4 m and of a pillar in it: the free side lies to the left.
fn faces() -> Vec<Segment> {
    let ring = |corners: &[[f64; 2]]| -> Vec<Segment> {
        let at = |i: usize| {
            let [x, y] = corners[i % corners.len()];
            Point2::new(x, y)
        };
        let count = corners.len();
        (0..count).map(|i| Segment::new(at(i), at(i + 1))).collect()
    };
    let mut all = ring(&[[-2.0, -1.0], [4.0, -1.0], [4.0, 3.0], [-2.0, 3.0]]);
    all.extend(ring(&[[2.0, 1.0], [2.0, 1.6], [2.7, 1.6], [2.7, 1.0]]));
    all
}

/// Surfaces seen from `at`: every piece whose free side faces it; occlusion is ignored.
fn seen_from(at: &Pose2, faces: &[Segment]) -> Vec<OrientedPoint> {
    let to = at.inverse();
    let pieces = faces.iter().flat_map(|face| pieces(face, 0.04));
    let faces_robot = |s: &Surfel| s.normal.dot(&(at.position() - s.position)) > 0.0;
    pieces
        .filter(faces_robot)
        .map(|s| OrientedPoint {
            position: to * s.position,
            normal: to.rotate(s.normal),
        })
        .collect()
}

fn begun_at(start: Pose2, sigmas: [f64; 3]) -> (ScanLocaliser, RobotState) {
    let sigmas = Vector3::from(sigmas);
    let start = PoseEstimate {
        pose: start,
        cov: Matrix3::from_diagonal(&sigmas.component_mul(&sigmas)),
    };
    let prior = OdometryErrors {
        curvature: 0.05,
        turn_scale: 0.05,
    };
    let state = RobotState::starting(&start, &prior).unwrap();
    (ScanLocaliser::new(&faces()).unwrap(), state)
}

fn off(state: &RobotState, truth: &Pose2) -> [f64; 2] {
    let d = truth.delta_to(&state.pose);
    [d.position().coords.length(), d.heading().abs()]
}

#[test]
fn a_start_that_is_roughly_known_becomes_exact() {
    let truth = Pose2::new(0.3, 0.4, 0.8);
    let (mut localiser, mut state) =
        begun_at(truth * Pose2::new(0.1, -0.08, 0.06), [0.1, 0.1, 0.06]);
    for _ in 0..5 {
        localiser.update(&mut state, &seen_from(&truth, &faces()), 0.0);
    }
    let [way, turn] = off(&state, &truth);
    assert!(way < 2e-3 && turn < 1e-3, "{way} m, {turn} rad");
}

#[test]
fn a_robot_carried_off_is_found_again() {
    let claimed = Pose2::new(0.0, 0.0, 0.0);
    let (mut localiser, mut state) = begun_at(claimed, [0.01, 0.01, 0.01]);
    localiser.update(&mut state, &seen_from(&claimed, &faces()), 0.0);
    let truth = Pose2::new(1.1, 0.9, 0.4);
    let mut scans = 0;
    while off(&state, &truth)[0] > 0.01 {
        localiser.update(&mut state, &seen_from(&truth, &faces()), 0.0);
        scans += 1;
        assert!(scans < 40, "{:?}", state.pose);
    }
    // The first window reaches half a metre: more than one scan was needed.
    assert!(scans > 1, "{scans}");
}

#[test]
fn a_scan_of_another_place_moves_nothing_far() {
    let start = Pose2::new(0.0, 0.0, 0.0);
    let (mut localiser, mut state) = begun_at(start, [0.01, 0.01, 0.01]);
    // Walls in a star shape: no three of them fit the room.
    let strange: Vec<OrientedPoint> = (0..200)
        .map(|i| {
            let angle = 0.4 * f64::from(i);
            let (sin, cos) = crate::geom::sin_cos(angle);
            OrientedPoint {
                position: Point2::new(
                    cos * (0.3 + 0.003 * f64::from(i)),
                    sin * (0.3 + 0.003 * f64::from(i)),
                ),
                normal: Vector2::new(-cos, -sin),
            }
        })
        .collect();
    for _ in 0..40 {
        localiser.update(&mut state, &strange, 0.0);
    }
    assert!(off(&state, &start)[0] < 0.2, "{:?}", state.pose);
}

#[test]
fn walls_without_thickness_are_met_from_both_sides() {
    let there = faces();
    let both: Vec<Segment> = there
        .iter()
        .flat_map(|f| [*f, Segment::new(f.b, f.a)])
        .collect();
    assert!(are_thin(&both) && !are_thin(&there));
}

#[test]
fn the_update_is_that_of_a_filter_over_all_five_states() {
    // A measured pose z with information I, reduced by Q: the Kalman update of (x, y, θ, κ, s) with
    // R = I⁻¹ + Q.
    let (_, mut state) = begun_at(Pose2::new(0.2, -0.1, 0.3), [0.03, 0.02, 0.04]);
    let moved = Odometry {
        motion: Pose2::new(0.5, 0.0, 0.4),
        cov: Matrix3::from_diagonal_element(1e-4),
        ..Odometry::standing(Stamp(0))
    };
    state.predict(&moved).unwrap();
    let before = state;
    let said = Matrix3::new(900.0, 40.0, -30.0, 40.0, 1600.0, 55.0, -30.0, 55.0, 2500.0);
    let z = Vector3::new(0.012, -0.009, 0.021);
    let predicted = before.estimate();
    let information = predicted.cov.try_inverse().unwrap();
    let both = (information + said).try_inverse().unwrap();
    let matched = both * said * z;
    let at = &predicted.pose;
    let found = Registration {
        estimate: PoseEstimate {
            pose: at.plus(&matched),
            cov: both,
        },
        information: said,
        inliers: 100,
        overlap: 1.0,
        residual: 0.0,
        iterations: 1,
        verdict: Verdict::Converged,
    };
    let swept = 3e-4;
    correct(&mut state, &predicted, &found, swept);

    let h = SMatrix::<f64, 3, 5>::identity();
    let mut noise = said.try_inverse().unwrap();
    noise[(2, 2)] += swept;
    let gain = before.cov
        * h.transpose()
        * (h * before.cov * h.transpose() + noise)
            .try_inverse()
            .unwrap();
    let cov = (Matrix5::identity() - gain * h) * before.cov;
    let shift: Vector5<f64> = gain * z;
    let after = &state;
    let moved = after.pose.minus(at);
    let got = [
        moved.x,
        moved.y,
        moved.z,
        after.errors.curvature,
        after.errors.turn_scale,
    ];
    for (i, got) in got.into_iter().enumerate() {
        assert!((got - shift[i]).abs() < 1e-9, "{i}: {got} {}", shift[i]);
    }
    assert!((after.cov - cov).amax() < 1e-9, "{}", after.cov - cov);
}

#[test]
fn walls_longer_or_farther_than_can_be_held_are_refused_before_memory_is_taken() {
    let wall = |x: f64, y: f64| Segment::new(Point2::new(-x, y), Point2::new(x, y));
    let parallel = |count: u32, x: f64| (0..count).map(move |row| wall(x, f64::from(row) * 0.1));
    let said = |faces: Vec<Segment>| {
        ScanLocaliser::new(&faces)
            .err()
            .map(|error| error.to_string())
    };
    assert!(
        said(parallel(200, 700.0).collect())
            .unwrap()
            .contains("pieces")
    );
    assert!(said(vec![wall(900.0, 0.0)]).unwrap().contains("800"));
    assert!(said(parallel(20, 700.0).collect()).is_none());
    // As wide as `campus`, and wider: a lost robot is still searched for.
    for half in [180.0, 700.0] {
        let around = vec![wall(half, -half), wall(half, half)];
        assert!(
            ScanLocaliser::new(&around)
                .unwrap()
                .walls
                .likelihood
                .is_some(),
            "{half} m"
        );
    }
}
