//! The codec against the example of the manual and a packet of a real sensor, and against what a line does to bytes.

use std::f64::consts::TAU;

use proptest::prelude::*;

use super::driver::{Driver, Event, Fault};
use super::*;
use crate::robot::{Scan, Stamp};
use crate::wire::message::DeviceState;
use crate::wire::revolution::RevolutionConfig;

/// The worked example of the development manual.
const EXAMPLE: [u8; LEN] = [
    0x54, 0x2C, 0x68, 0x08, 0xAB, 0x7E, 0xE0, 0x00, 0xE4, 0xDC, 0x00, 0xE2, 0xD9, 0x00, 0xE5, 0xD5,
    0x00, 0xE3, 0xD3, 0x00, 0xE4, 0xD0, 0x00, 0xE9, 0xCD, 0x00, 0xE4, 0xCA, 0x00, 0xE2, 0xC7, 0x00,
    0xE9, 0xC5, 0x00, 0xE5, 0xC2, 0x00, 0xE5, 0xC0, 0x00, 0xE5, 0xBE, 0x82, 0x3A, 0x1A, 0x50,
];

#[test]
fn the_manuals_example_is_read_as_the_manual_reads_it() {
    let packet = Packet::decode(&EXAMPLE).unwrap();
    assert_eq!(packet.speed, 2152);
    assert_eq!((packet.start_angle, packet.end_angle), (32_427, 33_470));
    assert_eq!(packet.millis, 6714);
    let distances = packet.readings.map(|reading| reading.distance);
    assert_eq!(
        distances,
        [224, 220, 217, 213, 211, 208, 205, 202, 199, 197, 194, 192]
    );
    let intensities = packet.readings.map(|reading| reading.intensity);
    assert_eq!(
        intensities,
        [228, 226, 229, 227, 228, 233, 228, 226, 233, 229, 229, 229]
    );
    assert_eq!(packet.encode(), EXAMPLE);
    let (angle, range, _) = packet.polar().last().unwrap();
    assert!((angle.to_degrees() - 334.70).abs() < 1e-9 && (range - 0.192).abs() < 1e-12);
}

#[test]
fn the_table_is_that_of_the_polynomial() {
    // First entries as the manual prints them.
    assert_eq!(
        CRC_TABLE[..8],
        [0x00, 0x4D, 0x9A, 0xD7, 0x79, 0x34, 0xE3, 0xAE]
    );
    assert_eq!(crc8(&EXAMPLE[..LEN - 1]), 0x50);
}

#[test]
fn spacing_wraps_at_a_whole_turn() {
    let packet = Packet {
        start_angle: 35_900,
        end_angle: 450,
        ..Packet::default()
    };
    assert!((packet.spacing().to_degrees() - 0.5).abs() < 1e-12);
}

/// A sensor in a round room of 2 m at 10 Hz: 450 readings a turn, 4500 a second.
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

fn listen(driver: &mut Driver, bytes: &[u8], from: f64, seconds: f64) -> Vec<Event> {
    let mut said = vec![];
    // Pieces of 10 ms.
    let pieces = (seconds * 100.0).round() as usize;
    for piece in 0..pieces {
        let part = |k: usize| bytes.len() * k / pieces;
        let now = Stamp::from_seconds(from + 0.01 * (piece + 1) as f64);
        driver.receive(&bytes[part(piece)..part(piece + 1)], now);
        driver.tick(now);
        said.extend(std::iter::from_fn(|| driver.next_event()));
    }
    said
}

fn scans(said: &[Event]) -> Vec<&Scan> {
    let scan = |event: &'_ Event| matches!(event, Event::Scan(_));
    said.iter()
        .filter(|event| scan(event))
        .filter_map(|event| {
            if let Event::Scan(scan) = event {
                Some(scan)
            } else {
                None
            }
        })
        .collect()
}

#[test]
fn ten_turns_a_second_give_ten_scans() {
    let bytes: Vec<u8> = packets(375 * 2)
        .flat_map(|packet| packet.encode())
        .collect();
    let mut driver = Driver::new(RevolutionConfig::ld06(), Stamp(0));
    let said = listen(&mut driver, &bytes, 0.0, 2.0);
    let scans = scans(&said);
    assert_eq!(scans.len(), 19);
    for scan in &scans {
        scan.validate().unwrap();
        assert_eq!(scan.len(), 450);
        assert!((scan.sweep - 449.0 / 4500.0).abs() < 1e-9, "{}", scan.sweep);
        assert!(scan.ranges.iter().all(|range| *range == 2.0));
        let turned: f64 = scan.bearings.windows(2).map(|pair| pair[0] - pair[1]).sum();
        assert!((turned - TAU * 449.0 / 450.0).abs() < 1e-9);
    }
    assert_eq!(driver.state(), DeviceState::Measuring);
}

