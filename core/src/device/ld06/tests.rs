//! An LD06 in a round room, and everything that can go wrong with it.

use std::f64::consts::TAU;

use super::*;
use crate::device::lidar::Lidar;
use crate::device::source::SourceEvent;
use crate::device::{Device, Want};
use crate::geom::Pose2;
use crate::robot::Scan;
use crate::wire::ld06::{LEN, Reading};

/// A sensor at 10 Hz in a round room of 2 m: 450 readings a turn, 4500 a second.
fn packets(count: usize) -> impl Iterator<Item = Packet> {
    (0..count).map(|k| {
        let angle = |reading: usize| ((k * READINGS + reading) * 80 % 36_000) as u16;
        Packet {
            speed: 3600,
            start_angle: angle(0),
            end_angle: angle(READINGS - 1),
            readings: [Reading {
                distance: 2000,
                intensity: 200,
            }; READINGS],
            millis: (k * READINGS * 10 / 45 % 30_000) as u16,
        }
    })
}

fn opened() -> Lidar<Ld06> {
    let mut lidar = Lidar::new("ld06:test", Ld06::default(), Pose2::identity());
    lidar.opened(Stamp(0));
    lidar
}

/// Passes these bytes on in pieces of 10 ms; returns the events.
fn listen(lidar: &mut Lidar<Ld06>, bytes: &[u8], from: f64, seconds: f64) -> Vec<SourceEvent> {
    let mut events = vec![];
    let pieces = (seconds * 100.0).round() as usize;
    for piece in 0..pieces {
        let part = |k: usize| bytes.len() * k / pieces;
        let now = Stamp::from_seconds(from + 0.01 * (piece + 1) as f64);
        lidar.receive(&bytes[part(piece)..part(piece + 1)], now);
        lidar.tick(now);
        events.extend(
            std::iter::from_fn(|| lidar.next_want()).filter_map(|want| match want {
                Want::Report(event) => Some(event),
                _ => None,
            }),
        );
    }
    events
}

fn scans(events: &[SourceEvent]) -> Vec<&Scan> {
    let scans = events.iter().filter_map(|event| match event {
        SourceEvent::Scan(scan) => Some(scan),
        _ => None,
    });
    scans.collect()
}

/// The last state reported, with its sentence.
fn last_state(events: &[SourceEvent]) -> Option<(DeviceState, &str)> {
    let state = |event| match event {
        &SourceEvent::Device {
            state, ref detail, ..
        } => Some((state, detail.as_str())),
        _ => None,
    };
    events.iter().filter_map(state).next_back()
}

#[test]
fn ten_turns_a_second_give_ten_scans() {
    let bytes: Vec<u8> = packets(375 * 2)
        .flat_map(|packet| packet.encode())
        .collect();
    let events = listen(&mut opened(), &bytes, 0.0, 2.0);
    let scans = scans(&events);
    assert_eq!(scans.len(), 19);
    for scan in &scans {
        scan.validate().unwrap();
        assert_eq!(scan.len(), 450);
        assert!((scan.sweep - 449.0 / 4500.0).abs() < 1e-9, "{}", scan.sweep);
        assert!(scan.ranges.iter().all(|range| *range == 2.0));
        let turned: f64 = scan.bearings.windows(2).map(|pair| pair[0] - pair[1]).sum();
        assert!((turned - TAU * 449.0 / 450.0).abs() < 1e-9);
    }
    assert_eq!(last_state(&events), Some((DeviceState::Sending, "")));
}

#[test]
fn each_fault_has_its_name_and_ends_by_itself() {
    let lidar = &mut opened();
    let assert_fault = |events: &[SourceEvent], fault: Ld06Fault| {
        let expected = (DeviceState::Fault, &*fault.to_string());
        assert_eq!(last_state(events), Some(expected));
    };
    let events = listen(lidar, &[], 0.0, 3.1);
    assert_fault(&events, Ld06Fault::Silent);
    let events = listen(lidar, &[0xF8; 3100], 3.1, 3.1);
    let Some((DeviceState::Fault, detail)) = last_state(&events) else {
        panic!("{events:?}");
    };
    assert!(detail.contains("but no packet"), "{detail}");
    let still = Packet {
        start_angle: 500,
        end_angle: 500,
        ..Packet::default()
    };
    let bytes: Vec<u8> = (0..1200).flat_map(|_| still.encode()).collect();
    let events = listen(lidar, &bytes, 6.2, 3.1);
    assert_fault(&events, Ld06Fault::DoesNotTurn);
    let bytes: Vec<u8> = packets(375).flat_map(|packet| packet.encode()).collect();
    let events = listen(lidar, &bytes, 9.3, 1.0);
    assert!(scans(&events).len() >= 8);
    assert_eq!(last_state(&events), Some((DeviceState::Sending, "")));
    // The plug is pulled in the middle of a turn: this is silence, although packets arrived since
    // the last scan. The first of these packets ends the turn before.
    let events = listen(lidar, &bytes[..20 * LEN], 10.3, 0.05);
    assert_eq!(scans(&events).len(), 1);
    let events = listen(lidar, &[], 10.35, 3.1);
    assert_fault(&events, Ld06Fault::Silent);
}
