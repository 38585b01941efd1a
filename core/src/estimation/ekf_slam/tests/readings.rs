//! Readings between two scans, against the dense update by one number with its row by central differences.

use nalgebra::{DMatrix, DVector};

use super::super::*;
use super::{ONCE, dense, feature, plain, some_state};
use crate::estimation::Readings;
use crate::geom::sin_cos;
use crate::points::{Beam, Points};
use crate::robot::Stamp;

const SIGMA: f64 = 0.03;
/// What the readings' errors count, and how far a wall's points lie from one another.
const TOGETHER: f64 = 2.5;
const STEP: f64 = 0.05;

/// A beam from the robot's middle to `end`, robot frame.
fn beam(end: Point2<f64>) -> Beam {
    Beam {
        beam_idx: 0,
        origin_in_robot: Point2::origin(),
        end_in_robot: end,
        range: end.coords.norm(),
        sigma: SIGMA,
        is_hit: true,
        quality: None,
    }
}

fn points(beams: Vec<Beam>) -> Points {
    Points {
        stamp: Stamp(1),
        sensor_in_robot: Point2::origin(),
        bearing_sigma: 0.0,
        beams,
    }
}

/// What a scan hits of a wall beyond the robot (α, r), `behind` deeper than where it stands, robot frame.
fn wall([alpha, r]: [f64; 2], behind: f64) -> Vec<Point2<f64>> {
    let (sin, cos) = sin_cos(alpha);
    let hit = |i: i32| {
        let along = STEP * f64::from(i);
        let deep = r + behind;
        Point2::new(deep * cos - along * sin, deep * sin + along * cos)
    };
    (-12..=12).map(hit).collect()
}

/// A filter that knows its walls, and the first of them as expected from where it is.
fn knowing() -> (EkfSlam, [f64; 2]) {
    let mut slam = some_state();
    for entry in &mut slam.landmarks {
        entry.sightings = 5;
    }
    let line = slam.expect(0).line;
    (slam, [line.alpha, line.r])
}

fn take(slam: &mut EkfSlam, end: Point2<f64>, scanned: Vec<Point2<f64>>) -> usize {
    let points = points(vec![beam(end)]);
    slam.take_readings(&Readings {
        points: &points,
        scanned,
        unsteady: 0.0,
    })
}

fn state(slam: &EkfSlam) -> DVector<f64> {
    let pose = [slam.pose.x(), slam.pose.y(), slam.pose.heading()];
    let errors = [slam.errors.curvature, slam.errors.turn_scale];
    let lines = slam.landmarks.iter().flat_map(|entry| entry.line);
    DVector::from_iterator(
        ROBOT + 2 * slam.landmarks.len(),
        pose.into_iter().chain(errors).chain(lines),
    )
}

#[test]
fn a_reading_is_the_dense_update_by_one_number() {
    for (turn, beyond) in [(0.1, 0.04), (-0.3, -0.05), (0.4, 0.0)] {
        let (mut slam, line) = knowing();
        let (before, p) = (state(&slam), dense(&slam));
        let anchor = slam.landmarks[0].anchor;
        let (sin, cos) = sin_cos(line[0] + turn);
        let range = line[1] / turn.cos() + beyond;
        let end = Point2::new(range * cos, range * sin);
        // How far the point is beyond the wall, for any state.
        let off = |x: &DVector<f64>| {
            let in_map = Pose2::new(x[0], x[1], x[2]) * end;
            let (sin, cos) = sin_cos(x[ROBOT]);
            let from = in_map - anchor;
            cos * from.x + sin * from.y - x[ROBOT + 1]
        };
        let row = DMatrix::from_fn(1, before.len(), |_, column| {
            let mut h = DVector::zeros(before.len());
            h[column] = 1e-6;
            (off(&(&before + &h)) - off(&(&before - &h))) / 2e-6
        });
        let own = TOGETHER * turn.cos() * SIGMA;
        let z = (&row * &p * row.transpose())[(0, 0)] + own * own;
        let gain = &p * row.transpose() / z;
        let expect = &before - &gain * off(&before);
        let expect_p = &p - &gain * &row * &p;
        assert_eq!(take(&mut slam, end, wall(line, 0.0)), 1, "turn {turn}");
        // The direction's variance is large, not infinite.
        let moved = (&expect - &before).norm();
        assert!(
            (state(&slam) - expect).norm() < 0.01 * moved + 1e-9,
            "{turn}"
        );
        let less = (&expect_p - &p).norm();
        assert!(less > 1e-4 && (dense(&slam) - expect_p).norm() < 0.01 * less);
    }
}

