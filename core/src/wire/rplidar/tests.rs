//! The codec against the bytes of the protocol document, and against all kinds of damage on a line.

mod any_stream;

use std::f64::consts::{PI, TAU};

use super::answer::{Descriptor, Health, Info, Rate, Status};
use super::configuration::{self, Kind, Question};
use super::decoder::{Answer, Decoder};
use super::express::{Capsule, READINGS, Reading};
use super::node::Node;
use super::request::{Request, RequestDecoder};

fn decode(bytes: &[u8]) -> Vec<Answer> {
    let mut decoder = Decoder::default();
    decoder.extend(bytes);
    decoder.by_ref().collect()
}

/// Decodes in pieces of the given sizes, used in turn.
fn decode_in_pieces(bytes: &[u8], sizes: &[usize]) -> Vec<Answer> {
    let mut decoder = Decoder::default();
    let (mut answers, mut rest) = (vec![], bytes);
    for &size in sizes.iter().cycle() {
        if rest.is_empty() {
            break;
        }
        let (piece, later) = rest.split_at(size.min(rest.len()));
        decoder.extend(piece);
        answers.extend(decoder.by_ref());
        rest = later;
    }
    answers
}

fn nodes(answers: &[Answer]) -> Vec<Node> {
    let node = |answer: &Answer| match answer {
        Answer::Node(node) => Some(*node),
        _ => None,
    };
    answers.iter().filter_map(node).collect()
}

/// `count` readings of a turning sensor, distances from `seed`.
fn turn(count: usize, seed: u64) -> Vec<Node> {
    let mut state = seed | 1;
    (0..count)
        .map(|k| {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            let range = 0.2 + (state >> 40) as f64 / (1_u64 << 24) as f64 * 8.0;
            Node {
                starts: k % 360 == 0,
                ..Node::new(TAU * k as f64 / 360.0, range, (state >> 20) as u8 >> 2)
            }
        })
        .collect()
}

fn standard_stream(nodes: &[Node]) -> Vec<u8> {
    let mut bytes = Descriptor::Scan.encode().to_vec();
    bytes.extend(nodes.iter().flat_map(Node::encode));
    bytes
}

#[test]
fn requests_are_those_of_the_document() {
    for (request, bytes) in [
        (Request::Stop, &[0xA5, 0x25][..]),
        (Request::Reset, &[0xA5, 0x40]),
        (Request::Scan, &[0xA5, 0x20]),
        (
            Request::ExpressScan,
            &[0xA5, 0x82, 0x05, 0, 0, 0, 0, 0, 0x22],
        ),
        (Request::Info, &[0xA5, 0x50]),
        (Request::Health, &[0xA5, 0x52]),
        (Request::Rate, &[0xA5, 0x59]),
    ] {
        assert_eq!(request.encode(), bytes);
        let mut decoder = RequestDecoder::default();
        decoder.extend(bytes);
        assert_eq!(decoder.next(), Some(request));
    }
}

#[test]
fn descriptors_are_those_of_the_document() {
    for (descriptor, bytes) in [
        (Descriptor::Scan, [0xA5, 0x5A, 0x05, 0, 0, 0x40, 0x81]),
        (Descriptor::Express, [0xA5, 0x5A, 0x54, 0, 0, 0x40, 0x82]),
        (Descriptor::Info, [0xA5, 0x5A, 0x14, 0, 0, 0, 0x04]),
        (Descriptor::Health, [0xA5, 0x5A, 0x03, 0, 0, 0, 0x06]),
        (Descriptor::Rate, [0xA5, 0x5A, 0x04, 0, 0, 0, 0x15]),
    ] {
        assert_eq!(descriptor.encode(), bytes);
        assert_eq!(Descriptor::decode(bytes), Some(descriptor));
    }
}

#[test]
fn answers_are_read_field_by_field() {
    let bytes = [
        &[0xA5, 0x5A, 0x14, 0, 0, 0, 0x04][..],
        &[0x18, 0x1D, 0x01, 0x07],
        &[0xC0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 0xCF],
        &[0xA5, 0x5A, 0x03, 0, 0, 0, 0x06, 0x02, 0x34, 0x12],
        &[0xA5, 0x5A, 0x04, 0, 0, 0, 0x15, 0xF4, 0x01, 0xFA, 0x00],
    ]
    .concat();
    let serial = [0xC0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 0xCF];
    let info = Info {
        model: 0x18,
        firmware: [1, 29],
        hardware: 7,
        serial,
    };
    let health = Health {
        status: Status::Error,
        error: 0x1234,
    };
    let rate = Rate {
        standard_micros: 500,
        express_micros: 250,
    };
    let expected = [
        Answer::Info(info),
        Answer::Health(health),
        Answer::Rate(rate),
    ];
    assert_eq!(decode(&bytes), expected);
    assert_eq!(Info::decode(info.encode()), info);
    assert_eq!(Health::decode(health.encode()), Some(health));
    assert_eq!(Rate::decode(rate.encode()), rate);
}

