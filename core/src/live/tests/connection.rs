//! What ends a task, what survives a new connection, and what a bridge may not send.

use super::*;
use crate::geom::Length;

#[test]
fn whatever_disarms_ends_the_errand_and_nothing_goes_on_by_itself() {
    let (mut bridge, mut live) = (Bridge::new(SensorModel::lidar()), live());
    bridge.greet(&mut live);
    bridge.hear(&mut live);
    live.take_lease(bridge.micros(), false);
    live.set_mode(Mode::Explore);
    for _ in 0..100 {
        bridge.step(&mut live);
    }
    assert!(live.session().distance() > 0.05, "it has begun");
    // Somebody else presses Stop.
    bridge.armed = false;
    bridge.safety(&mut live);
    let before = bridge.said.len();
    for _ in 0..20 {
        bridge.step(&mut live);
    }
    live.take_lease(bridge.micros(), false);
    for _ in 0..20 {
        bridge.step(&mut live);
    }
    assert!(live.client().is_armed());
    let moves = |message: &ToBridge| matches!(message, ToBridge::Drive(body) if body.motion != Command::Stop);
    assert!(!bridge.said[before..].iter().any(moves));
    assert_eq!(live.session().pilot().mode(), Mode::Manual);
}

#[test]
fn what_was_asked_for_while_disarmed_does_not_begin_by_itself_when_armed() {
    let (mut bridge, mut live) = (Bridge::new(SensorModel::lidar()), live());
    bridge.greet(&mut live);
    bridge.hear(&mut live);
    live.set_mode(Mode::Explore);
    live.take_lease(bridge.micros(), false);
    for _ in 0..40 {
        bridge.step(&mut live);
    }
    assert!(live.client().is_armed());
    let moves = |message: &ToBridge| matches!(message, ToBridge::Drive(body) if body.motion != Command::Stop);
    assert!(!bridge.said.iter().any(moves));
    assert_eq!(live.session().pilot().mode(), Mode::Manual);
}

#[test]
fn a_new_connection_goes_on_in_the_old_map_without_the_right_to_drive() {
    let (mut bridge, mut live) = (Bridge::new(SensorModel::lidar()), live());
    bridge.greet(&mut live);
    for _ in 0..60 {
        bridge.step(&mut live);
    }
    let walls = live.session().slam().view().landmarks.len();
    assert!(walls > 0);
    live.reconnect();
    for _ in 0..100 {
        bridge.robot.advance(0.01);
    }
    // What the robot did meanwhile is not reported.
    bridge.robot.odometry();
    while bridge.robot.take_scan().is_some() {}
    bridge.greet(&mut live);
    for _ in 0..40 {
        bridge.step(&mut live);
    }
    assert!(!live.client().is_armed());
    assert!(live.session().slam().view().landmarks.len() >= walls);
    let notes = live.take_notes();
    assert!(
        notes.iter().any(|note| note.text.contains("1.0 s")),
        "{notes:?}"
    );
    let error = live.session().slam().estimate().pose.position() - truth(&bridge).position();
    assert!(error.length() < 0.05, "{} m off", error.length());
}

#[test]
fn a_reading_that_cannot_be_is_told_and_left_out() {
    let (mut bridge, mut live) = (Bridge::new(SensorModel::lidar()), live());
    bridge.greet(&mut live);
    bridge.step(&mut live);
    let mut body = OdometryBody::new(0, &bridge.robot.odometry());
    body.motion[0] = f64::NAN;
    let before = live.session().dead_reckoning();
    bridge.tell(&mut live, &FromBridge::Odometry(body));
    assert_eq!(live.session().dead_reckoning(), before);
    let notes = live.take_notes();
    assert!(
        notes.iter().any(|note| note.text.contains("not finite")),
        "{notes:?}"
    );
}
