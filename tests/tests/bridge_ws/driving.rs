//! Driving: the robot obeys, and stops whatever breaks on the way.

use std::time::{Duration, Instant};

use slamlab_bridge::Config;
use slamlab_bridge::source::Order;
use slamlab_core::geom::Pose2;
use slamlab_core::robot::Command;
use slamlab_core::sim::World;
use slamlab_core::wire::message::{
    DisarmReason, FromBridge, LinkState, RefusalReason, ToBridge, close,
};
use slamlab_tests::calm::async_on_a_calm_machine;

use super::client::{Bridge, Client};
use super::robot::{Memory, is_motion, with_robot, with_robot_in};

/// Maximum time from the last command to the stop order, by the specification.
const WATCHDOG: Duration = Duration::from_millis(250);

/// A moving robot with its driver, and its memory of orders.
async fn driven() -> (Bridge, Client, Memory) {
    let (config, memory) = with_robot();
    let bridge = Bridge::start(config).await;
    let mut driver = bridge.armed().await;
    driver.drive_for(Duration::from_millis(300), 0.2).await;
    (bridge, driver, memory)
}

fn reason(message: &FromBridge) -> Option<DisarmReason> {
    match message {
        FromBridge::Safety(state) if !state.armed => Some(state.reason),
        _ => None,
    }
}

#[test]
fn the_robot_runs_while_it_is_driven_and_stops_when_nobody_does() {
    async_on_a_calm_machine(async || {
        let (config, memory) = with_robot();
        let bridge = Bridge::start(config).await;
        let mut driver = bridge.armed().await;
        driver.drive_for(Duration::from_millis(600), 0.2).await;
        let last = Instant::now();
        assert!(memory.was_moved());
        let took = memory.stopped_after(last).await;
        assert!(took < WATCHDOG, "{took:?} after the last command");
        // The motors slow down from 0.2 m/s at 0.6 m/s².
        tokio::time::sleep(Duration::from_secs(1)).await;
        let ran = memory.ran().unwrap().duration_since(last);
        assert!(ran < WATCHDOG + Duration::from_millis(500), "{ran:?}");
        bridge.stop().await;
    });
}

#[test]
fn a_driver_whose_connection_breaks_is_no_driver_any_more() {
    async_on_a_calm_machine(async || {
        let (config, memory) = with_robot();
        let bridge = Bridge::start(config).await;
        let mut watcher = bridge.watcher().await;
        let mut driver = bridge.armed().await;
        driver.drive_for(Duration::from_millis(300), 0.2).await;
        let from = Instant::now();
        drop(driver);
        let took = memory.stopped_after(from).await;
        assert!(took < WATCHDOG, "{took:?}");
        let gone =
            |message: &FromBridge| reason(message).filter(|r| *r == DisarmReason::DriverGone);
        watcher.wait(gone).await;
        // A client that comes back has to arm again.
        let mut again = bridge.driver().await;
        again.take(false).await;
        memory.forget();
        again.drive(0.2, 0.0).await;
        let refused = again.wait(|message| match message {
            FromBridge::Refused(reason) => Some(*reason),
            _ => None,
        });
        assert_eq!(refused.await, RefusalReason::Disarmed);
        assert!(!memory.was_moved());
        bridge.stop().await;
    });
}

#[test]
fn a_network_that_swallows_everything_stops_the_robot_and_ends_the_connection() {
    async_on_a_calm_machine(async || {
        let (bridge, mut driver, memory) = driven().await;
        // No FIN, no reset: the socket stays open, and nothing is read or written any more.
        let from = Instant::now();
        let took = memory.stopped_after(from).await;
        assert!(took < WATCHDOG, "{took:?}");
        tokio::time::sleep(Duration::from_millis(5500)).await;
        assert_eq!(driver.end().await, Some(close::HEARTBEAT));
        bridge.stop().await;
    });
}

#[test]
fn taking_over_stops_the_robot_and_shows_the_other_out() {
    async_on_a_calm_machine(async || {
        let (bridge, mut first, memory) = driven().await;
        let mut second = bridge.driver().await;
        second.say(ToBridge::Take { force: false }).await;
        let held = second.wait(|message| match message {
            FromBridge::Refused(reason) => Some(*reason),
            _ => None,
        });
        assert_eq!(held.await, RefusalReason::Held);
        let from = Instant::now();
        second.take(true).await;
        assert!(second.epoch > first.epoch);
        let took = memory.stopped_after(from).await;
        assert!(took < WATCHDOG, "{took:?}");
        assert_eq!(first.end().await, Some(close::TAKEN_OVER));
        bridge.stop().await;
    });
}

#[test]
fn a_cable_that_is_pulled_disarms_and_its_return_moves_nothing() {
    async_on_a_calm_machine(async || {
        let (bridge, mut driver, memory) = driven().await;
        let from = Instant::now();
        memory.cut(true);
        let took = memory.stopped_after(from).await;
        assert!(took < WATCHDOG, "{took:?}");
        let lost = |message: &FromBridge| reason(message).filter(|r| *r == DisarmReason::Link);
        driver.wait(lost).await;
        memory.cut(false);
        let is_up = |message: &FromBridge| match message {
            FromBridge::Link(link) => Some(()).filter(|()| link.state == LinkState::Up),
            _ => None,
        };
        driver.wait(is_up).await;
        memory.forget();
        driver.drive_for(Duration::from_millis(300), 0.2).await;
        assert!(!memory.was_moved(), "it must be armed again");
        driver.arm().await;
        driver.drive_for(Duration::from_millis(300), 0.2).await;
        assert!(memory.was_moved());
        bridge.stop().await;
    });
}

