//! The codec against the example of the manual and a packet of a real sensor, and against damage on
//! the line.

use proptest::prelude::*;

use super::*;

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
        [0, 1, 2, 3, 4, 5, 6, 7].map(|byte| CRC.checksum(&[byte])),
        [0x00, 0x4D, 0x9A, 0xD7, 0x79, 0x34, 0xE3, 0xAE]
    );
    assert_eq!(CRC.checksum(&EXAMPLE[..LEN - 1]), 0x50);
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
        let mut decoder = Decoder::default();
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
        // Noise that happens to contain a header may delay the last packet, but never damages one.
        prop_assert!(got.iter().all(|packet| sent.contains(packet)));
        let holds_header = noise.windows(2).any(|pair| pair == HEADER) || noise.ends_with(&HEADER[..1]);
        prop_assert!(holds_header || got == sent);
    }
}
