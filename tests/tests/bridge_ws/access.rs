//! Who may connect, watch and drive; and that everyone else has no effect on the robot.

use std::time::{Duration, Instant};

use slamlab_bridge::{Config, Limits};
use slamlab_core::robot::Command;
use slamlab_core::wire::message::{
    ClientHello, Format, FromBridge, Header, RefusalReason, SCHEMA, ToBridge, close, encode, proof,
};
use slamlab_tests::calm::async_on_a_calm_machine;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;
use tokio_tungstenite::tungstenite::Message;
use tokio_tungstenite::tungstenite::client::IntoClientRequest;
use tokio_tungstenite::tungstenite::http::HeaderValue;

use super::client::{Bridge, Came, Client, limits, stream_from};
use super::robot::{is_stop, private, with_robot};
use super::streams::get;

/// Status of the answer to an upgrade with these headers; 101 if it succeeds.
async fn upgrade(bridge: &Bridge, headers: &[(&'static str, &str)]) -> u16 {
    let stream = TcpStream::connect(bridge.address).await.unwrap();
    let url = format!("ws://{}/ws", bridge.address);
    let mut request = url.into_client_request().unwrap();
    for (name, value) in headers {
        request
            .headers_mut()
            .insert(*name, HeaderValue::from_str(value).unwrap());
    }
    match tokio_tungstenite::client_async(request, stream).await {
        Ok(_) => 101,
        Err(tokio_tungstenite::tungstenite::Error::Http(response)) => response.status().as_u16(),
        Err(error) => panic!("{error}"),
    }
}

#[test]
fn foreign_pages_and_rebound_names_are_refused() {
    async_on_a_calm_machine(async || {
        let (config, memory) = with_robot();
        let bridge = Bridge::start(Config {
            origins: vec!["https://lab.example".into()],
            ..config
        })
        .await;
        let own = format!("http://{}", bridge.address);
        for (headers, expect) in [
            (vec![], 101),
            (vec![("origin", own.as_str())], 101),
            (vec![("origin", "https://lab.example")], 101),
            (vec![("origin", "https://evil.example")], 403),
            (vec![("origin", "null")], 403),
            (vec![("origin", "http://127.0.0.1")], 403),
            (vec![("host", "evil.example")], 421),
            (
                vec![("host", "evil.example"), ("origin", "http://evil.example")],
                421,
            ),
            (
                vec![("host", "robot.local"), ("origin", "http://robot.local")],
                101,
            ),
        ] {
            assert_eq!(upgrade(&bridge, &headers).await, expect, "{headers:?}");
        }
        assert!(!memory.was_moved());
        bridge.stop().await;
    });
}

#[test]
fn a_missing_wrong_or_replayed_proof_is_worth_nothing() {
    async_on_a_calm_machine(async || {
        let (config, memory) = with_robot();
        let bridge = Bridge::start(config).await;
        let mut watcher = bridge.connect().await;
        assert!(!watcher.enter(None).await, "without a token one watches");

        let mut wrong = bridge.connect().await;
        let hello = wrong.hello(Some("0123456789abcdef0123456789abcdef"));
        wrong.say(hello).await;
        assert_eq!(wrong.end().await, Some(close::ACCESS));

        let mut first = bridge.connect().await;
        let overheard = first.hello(Some(&bridge.token));
        first.say(overheard.clone()).await;
        let mut second = bridge.connect().await;
        assert_ne!(first.challenge, second.challenge);
        second.say(overheard).await;
        assert_eq!(second.end().await, Some(close::ACCESS));
        assert!(!memory.was_moved());
        bridge.stop().await;
    });
}

#[test]
fn where_watching_needs_the_token_nobody_watches_without() {
    async_on_a_calm_machine(async || {
        let bridge = Bridge::start(private()).await;
        let mut client = bridge.connect().await;
        let hello = client.hello(None);
        client.say(hello).await;
        assert_eq!(client.end().await, Some(close::ACCESS));
        assert!(bridge.connect().await.enter(Some(&bridge.token)).await);
        bridge.stop().await;
    });
}

#[test]
fn who_says_nothing_or_something_else_first_is_shown_out() {
    async_on_a_calm_machine(async || {
        let (config, memory) = with_robot();
        let bridge = Bridge::start(config).await;
        let start = Instant::now();
        let mut silent = bridge.connect().await;
        assert_eq!(silent.end().await, Some(close::ACCESS));
        let waited = start.elapsed();
        assert!((1.9..3.0).contains(&waited.as_secs_f64()), "{waited:?}");
        for first in [
            ToBridge::Heartbeat,
            ToBridge::Take { force: true },
            ToBridge::Arm { epoch: 1 },
        ] {
            let mut client = bridge.connect().await;
            client.say(first).await;
            assert_eq!(client.end().await, Some(close::ACCESS));
        }
        assert!(!memory.was_moved());
        bridge.stop().await;
    });
}

#[test]
fn a_watcher_who_wants_to_drive_is_shown_out_and_may_stop() {
    async_on_a_calm_machine(async || {
        let (config, memory) = with_robot();
        let bridge = Bridge::start(config).await;
        let mut driver = bridge.armed().await;
        let drive = ToBridge::Drive(driver.body(Command::Forward(1.0)));
        let epoch = driver.epoch;
        for wish in [
            ToBridge::Take { force: true },
            ToBridge::Arm { epoch },
            ToBridge::Renew { epoch },
            ToBridge::Release { epoch },
            ToBridge::ResetEmergencyStop { epoch },
            ToBridge::ResetMap,
            drive,
        ] {
            let mut watcher = bridge.watcher().await;
            watcher.say(wish).await;
            assert_eq!(watcher.end().await, Some(close::NO_RIGHT));
        }
        assert!(!memory.was_moved());
        bridge.watcher().await.say(ToBridge::Stop).await;
        let is_armed = |message: &FromBridge| match message {
            FromBridge::Safety(state) => Some(state.armed),
            _ => None,
        };
        assert!(!driver.wait(is_armed).await);
        bridge.stop().await;
    });
}

#[test]
fn stale_epochs_and_sequences_have_no_effect() {
    async_on_a_calm_machine(async || {
        let (config, memory) = with_robot();
        let bridge = Bridge::start(config).await;
        let mut driver = bridge.armed().await;
        let mut body = driver.body(Command::Forward(1.0));
        body.epoch -= 1;
        driver.say(ToBridge::Drive(body)).await;
        let refusal = |message: &FromBridge| match message {
            FromBridge::Refused(reason) => Some(*reason),
            _ => None,
        };
        assert_eq!(driver.wait(refusal).await, RefusalReason::StaleEpoch);
        // A command that claims to be a reaction to what was seen a second ago.
        let mut body = driver.body(Command::Forward(1.0));
        tokio::time::sleep(Duration::from_secs(1)).await;
        body.ttl_millis = u16::MAX;
        driver.say(ToBridge::Drive(body)).await;
        assert_eq!(driver.wait(refusal).await, RefusalReason::TooOld);
        // Exactly the same message once more.
        driver.sequence -= 1;
        driver.say(ToBridge::Heartbeat).await;
        assert_eq!(driver.end().await, Some(1007));
        assert!(!memory.was_moved());
        bridge.stop().await;
    });
}

#[test]
fn malformed_oversize_and_too_many_messages_end_the_connection() {
    async_on_a_calm_machine(async || {
        let (config, memory) = with_robot();
        let bridge = Bridge::start(config).await;
        let header = Header {
            sequence: 9,
            micros: 0,
        };
        let good = encode(header, &ToBridge::Stop, Format::Binary).unwrap();
        let mut spoilt = good.clone();
        spoilt[3] = 200;
        for (message, code) in [
            (Message::binary(vec![1, 2, 3]), 1007),
            (Message::binary(spoilt), 1007),
            (Message::text("{}"), 1003),
            (Message::binary(vec![0; 65 * 1024]), 1009),
            (Message::binary([good.as_slice(), &[0]].concat()), 1007),
        ] {
            let mut client = bridge.driver().await;
            client.send(message).await;
            assert_eq!(client.end().await, Some(code));
        }
        let mut noisy = bridge.driver().await;
        for _ in 0..600 {
            noisy.say(ToBridge::Heartbeat).await;
        }
        assert_eq!(noisy.end().await, Some(1008));
        let mut long = bridge.connect().await;
        let hello = ClientHello {
            schema: SCHEMA,
            // 33 letters of two bytes; the 32nd ends at the 64th byte.
            name: "ő".repeat(33),
            proof: Some(proof(&bridge.token, &long.challenge)),
        };
        long.say(ToBridge::Hello(hello)).await;
        long.say(ToBridge::Take { force: true }).await;
        let driver = long.wait(|message| match message {
            FromBridge::Safety(body) => Some(&body.driver_name)
                .filter(|name| !name.is_empty())
                .cloned(),
            _ => None,
        });
        assert_eq!(driver.await, "ő".repeat(32), "a long name is cut off");
        assert!(!memory.was_moved());
        bridge.stop().await;
    });
}

#[test]
fn a_slow_header_does_not_keep_a_connection() {
    async_on_a_calm_machine(async || {
        let bridge = Bridge::start(Config {
            limits: Limits {
                header: Duration::from_millis(500),
                ..limits()
            },
            ..Config::default()
        })
        .await;
        let start = Instant::now();
        let mut stream = TcpStream::connect(bridge.address).await.unwrap();
        stream.write_all(b"GET / HTTP/1.1\r\n").await.unwrap();
        let mut ended = false;
        for _ in 0..100 {
            tokio::time::sleep(Duration::from_millis(50)).await;
            let mut answer = [0; 512];
            let read =
                tokio::time::timeout(Duration::from_millis(1), stream.read(&mut answer)).await;
            if matches!(read, Ok(Ok(0) | Err(_))) || stream.write_all(b"X-A: b\r\n").await.is_err()
            {
                ended = true;
                break;
            }
        }
        assert!(
            ended && start.elapsed() < Duration::from_secs(3),
            "{:?}",
            start.elapsed()
        );
        bridge.stop().await;
    });
}

#[test]
fn a_thousand_connections_do_not_keep_the_driver_from_stopping() {
    async_on_a_calm_machine(async || {
        let (config, memory) = with_robot();
        let bridge = Bridge::start(Config {
            limits: Limits {
                sockets: 100,
                ..limits()
            },
            ..config
        })
        .await;
        let mut driver = bridge.armed().await;
        driver.drive(0.1, 0.0).await;
        let mut idle = Vec::new();
        for _ in 0..1000 {
            idle.push(TcpStream::connect(bridge.address).await.unwrap());
        }
        tokio::time::sleep(Duration::from_millis(200)).await;
        let mut open = 0;
        for stream in &mut idle {
            let mut answer = [0; 12];
            let read = stream.read(&mut answer);
            open += usize::from(
                tokio::time::timeout(Duration::from_millis(1), read)
                    .await
                    .is_err(),
            );
        }
        // The newest connections are refused, and the driver was there before them.
        assert_eq!(open, 99);
        let from = Instant::now();
        driver.say(ToBridge::Stop).await;
        let took = memory.stopped_after(from).await;
        assert!(took < Duration::from_millis(100), "{took:?}");
        drop(idle);
        bridge.stop().await;
    });
}

/// A regression: each repeated Stop was told to everybody, until all queues were full. All clients
/// were closed, even the driver, and told that they were too slow.
#[test]
fn a_burst_of_stops_throws_nobody_out() {
    async_on_a_calm_machine(async || {
        let (config, memory) = with_robot();
        let limits = Limits {
            heartbeat: Duration::from_secs(3600),
            ..limits()
        };
        let bridge = Bridge::start(Config { limits, ..config }).await;
        let mut honest = bridge.watcher().await;
        let mut driver = bridge.armed().await;
        driver.drive(0.1, 0.0).await;
        for _ in 0..5 {
            let mut hostile = bridge.watcher().await;
            for sequence in 0..390 {
                hostile
                    .say(match sequence % 2 {
                        0 => ToBridge::Stop,
                        _ => ToBridge::EmergencyStop,
                    })
                    .await;
            }
            assert_eq!(hostile.end().await, Some(1008));
        }
        let stopped = memory
            .orders()
            .into_iter()
            .filter(|(_, order)| is_stop(order));
        let stops = stopped.count();
        assert!((2..100).contains(&stops), "{stops} orders to stop");
        for client in [&mut honest, &mut driver] {
            client.say(ToBridge::Probe { token: 7 }).await;
            let is_answer =
                |message: &FromBridge| matches!(message, FromBridge::Probe(_)).then_some(());
            client.wait(is_answer).await;
        }
        bridge.stop().await;
    });
}

/// A regression: they took all places, and the owner could not even stop the robot.
#[test]
fn watchers_from_everywhere_leave_a_place_for_the_owner() {
    async_on_a_calm_machine(async || {
        let (config, memory) = with_robot();
        let limits = Limits {
            heartbeat: Duration::from_secs(3600),
            ..limits()
        };
        let bridge = Bridge::start(Config { limits, ..config }).await;
        let (mut watching, mut codes) = (vec![], vec![]);
        for number in 0..299_u32 {
            let mut client = Client::connect_from(bridge.address, 2 + (number % 5) as u8).await;
            let hello = client.hello(None);
            client.say(hello).await;
            match client.next().await {
                Came::Message(_) => watching.push(client),
                other => codes.push(other),
            }
        }
        assert_eq!(watching.len(), 200);
        assert!(
            codes
                .iter()
                .all(|came| matches!(came, Came::Closed(close::FULL)))
        );
        // And as many connections that say nothing.
        let mut idle = vec![];
        for number in 0..150 {
            idle.push(stream_from(bridge.address, 2 + number % 5).await);
        }
        let from = Instant::now();
        let mut owner = bridge.driver().await;
        owner.say(ToBridge::Stop).await;
        memory.stopped_after(from).await;
        drop((watching, idle));
        bridge.stop().await;
    });
}

#[test]
fn who_shows_nothing_without_the_token_shows_no_figures_either() {
    async_on_a_calm_machine(async || {
        let bridge = Bridge::start(private()).await;
        for path in ["/bridge.json", "/metrics"] {
            let text = get(&bridge, path).await;
            assert!(
                !text.contains("test") && !text.contains("slamlab_"),
                "{text}"
            );
        }
        // But the page must know where to show the token.
        let about: serde_json::Value =
            serde_json::from_str(&get(&bridge, "/bridge.json").await).unwrap();
        assert_eq!(
            about,
            serde_json::json!({ "websocket": "/ws", "watching": "token" })
        );
        bridge.stop().await;
    });
}

#[test]
fn the_same_protocol_is_spoken_in_text() {
    async_on_a_calm_machine(async || {
        let (config, memory) = with_robot();
        let bridge = Bridge::start(config).await;
        let mut client = Client::connect(bridge.address, "?fmt=json").await;
        assert!(client.enter(Some(&bridge.token)).await);
        client.take(false).await;
        client.arm().await;
        client.drive_for(Duration::from_millis(400), 0.1).await;
        assert!(memory.was_moved());
        assert_eq!(upgrade_path(&bridge, "/ws?fmt=xml").await, 400);
        bridge.stop().await;
    });
}

async fn upgrade_path(bridge: &Bridge, path: &str) -> u16 {
    let stream = TcpStream::connect(bridge.address).await.unwrap();
    let url = format!("ws://{}{path}", bridge.address);
    match tokio_tungstenite::client_async(url, stream).await {
        Ok(_) => 101,
        Err(tokio_tungstenite::tungstenite::Error::Http(response)) => response.status().as_u16(),
        Err(error) => panic!("{error}"),
    }
}
