//! Named rights: who may do what, and what remains of a right that was revoked.

use std::time::{Duration, Instant};

use serde_json::{Map, Value, json};
use slamlab_bridge::Config;
use slamlab_core::robot::Command;
use slamlab_core::wire::message::{FromBridge, RefusalReason, Role, ToBridge, Watching, close};
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;

use crate::client::Bridge;
use crate::rights_stand::{Stand, drive_on};
use crate::robot::with_robot;

/// Maximum time from the command that revokes a right to the robot's stop.
const AT_ONCE: Duration = Duration::from_millis(1000);

/// Each case, and whether all hold.
pub(crate) async fn report() -> (bool, Map<String, Value>) {
    let mut cases = Map::new();
    let mut note = |name: &str, holds: bool, got: Value| {
        cases.insert(name.into(), json!({ "holds": holds, "got": got }));
    };
    let stand = Stand::start(Watching::Token).await;
    let wall = stand.add("wall", Role::Watcher);
    let anna = stand.add("anna", Role::Driver);

    let mut nobody = stand.bridge.connect().await;
    nobody.say(nobody.hello(None)).await;
    let code = nobody.end().await;
    note(
        "private: no token",
        code == Some(close::ACCESS),
        json!(code),
    );
    for (name, message) in [
        (
            "the token of a watcher takes the lease",
            ToBridge::Take { force: true },
        ),
        ("the token of a watcher arms", ToBridge::Arm { epoch: 1 }),
        (
            "the token of a watcher resets the emergency stop",
            ToBridge::ResetEmergencyStop { epoch: 1 },
        ),
        (
            "the token of a watcher begins the bridge's map anew",
            ToBridge::ResetMap,
        ),
    ] {
        let mut client = stand.enter(&wall).await;
        client.say(message).await;
        let code = client.end().await;
        note(name, code == Some(close::NO_RIGHT), json!(code));
    }
    let mut client = stand.enter(&wall).await;
    client
        .say(ToBridge::Drive(client.body(Command::Forward(1.0))))
        .await;
    let code = client.end().await;
    let was_moved = stand.memory.was_moved();
    let holds = code == Some(close::NO_RIGHT) && !was_moved;
    note("the token of a watcher drives", holds, json!(code));

    let mut driver = stand.enter(&anna).await;
    driver.take(false).await;
    driver.arm().await;
    driver.drive(0.1, 0.0).await;
    let mut watcher = stand.enter(&wall).await;
    let from = Instant::now();
    watcher.say(ToBridge::Stop).await;
    let stopped = stand.memory.stopped_after(from).await;
    note(
        "the token of a watcher stops",
        stopped < AT_ONCE,
        json!(stopped.as_secs_f64()),
    );

    driver.arm().await;
    driver.drive(0.1, 0.0).await;
    let from = Instant::now();
    stand.revoke("anna");
    let code = drive_on(&mut driver).await;
    // Of the stops, the one that no further order follows.
    let shown_out = from.elapsed();
    let at_rest = stand.memory.stopped_since(from) && shown_out < AT_ONCE;
    let got = json!({ "code": code, "after_s": shown_out.as_secs_f64() });
    note(
        "revoked while it drives on",
        code == Some(close::REVOKED) && at_rest,
        got,
    );
    let is_good = stand.is_good(&anna).await;
    note("a revoked token again", !is_good, json!(is_good));

    let bert = stand.add("bert", Role::Driver);
    let mut owner = stand.bridge.driver().await;
    owner.take(false).await;
    let mut bert = stand.enter(&bert).await;
    bert.say(ToBridge::Take { force: true }).await;
    let refusal = bert
        .wait(|message| match message {
            FromBridge::Refused(reason) => Some(*reason),
            _ => None,
        })
        .await;
    let holds = refusal == RefusalReason::Held;
    note("a driver takes over from the owner", holds, json!(refusal));

    let secrets = [wall, anna, stand.bridge.token.clone()];
    let path = stand.rights.path().to_owned();
    let file = std::fs::read_to_string(path).unwrap_or_default();
    let (lines, _folder) = stand.stop().await;
    let audit = json!(lines).to_string();
    let is_told = secrets
        .iter()
        .any(|secret| file.contains(secret) || audit.contains(secret));
    note(
        "a token in the rights or in the audit",
        !is_told,
        json!(is_told),
    );
    let count = |what: &str| lines.iter().filter(|line| line["what"] == what).count();
    let told = ["lease", "drives", "stops", "revoked", "refused"].map(|what| (what, count(what)));
    let holds = told.iter().all(|(_, count)| *count > 0);
    let told: Map<String, Value> = told
        .iter()
        .map(|(what, n)| ((*what).into(), json!(n)))
        .collect();
    note("told in the audit", holds, json!(told));
    for (name, status) in hosts().await {
        note(name.0, status == Some(name.1), json!(status));
    }
    let holds = cases.values().all(|case| case["holds"] == true);
    (holds, cases)
}

/// Host names for the bridge: each case with its expected status, and the status received.
async fn hosts() -> Vec<((&'static str, u16), Option<u16>)> {
    let config = Config {
        hosts: vec!["robot.example.com".into()],
        ..with_robot().0
    };
    let bridge = Bridge::start(config).await;
    let mut all = vec![];
    for (case, host) in [
        (("a host that was allowed", 200), "robot.example.com"),
        (
            ("that host at a proxy's port", 200),
            "robot.example.com:443",
        ),
        (("a host below it", 421), "evil.robot.example.com"),
        (
            ("a host that begins like it", 421),
            "robot.example.com.evil.com",
        ),
    ] {
        all.push((case, ask(&bridge, host).await));
    }
    bridge.stop().await;
    all
}

async fn ask(bridge: &Bridge, host: &str) -> Option<u16> {
    let mut stream = TcpStream::connect(bridge.address).await.ok()?;
    let request = format!("GET /healthz HTTP/1.1\r\nHost: {host}\r\nConnection: close\r\n\r\n");
    stream.write_all(request.as_bytes()).await.ok()?;
    let mut head = [0; 12];
    stream.read_exact(&mut head).await.ok()?;
    std::str::from_utf8(&head[9..]).ok()?.parse().ok()
}
