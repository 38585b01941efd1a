//! A bridge that maps without a page: its map grows, agrees with the simulator's walls, survives a
//! restart, and is closed to those who may not look or drive.

use std::fs;
use std::path::Path;
use std::time::Duration;

use futures_util::{SinkExt, StreamExt};
use serde_json::{Value, json};
use slamlab_bridge::{Config, MapConfig, RunError};
use slamlab_core::format::slamlab;
use slamlab_core::sim::worlds;
use slamlab_core::slam::Method;
use slamlab_core::wire::message::{
    FromBridge, MapBody, PoseBody, PoseState, RefusalReason, ToBridge,
};
use slamlab_tests::calm::async_on_a_calm_machine;
use slamlab_tests::map_truth::{self, MapTruth};
use tokio_tungstenite::tungstenite::Message;

use super::client::{Bridge, Client, until_there};
use super::robot::private;
use super::streams::{get, simulated};

fn mapping(file: Option<&Path>) -> Config {
    Config {
        map: Some(MapConfig {
            file: file.map(Path::to_owned),
            save_every: Duration::from_secs(1),
            ..MapConfig::default()
        }),
        ..simulated()
    }
}

fn map(message: &FromBridge) -> Option<MapBody> {
    match message {
        FromBridge::Map(map) => Some(map.clone()),
        _ => None,
    }
}

fn pose(message: &FromBridge) -> Option<PoseBody> {
    match message {
        FromBridge::Pose(pose) => Some(*pose),
        _ => None,
    }
}

fn known(map: &MapBody) -> u64 {
    let runs = map.runs.iter().filter(|run| *run % 4 != 0);
    runs.map(|run| u64::from(run / 4)).sum()
}

async fn truth(bridge: &Bridge) -> MapTruth {
    let yaml = get(bridge, "/map.yaml").await;
    let image = yaml.lines().next().unwrap().strip_prefix("image: ");
    let image = image.unwrap().trim_matches('"');
    let pgm = get_bytes(bridge, &format!("/{image}")).await;
    let arena = worlds::builtin("arena").unwrap();
    map_truth::compare(&arena, &pgm, &yaml).unwrap()
}

async fn get_bytes(bridge: &Bridge, path: &str) -> Vec<u8> {
    use tokio::io::{AsyncReadExt, AsyncWriteExt};
    let mut stream = tokio::net::TcpStream::connect(bridge.address)
        .await
        .unwrap();
    let host = bridge.address;
    let request = format!("GET {path} HTTP/1.1\r\nHost: {host}\r\nConnection: close\r\n\r\n");
    stream.write_all(request.as_bytes()).await.unwrap();
    let mut answer = vec![];
    stream.read_to_end(&mut answer).await.unwrap();
    let body = answer
        .windows(4)
        .position(|four| four == b"\r\n\r\n")
        .unwrap();
    answer.split_off(body + 4)
}

/// Drives at these speeds, m/s and rad/s, each for this many twentieths of a second.
async fn drive(driver: &mut Client, legs: &[(f64, f64, u32)]) {
    for &(forward, turn, times) in legs {
        let mut ticks = tokio::time::interval(Duration::from_millis(50));
        let mut left = times;
        while left > 0 {
            tokio::select! {
                _ = ticks.tick() => {
                    driver.drive(forward, turn).await;
                    left -= 1;
                }
                _ = driver.next() => (),
            }
        }
    }
}

/// Turns around and drives a little, to see more.
const ABOUT: [(f64, f64, u32); 3] = [(0.0, 1.0, 60), (0.2, 0.0, 60), (0.0, -1.0, 60)];

