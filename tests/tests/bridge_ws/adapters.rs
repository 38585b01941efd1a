//! Clients that speak the protocols of other tools: how much of the bridge they may use, and that
//! they are heard.

use std::time::{Duration, Instant};

use futures_util::{SinkExt, StreamExt};
use serde_json::json;
use slamlab_bridge::{Config, Limits};
use slamlab_core::wire::message::close;
use slamlab_tests::calm::async_on_a_calm_machine;
use tokio::net::{TcpSocket, TcpStream};
use tokio::time::timeout;
use tokio_tungstenite::WebSocketStream;
use tokio_tungstenite::tungstenite::Message;
use tokio_tungstenite::tungstenite::client::IntoClientRequest;
use tokio_tungstenite::tungstenite::http::HeaderValue;

use super::client::{Bridge, limits};
use super::robot::{is_stop, private, with_robot};
use super::streams::get;

const NEVER: Duration = Duration::from_secs(60);

/// A client with small socket buffers, at one of the endpoints.
async fn socket(bridge: &Bridge, path: &str) -> WebSocketStream<TcpStream> {
    let socket = TcpSocket::new_v4().unwrap();
    socket.set_recv_buffer_size(4096).unwrap();
    let stream = socket.connect(bridge.address).await.unwrap();
    let url = format!("ws://{}{path}", bridge.address);
    let mut request = url.into_client_request().unwrap();
    if path == "/foxglove" {
        let protocol = HeaderValue::from_static("foxglove.sdk.v1");
        request
            .headers_mut()
            .insert("sec-websocket-protocol", protocol);
    }
    let answered = tokio_tungstenite::client_async(request, stream).await;
    answered.unwrap().0
}

async fn say(socket: &mut WebSocketStream<TcpStream>, said: serde_json::Value) {
    socket.send(Message::text(said.to_string())).await.unwrap();
}

async fn call(
    socket: &mut WebSocketStream<TcpStream>,
    service: &str,
    args: serde_json::Value,
) -> serde_json::Value {
    let call = json!({ "op": "call_service", "service": service, "args": args });
    say(socket, call).await;
    until(socket, |said| said["op"] == "service_response").await
}

/// The first message from now on for which this holds.
async fn until(
    socket: &mut WebSocketStream<TcpStream>,
    is: impl Fn(&serde_json::Value) -> bool,
) -> serde_json::Value {
    loop {
        let came = timeout(NEVER, socket.next()).await.unwrap();
        let Message::Text(text) = came.unwrap().unwrap() else {
            continue;
        };
        let said = serde_json::from_str(&text).unwrap();
        if is(&said) {
            return said;
        }
    }
}

/// Reads to the end: code and reason of the close.
async fn end(socket: &mut WebSocketStream<TcpStream>) -> (u16, String) {
    loop {
        let came = timeout(NEVER, socket.next()).await.unwrap();
        match came.unwrap().unwrap() {
            Message::Close(Some(frame)) => return (frame.code.into(), frame.reason.to_string()),
            Message::Close(None) => panic!("closed without a word"),
            _ => (),
        }
    }
}

async fn metric(bridge: &Bridge, name: &str) -> u64 {
    let text = get(bridge, "/metrics").await;
    let mut lines = text.lines();
    let line = lines.find_map(|line| line.strip_prefix(&format!("slamlab_{name} ")));
    line.unwrap().parse().unwrap()
}

/// A regression: reads and writes were one task. While a write hung, up to 30 s, nothing that the
/// client said was heard.
#[test]
fn a_client_of_rosbridge_that_reads_nothing_still_stops_the_robot() {
    async_on_a_calm_machine(async || {
        let (config, memory) = with_robot();
        let limits = Limits {
            write: Duration::from_secs(3600),
            heartbeat: Duration::from_secs(3600),
            ..limits()
        };
        let bridge = Bridge::start(Config {
            rosbridge: true,
            limits,
            ..config
        })
        .await;
        let mut socket = socket(&bridge, "/rosbridge").await;
        for topic in ["/scan", "/odom", "/tf"] {
            say(&mut socket, json!({ "op": "subscribe", "topic": topic })).await;
        }
        // Until a write hangs: no other client receives anything.
        let mut sent = 0;
        loop {
            tokio::time::sleep(Duration::from_secs(2)).await;
            let now = metric(&bridge, "messages_sent_total").await;
            if now > 0 && now == std::mem::replace(&mut sent, now) {
                break;
            }
        }
        let from = Instant::now();
        say(
            &mut socket,
            json!({ "op": "call_service", "service": "/slamlab/stop" }),
        )
        .await;
        let is_stopped = || {
            let orders = memory.orders();
            orders
                .iter()
                .any(|(at, order)| *at >= from && is_stop(order))
        };
        while !is_stopped() {
            assert!(from.elapsed() < NEVER, "nobody heard it");
            tokio::time::sleep(Duration::from_millis(10)).await;
        }
        drop(socket);
        bridge.stop().await;
    });
}

