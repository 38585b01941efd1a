//! Recordings: nothing that was acknowledged is lost, and recordings can be played back.

use std::time::Duration;

use mcap::read::MessageStream;
use slamlab_bridge::Config;
use slamlab_bridge::record::export;
use slamlab_bridge::source::replay::ReplaySource;
use slamlab_bridge::source::sim::SimSource;
use slamlab_bridge::source::{SourceEvent, SourceName};
use slamlab_core::format::map_server::{MapMode, OccupancyMap};
use slamlab_core::replay::{Log, Replay};
use slamlab_core::slam::Method;
use slamlab_core::wire::message::FromBridge;
use slamlab_core::wire::recording::Recording;
use slamlab_tests::calm::async_on_a_calm_machine;
use tempfile::TempDir;

use super::client::Bridge;

/// The recording names its robot and is mapped with it; the export contains the whole recording,
/// plus a pose for each scan, and the map as the replay itself has it.
#[tokio::test]
async fn an_export_holds_the_recording_and_its_map() {
    let folder = TempDir::new().unwrap();
    let (file, mapped) = (folder.path().join("a.mcap"), folder.path().join("b.mcap"));
    let bridge = Bridge::start(Config {
        sources: vec![Box::new(SimSource::new("arena,lidar").unwrap())],
        record: Some(file.clone()),
        ..Config::default()
    })
    .await;
    let mut watcher = bridge.watcher().await;
    for _ in 0..10 {
        let scan = |message: &FromBridge| matches!(message, FromBridge::Scan(_)).then_some(());
        watcher.wait(scan).await;
    }
    bridge.stop().await;

    let done = export(&file, &mapped, Method::ScanMatching).unwrap();
    let (old, new) = (
        Recording::parse(&std::fs::read(&file).unwrap()).unwrap(),
        Recording::parse(&std::fs::read(&mapped).unwrap()).unwrap(),
    );
    assert_eq!(done.notes, [""; 0]);
    assert_eq!(
        (old.robot().unwrap().preset, new.len()),
        ("rp6".to_owned(), old.len())
    );
    // Compared as text, in which NaN equals itself.
    let messages = old.messages().zip(new.messages());
    for (old, new) in messages {
        let [old, new] = [old, new].map(|message| format!("{:?}", message.unwrap().said));
        assert_eq!(old, new);
    }

    let old = Log::from(old);
    let mut replay = Replay::new(old.clone(), Method::ScanMatching, &old.settings()).unwrap();
    while replay.step().unwrap() {}
    let truth = OccupancyMap::of_grid(replay.session().slam().grid(), MapMode::Trinary).unwrap();
    let bytes = std::fs::read(&mapped).unwrap();
    let messages: Vec<_> = MessageStream::new(&bytes)
        .unwrap()
        .map(|message| message.unwrap())
        .collect();
    let of = |topic: &str| -> Vec<_> {
        let all = messages.iter();
        all.filter(|message| message.channel.topic == topic)
            .collect()
    };
    assert_eq!(
        (of("/pose").len(), of("/map").len()),
        (done.poses, done.maps)
    );
    assert_eq!(done.poses, replay.session().scans());
    // The cells are at the end of the message.
    let map = of("/map").last().unwrap().data.to_vec();
    let cells = map[map.len() - truth.cells.len()..].iter();
    assert!(
        cells
            .map(|&cell| cell as i8)
            .eq(truth.cells.iter().copied())
    );
    // Only a new file is accepted.
    let error = export(&file, &mapped, Method::ScanMatching).unwrap_err();
    assert!(error.to_string().contains("already there"), "{error}");
}

#[test]
fn what_was_recorded_plays_back() {
    async_on_a_calm_machine(async || {
        let folder = TempDir::new().unwrap();
        let file = folder.path().join("drive.mcap");
        let bridge = Bridge::start(Config {
            sources: vec![Box::new(SimSource::new("arena,lidar").unwrap())],
            record: Some(file.clone()),
            ..Config::default()
        })
        .await;
        let mut watcher = bridge.watcher().await;
        let acknowledged = watcher
            .wait(|message| match message {
                FromBridge::Recording(body) if body.acknowledged > 100 => Some(body.acknowledged),
                _ => None,
            })
            .await;
        // As SIGKILL would leave it: a copy of the file's present content.
        let copy = folder.path().join("killed.mcap");
        std::fs::copy(&file, &copy).unwrap();
        let events = ReplaySource::open(&copy).unwrap().events().count() as u64;
        // Device states and the like are acknowledged as well, but are not events.
        assert!(events + 10 >= acknowledged, "{events} of {acknowledged}");
        bridge.stop().await;

        let whole = ReplaySource::open(&file).unwrap();
        let odometry = whole.events().filter_map(|(_, event)| match event {
            SourceEvent::Odometry(odometry) => Some(odometry),
            _ => None,
        });
        let odometry: Vec<_> = odometry.collect();
        assert!(odometry.windows(2).all(|pair| pair[0].to == pair[1].from));
        assert!(
            whole
                .events()
                .any(|(_, event)| matches!(event, SourceEvent::Scan(_)))
        );

        let name: SourceName = format!("replay:{}", file.display()).parse().unwrap();
        let bridge = Bridge::start(Config {
            sources: vec![name.open(None).unwrap()],
            ..Config::default()
        })
        .await;
        let mut watcher = bridge.connect().await;
        assert!(watcher.robot.is_some(), "a recording has a robot, too");
        watcher.enter(None).await;
        let scan = watcher.wait(|message| match message {
            FromBridge::Scan(body) => Some(body.clone()),
            _ => None,
        });
        assert!(
            tokio::time::timeout(Duration::from_secs(5), scan)
                .await
                .unwrap()
                .scan()
                .is_ok()
        );
        bridge.stop().await;
    });
}
