//! Settings: the initial ones, those changed on the way, those of another robot.

use super::*;

/// How far in front of the wall a robot stops that is driven at it by hand; with `settings` from
/// the start, and `later` ones after a second.
fn room_ahead(settings: &[(&str, f64)], later: &[(&str, f64)]) -> f64 {
    let owned = |changes: &[(&str, f64)]| {
        let changes = changes.iter();
        changes
            .map(|(key, value)| ((*key).to_owned(), *value))
            .collect::<Vec<_>>()
    };
    let (mut bridge, mut live) = (Bridge::new(SensorModel::lidar()), live());
    live.config.settings = owned(settings);
    bridge.greet(&mut live);
    bridge.hear(&mut live);
    live.take_lease(bridge.micros(), false);
    for _ in 0..20 {
        bridge.step(&mut live);
    }
    live.drive(1.0, 0.0);
    // Ten seconds: it has stopped, and nobody has walked up to it.
    for step in 0..200 {
        if step == 20 && !later.is_empty() {
            live.reconfigure(owned(later)).unwrap();
        }
        bridge.step(&mut live);
    }
    let (forward, _) = bridge.robot.speeds();
    assert!(forward.abs() < 0.05, "still drives: {forward}");
    let (truth, world) = (bridge.robot.truth(), bridge.robot.world());
    let ahead = truth.rotate(nalgebra::Vector2::x());
    let caster = crate::sim::Caster::new(world.walls());
    let hit = caster.cast(truth.position(), ahead, 100.0);
    hit.unwrap().distance
}

#[test]
fn a_robot_behind_a_bridge_obeys_settings_and_their_changes() {
    let usual = room_ahead(&[], &[]);
    let wide = [("pilot.gap", 0.4)];
    let (from_the_start, on_the_way) = (room_ahead(&wide, &[]), room_ahead(&[], &wide));
    assert!(from_the_start > usual + 0.2, "{from_the_start} {usual}");
    assert!((on_the_way - from_the_start).abs() < 0.05, "{on_the_way}");
}

#[test]
fn settings_stay_with_another_robot_and_wrong_ones_change_nothing() {
    let (mut bridge, mut live) = (Bridge::new(SensorModel::lidar()), live());
    let changes = vec![
        ("points.max_range".to_owned(), 7.0),
        ("odometry.left".to_owned(), 0.01),
    ];
    live.reconfigure(changes).unwrap();
    for wrong in [("pilot.gap", -1.0), ("pilot.no_such", 0.0)] {
        let wrong = vec![(wrong.0.to_owned(), wrong.1)];
        assert!(live.reconfigure(wrong).is_err());
    }
    bridge.greet(&mut live);
    assert_eq!(live.begun, 1);
    assert_eq!(live.session().slam().config().points.max_range, 7.0);
    assert_eq!(live.session().calibration().wear.left, 0.01);
}
