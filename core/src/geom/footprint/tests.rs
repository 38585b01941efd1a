//! Contact and distance compared with sampled poses and points.

use super::*;
use crate::geom::Length;
use proptest::prelude::*;

fn robot() -> Footprint {
    Footprint::rectangle(0.5, 0.3).unwrap()
}

fn wall() -> impl Strategy<Value = Segment> {
    proptest::array::uniform4(-1.0..1.0_f64)
        .prop_map(|w| Segment::new(Point2::new(w[0], w[1]), Point2::new(w[2], w[3])))
}

/// Depth of the wall in the outline, by sampled points of the wall: positive inside.
fn depth(pose: &Pose2, wall: &Segment) -> f64 {
    let inverse = pose.inverse();
    let points = (0..=400).map(|i| inverse * (wall.a + wall.vector() * (f64::from(i) / 400.0)));
    let depth = points.map(|p| (0.25 - p.x.abs()).min(0.15 - p.y.abs()));
    depth.fold(f64::NEG_INFINITY, f64::max)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn standing_turning_and_driving_touch_what_sampled_poses_touch(
        wall in wall(), x in -0.3..0.3_f64, y in -0.3..0.3_f64, heading in -3.1..3.1_f64, turn in -3.1..3.1_f64, length in 0.05..0.8_f64,
    ) {
        let robot = robot();
        let pose = Pose2::new(x, y, heading);
        let deepest = |poses: &mut dyn Iterator<Item = Pose2>| {
            poses.map(|pose| depth(&pose, &wall)).fold(f64::NEG_INFINITY, f64::max)
        };
        let check = |found: bool, deepest: f64| {
            // Within the resolution of the samples, sampling decides nothing.
            deepest.abs() < 8e-3 || found == (deepest < 0.0)
        };
        prop_assert!(check(robot.fits(&pose, &[wall]), depth(&pose, &wall)));
        let part = |i: i32| f64::from(i) / 200.0;
        let mut turned = (0..=200).map(|i| Pose2::new(x, y, heading + turn * part(i)));
        prop_assert!(check(robot.turns(&pose, turn, &[wall]), deepest(&mut turned)));
        let along = Vector2::new(libm::cos(heading), libm::sin(heading)) * length;
        let leg = Segment::new(Point2::new(x, y), Point2::new(x, y) + along);
        let mut driven = (0..=200).map(|i| Pose2::new(x + along.x * part(i), y + along.y * part(i), heading));
        prop_assert!(check(robot.drives(&leg, &[wall]), deepest(&mut driven)));
    }
}

proptest! {
    #[test]
    fn what_is_nearest_is_as_near_as_sampled_points(wall in wall(), x in -0.9..0.9_f64, y in -0.9..0.9_f64, heading in -3.1..3.1_f64) {
        let robot = robot();
        let pose = Pose2::new(x, y, heading);
        prop_assume!(robot.fits(&pose, &[wall]));
        let [on_robot, on_wall] = robot.nearest(&pose, &wall);
        let inverse = pose.inverse();
        prop_assert!(robot.distance(inverse * on_robot).abs() < 1e-9 && wall.distance(on_wall) < 1e-9);
        let apart = (on_robot - on_wall).length();
        let sampled = (0..=400).map(|i| inverse * (wall.a + wall.vector() * (f64::from(i) / 400.0)));
        // Distance to a rectangle: the parts of the coordinates beyond its half sides.
        let to_rectangle = |p: Point2<f64>| libm::hypot((p.x.abs() - 0.25).max(0.0), (p.y.abs() - 0.15).max(0.0));
        let least = sampled.clone().map(to_rectangle).fold(f64::INFINITY, f64::min);
        prop_assert!(apart <= least + 1e-9 && least - apart < 0.01, "{} {}", apart, least);
        for p in sampled.chain([Point2::new(0.3 * x, 0.3 * y)]) {
            let within = (p.x.abs() - 0.25).max(p.y.abs() - 0.15);
            let truth = if within < 0.0 { within } else { to_rectangle(p) };
            prop_assert!((robot.distance(p) - truth).abs() < 1e-9);
        }
    }
}

#[test]
fn a_door_wider_than_the_robot_but_not_than_its_disc_is_passed_straight_only() {
    let post = |y0: f64, y1: f64| Segment::new(Point2::new(1.0, y0), Point2::new(1.0, y1));
    let walls = [post(-2.0, -0.16), post(0.16, 2.0)];
    let path = |points: &[(f64, f64)]| -> Vec<Segment> {
        let points: Vec<_> = points.iter().map(|&(x, y)| Point2::new(x, y)).collect();
        points
            .windows(2)
            .map(|p| Segment::new(p[0], p[1]))
            .collect()
    };
    let through = path(&[(0.0, 0.0), (2.0, 0.0)]);
    assert!(robot().follows(through.clone(), 2.0, &walls));
    // The disc around it has a radius of 29 cm.
    assert!(
        through
            .iter()
            .any(|leg| walls.iter().any(|w| w.distance_to(leg) < 0.29))
    );
    assert!(!robot().follows(path(&[(0.0, 0.0), (1.2, 0.0), (1.2, 1.0)]), 0.0, &walls));
    assert!(!robot().follows(path(&[(0.3, -0.7), (1.7, 0.7)]), 0.0, &walls));
}

#[test]
fn the_discs_within_and_around_are_those_of_the_rectangle() {
    assert!((robot().radius_within() - 0.15).abs() < 1e-12);
    assert!((robot().radius_around() - libm::hypot(0.25, 0.15)).abs() < 1e-12);
}

#[test]
fn rectangles_without_area_are_refused() {
    for (length, width) in [(f64::NAN, 1.0), (0.0, 1.0), (1.0, -0.1)] {
        assert_eq!(Footprint::rectangle(length, width), None);
    }
}
