//! Capsules and streams of any content, cut and damaged anywhere.

use proptest::prelude::*;

use super::*;

fn any_capsule() -> impl Strategy<Value = Capsule> {
    let reading = (0..=0x3FFF_u16, 0..64_u8).prop_map(|(mm, offset)| Reading {
        distance: mm << 2,
        offset,
    });
    (
        any::<bool>(),
        0..23_040_u16,
        prop::collection::vec(reading, READINGS),
    )
        .prop_map(|(starts, start_angle, readings)| Capsule {
            starts,
            start_angle,
            readings: std::array::from_fn(|k| readings[k]),
        })
}

proptest! {
    #[test]
    fn nodes_round_trip(starts: bool, quality in 0..64_u8, angle in 0..23_040_u16, distance: u16) {
        let node = Node { starts, quality, angle, distance };
        prop_assert_eq!(Node::decode(node.encode()), Some(node));
    }

    #[test]
    fn capsules_round_trip(capsule in any_capsule()) {
        prop_assert_eq!(Capsule::decode(&capsule.encode()), Some(capsule));
    }

    #[test]
    fn one_flipped_bit_of_a_capsule_is_seen(capsule in any_capsule(), bit in 0..84_usize * 8) {
        let mut bytes = capsule.encode();
        bytes[bit / 8] ^= 1 << (bit % 8);
        prop_assert_eq!(Capsule::decode(&bytes), None);
    }

    #[test]
    fn pieces_do_not_matter(seed: u64, sizes in prop::collection::vec(1..40_usize, 1..20)) {
        let bytes = standard_stream(&turn(200, seed));
        prop_assert_eq!(decode_in_pieces(&bytes, &sizes), decode(&bytes));
    }

    /// 1 bit of 1000: most nodes come through, and only those that the line damaged are wrong.
    #[test]
    fn flipped_bits_cost_little(seed: u64) {
        let sent = turn(1000, seed);
        let mut bytes = standard_stream(&sent);
        let mut state = seed | 1;
        for byte in bytes.iter_mut().skip(7) {
            for bit in 0..8 {
                state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                if (state >> 33) % 1000 == 0 {
                    *byte ^= 1 << bit;
                }
            }
        }
        let got = nodes(&decode(&bytes));
        let right = got.iter().filter(|node| sent.contains(node)).count();
        prop_assert!(right >= 900, "{} right of {}", right, got.len());
    }

    /// Any bytes: no panic, and every byte is accounted for.
    #[test]
    fn every_byte_is_accounted_for(
        noise in prop::collection::vec(any::<u8>(), 0..2000),
        express: bool,
        sizes in prop::collection::vec(1..100_usize, 1..20),
    ) {
        let descriptor = if express { Descriptor::Express } else { Descriptor::Scan };
        let mut bytes = descriptor.encode().to_vec();
        bytes.extend(&noise);
        let mut decoder = Decoder::default();
        let (mut rest, mut in_frames) = (&bytes[..], 0);
        for size in sizes.into_iter().cycle() {
            if rest.is_empty() { break; }
            let (piece, later) = rest.split_at(size.min(rest.len()));
            decoder.extend(piece);
            rest = later;
            for answer in decoder.by_ref() {
                in_frames += match answer {
                    Answer::Begins(_) => 7,
                    Answer::Info(_) => 7 + 20,
                    Answer::Health(_) => 7 + 3,
                    Answer::Rate(_) => 7 + 4,
                    Answer::Node(_) => 5,
                    Answer::Capsule { .. } => 84,
                    Answer::Restarted => 0,
                };
            }
        }
        let before = decoder.tally();
        decoder.expect_answer();
        let waiting = decoder.tally().discarded - before.discarded;
        prop_assert_eq!(before.bytes, bytes.len() as u64);
        // The descriptor of a single answer that is still being read is counted but not yet handed
        // on: at most 7 bytes.
        let sum = in_frames + before.discarded + waiting;
        prop_assert!(sum <= before.bytes && before.bytes - sum <= 7, "{} of {}", sum, before.bytes);
        // A scan that never ends keeps fewer bytes waiting than locking needs.
        prop_assert!(waiting < 84 + 1);
    }

    #[test]
    fn requests_survive_noise_before_them(noise in prop::collection::vec(0..0xA5_u8, 0..50)) {
        let mut bytes = noise;
        bytes.extend(Request::ExpressScan.encode());
        bytes.extend(Request::Health.encode());
        let mut decoder = RequestDecoder::default();
        decoder.extend(&bytes);
        prop_assert_eq!(decoder.collect::<Vec<_>>(), [Request::ExpressScan, Request::Health]);
    }

    #[test]
    fn any_bytes_to_the_request_decoder_are_harmless(noise in prop::collection::vec(any::<u8>(), 0..500)) {
        let mut decoder = RequestDecoder::default();
        decoder.extend(&noise);
        let count = decoder.by_ref().count() as u64;
        prop_assert_eq!(decoder.tally().frames, count);
    }
}
