//! What clients receive: everything if they are quick, the newest if they are slow, and figures
//! about both.

use std::time::{Duration, Instant};

use slamlab_bridge::Config;
use slamlab_bridge::source::sim::SimSource;
use slamlab_core::slam::{Method, Slam, SlamConfig};
use slamlab_core::wire::message::{About, FromBridge, ToBridge, Watching};
use slamlab_tests::calm::async_on_a_calm_machine;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;

use super::client::{Bridge, Came, Client};
use super::robot::with_robot;

pub(crate) fn simulated() -> Config {
    Config {
        sources: vec![Box::new(SimSource::new("arena,lidar").unwrap())],
        ..Config::default()
    }
}

/// The body of the answer to a GET.
pub(crate) async fn get(bridge: &Bridge, path: &str) -> String {
    let mut stream = TcpStream::connect(bridge.address).await.unwrap();
    let host = bridge.address;
    let request = format!("GET {path} HTTP/1.1\r\nHost: {host}\r\nConnection: close\r\n\r\n");
    stream.write_all(request.as_bytes()).await.unwrap();
    let mut answer = String::new();
    stream.read_to_string(&mut answer).await.unwrap();
    answer.split_once("\r\n\r\n").unwrap().1.to_owned()
}

#[test]
fn the_bridge_says_what_is_behind_it() {
    async_on_a_calm_machine(async || {
        let bridge = Bridge::start(simulated()).await;
        let about: About = serde_json::from_str(&get(&bridge, "/bridge.json").await).unwrap();
        assert_eq!(about.sources, ["sim:arena,lidar"]);
        assert_eq!(about.robot.as_deref(), Some("rp6"));
        assert_eq!(
            (about.websocket.as_str(), about.watching),
            ("/ws", Watching::Anyone)
        );
        assert_eq!(get(&bridge, "/healthz").await, "ok\n");
        let _watcher = bridge.watcher().await;
        tokio::time::sleep(Duration::from_millis(300)).await;
        let metrics = get(&bridge, "/metrics").await;
        assert!(metrics.contains("\nslamlab_clients 1\n"), "{metrics}");
        assert!(
            !metrics.contains("\nslamlab_source_events_total 0\n"),
            "{metrics}"
        );
        assert!(!metrics.contains(&bridge.token));
        bridge.stop().await;
    });
}

/// What a page does: its own SLAM on what it receives.
#[test]
fn odometry_without_gaps_and_scans_make_a_map() {
    async_on_a_calm_machine(async || {
        let bridge = Bridge::start(simulated()).await;
        let mut watcher = bridge.watcher().await;
        let mut slam = Slam::new(Method::LineEkf, SlamConfig::default()).unwrap();
        let (mut to, mut scans) = (None, 0);
        let mut heartbeat = tokio::time::interval(Duration::from_secs(1));
        while scans < 12 {
            let came = tokio::select! {
                came = watcher.next() => came,
                _ = heartbeat.tick() => {
                    watcher.say(ToBridge::Heartbeat).await;
                    continue;
                }
            };
            match came {
                Came::Message(FromBridge::Odometry(body)) => {
                    assert!(
                        to.is_none_or(|to| to == body.from),
                        "a gap before {}",
                        body.from
                    );
                    to = Some(body.to);
                    slam.odometry(&body.odometry().unwrap()).unwrap();
                }
                Came::Message(FromBridge::Scan(body)) => {
                    assert!(
                        to.is_some_and(|to| to >= body.stamp),
                        "a scan before its odometry"
                    );
                    slam.scan(&body.scan().unwrap()).unwrap();
                    scans += 1;
                }
                Came::Message(..) => (),
                ended => panic!("{ended:?}"),
            }
        }
        // It stood still in the middle of a room, and has seen its walls.
        assert!(slam.estimate().pose.position().coords.norm() < 0.05);
        assert!(slam.points().unwrap().hits().count() > 100);
        bridge.stop().await;
    });
}

/// A watcher that reads 1 kB a second must not slow down the others, nor fill the memory, and gets
/// the newest messages.
#[test]
fn a_slow_watcher_gets_fewer_and_newer_and_is_told() {
    async_on_a_calm_machine(async || {
        let (config, _) = with_robot();
        let bridge = Bridge::start(config).await;
        let mut slow = Client::connect_narrow(bridge.address, 4096).await;
        slow.enter(None).await;
        let mut quick = bridge.watcher().await;
        let until = Instant::now() + Duration::from_secs(4);
        let mut newest = 0;
        while Instant::now() < until {
            if let Came::Message(FromBridge::Odometry(body)) = quick.next().await {
                newest = body.to;
            }
        }
        // It has read nothing until now, and reads everything at once: first the content of the
        // system's buffers, then the newest.
        let (mut last, mut dropped, mut stamps) = (0, 0, Vec::new());
        let mut said = 0;
        while last < newest || dropped == 0 {
            if slow.seen > said + 500_000 {
                said = slow.seen;
                slow.say(ToBridge::Heartbeat).await;
            }
            match slow.next().await {
                Came::Message(FromBridge::Odometry(body)) => {
                    assert!(
                        last == 0 || body.from == last,
                        "motion was lost: {last} to {}",
                        body.from
                    );
                    last = body.to;
                }
                Came::Message(FromBridge::Scan(body)) => stamps.push(body.stamp),
                Came::Message(FromBridge::Heartbeat(beat)) => dropped = beat.dropped,
                Came::Message(..) => (),
                ended => panic!("{ended:?}"),
            }
        }
        assert!(dropped > 0);
        assert!(
            stamps.windows(2).all(|pair| pair[0] < pair[1]),
            "{stamps:?}"
        );
        bridge.stop().await;
    });
}

#[test]
fn a_probe_measures_the_way_there_and_back() {
    async_on_a_calm_machine(async || {
        let bridge = Bridge::start(simulated()).await;
        let mut client = bridge.watcher().await;
        client
            .wait(|message| matches!(message, FromBridge::Odometry(_)).then_some(()))
            .await;
        client.say(ToBridge::Probe { token: 77 }).await;
        let answer = client.wait(|message| match message {
            FromBridge::Probe(answer) => Some(*answer),
            _ => None,
        });
        let answer = answer.await;
        assert_eq!(answer.token, 77);
        assert!(answer.robot_came_micros <= client.seen && answer.came_micros <= client.seen);
        assert!(answer.robot_micros > 0);
        bridge.stop().await;
    });
}