#[test]
fn a_node_is_read_bit_by_bit() {
    // Quality 15, first of a turn; 90° = 5760/64, shifted with its check bit: 0x2D01; 1 m = 4000/4
    // mm = 0x0FA0.
    let bytes = [0x3D, 0x01, 0x2D, 0xA0, 0x0F];
    let node = Node {
        starts: true,
        quality: 15,
        angle: 5760,
        distance: 4000,
    };
    assert_eq!(Node::decode(bytes), Some(node));
    assert_eq!(node.encode(), bytes);
    assert!((node.radians() - PI / 2.0).abs() < 1e-15);
    assert!((node.metres() - 1.0).abs() < 1e-15);
    assert_eq!(
        Node::new(PI / 2.0, 1.0, 15),
        Node {
            starts: false,
            ..node
        }
    );
    // S = !S both ways, check bit 0, 360°.
    for damaged in [
        [0x3C, 0x01, 0x2D, 0xA0, 0x0F],
        [0x3F, 0x01, 0x2D, 0xA0, 0x0F],
        [0x3D, 0x00, 0x2D, 0xA0, 0x0F],
        [0x3D, 0x01, 0xB4, 0xA0, 0x0F],
    ] {
        assert_eq!(Node::decode(damaged), None, "{damaged:02X?}");
    }
}

#[test]
fn a_capsule_is_read_bit_by_bit() {
    let mut bytes = [0_u8; 84];
    // Start at 10° = 640 = 0x0280, first of a scan.
    bytes[2] = 0x80;
    bytes[3] = 0x82;
    // Cabin 0: 1 m = 4000 = 0x0FA0, offset 1 = 0b10_0011 = 35: high bits 2 in the word, low bits 3.
    bytes[4] = 0xA2;
    bytes[5] = 0x0F;
    // 2 m = 8000 = 0x1F40, offset 2 = 0b01_1100 = 28: high bits 1, low bits C.
    bytes[6] = 0x41;
    bytes[7] = 0x1F;
    bytes[8] = 0xC3;
    // Xor: 80^82 = 02, ^A2 = A0, ^0F = AF, ^41 = EE, ^1F = F1, ^C3 = 32.
    bytes[0] = 0xA2;
    bytes[1] = 0x53;
    let capsule = Capsule::decode(&bytes).unwrap();
    assert!(capsule.starts);
    assert_eq!(capsule.start_angle, 640);
    assert_eq!(
        capsule.readings[0],
        Reading {
            distance: 4000,
            offset: 35
        }
    );
    assert_eq!(
        capsule.readings[1],
        Reading {
            distance: 8000,
            offset: 28
        }
    );
    assert_eq!(capsule.readings[2], Reading::default());
    assert_eq!(capsule.encode(), bytes);
    // The next starts at 26°: 0.5° a reading. 10° - 35/8° = 5.625°; 10.5° - 28/8° = 7°; 11°.
    let angles: Vec<u16> = capsule.nodes(26 * 64).map(|node| node.angle).collect();
    assert_eq!(angles[..3], [360, 448, 704]);
}

#[test]
fn angles_of_a_capsule_wrap_at_a_whole_turn() {
    let mut readings = [Reading {
        distance: 400,
        offset: 0,
    }; READINGS];
    readings[0].offset = 63;
    let capsule = Capsule {
        starts: false,
        start_angle: 2 * 64,
        readings,
    };
    // From 2° over 10° (32 × 0.25°); the first less 7.875° lies before 0.
    let angles: Vec<u16> = capsule.nodes(10 * 64).map(|node| node.angle).collect();
    assert_eq!(angles[0], 23_040 - 376);
    assert_eq!(angles[31], 2 * 64 + 31 * 16);
    // From 356° to 4° is 8°, not -352°.
    let capsule = Capsule {
        start_angle: 356 * 64,
        ..capsule
    };
    let angles: Vec<u16> = capsule.nodes(4 * 64).map(|node| node.angle).collect();
    assert_eq!(angles[16], 0);
    assert_eq!(angles[31], 15 * 16);
}

