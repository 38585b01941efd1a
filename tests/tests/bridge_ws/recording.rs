//! Recordings: nothing that was acknowledged is lost, and what was recorded plays back.

use std::time::Duration;

use slamlab_bridge::Config;
use slamlab_bridge::source::replay::ReplaySource;
use slamlab_bridge::source::sim::SimSource;
use slamlab_bridge::source::{Event, SourceName};
use slamlab_core::wire::message::FromBridge;
use slamlab_tests::calm::async_on_a_calm_machine;
use tempfile::TempDir;

use crate::client::Bridge;

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
        // As SIGKILL would leave it: a copy of what the system has at this moment.
        let copy = folder.path().join("killed.mcap");
        std::fs::copy(&file, &copy).unwrap();
        let events = ReplaySource::open(&copy).unwrap().events().len() as u64;
        // Devices and the like are acknowledged as well, and are no events.
        assert!(events + 10 >= acknowledged, "{events} of {acknowledged}");
        bridge.stop().await;

        let whole = ReplaySource::open(&file).unwrap();
        let odometry = whole.events().iter().filter_map(|(_, event)| match event {
            Event::Odometry(odometry) => Some(odometry),
            _ => None,
        });
        let odometry: Vec<_> = odometry.collect();
        assert!(odometry.windows(2).all(|pair| pair[0].to == pair[1].from));
        assert!(
            whole
                .events()
                .iter()
                .any(|(_, event)| matches!(event, Event::Scan(_)))
        );

        let name: SourceName = format!("replay:{}", file.display()).parse().unwrap();
        let bridge = Bridge::start(Config {
            sources: vec![name.open(None).unwrap()],
            ..Config::default()
        })
        .await;
        let mut watcher = bridge.watcher().await;
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
