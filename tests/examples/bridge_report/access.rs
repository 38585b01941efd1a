//! Which clients are refused, and with which code; and that none of them moved the robot.

use serde_json::{Map, Value, json};
use slamlab_core::robot::Command;
use slamlab_core::wire::message::{ToBridge, close};
use tokio_tungstenite::tungstenite::Message;

use crate::client::{Bridge, Client};
use crate::robot::with_robot;
use crate::{crowding, door, named, words};

/// The last case is a flood of `minutes`.
pub(crate) async fn report(minutes: f64) -> (bool, Value) {
    let (config, memory) = with_robot();
    let bridge = Bridge::start(config).await;
    let mut cases = Map::new();
    let mut holds = true;
    let mut note = |name: &str, got: Option<u16>, expect: u16| {
        holds &= got == Some(expect);
        cases.insert(name.into(), json!({ "code": got, "expected": expect }));
    };

    let mut client = bridge.connect().await;
    note("says nothing", client.end().await, close::ACCESS);

    let mut client = bridge.connect().await;
    let wrong = client.hello(Some("0123456789abcdef0123456789abcdef"));
    note(
        "wrong token",
        after(&mut client, wrong).await,
        close::ACCESS,
    );

    let first = bridge.connect().await;
    let overheard = first.hello(Some(&bridge.token));
    let mut client = bridge.connect().await;
    note(
        "replayed proof",
        after(&mut client, overheard).await,
        close::ACCESS,
    );

    for (name, wish) in [
        ("watcher takes the lease", ToBridge::Take { force: true }),
        ("watcher arms", ToBridge::Arm { epoch: 1 }),
        ("watcher begins the bridge's map anew", ToBridge::ResetMap),
        (
            "watcher takes the geofence away",
            ToBridge::SetGeofence { zones: vec![] },
        ),
        (
            "watcher drives",
            ToBridge::Drive(first.body(Command::Forward(1.0))),
        ),
    ] {
        let mut client = bridge.watcher().await;
        note(name, after(&mut client, wish).await, close::NO_RIGHT);
    }
    for (name, message, code) in [
        ("malformed", vec![1, 2, 3], 1007),
        ("oversize", vec![0; 65 * 1024], 1009),
    ] {
        let mut client = bridge.driver().await;
        client.send(Message::binary(message)).await;
        note(name, client.end().await, code);
    }
    let mut client = bridge.driver().await;
    client.say(ToBridge::Heartbeat).await;
    client.sequence = 0;
    let again = ToBridge::Heartbeat;
    note("replayed message", after(&mut client, again).await, 1007);

    let was_moved = memory.was_moved();
    bridge.stop().await;
    let (door_holds, at_the_door) = door::report().await;
    let (crowding_holds, crowded) = crowding::report().await;
    let (rights_hold, rights) = named::report().await;
    let (words_hold, in_words) = words::report().await;
    let (disk_holds, on_a_full_disk) = disk().await;
    let (flood_holds, flooded) = flood(minutes).await;
    (
        holds
            && door_holds
            && crowding_holds
            && rights_hold
            && words_hold
            && disk_holds
            && flood_holds
            && !was_moved,
        json!({
            "cases": cases, "at_the_door": at_the_door, "crowded": crowded,
            "named_rights": rights, "in_words": in_words, "on_a_full_disk": on_a_full_disk, "flooded": flooded,
            "robot_was_moved": was_moved,
        }),
    )
}

#[cfg(target_os = "linux")]
async fn flood(minutes: f64) -> (bool, Value) {
    crate::flood::report(minutes).await
}

#[cfg(target_os = "linux")]
async fn disk() -> (bool, Value) {
    crate::disk::report().await
}

/// The disk is filled by means of Linux's limits.
#[cfg(not(target_os = "linux"))]
async fn disk() -> (bool, Value) {
    (false, json!("a full disk is tried on Linux only"))
}

/// Memory is read from `/proc`.
#[cfg(not(target_os = "linux"))]
async fn flood(_: f64) -> (bool, Value) {
    (false, json!("the flood is measured on Linux only"))
}

async fn after(client: &mut Client, message: ToBridge) -> Option<u16> {
    client.say(message).await;
    client.end().await
}