#[test]
fn only_what_is_beyond_doubt_counts() {
    let at = |line: [f64; 2], beyond: f64| {
        let (sin, cos) = sin_cos(line[0]);
        Point2::new((line[1] + beyond) * cos, (line[1] + beyond) * sin)
    };
    let check =
        |what: &str, count: usize, scanned: &dyn Fn([f64; 2]) -> Vec<Point2<f64>>, beyond: f64| {
            let (mut slam, line) = knowing();
            assert_eq!(
                take(&mut slam, at(line, beyond), scanned(line)),
                count,
                "{what}"
            );
        };
    let whole = |line| wall(line, 0.0);
    let jamb = |line| [wall(line, 0.0), wall(line, 0.15)].concat();
    let one_side = |line| wall(line, 0.0).split_off(13);
    check("a wall that was scanned", 1, &whole, 0.02);
    check("a door's jamb behind it", 0, &jamb, 0.02);
    check("beside the scanned part", 0, &one_side, 0.02);
    check("not scanned at all", 0, &|_| vec![], 0.02);
    check("somebody before it", 0, &whole, -0.9);
    // A wall that was seen once may be none.
    let (mut slam, line) = knowing();
    slam.landmarks[0].sightings = 1;
    assert_eq!(take(&mut slam, at(line, 0.0), wall(line, 0.0)), 0);
}

#[test]
fn readings_leave_walls_as_long_and_as_sure_as_they_were() {
    let (mut slam, line) = knowing();
    let walls = |s: &EkfSlam| -> Vec<_> {
        let known = |e: &landmark::Entry| (e.id, e.extent, e.sightings, e.last_seen);
        s.landmarks.iter().map(known).collect()
    };
    let before = walls(&slam);
    let (sin, cos) = sin_cos(line[0]);
    let end = Point2::new(line[1] * cos, line[1] * sin);
    assert_eq!(take(&mut slam, end, wall(line, 0.0)), 1);
    assert_eq!(walls(&slam), before);
}

#[test]
fn heading_is_kept_along_a_wall_by_readings_before_and_behind() {
    let mut slam = EkfSlam::new(plain()).unwrap();
    let seen = feature(std::f64::consts::FRAC_PI_2, 0.6);
    for _ in 0..4 {
        slam.update(&[seen], &ONCE).unwrap();
    }
    // The tracks slip: the robot believes that it goes on straight and has turned by 0.1 rad.
    let slipped = Pose2::new(0.1, 0.0, 0.1);
    let mut cov = Matrix3::zeros();
    (cov[(0, 0)], cov[(1, 1)], cov[(2, 2)]) = (1e-4, 1e-4, 1e-2);
    slam.predict(&super::odometry(Pose2::new(0.1, 0.0, 0.0), cov))
        .unwrap();
    let in_robot = |x: f64| slipped.inverse() * Point2::new(x, 0.6);
    let scanned: Vec<_> = (-20..=20).map(|i| in_robot(0.05 * f64::from(i))).collect();
    let beams = [-0.4, -0.2, 0.2, 0.4, 0.6].map(|x| beam(in_robot(x)));
    let points = points([beams, beams].concat());
    let readings = Readings {
        points: &points,
        scanned,
        unsteady: 0.0,
    };
    assert_eq!(slam.take_readings(&readings), 10);
    let estimate = slam.estimate();
    let sigma = estimate.cov[(2, 2)].sqrt();
    assert!(sigma < 0.08, "{sigma}");
    assert!((estimate.pose.heading() - 0.1).abs() < 2.0 * sigma);
    assert!(
        estimate.pose.heading() > 0.04,
        "{}",
        estimate.pose.heading()
    );
}