#[test]
fn the_end_of_the_bridge_stops_the_robot_before_anything_else() {
    async_on_a_calm_machine(async || {
        let (bridge, mut driver, memory) = driven().await;
        let from = Instant::now();
        bridge.stop().await;
        assert!(memory.has_ended());
        let took = memory.stopped_after(from).await;
        assert!(took < Duration::from_millis(50), "{took:?}");
        let (_, last) = memory.orders().pop().unwrap();
        assert_eq!(last, Order::Command(Command::Stop));
        assert_eq!(driver.end().await, Some(1001));
    });
}

#[test]
fn the_emergency_stop_holds_until_it_is_reset_and_armed() {
    async_on_a_calm_machine(async || {
        let (bridge, mut driver, memory) = driven().await;
        bridge.watcher().await.say(ToBridge::EmergencyStop).await;
        let cut = |message: &FromBridge| match message {
            FromBridge::Safety(state) => Some(state.emergency).filter(|is_cut| *is_cut),
            _ => None,
        };
        driver.wait(cut).await;
        memory.forget();
        let epoch = driver.epoch;
        driver.say(ToBridge::Arm { epoch }).await;
        driver.drive_for(Duration::from_millis(200), 0.2).await;
        driver.say(ToBridge::ResetEmergencyStop { epoch }).await;
        driver.drive_for(Duration::from_millis(200), 0.2).await;
        assert!(!memory.was_moved(), "{:?}", memory.orders());
        let mut orders = memory.orders().into_iter();
        assert!(orders.any(|(_, order)| order == Order::ResetEmergencyStop));
        driver.arm().await;
        driver.drive_for(Duration::from_millis(200), 0.2).await;
        assert!(memory.was_moved());
        bridge.stop().await;
    });
}

/// A wall 1 m ahead; the driver holds the key down.
#[test]
fn safe_mode_keeps_the_robot_off_the_wall() {
    async_on_a_calm_machine(async || {
        let world = World::new("wall", Pose2::identity()).with_room(&[
            (-1.0, -1.0),
            (1.0, -1.0),
            (1.0, 1.0),
            (-1.0, 1.0),
        ]);
        let (config, memory) = with_robot_in(world);
        let bridge = Bridge::start(config).await;
        let mut driver = bridge.armed().await;
        let speeds = || -> Vec<f64> {
            let orders = memory.orders().into_iter();
            orders
                .filter_map(|(_, order)| match order {
                    Order::Command(Command::Velocity { forward, .. }) => Some(forward),
                    _ => None,
                })
                .collect()
        };
        let ran = |speeds: &[f64]| speeds.iter().any(|speed| *speed > 0.25);
        let stands = |speeds: &[f64]| speeds.last().is_some_and(|speed| speed.abs() < 0.02);
        for _ in 0..30 {
            driver.drive_for(Duration::from_secs(1), 0.3).await;
            if ran(&speeds()) && stands(&speeds()) {
                break;
            }
        }
        let speeds = speeds();
        assert!(ran(&speeds), "it began at full speed");
        assert!(stands(&speeds), "{:?}", speeds.last());
        bridge.stop().await;
    });
}

#[test]
fn a_leg_goes_on_while_it_is_held() {
    async_on_a_calm_machine(async || {
        let (config, memory) = with_robot();
        let bridge = Bridge::start(config).await;
        let mut driver = bridge.armed().await;
        // Until the first scan, safe mode lets nothing move.
        driver
            .wait(|message| matches!(message, FromBridge::Scan(_)).then_some(()))
            .await;
        let body = driver.body(Command::Turn(1.0));
        driver.say(ToBridge::Drive(body)).await;
        driver.hold_for(Duration::from_millis(600)).await;
        let orders = memory.orders();
        assert_eq!(
            orders.iter().filter(|(_, order)| is_motion(order)).count(),
            1
        );
        let since = orders
            .iter()
            .position(|(_, order)| is_motion(order))
            .unwrap();
        assert_eq!(
            orders.len(),
            since + 1,
            "not stopped while held: {orders:?}"
        );
        let took = memory.stopped_after(Instant::now()).await;
        assert!(took < WATCHDOG, "{took:?}");
        bridge.stop().await;
    });
}

/// Without a robot there is nothing to arm.
#[test]
fn a_bridge_without_a_robot_arms_nothing() {
    async_on_a_calm_machine(async || {
        let bridge = Bridge::start(Config::default()).await;
        let mut driver = bridge.driver().await;
        driver.take(false).await;
        let epoch = driver.epoch;
        driver.say(ToBridge::Arm { epoch }).await;
        let refused = driver.wait(|message| match message {
            FromBridge::Refused(reason) => Some(*reason),
            _ => None,
        });
        assert_eq!(refused.await, RefusalReason::NoRobot);
        bridge.stop().await;
    });
}
