//! A robot whose driver is gone: it goes home if it may and knows the way, and stays if there is
//! any doubt.

use super::*;
use crate::geom::Length;
use crate::live::{Homing, HomingConfig};

const OTHER: u32 = 9;

/// A bridge with a driver of its own, who drives the robot away from where it was armed, and with
/// the bridge's mapper.
struct Scene {
    bridge: Bridge,
    live: Live,
    homing: Homing,
    notes: Vec<String>,
}

impl Scene {
    fn new(config: HomingConfig) -> Self {
        let mut live = Live::new(LiveConfig {
            method: Method::ScanMatching,
            ..live().config
        })
        .unwrap();
        let mut bridge = Bridge::new(SensorModel::lidar());
        bridge.greet(&mut live);
        bridge.hear(&mut live);
        let homing = Homing::new(config);
        let notes = vec![];
        let mut scene = Self {
            bridge,
            live,
            homing,
            notes,
        };
        scene.go(30);
        scene
    }

    fn state(&mut self, armed: bool, reason: DisarmReason) {
        self.bridge.armed = armed;
        let safety = SafetyBody {
            driver: armed.then_some(OTHER),
            driver_name: String::new(),
            armed,
            emergency: false,
            reason,
        };
        self.bridge
            .tell(&mut self.live, &FromBridge::Safety(safety));
    }

    /// In steps of 50 ms.
    fn go(&mut self, steps: usize) {
        for _ in 0..steps {
            let note = self.homing.step(self.bridge.micros(), &mut self.live);
            self.notes.extend(note.map(|note| note.text));
            self.bridge.step(&mut self.live);
        }
    }

    /// The other client drives ahead, and then is gone.
    fn driven_and_lost(&mut self, reason: DisarmReason) {
        self.state(true, DisarmReason::Start);
        for _ in 0..60 {
            let motion = Command::Velocity {
                forward: 0.2,
                turn: 0.0,
            };
            self.bridge.driven = self.bridge.robot.stamp().seconds();
            self.bridge.robot.command(motion);
            self.go(1);
        }
        self.bridge.robot.command(Command::Stop);
        self.state(false, reason);
    }

    fn away(&self) -> f64 {
        truth(&self.bridge).position().coords.length()
    }

    fn said(&self, words: &str) -> bool {
        self.notes.iter().any(|note| note.contains(words))
    }
}

fn on_link_loss() -> HomingConfig {
    HomingConfig {
        on_link_loss: true,
        ..HomingConfig::default()
    }
}

#[test]
fn a_driver_who_is_gone_leaves_a_robot_that_goes_home() {
    for reason in [DisarmReason::DriverGone, DisarmReason::LeaseExpired] {
        let mut scene = Scene::new(on_link_loss());
        scene.driven_and_lost(reason);
        let away = scene.away();
        assert!(away > 0.4, "{away}");
        scene.go(400);
        assert!(scene.away() < 0.3, "{} {:?}", scene.away(), scene.notes);
        assert!(
            scene.said("goes home") && scene.said("is at home"),
            "{:?}",
            scene.notes
        );
        let gave_back = |said: &ToBridge| matches!(said, ToBridge::Release { .. });
        assert!(scene.bridge.said.iter().any(gave_back));
    }
}

#[test]
fn by_default_and_after_everything_that_is_meant_to_stop_it_it_stays() {
    let mut cases = vec![(HomingConfig::default(), DisarmReason::DriverGone)];
    let stops = [
        DisarmReason::Stop,
        DisarmReason::EmergencyStop,
        DisarmReason::Bumper,
        DisarmReason::Released,
        DisarmReason::TakenOver,
        DisarmReason::Revoked,
        DisarmReason::Link,
        DisarmReason::Battery,
        DisarmReason::Stall,
    ];
    cases.extend(stops.map(|reason| (on_link_loss(), reason)));
    for (config, reason) in cases {
        let mut scene = Scene::new(config);
        scene.driven_and_lost(reason);
        let before = scene.bridge.said.len();
        let away = scene.away();
        scene.go(60);
        assert!((scene.away() - away).abs() < 0.05, "{reason}");
        let takes = |said: &ToBridge| matches!(said, ToBridge::Take { .. } | ToBridge::Drive(_));
        assert!(!scene.bridge.said[before..].iter().any(takes), "{reason}");
    }
}

#[test]
fn a_right_that_was_taken_away_keeps_it_where_it_is_and_nobody_is_told_that_it_goes() {
    let mut scene = Scene::new(on_link_loss());
    scene.bridge.refuses = true;
    scene.driven_and_lost(DisarmReason::DriverGone);
    scene.go(100);
    assert_eq!(
        scene.notes,
        ["The link to the driver was lost, and the robot stays: the bridge does not let it drive."]
    );
}

#[test]
fn a_stop_on_the_way_ends_it_for_good() {
    let mut scene = Scene::new(on_link_loss());
    scene.driven_and_lost(DisarmReason::DriverGone);
    scene.go(30);
    assert!(scene.live.client().is_armed(), "{:?}", scene.notes);
    scene.bridge.robot.command(Command::Stop);
    scene.state(false, DisarmReason::Stop);
    let before = scene.bridge.said.len();
    scene.go(100);
    assert!(scene.said("it was stopped (stop)"), "{:?}", scene.notes);
    let goes_on = |said: &ToBridge| {
        matches!(
            said,
            ToBridge::Take { .. } | ToBridge::Arm { .. } | ToBridge::Drive(_)
        )
    };
    assert!(!scene.bridge.said[before..].iter().any(goes_on));
}

#[test]
fn whoever_has_no_right_or_is_not_sure_where_it_is_does_not_begin() {
    let unsure = HomingConfig {
        sigma: 1e-9,
        ..on_link_loss()
    };
    let mut scene = Scene::new(unsure);
    scene.driven_and_lost(DisarmReason::DriverGone);
    scene.go(20);
    assert!(
        scene.said("does not know where home is"),
        "{:?}",
        scene.notes
    );

    let mut scene = Scene::new(on_link_loss());
    scene.driven_and_lost(DisarmReason::DriverGone);
    // It was certain when the robot was armed, and is not any more.
    scene.homing.config.turn_sigma = 1e-9;
    scene.go(20);
    assert!(scene.said("its pose is not sure"), "{:?}", scene.notes);
    assert!(!scene.live.client().has_lease());
}

#[test]
fn a_low_battery_takes_the_robot_home_from_its_driver_once() {
    let mut scene = Scene::new(HomingConfig {
        on_low_battery: true,
        low_volts: 100.0,
        ..HomingConfig::default()
    });
    scene.state(true, DisarmReason::Start);
    scene.live.battery = Some(7.0);
    scene.go(20);
    assert!(scene.notes.is_empty(), "not yet: {:?}", scene.notes);
    scene.go(60);
    assert!(scene.said("The battery is low"), "{:?}", scene.notes);
}
