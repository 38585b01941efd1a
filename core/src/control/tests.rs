//! Following and safe mode against a robot that obeys its model, and against closed forms.

use nalgebra::Point2;
use proptest::prelude::*;

use super::*;
use crate::geom::{Length, Pose2, sin_cos};
use crate::plan::Path;
use crate::points::Points;
use crate::points::fixture::scan_of_hits;
use crate::robot::{RobotModel, Stamp};

pub(super) const TICK: f64 = 0.05;

/// Speeds that follow the request within the model's accelerations, then the midpoint rule.
pub(super) fn drive(
    pose: Pose2,
    speeds: &mut (f64, f64),
    wish: (f64, f64),
    model: &RobotModel,
) -> Pose2 {
    let towards = |now: f64, wish: f64, most: f64| now + (wish - now).clamp(-most, most);
    speeds.0 = towards(speeds.0, wish.0, model.max_acceleration * TICK);
    speeds.1 = towards(speeds.1, wish.1, model.max_turn_acceleration * TICK);
    let (sin, cos) = sin_cos(0.5 * speeds.1 * TICK);
    pose * Pose2::new(
        speeds.0 * TICK * cos,
        speeds.0 * TICK * sin,
        speeds.1 * TICK,
    )
}

fn obstacle(x: f64, y: f64) -> Points {
    scan_of_hits([Point2::new(x, y)])
}

/// A robot that was commanded these speeds and has reached them.
fn at(speeds: (f64, f64)) -> Underway {
    Underway {
        commanded: speeds,
        runs: speeds,
        ..Underway::default()
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]
    #[test]
    fn follower_arrives_near_the_line_without_swinging(
        corners in proptest::collection::vec((-3.0..3.0_f64, -3.0..3.0_f64), 1..6), heading in -3.1..3.1_f64, pioneer: bool,
    ) {
        let model = if pioneer { RobotModel::pioneer() } else { RobotModel::rp6() };
        let mut points = vec![Point2::origin()];
        points.extend(corners.iter().map(|&(x, y)| Point2::new(x, y)));
        let path = Path { points };
        let mut follower = Follower::new(&path);
        let (mut pose, mut speeds) = (Pose2::new(0.0, 0.0, heading), (0.0, 0.0));
        let config = FollowConfig::default();
        let (mut off, mut turned, mut arrived) = (0.0_f64, 0.0, false);
        for _ in 0..20_000 {
            match follower.steer(&pose, &model, &config) {
                Some((forward, turn)) => {
                    prop_assert!((0.0..=model.max_speed).contains(&forward) && turn.abs() <= model.max_turn_rate);
                    pose = drive(pose, &mut speeds, (forward, turn), &model);
                }
                None => { arrived = true; break; }
            }
            turned += (speeds.1 * TICK).abs();
            off = path.legs().map(|leg| leg.distance(pose.position())).fold(f64::INFINITY, f64::min).max(off);
        }
        prop_assert!(arrived, "still at {pose:?}");
        // It stops where it arrived, at the end of the path, and was never far from the path.
        while speeds.0 > 1e-6 { pose = drive(pose, &mut speeds, (0.0, 0.0), &model); }
        let end = path.points[path.points.len() - 1];
        prop_assert!((pose.position() - end).length() < 0.05, "{} m from the end", (pose.position() - end).length());
        prop_assert!(off < 0.08, "{off} m off the path");
        // All turns together are little more than the corners require: no swinging.
        let mut asked = std::f64::consts::PI;
        let directions: Vec<_> = path.legs().map(|leg| leg.vector()).collect();
        for pair in directions.windows(2) {
            asked += libm::atan2(pair[0].perp(&pair[1]), pair[0].dot(&pair[1])).abs();
        }
        prop_assert!(turned < 1.3 * asked + 0.8, "turned {turned} where {asked} was asked");
    }

    #[test]
    fn straight_free_distance_is_the_closed_form(x in -1.0..1.0_f64, y in -0.4..0.4_f64, forward in prop_oneof![Just(0.2), Just(-0.2)]) {
        let radius = 0.15;
        prop_assume!(libm::hypot(x, y) > radius + 0.005);
        let found = free_distance((forward, 0.0), &obstacle(x, y), &Pose2::identity(), radius, 0.8);
        let ahead = x * forward.signum();
        let expect = if ahead > 0.0 && y.abs() < radius {
            (ahead - (radius * radius - y * y).sqrt()).min(0.8)
        } else {
            0.8
        };
        // Marched in steps of 1 cm, never too far; a graze shorter than a step may just be stepped
        // over.
        let grazes = radius - y.abs() < 2e-4;
        prop_assert!(grazes || (found <= expect + 1e-9 && found >= expect - 0.0101), "{found} for {expect}");
    }

    #[test]
    fn speed_before_a_wall_can_always_be_braked(distance in 0.2..2.0_f64, forward in 0.01..0.7_f64) {
        let model = RobotModel::pioneer();
        let config = SafeConfig::default();
        let (v, turn) = limit_speed((forward, 0.0), &obstacle(model.radius() + distance, 0.0), &at((forward, 0.0)), (&model, &config));
        prop_assert!(v >= 0.0 && v <= forward && turn == 0.0);
        let needs = v * config.reaction + v * v / (2.0 * safe::BRAKING * model.max_acceleration);
        prop_assert!(needs <= distance - config.gap + 1e-9);
        // And it is no slower than necessary, except for the step of the march.
        let w = v + 1e-6;
        let more = w * config.reaction + w * w / (2.0 * safe::BRAKING * model.max_acceleration);
        prop_assert!(v == forward || more > distance - config.gap - 0.0101);
    }
}

#[test]
fn touching_a_wall_leaves_turning_and_backing_off() {
    let model = RobotModel::rp6();
    let config = SafeConfig::default();
    let wall = obstacle(model.radius() + 0.001, 0.0);
    let limited = |wish| limit_speed(wish, &wall, &Underway::default(), (&model, &config));
    assert_eq!(limited((0.2, 0.0)).0, 0.0);
    assert_eq!(limited((0.0, 1.0)), (0.0, 1.0));
    assert_eq!(limited((-0.2, 0.0)), (-0.2, 0.0));
    assert_eq!(limited((f64::NAN, f64::NAN)), (0.0, 0.0));
    // Having moved back by 1 m since the scan, the wall is far.
    let moved = Underway {
        since_scan: Pose2::new(-1.0, 0.0, 0.0),
        ..at((0.2, 0.0))
    };
    assert_eq!(
        limit_speed((0.2, 0.0), &wall, &moved, (&model, &config)).0,
        0.2
    );
    // Turned round since the scan, the wall is behind.
    let turned = Underway {
        since_scan: Pose2::new(0.0, 0.0, std::f64::consts::PI),
        ..Underway::default()
    };
    assert_eq!(
        limit_speed((-0.2, 0.0), &wall, &turned, (&model, &config)).0,
        0.0
    );
}

#[test]
fn a_robot_on_the_move_is_not_idle_and_a_standing_one_is() {
    let mut watch = ProgressWatch::default();
    for i in 0..100 {
        let moving = Pose2::new(0.01 * f64::from(i), 0.0, 0.0);
        assert!(watch.idle_for(Stamp::from_seconds(0.1 * f64::from(i)), &moving) < 0.6);
    }
    let at = Pose2::new(0.99, 0.0, 0.0);
    assert!(watch.idle_for(Stamp::from_seconds(15.0), &at) > 4.9);
    watch.reset();
    assert_eq!(watch.idle_for(Stamp::from_seconds(16.0), &at), 0.0);
}