#[test]
fn each_fault_has_its_name_and_ends_by_itself() {
    let mut driver = Driver::new(RevolutionConfig::ld06(), Stamp(0));
    let fault = |said: &[Event]| {
        said.iter().find_map(|event| match event {
            Event::Fault(fault) => Some(fault.clone()),
            _ => None,
        })
    };
    let said = listen(&mut driver, &[], 0.0, 3.1);
    assert_eq!(fault(&said), Some(Fault::Silent));
    let said = listen(&mut driver, &[0xF8; 3100], 3.1, 3.1);
    assert!(
        matches!(fault(&said), Some(Fault::NotUnderstood { bytes }) if bytes > 2900),
        "{said:?}"
    );
    let still = Packet {
        start_angle: 500,
        end_angle: 500,
        ..Packet::default()
    };
    let bytes: Vec<u8> = (0..1200).flat_map(|_| still.encode()).collect();
    let said = listen(&mut driver, &bytes, 6.2, 3.1);
    assert_eq!(fault(&said), Some(Fault::DoesNotTurn));
    assert_eq!(driver.state(), DeviceState::Fault);
    let bytes: Vec<u8> = packets(375).flat_map(|packet| packet.encode()).collect();
    let said = listen(&mut driver, &bytes, 9.3, 1.0);
    assert!(scans(&said).len() >= 8 && driver.state() == DeviceState::Measuring);
    // The plug is pulled in the middle of a turn: silence, though packets came since the last scan. The first of these
    // packets ends the turn before.
    let said = listen(&mut driver, &bytes[..20 * LEN], 10.3, 0.05);
    assert_eq!(scans(&said).len(), 1);
    let said = listen(&mut driver, &[], 10.35, 3.1);
    assert_eq!(fault(&said), Some(Fault::Silent));
}

fn any_packet() -> impl Strategy<Value = Packet> {
    let readings = prop::collection::vec((any::<u16>(), any::<u8>()), READINGS);
    (
        any::<u16>(),
        0..36_000_u16,
        readings,
        0..36_000_u16,
        any::<u16>(),
    )
        .prop_map(|(speed, start_angle, readings, end_angle, millis)| Packet {
            speed,
            start_angle,
            end_angle,
            millis,
            readings: std::array::from_fn(|k| Reading {
                distance: readings[k].0,
                intensity: readings[k].1,
            }),
        })
}

proptest! {
    #[test]
    fn packets_round_trip(packet in any_packet()) {
        prop_assert_eq!(Packet::decode(&packet.encode()), Some(packet));
    }

    #[test]
    fn one_flipped_bit_is_seen(packet in any_packet(), bit in 0..LEN * 8) {
        let mut bytes = packet.encode();
        bytes[bit / 8] ^= 1 << (bit % 8);
        prop_assert_eq!(Packet::decode(&bytes), None);
    }

    #[test]
    fn packets_are_found_between_noise_in_any_pieces(
        sent in prop::collection::vec(any_packet(), 1..8),
        noise in prop::collection::vec(any::<u8>(), 0..60),
        sizes in prop::collection::vec(1..60_usize, 1..9),
    ) {
        let mut bytes = vec![];
        for packet in &sent {
            bytes.extend(&noise);
            bytes.extend(packet.encode());
        }
        let mut decoder = Decoder::new();
        let (mut got, mut rest) = (vec![], &bytes[..]);
        for size in sizes.into_iter().cycle() {
            if rest.is_empty() { break; }
            let (piece, later) = rest.split_at(size.min(rest.len()));
            decoder.extend(piece);
            got.extend(decoder.by_ref());
            rest = later;
        }
        let tally = decoder.tally();
        prop_assert_eq!(tally.frames * LEN as u64 + tally.discarded + decoder.inbox.len() as u64, tally.bytes);
        // Noise that happens to hold a header may hold up the last packet, never spoil one.
        prop_assert!(got.iter().all(|packet| sent.contains(packet)));
        let holds_header = noise.windows(2).any(|pair| pair == HEADER) || noise.ends_with(&HEADER[..1]);
        prop_assert!(holds_header || got == sent);
    }
}