#[test]
fn a_map_comes_without_a_page_grows_and_is_true() {
    async_on_a_calm_machine(async || {
        let bridge = Bridge::start(mapping(None)).await;
        let mut watcher = bridge.watcher().await;
        let first = watcher.wait(map).await;
        assert!(known(&first) > 500, "{}", known(&first));
        let at = watcher.wait(pose).await;
        assert_eq!(at.state, PoseState::Localised);
        // The watcher is the only client.
        let clients = watcher.wait(|message| match message {
            FromBridge::Heartbeat(beat) => Some(beat.clients),
            _ => None,
        });
        assert_eq!(clients.await, 1);

        let mut driver = bridge.armed().await;
        drive(&mut driver, &ABOUT).await;
        let grown = |message: &FromBridge| map(message).filter(|map| known(map) > known(&first));
        let later = watcher.wait(grown).await;
        assert!(later.revision > first.revision);

        // A client that connects later has it at once.
        let mut newcomer = bridge.watcher().await;
        let mut before = vec![];
        let its = newcomer
            .wait(|message| {
                before.push(matches!(message, FromBridge::Scan(_)));
                map(message)
            })
            .await;
        assert!(known(&its) >= known(&later));
        assert!(before.iter().filter(|is_scan| **is_scan).count() <= 2);

        let truth = truth(&bridge).await;
        assert!(truth.true_walls > 0.95, "{truth:?}");
        assert!(truth.wall_error < 0.05, "{truth:?}");
        assert!(truth.explored > 0.4, "{truth:?}");
        bridge.stop().await;
    });
}

#[test]
fn a_map_survives_the_end_of_the_bridge_and_is_gone_on_in() {
    async_on_a_calm_machine(async || {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("flat.slamlab");
        let bridge = Bridge::start(mapping(Some(&file))).await;
        let mut driver = bridge.armed().await;
        // It returns to where it began, because the simulated robot stands there after a restart.
        drive(&mut driver, &[(0.0, 1.0, 40), (0.0, -1.0, 40)]).await;
        // Written during the run, not only at the end.
        let saved = |message: &FromBridge| match message {
            FromBridge::Mapping(body) if body.saved > 0 => Some(body.clone()),
            _ => None,
        };
        let body = driver.wait(saved).await;
        assert_eq!((body.file.as_str(), body.fault), ("flat.slamlab", None));
        let last = driver.wait(map).await;
        drop(driver);
        bridge.stop().await;
        let kept = slamlab::read(&fs::read(&file).unwrap()).unwrap();
        assert_eq!(kept.title, "flat");

        let bridge = Bridge::start(mapping(Some(&file))).await;
        let mut watcher = bridge.watcher().await;
        let mut has_seen = false;
        let first = watcher
            .wait(|message| {
                has_seen |= matches!(message, FromBridge::Pose(_));
                map(message)
            })
            .await;
        assert!(!has_seen, "the map is there before the first scan is in it");
        let (first, last) = (known(&first), known(&last));
        assert!(first as f64 > 0.95 * last as f64, "{first} of {last}");
        let at = watcher.wait(pose).await;
        assert_eq!(
            at.state,
            PoseState::Localised,
            "it sees what it saw: {at:?}"
        );
        let truth = truth(&bridge).await;
        assert!(
            truth.true_walls > 0.95 && truth.wall_error < 0.05,
            "{truth:?}"
        );
        bridge.stop().await;
        // The file holds both runs.
        let again = slamlab::read(&fs::read(&file).unwrap()).unwrap();
        assert!(again.map != kept.map);
    });
}

/// The robot was carried between two runs. If it does not localise itself at once, it maps a
/// separate piece until the piece's place is proved, and the earlier map is not spoilt.
#[test]
fn a_robot_that_was_carried_meanwhile_finds_itself_in_the_map_of_before() {
    async_on_a_calm_machine(async || {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("flat.slamlab");
        let bridge = Bridge::start(mapping(Some(&file))).await;
        let mut driver = bridge.armed().await;
        drive(&mut driver, &ABOUT).await;
        drive(&mut driver, &ABOUT).await;
        bridge.stop().await;

        let bridge = Bridge::start(mapping(Some(&file))).await;
        let mut driver = bridge.armed().await;
        let at = driver.wait(pose).await;
        // It stands at the origin of the map again, more than a metre from where it was left.
        let [x, y, _] = at.pose;
        let is_there = x.hypot(y) < 0.1;
        assert!(at.state == PoseState::Unplaced || is_there, "{at:?}");
        let mut state = at.state;
        for _ in 0..6 {
            if state == PoseState::Localised {
                break;
            }
            drive(&mut driver, &ABOUT).await;
            state = driver.wait(pose).await.state;
        }
        assert_eq!(state, PoseState::Localised);
        let truth = truth(&bridge).await;
        assert!(
            truth.true_walls > 0.95 && truth.wall_error < 0.05,
            "{truth:?}"
        );
        bridge.stop().await;
    });
}