#[test]
fn one_flipped_check_bit_costs_few_nodes() {
    let sent = turn(720, 7);
    let mut bytes = standard_stream(&sent);
    bytes[7 + 5 * 100] ^= 1;
    let mut decoder = Decoder::default();
    decoder.extend(&bytes);
    let got = nodes(&decoder.by_ref().collect::<Vec<_>>());
    assert!(got.len() >= 719 - 5, "{} of 720", got.len());
    assert!(decoder.tally().rejected >= 1);
    let tally = decoder.tally();
    assert_eq!(tally.bytes, 7 + 5 * 720);
    assert!(got.iter().all(|node| sent.contains(node)));
}

#[test]
fn a_cut_of_any_length_is_bridged() {
    let sent = turn(720, 3);
    let whole = standard_stream(&sent);
    for cut in 1..=11 {
        let mut bytes = whole.clone();
        bytes.drain(1000..1000 + cut);
        let got = nodes(&decode(&bytes));
        let wrong = got.iter().filter(|node| !sent.contains(node)).count();
        // The node in which the cut joined two parts may pass its three check bits.
        assert!(
            got.len() >= 720 - 8 && wrong <= 2,
            "cut {cut}: {} nodes, {wrong} wrong",
            got.len()
        );
    }
}

#[test]
fn a_capsule_that_was_lost_does_not_complete_the_one_before() {
    let capsule = |k: u16| Capsule {
        starts: k == 0,
        start_angle: k * 640,
        readings: [Reading {
            distance: 4000,
            offset: 1,
        }; READINGS],
    };
    let mut bytes = Descriptor::Express.encode().to_vec();
    for k in 0..6 {
        let mut encoded = capsule(k).encode();
        if k == 3 {
            encoded[40] ^= 0x10;
        }
        bytes.extend(encoded);
    }
    let follows: Vec<(u16, bool)> = decode(&bytes)
        .into_iter()
        .filter_map(|answer| match answer {
            Answer::Capsule { capsule, follows } => Some((capsule.start_angle / 640, follows)),
            _ => None,
        })
        .collect();
    assert_eq!(
        follows,
        [(0, false), (1, true), (2, true), (4, false), (5, true)]
    );
}

#[test]
fn the_banner_is_noticed_between_and_during_answers() {
    let banner = b"RP LIDAR System.\r\nFirmware Ver 1.20, HW Ver 0\r\nModel: 18\r\n";
    assert_eq!(decode(banner), [Answer::Restarted]);
    let mut bytes = standard_stream(&turn(100, 5));
    bytes.extend(banner);
    assert_eq!(decode(&bytes).last(), Some(&Answer::Restarted));
}

/// The maker's own driver pads its questions with zeros; a damaged question costs no other request.
#[test]
fn a_question_about_the_configuration_is_read_at_any_length() {
    let question = Question {
        kind: 0x75,
        mode: 1,
    };
    assert_eq!(question.known(), Some(Kind::AnswerType));
    let short = Request::Configuration(question).encode();
    assert_eq!(
        short,
        [
            0xA5,
            0x84,
            6,
            0x75,
            0,
            0,
            0,
            1,
            0,
            0xA5 ^ 0x84 ^ 6 ^ 0x75 ^ 1
        ]
    );
    let mut long = vec![0xA5, 0x84, 36, 0x75, 0, 0, 0, 1, 0];
    long.extend([0; 30]);
    long.push(0xA5 ^ 0x84 ^ 36 ^ 0x75 ^ 1);
    let mut damaged = short.clone();
    damaged[9] ^= 0x10;
    let mut decoder = RequestDecoder::default();
    let mut read = vec![];
    for byte in [short, damaged, long, Request::Health.encode()].concat() {
        decoder.extend(&[byte]);
        read.extend(decoder.next());
    }
    let asked = Request::Configuration(question);
    assert_eq!(read, [asked, asked, Request::Health]);
    assert_eq!(decoder.tally().rejected, 1);
    assert_eq!(
        configuration::answer(Kind::ModeCount, &2_u16.to_le_bytes()),
        [0xA5, 0x5A, 6, 0, 0, 0, 0x20, 0x70, 0, 0, 0, 2, 0]
    );
}
