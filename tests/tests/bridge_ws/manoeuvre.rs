//! Manoeuvres: the client that gave one learns from the bridge alone when it is over.

use std::time::Duration;

use slamlab_bridge::Config;
use slamlab_bridge::source::sim::SimSource;
use slamlab_core::robot::Command;
use slamlab_core::wire::message::{FromBridge, ManoeuvreBody, ToBridge};
use slamlab_tests::calm::async_on_a_calm_machine;

use super::client::{Bridge, Came, Client};

async fn bridge(which: &str) -> Bridge {
    Bridge::start(Config {
        sources: vec![Box::new(SimSource::new(which).unwrap())],
        ..Config::default()
    })
    .await
}

/// Gives a manoeuvre; returns the sequence number of the message.
async fn give(driver: &mut Client, motion: Command) -> u32 {
    let body = driver.body(motion);
    driver.say(ToBridge::Drive(body)).await;
    driver.sequence
}

/// What arrives until the manoeuvre is over; it is kept alive all the time if `is_held`.
async fn until_over(driver: &mut Client, sequence: u32, is_held: bool) -> Vec<FromBridge> {
    let mut ticks = tokio::time::interval(Duration::from_millis(50));
    let mut all = vec![];
    loop {
        tokio::select! {
            _ = ticks.tick(), if is_held => {
                let (epoch, seen, ttl_millis) = (driver.epoch, driver.seen, 300);
                driver.say(ToBridge::Hold { epoch, seen, ttl_millis }).await;
            }
            came = driver.next() => match came {
                Came::Message(message) => {
                    let is_over = matches!(&message, FromBridge::Manoeuvre(body)
                        if body.sequence == sequence && !body.busy);
                    all.push(message);
                    if is_over {
                        return all;
                    }
                }
                other => panic!("the connection ended: {other:?}"),
            },
        }
    }
}

fn manoeuvres(messages: &[FromBridge]) -> Vec<(u32, bool)> {
    let manoeuvre = |message: &FromBridge| match message {
        FromBridge::Manoeuvre(ManoeuvreBody { sequence, busy, .. }) => Some((*sequence, *busy)),
        _ => None,
    };
    messages.iter().filter_map(manoeuvre).collect()
}

fn turned(messages: &[FromBridge]) -> f64 {
    let heading = |message: &FromBridge| match message {
        FromBridge::Odometry(odometry) => odometry.motion[2],
        _ => 0.0,
    };
    messages.iter().map(heading).sum()
}

/// Until the first scan, safe mode lets nothing move.
async fn first_scan(driver: &mut Client) {
    let scan = |message: &FromBridge| matches!(message, FromBridge::Scan(_)).then_some(());
    driver.wait(scan).await;
}

#[test]
fn a_turn_is_over_when_the_robot_has_turned_and_not_before() {
    async_on_a_calm_machine(async || {
        let bridge = bridge("arena,lidar").await;
        let mut driver = bridge.armed().await;
        first_scan(&mut driver).await;
        let sequence = give(&mut driver, Command::Turn(0.8)).await;
        let messages = until_over(&mut driver, sequence, true).await;
        assert_eq!(manoeuvres(&messages), [(sequence, true), (sequence, false)]);
        let turned = turned(&messages);
        assert!((turned - 0.8).abs() < 0.15, "{turned} rad");
        bridge.stop().await;
    });
}

#[test]
fn a_manoeuvre_that_nobody_keeps_alive_is_over_when_the_bridge_stops_it() {
    async_on_a_calm_machine(async || {
        let bridge = bridge("arena,lidar").await;
        let mut driver = bridge.armed().await;
        first_scan(&mut driver).await;
        let sequence = give(&mut driver, Command::Turn(3.0)).await;
        let messages = until_over(&mut driver, sequence, false).await;
        assert_eq!(manoeuvres(&messages).last(), Some(&(sequence, false)));
        let turned = turned(&messages);
        assert!(turned < 2.5, "it was stopped: {turned} rad");
        bridge.stop().await;
    });
}

#[test]
fn another_manoeuvre_ends_the_one_before() {
    async_on_a_calm_machine(async || {
        let bridge = bridge("arena,lidar").await;
        let mut driver = bridge.armed().await;
        first_scan(&mut driver).await;
        let first = give(&mut driver, Command::Turn(3.0)).await;
        driver
            .wait(|message| {
                matches!(message, FromBridge::Manoeuvre(body) if body.busy).then_some(())
            })
            .await;
        let second = give(&mut driver, Command::Turn(-0.4)).await;
        let messages = until_over(&mut driver, second, true).await;
        let seen = manoeuvres(&messages);
        assert_eq!(seen.last(), Some(&(second, false)), "{seen:?}");
        assert!(seen.iter().all(|one| *one != (first, true)), "{seen:?}");
        bridge.stop().await;
    });
}

#[test]
fn a_sweep_is_over_after_its_scan() {
    async_on_a_calm_machine(async || {
        let bridge = bridge("arena,rangers").await;
        let mut driver = bridge.armed().await;
        let sequence = give(&mut driver, Command::Scan).await;
        let messages = until_over(&mut driver, sequence, true).await;
        assert_eq!(manoeuvres(&messages), [(sequence, true), (sequence, false)]);
        let scans = messages.iter().filter(|m| matches!(m, FromBridge::Scan(_)));
        assert_eq!(scans.count(), 1);
        bridge.stop().await;
    });
}

/// Otherwise a page would blame its goal when the bridge ends a leg because of a person.
#[test]
fn looks_on_the_move_reach_whoever_drives() {
    async_on_a_calm_machine(async || {
        let bridge = bridge("arena,rangers").await;
        let mut driver = bridge.armed().await;
        let sequence = give(&mut driver, Command::Scan).await;
        until_over(&mut driver, sequence, true).await;
        let sequence = give(&mut driver, Command::Forward(0.3)).await;
        let messages = until_over(&mut driver, sequence, true).await;
        let looks = messages
            .iter()
            .filter(|m| matches!(m, FromBridge::PartialScan(_)));
        assert!(looks.count() > 0, "{messages:?}");
        bridge.stop().await;
    });
}

#[test]
fn a_manoeuvre_that_is_refused_is_over_at_once_and_only_its_sender_hears_of_it() {
    async_on_a_calm_machine(async || {
        let bridge = bridge("arena,lidar").await;
        let mut driver = bridge.driver().await;
        driver.take(false).await;
        // It has the lease but has not armed.
        let sequence = give(&mut driver, Command::Forward(1.0)).await;
        let messages = until_over(&mut driver, sequence, false).await;
        assert_eq!(manoeuvres(&messages), [(sequence, false)]);
        assert!(
            messages
                .iter()
                .any(|message| matches!(message, FromBridge::Refused(_)))
        );
        bridge.stop().await;
    });
}