#[test]
fn what_is_no_map_is_refused_with_its_name_and_left_alone() {
    async_on_a_calm_machine(async || {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("flat.slamlab");
        let fails = async |config: Config| -> String {
            let listener = slamlab_bridge::bind(([127, 0, 0, 1], 0).into()).await;
            match slamlab_bridge::start(listener.unwrap(), config) {
                Err(RunError::Map(error)) => error.to_string(),
                other => panic!("{other:?}"),
            }
        };
        for bytes in [&b"P5 1 1 255 x"[..], b"", b"\x89slamlab\x07\0\0\0"] {
            fs::write(&file, bytes).unwrap();
            let error = fails(mapping(Some(&file))).await;
            assert!(
                error.contains("flat.slamlab") && error.contains("left as it is"),
                "{error}"
            );
            assert_eq!(fs::read(&file).unwrap(), bytes);
        }
        fs::remove_file(&file).unwrap();
        let nowhere = folder.path().join("none").join("flat.slamlab");
        let error = fails(mapping(Some(&nowhere))).await;
        assert!(
            error.contains("none") && error.contains("No such file"),
            "{error}"
        );

        let with = |change: &dyn Fn(&mut MapConfig)| {
            let mut config = mapping(Some(&file));
            change(config.map.as_mut().unwrap());
            config
        };
        let error = fails(with(&|map| map.method = Method::LineEkf)).await;
        assert!(
            error.contains("only scan-matching") && error.contains("line-ekf"),
            "{error}"
        );
        let error = fails(with(&|map| {
            map.file = None;
            map.method = Method::ParticleLocalisation;
        }))
        .await;
        assert!(error.contains("particle-localisation"), "{error}");
        let error = fails(with(&|map| {
            map.settings = vec![("grid.nonsense".into(), 1.0)]
        }))
        .await;
        assert!(error.contains("grid.nonsense"), "{error}");
        let error = fails(with(&|map| {
            map.settings = vec![("grid.resolution".into(), -1.0)]
        }))
        .await;
        assert!(
            error.contains("Cell size") || error.contains("grid.resolution"),
            "{error}"
        );
        assert!(!file.exists(), "nothing was written");
    });
}

#[test]
fn who_may_not_look_gets_no_map_and_who_drives_begins_it_anew() {
    async_on_a_calm_machine(async || {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("flat.slamlab");
        let bridge = Bridge::start(Config {
            watching: private().watching,
            ..mapping(Some(&file))
        })
        .await;
        for path in ["/map.yaml", "/map.pgm", "/map/1.pgm", "/map.slamlab"] {
            assert!(
                get(&bridge, path).await.contains("needs the token"),
                "{path}"
            );
        }
        let mut owner = bridge.driver().await;
        let saved = |message: &FromBridge| match message {
            FromBridge::Mapping(body) => Some(body.saved).filter(|saved| *saved > 0),
            _ => None,
        };
        owner.wait(saved).await;
        owner.say(ToBridge::ResetMap).await;
        let begun = |message: &FromBridge| match message {
            FromBridge::Mapping(body) => Some(body.saved).filter(|saved| *saved == 0),
            _ => None,
        };
        owner.wait(begun).await;
        let aside = folder.path().join("flat.1.slamlab");
        assert!(slamlab::read(&fs::read(aside).unwrap()).is_ok());
        owner.wait(saved).await;
        bridge.stop().await;
        assert!(slamlab::read(&fs::read(file).unwrap()).is_ok());

        let bridge = Bridge::start(simulated()).await;
        let mut owner = bridge.driver().await;
        owner.say(ToBridge::ResetMap).await;
        let refused = owner.wait(|message| match message {
            FromBridge::Refused(reason) => Some(*reason),
            _ => None,
        });
        assert_eq!(refused.await, RefusalReason::NoMap);
        assert!(get(&bridge, "/map.yaml").await.contains("There is no"));
        bridge.stop().await;
    });
}

