//! Clients that are refused before the WebSocket opens, over plain sockets; and orders under a
//! lease that has ended.

use std::net::SocketAddr;
use std::time::{Duration, Instant};

use serde_json::{Map, Value, json};
use slamlab_core::robot::Command;
use slamlab_core::wire::message::{FromBridge, RefusalReason, ToBridge};
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;
use tokio::time::timeout;

use crate::client::Bridge;
use crate::robot::with_robot;

const CROWD: usize = 1000;
/// Longer than the bridge waits for a request's header.
const PATIENCE: Duration = Duration::from_secs(20);

/// Each case, and whether all hold; the robot must not have moved.
pub(crate) async fn report() -> (bool, Map<String, Value>) {
    let (config, memory) = with_robot();
    let bridge = Bridge::start(config).await;
    let own = bridge.address.to_string();
    let mut cases = Map::new();
    for (name, host, origin, expected) in [
        ("foreign origin", own.as_str(), "https://evil.example", 403),
        ("rebinding host", "evil.example", "http://evil.example", 421),
    ] {
        let got = knock(bridge.address, host, origin).await;
        cases.insert(name.into(), case(got == Some(expected), &json!(got)));
    }
    let slow = slowloris(bridge.address).await;
    cases.insert(
        "slowloris".into(),
        case(slow.is_some(), &json!({ "cut_off_after_s": slow })),
    );
    let stale = stale_lease(&bridge).await;
    cases.insert(
        "stale lease epoch".into(),
        case(stale, &json!(RefusalReason::StaleEpoch)),
    );
    let (served, open) = crowd(bridge.address).await;
    cases.insert(
        "1000 connections from one address".into(),
        case(
            open <= 100 && served > 0,
            &json!({ "served": served, "open_at_the_end": open }),
        ),
    );
    // Once all of them are gone, it serves again.
    let watcher = timeout(PATIENCE, bridge.watcher()).await;
    cases.insert(
        "afterwards".into(),
        case(watcher.is_ok(), &json!("a watcher is served")),
    );
    drop(watcher);
    let was_moved = memory.was_moved();
    bridge.stop().await;
    let holds = cases.values().all(|case| case["holds"] == true);
    (holds && !was_moved, cases)
}

fn case(holds: bool, got: &Value) -> Value {
    json!({ "holds": holds, "got": got })
}

fn request(host: &str, origin: &str) -> String {
    format!(
        "GET /ws HTTP/1.1\r\nHost: {host}\r\nOrigin: {origin}\r\nConnection: Upgrade\r\nUpgrade: websocket\r\n\
         Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n"
    )
}

/// The status of the answer.
async fn knock(address: SocketAddr, host: &str, origin: &str) -> Option<u16> {
    let mut stream = TcpStream::connect(address).await.ok()?;
    stream
        .write_all(request(host, origin).as_bytes())
        .await
        .ok()?;
    status(&mut stream).await
}

async fn status(stream: &mut TcpStream) -> Option<u16> {
    let mut head = [0; 12];
    timeout(PATIENCE, stream.read_exact(&mut head))
        .await
        .ok()?
        .ok()?;
    std::str::from_utf8(&head[9..]).ok()?.parse().ok()
}

/// A header that arrives byte by byte; seconds until the bridge closes the connection.
async fn slowloris(address: SocketAddr) -> Option<f64> {
    let mut stream = TcpStream::connect(address).await.ok()?;
    let begun = Instant::now();
    for byte in request("127.0.0.1", "http://127.0.0.1").bytes() {
        let mut answer = [0; 64];
        let is_open = stream.write_all(&[byte]).await.is_ok();
        let heard = timeout(Duration::from_millis(200), stream.read(&mut answer)).await;
        if !is_open || matches!(heard, Ok(Ok(0) | Err(_))) {
            return Some(begun.elapsed().as_secs_f64());
        }
        if begun.elapsed() > PATIENCE {
            return None;
        }
    }
    None
}

/// Somebody took over; the previous driver comes back, and sends orders under the lease that it
/// had, and under the one that is not its own.
async fn stale_lease(bridge: &Bridge) -> bool {
    let mut before = bridge.driver().await;
    before.take(false).await;
    let mut holder = bridge.driver().await;
    holder.take(true).await;
    holder.arm().await;
    let mut again = bridge.driver().await;
    for epoch in [before.epoch, holder.epoch] {
        let mut body = again.body(Command::Forward(1.0));
        body.epoch = epoch;
        again.say(ToBridge::Drive(body)).await;
        let refusal = again
            .wait(|message| match message {
                FromBridge::Refused(reason) => Some(*reason),
                _ => None,
            })
            .await;
        if refusal != RefusalReason::StaleEpoch {
            return false;
        }
    }
    true
}

/// Many connections: how many got a WebSocket, and how many still have one at the end, because the
/// first to come make room.
async fn crowd(address: SocketAddr) -> (usize, usize) {
    let own = address.to_string();
    let mut all = Vec::with_capacity(CROWD);
    let mut served = 0;
    for _ in 0..CROWD {
        let Ok(mut stream) = TcpStream::connect(address).await else {
            continue;
        };
        let text = request(&own, &format!("http://{own}"));
        // A refused connection may already be closed.
        let _ = stream.write_all(text.as_bytes()).await;
        if status(&mut stream).await == Some(101) {
            served += 1;
            all.push(stream);
        }
    }
    let mut open = 0;
    for stream in &mut all {
        let end = async {
            while stream
                .read(&mut [0; 4096])
                .await
                .is_ok_and(|bytes| bytes > 0)
            {}
        };
        open += usize::from(timeout(Duration::from_millis(1), end).await.is_err());
    }
    (served, open)
}
