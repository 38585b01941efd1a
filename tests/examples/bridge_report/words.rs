//! Errors that once prevented a stop or a drive, or were not reported: slips of a client of
//! rosbridge, a key that is held at once, settings that let nobody or everybody in, an invalid
//! token file.

use std::time::{Duration, Instant};

use futures_util::{SinkExt, StreamExt};
use serde_json::{Map, Value, json};
use slamlab_bridge::Config;
use slamlab_bridge::host;
use slamlab_bridge::source::sim::SimSource;
use slamlab_bridge::token::Token;
use slamlab_core::robot::Command;
use slamlab_core::wire::message::{FromBridge, ToBridge};
use tokio::net::TcpStream;
use tokio::time::timeout;
use tokio_tungstenite::WebSocketStream;
use tokio_tungstenite::tungstenite::Message;

use crate::client::{Bridge, Came};
use crate::robot::{is_motion, with_robot};

const PATIENCE: Duration = Duration::from_secs(10);
/// Maximum time from a stop to the robot's order.
const AT_ONCE: Duration = Duration::from_millis(250);

/// Each case, and whether all hold.
pub(crate) async fn report() -> (bool, Map<String, Value>) {
    let mut cases = Map::new();
    let mut note = |name: &str, holds: bool, got: Value| {
        cases.insert(name.into(), json!({ "holds": holds, "got": got }));
    };
    let (config, memory) = with_robot();
    let config = Config {
        rosbridge: true,
        ..config
    };
    let bridge = Bridge::start(config).await;
    for (name, slip) in [
        (
            "id that is a number",
            json!({ "op": "subscribe", "id": 7, "topic": "/odom" }),
        ),
        (
            "throttle_rate that is a float",
            json!({ "op": "subscribe", "topic": "/scan", "throttle_rate": 100.0 }),
        ),
        (
            "a stamped twist without a right",
            json!({ "op": "publish", "topic": "/cmd_vel", "msg": { "header": {}, "twist": { "linear": { "x": 0.1 }, "angular": {} } } }),
        ),
        (
            "an operation that is none",
            json!({ "op": "dance", "id": 7 }),
        ),
        (
            "two calls at once",
            json!({ "op": "call_service", "id": "first", "service": "/rosapi/topics" }),
        ),
    ] {
        let after = stop_after(&bridge, &memory, &slip).await;
        let holds = after.is_some_and(|after| after < AT_ONCE);
        note(
            &format!("rosbridge: stop behind {name}"),
            holds,
            json!(after.map(|a| a.as_secs_f64())),
        );
    }

    // A look to the side, or any other order, must not replace the held key: a person who arms and
    // holds it at once drives.
    let from = Instant::now();
    let mut driver = bridge.driver().await;
    driver.take(false).await;
    driver.arm().await;
    let armed = Instant::now();
    while armed.elapsed() < Duration::from_millis(300) {
        driver.drive(0.1, 0.0).await;
        let next = tokio::time::Instant::now() + Duration::from_millis(50);
        while tokio::time::timeout_at(next, driver.next()).await.is_ok() {}
    }
    let orders = memory.orders();
    let first = orders
        .iter()
        .find(|(at, order)| *at >= from && is_motion(order));
    let after = first.map(|(at, _)| at.duration_since(armed).as_secs_f64());
    note(
        "a key held within 0.3 s of arming drives",
        after.is_some_and(|s| s < 0.3),
        json!(after),
    );
    drop(driver);
    bridge.stop().await;

    let looks = looks().await;
    note(
        "looks on the move are told to who drives",
        looks > 0,
        json!(looks),
    );

    for origin in ["*", "null", "https://lab.example/", "lab.example"] {
        let said = host::check_origin(origin).err();
        note(
            &format!("allow-origin {origin:?}"),
            said.is_some(),
            json!(said),
        );
    }
    for name in ["*", "https://robot.example", "robot.example:443"] {
        let said = host::check_host(name).err();
        note(&format!("allow-host {name:?}"), said.is_some(), json!(said));
    }
    let (holds, said) = renewed();
    note("token --new over what is no token", holds, json!(said));
    let holds = cases.values().all(|case| case["holds"] == true);
    (holds, cases)
}

/// A client's slip, followed at once by the stop of a moving robot: time until its order.
async fn stop_after(
    bridge: &Bridge,
    memory: &crate::robot::Memory,
    slip: &Value,
) -> Option<Duration> {
    let mut driver = bridge.driver().await;
    driver.take(true).await;
    driver.arm().await;
    driver
        .say(ToBridge::Drive(driver.body(Command::Turn(1.0))))
        .await;
    let stream = TcpStream::connect(bridge.address).await.ok()?;
    let url = format!("ws://{}/rosbridge", bridge.address);
    let (mut socket, _): (WebSocketStream<TcpStream>, _) =
        tokio_tungstenite::client_async(url, stream).await.ok()?;
    let stop = json!({ "op": "call_service", "id": "stop", "service": "/slamlab/stop" });
    let from = Instant::now();
    for said in [slip, &stop] {
        socket.send(Message::text(said.to_string())).await.ok()?;
    }
    let answered = async {
        while let Some(Ok(message)) = socket.next().await {
            let Message::Text(text) = message else {
                continue;
            };
            let answer: Value = serde_json::from_str(&text).ok()?;
            if answer["id"] == "stop" {
                return (answer["result"] == true).then_some(());
            }
        }
        None
    };
    timeout(PATIENCE, answered).await.ok()??;
    let is_disarmed = driver.wait(|message| match message {
        FromBridge::Safety(state) if !state.armed => Some(()),
        _ => None,
    });
    timeout(PATIENCE, is_disarmed).await.ok()?;
    Some(memory.stopped_after(from).await)
}

/// A robot that only scans while standing looks to the side during a leg: how often its driver is
/// told.
async fn looks() -> usize {
    let source = SimSource::new("arena,rangers").unwrap();
    let bridge = Bridge::start(Config {
        sources: vec![Box::new(source)],
        ..Config::default()
    })
    .await;
    let mut driver = bridge.armed().await;
    let mut looks = 0;
    // Until a sweep has shown what is ahead, safe mode lets nothing move.
    for motion in [Command::Scan, Command::Forward(0.3)] {
        driver.say(ToBridge::Drive(driver.body(motion))).await;
        let given = driver.sequence;
        let mut ticks = tokio::time::interval(Duration::from_millis(50));
        let goes_on = async {
            loop {
                tokio::select! {
                    _ = ticks.tick() => {
                        let (epoch, seen, ttl_millis) = (driver.epoch, driver.seen, 300);
                        driver.say(ToBridge::Hold { epoch, seen, ttl_millis }).await;
                    }
                    came = driver.next() => match came {
                        Came::Message(FromBridge::PartialScan(_)) => looks += 1,
                        Came::Message(FromBridge::Manoeuvre(body)) if body.sequence == given && !body.busy => return,
                        Came::Message(_) => (),
                        Came::Closed(_) | Came::Lost => return,
                    },
                }
            }
        };
        if timeout(PATIENCE, goes_on).await.is_err() {
            break;
        }
    }
    bridge.stop().await;
    looks
}

/// A file that is not a token stays as it is.
fn renewed() -> (bool, String) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("notes.txt");
    std::fs::write(&path, "buy batteries").unwrap();
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        std::fs::set_permissions(&path, std::fs::Permissions::from_mode(0o600)).unwrap();
    }
    let said = Token::renew(&path).err().map(|error| error.to_string());
    let is_kept = std::fs::read_to_string(&path).is_ok_and(|text| text == "buy batteries");
    (said.is_some() && is_kept, said.unwrap_or_default())
}