#[test]
fn what_was_not_saved_yet_stays_with_the_map_before_when_it_begins_anew() {
    async_on_a_calm_machine(async || {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("flat.slamlab");
        let mut config = mapping(Some(&file));
        config.map.as_mut().unwrap().save_every = Duration::from_secs(3600);
        let bridge = Bridge::start(config).await;
        let mut owner = bridge.driver().await;
        let mapped = |message: &FromBridge| match message {
            FromBridge::Mapping(body) => Some(body.scans).filter(|scans| *scans > 3),
            _ => None,
        };
        owner.wait(mapped).await;
        assert!(!file.exists());
        owner.say(ToBridge::ResetMap).await;
        let aside = folder.path().join("flat.1.slamlab");
        until_there(&aside, true, Duration::from_secs(60)).await;
        assert!(slamlab::read(&fs::read(aside).unwrap()).is_ok());
        bridge.stop().await;
    });
}

#[test]
fn foxglove_and_rosbridge_see_the_map_and_where_the_odometry_lies_in_it() {
    async_on_a_calm_machine(async || {
        let bridge = Bridge::start(Config {
            foxglove: true,
            rosbridge: true,
            ..mapping(None)
        })
        .await;
        let url = format!("ws://{}/rosbridge", bridge.address);
        let (mut socket, _) = tokio_tungstenite::connect_async(url).await.unwrap();
        let mut say =
            async |said: Value| socket.send(Message::text(said.to_string())).await.unwrap();
        for topic in ["/map", "/tf", "/pose"] {
            say(json!({ "op": "subscribe", "topic": topic })).await;
        }
        let (mut map, mut tf, mut pose) = (None, None, None);
        while map.is_none() || tf.is_none() || pose.is_none() {
            let came = tokio::time::timeout(Duration::from_secs(20), socket.next()).await;
            let Message::Text(text) = came.unwrap().unwrap().unwrap() else {
                continue;
            };
            let said: Value = serde_json::from_str(&text).unwrap();
            let msg = said["msg"].clone();
            match said["topic"].as_str() {
                Some("/map") => map = Some(msg),
                Some("/pose") => pose = Some(msg),
                Some("/tf") if msg["transforms"][0]["header"]["frame_id"] == "map" => {
                    tf = Some(msg);
                }
                _ => assert_ne!(said["op"], "status", "{said}"),
            }
        }
        let info = &map.as_ref().unwrap()["info"];
        let cells = map.as_ref().unwrap()["data"].as_array().unwrap();
        let size = info["width"].as_u64().unwrap() * info["height"].as_u64().unwrap();
        assert_eq!(cells.len() as u64, size);
        assert!(cells.iter().any(|cell| *cell == 100) && cells.iter().any(|cell| *cell == 0));
        // It stands where it began: map, odometry and robot frames coincide.
        let shift = &tf.unwrap()["transforms"][0]["transform"]["translation"];
        assert!(shift["x"].as_f64().unwrap().abs() < 0.05, "{shift}");
        assert_eq!(pose.unwrap()["header"]["frame_id"], "map");

        let mut request =
            tokio_tungstenite::tungstenite::client::IntoClientRequest::into_client_request(
                format!("ws://{}/foxglove", bridge.address),
            )
            .unwrap();
        let protocol = "foxglove.sdk.v1".parse().unwrap();
        request
            .headers_mut()
            .insert("sec-websocket-protocol", protocol);
        let (mut socket, _) = tokio_tungstenite::connect_async(request).await.unwrap();
        let mut channel = None;
        loop {
            let came = tokio::time::timeout(Duration::from_secs(20), socket.next()).await;
            match came.unwrap().unwrap().unwrap() {
                Message::Text(text) => {
                    let said: Value = serde_json::from_str(&text).unwrap();
                    let Some(channels) = said["channels"].as_array() else {
                        continue;
                    };
                    let mut maps = channels.iter().filter(|channel| channel["topic"] == "/map");
                    channel = maps.next().map(|channel| channel["id"].clone());
                    let wants = json!({ "op": "subscribe", "subscriptions": [{ "id": 7, "channelId": channel }] });
                    socket.send(Message::text(wants.to_string())).await.unwrap();
                }
                Message::Binary(bytes) => {
                    assert_eq!(&bytes[..5], b"\x01\x07\0\0\0");
                    // Header, encapsulation, and one byte per cell.
                    assert!(bytes.len() as u64 > 13 + 4 + size / 2);
                    break;
                }
                _ => (),
            }
        }
        assert!(channel.is_some());
        bridge.stop().await;
    });
}
