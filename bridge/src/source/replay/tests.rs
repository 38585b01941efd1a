//! Recordings with impossible times.

use std::collections::BTreeMap;
use std::fs::File;

use mcap::WriteOptions;
use mcap::records::MessageHeader;
use slamlab_core::robot::RobotModel;
use slamlab_core::wire::message::{
    BatteryBody, BridgeHello, Format, Header, SCHEMA, Watching, encode,
};
use slamlab_core::wire::recording::{CHANNEL, ENCODING};

use super::*;
use crate::source::scans_on_command;

/// A recording of these messages at these times, s.
fn record(said: &[(u64, FromBridge)]) -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.mcap");
    let file = File::create(&path).unwrap();
    let options = WriteOptions::new().use_chunks(false).compression(None);
    let mut writer = options.create(file).unwrap();
    let channel = writer
        .add_channel(0, CHANNEL, ENCODING, &BTreeMap::new())
        .unwrap();
    for (sequence, (seconds, message)) in (1..).zip(said) {
        let header = MessageHeader {
            channel_id: channel,
            sequence,
            log_time: seconds * 1_000_000_000,
            publish_time: 0,
        };
        let micros = 0;
        let body = encode(Header { sequence, micros }, message, Format::Binary).unwrap();
        writer.write_to_known_channel(&header, &body).unwrap();
    }
    writer.finish().unwrap();
    (folder, path)
}

fn battery() -> FromBridge {
    FromBridge::Battery(BatteryBody {
        source: 0,
        stamp: 1,
        volts: 7.0,
    })
}

/// Regression: a flipped bit in a time made the bridge wait for centuries.
#[test]
fn no_pause_is_longer_than_a_minute_and_no_time_runs_backwards() {
    let times = [100, 101, 9_000_000_000, 102, 104, 50, 53];
    let (_folder, path) = record(&times.map(|seconds| (seconds, battery())));
    let source = ReplaySource::open(&path).unwrap();
    let pauses: Vec<u64> = source.events().map(|(pause, _)| pause.as_secs()).collect();
    assert_eq!(pauses, [0, 1, 60, 0, 2, 0, 3]);
}

/// Messages between two events count for the pause, although they are no events.
#[test]
fn pauses_before_what_is_no_event_add_up() {
    let clients = FromBridge::Devices(vec![]);
    let (_folder, path) = record(&[(1, battery()), (3, clients), (4, battery())]);
    let source = ReplaySource::open(&path).unwrap();
    let pauses: Vec<u64> = source.events().map(|(pause, _)| pause.as_secs()).collect();
    assert_eq!(pauses, [0, 3]);
}

#[test]
fn a_recording_has_the_robot_that_it_was_made_with_and_takes_no_orders() {
    let hello = BridgeHello {
        version: String::new(),
        schema: SCHEMA,
        challenge: [0; 16],
        watching: Watching::Anyone,
        robot: Some(RobotFigures::new(&RobotModel::rp6(), true)),
        watchdog_millis: 250,
        lease_millis: 2000,
    };
    let (_folder, path) = record(&[(1, FromBridge::Hello(hello)), (2, battery())]);
    let profile = ReplaySource::open(&path).unwrap().profile();
    assert_eq!(profile.robot, Some(RobotModel::rp6()));
    assert!(!profile.takes_orders);
    assert!(scans_on_command(&[&profile]));
}