#[test]
fn who_shows_no_proof_to_a_private_rosbridge_in_time_is_sent_away_and_counted() {
    async_on_a_calm_machine(async || {
        let bridge = Bridge::start(Config {
            rosbridge: true,
            foxglove: true,
            ..private()
        })
        .await;
        let mut silent = socket(&bridge, "/rosbridge").await;
        let (code, reason) = end(&mut silent).await;
        assert_eq!(code, close::ACCESS);
        assert!(reason.contains("proof"), "{reason}");

        let enter = json!({ "op": "call_service", "service": "/slamlab/enter",
            "args": { "proof": "00".repeat(32) } });
        let mut liar = socket(&bridge, "/rosbridge").await;
        call(&mut liar, "/slamlab/challenge", json!({})).await;
        say(&mut liar, enter.clone()).await;
        assert_eq!(end(&mut liar).await.0, close::ACCESS);
        bridge.stop().await;

        // Figures are only for bridges that anyone may watch.
        let bridge = Bridge::start(Config {
            rosbridge: true,
            ..with_robot().0
        })
        .await;
        let mut liar = socket(&bridge, "/rosbridge").await;
        call(&mut liar, "/slamlab/challenge", json!({})).await;
        say(&mut liar, enter).await;
        assert_eq!(end(&mut liar).await.0, close::ACCESS);
        assert_eq!(metric(&bridge, "intruders_total").await, 1);
        bridge.stop().await;
    });
}

/// A regression: it ended the connection, as if a wrong proof had been tried.
#[test]
fn who_enters_without_challenge_or_proof_is_told_what_is_missing() {
    async_on_a_calm_machine(async || {
        let bridge = Bridge::start(Config {
            rosbridge: true,
            ..with_robot().0
        })
        .await;
        let mut socket = socket(&bridge, "/rosbridge").await;
        let proof = json!({ "proof": "00".repeat(32) });
        let without = call(&mut socket, "/slamlab/enter", proof).await;
        assert_eq!(without["result"], false);
        assert!(without["values"].to_string().contains("challenge"));
        call(&mut socket, "/slamlab/challenge", json!({})).await;
        for args in [json!({}), json!({ "proof": 7 }), json!([])] {
            let without = call(&mut socket, "/slamlab/enter", args).await;
            assert_eq!(without["result"], false);
            assert!(without["values"].to_string().contains("proof"));
        }
        // The challenge remains valid: it is good for one proof, and none was shown.
        let enter = json!({ "op": "call_service", "service": "/slamlab/enter",
            "args": { "proof": "no figures" } });
        say(&mut socket, enter).await;
        assert_eq!(end(&mut socket).await.0, close::ACCESS);
        bridge.stop().await;
    });
}

/// A regression: with subscriptions known by topic alone, two parts of a program that had each
/// subscribed with its own `id` silenced each other.
#[test]
fn a_subscription_outlives_another_of_the_same_topic() {
    async_on_a_calm_machine(async || {
        let bridge = Bridge::start(Config {
            rosbridge: true,
            ..with_robot().0
        })
        .await;
        let mut socket = socket(&bridge, "/rosbridge").await;
        let of = |op: &str, id: &str| json!({ "op": op, "topic": "/odom", "id": id });
        say(&mut socket, of("subscribe", "subscribe:/odom:1")).await;
        say(&mut socket, of("subscribe", "subscribe:/odom:2")).await;
        say(&mut socket, of("unsubscribe", "subscribe:/odom:2")).await;
        // Messages sent before the bridge received that do not count.
        call(&mut socket, "/slamlab/challenge", json!({})).await;
        until(&mut socket, |said| said["topic"] == "/odom").await;
        drop(socket);
        bridge.stop().await;
    });
}

/// A regression: the WebSocket library answers pings, and they were not counted. A client that sent
/// nothing else could send any number of them.
#[test]
fn a_flood_of_pings_ends_the_connection() {
    async_on_a_calm_machine(async || {
        let (config, _) = with_robot();
        let bridge = Bridge::start(Config {
            rosbridge: true,
            foxglove: true,
            limits: Limits {
                watcher_rate: 1,
                ..limits()
            },
            ..config
        })
        .await;
        for path in ["/ws", "/rosbridge", "/foxglove"] {
            let mut socket = socket(&bridge, path).await;
            for _ in 0..20 {
                // The bridge may already have closed the connection.
                let _ = socket.send(Message::Ping(vec![].into())).await;
            }
            assert_eq!(end(&mut socket).await.0, 1008, "{path}");
        }
        bridge.stop().await;
    });
}
