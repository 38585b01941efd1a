//! The messages against bytes written by hand, and against anything a network may bring.

mod samples;

use proptest::prelude::*;
use twox_hash::XxHash64;

use super::*;
use crate::geom::Pose2;
use crate::robot::{Command, Odometry, RobotModel, Scan, Stamp};
use samples::{from_bridge, to_bridge};

const HEADER: Header = Header {
    sequence: 0x0403_0201,
    micros: 0x0C0B_0A09_0807_0605,
};
const BOTH: [Format; 2] = [Format::Binary, Format::Json];

fn bytes(message: &impl Packet) -> Vec<u8> {
    encode(HEADER, message, Format::Binary).unwrap()
}

/// Compares the texts of both: NaN is not equal to itself, but its text is.
fn check<M: Packet + std::fmt::Debug>(message: &M) {
    for format in BOTH {
        let written = encode(HEADER, message, format).unwrap();
        let (header, read) = decode::<M>(&written, format).unwrap();
        assert_eq!(header, HEADER);
        assert_eq!(format!("{read:?}"), format!("{message:?}"), "{format:?}");
    }
}

#[test]
fn every_kind_comes_back_in_both_formats() {
    from_bridge().iter().for_each(check);
    to_bridge().iter().for_each(check);
}

#[test]
fn the_samples_hold_every_kind_in_order() {
    let names = |error: MessageError| {
        let text = error.to_string();
        let list = text.split("expected one of ").nth(1).unwrap().to_owned();
        let names = list.split('`').skip(1).step_by(2).map(str::to_owned);
        names.collect::<Vec<_>>()
    };
    let unknown = br#"{"protocol":2,"sequence":1,"micros":1,"message":{"Unheard":1}}"#;
    let known = names(decode::<FromBridge>(unknown, Format::Json).unwrap_err());
    assert_eq!(known.len(), from_bridge().len());
    for (kind, (message, name)) in from_bridge().iter().zip(known).enumerate() {
        assert_eq!(usize::from(bytes(message)[3]), kind);
        assert!(format!("{message:?}").starts_with(&name), "{name}");
    }
    let known = names(decode::<ToBridge>(unknown, Format::Json).unwrap_err());
    assert_eq!(known.len(), to_bridge().len());
    for (kind, (message, name)) in to_bridge().iter().zip(known).enumerate() {
        assert_eq!(usize::from(bytes(message)[3]), 128 + kind);
        assert!(format!("{message:?}").starts_with(&name), "{name}");
    }
}

/// If this fails, a message has changed: was that intended, and does it only grow at its end? Then
/// write the new number into [`SCHEMA`], so that a page loaded earlier learns that it must be
/// reloaded.
#[test]
fn the_schema_changes_with_the_messages() {
    let mut all = Vec::new();
    for format in BOTH {
        for message in from_bridge() {
            all.extend(encode(Header::default(), &message, format).unwrap());
        }
        for message in to_bridge() {
            all.extend(encode(Header::default(), &message, format).unwrap());
        }
    }
    let schema = XxHash64::oneshot(0, &all);
    assert_eq!(schema, SCHEMA, "now {schema:#018x}");
}

#[test]
fn golden_bytes() {
    let header = [b'S', b'L', 2, 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12];
    let check = |message: &dyn Fn() -> Vec<u8>, kind: u8, body: &[u8]| {
        let mut expect = header.to_vec();
        expect[3] = kind;
        expect.extend(body);
        assert_eq!(message(), expect);
    };
    check(&|| bytes(&ToBridge::Heartbeat), 129, &[]);
    check(&|| bytes(&ToBridge::Take { force: true }), 131, &[1]);
    // Integers are varints of seven bits, lowest first: 300 = 0b10_0101100.
    check(&|| bytes(&ToBridge::Arm { epoch: 300 }), 134, &[0xAC, 2]);
    check(&|| bytes(&ToBridge::Stop), 137, &[]);
    let drive = ToBridge::Drive(DriveBody {
        epoch: 1,
        seen: 128,
        ttl_millis: 250,
        motion: Command::Velocity {
            forward: 0.5,
            turn: -2.0,
        },
    });
    #[rustfmt::skip]
    let body = [
        1, 0x80, 1, 0xFA, 1, // epoch, seen, ttl
        1, // Velocity
        0, 0, 0, 0, 0, 0, 0xE0, 0x3F, // 0.5, IEEE 754, little-endian
        0, 0, 0, 0, 0, 0, 0, 0xC0, // -2.0
    ];
    check(&|| bytes(&drive), 135, &body);
    let bumpers = FromBridge::Bumpers(BumpersBody {
        source: 2,
        stamp: 5,
        left: false,
        right: true,
    });
    check(&|| bytes(&bumpers), 6, &[2, 5, 0, 1]);
    let refused = FromBridge::Refused(RefusalReason::StaleEpoch);
    check(&|| bytes(&refused), 14, &[2]);
    let event = FromBridge::Notice(Notice {
        severity: Severity::Error,
        text: "ok".into(),
    });
    check(&|| bytes(&event), 11, &[2, 2, b'o', b'k']);
    let errand = FromBridge::Manoeuvre(ManoeuvreBody {
        client: 7,
        sequence: 300,
        busy: true,
    });
    check(&|| bytes(&errand), 17, &[7, 0xAC, 2, 1]);
}

#[test]
fn names_are_those_of_json_and_no_two_are_alike() {
    fn check<T: Copy + serde::Serialize>(all: &[T], name: impl Fn(T) -> &'static str) {
        let mut names: Vec<_> = all.iter().map(|variant| name(*variant)).collect();
        let json: Vec<_> = all
            .iter()
            .map(|v| serde_json::to_value(v).unwrap())
            .collect();
        assert_eq!(json, names);
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), all.len());
    }
    check(DisarmReason::ALL, DisarmReason::name);
    check(RefusalReason::ALL, RefusalReason::name);
    check(LinkState::ALL, LinkState::name);
    check(DeviceState::ALL, DeviceState::name);
    check(Severity::ALL, Severity::name);
    let refused = FromBridge::Refused(RefusalReason::FromTheFuture);
    let text = encode(HEADER, &refused, Format::Json).unwrap();
    let text = String::from_utf8(text).unwrap();
    assert!(text.contains(r#"{"Refused":"from-the-future"}"#), "{text}");
}

#[test]
fn golden_text() {
    let text = br#"{"protocol":2,"sequence":7,"micros":9,"message":{"Drive":{"epoch":1,"seen":2,
        "ttl_millis":3,"motion":{"Velocity":{"forward":0.5,"turn":-2.0}}}}}"#;
    let (header, message) = decode::<ToBridge>(text, Format::Json).unwrap();
    assert_eq!((header.sequence, header.micros), (7, 9));
    let ToBridge::Drive(body) = message else {
        panic!("{message:?}")
    };
    assert_eq!(
        body.motion,
        Command::Velocity {
            forward: 0.5,
            turn: -2.0
        }
    );
    let scan = encode(HEADER, &from_bridge()[4], Format::Json).unwrap();
    let scan = String::from_utf8(scan).unwrap();
    assert!(scan.contains(r#""ranges":[1.5,"inf","nan"]"#), "{scan}");
}

/// A script in JavaScript could not: it reads a number above 2^53 as the nearest one that it can
/// hold.
#[test]
fn a_script_can_send_the_schema_back_as_it_came() {
    let hello = encode(HEADER, &from_bridge()[0], Format::Json).unwrap();
    let hello: serde_json::Value = serde_json::from_slice(&hello).unwrap();
    let schema = &hello["message"]["Hello"]["schema"];
    assert_eq!(schema, "0000000000000003");
    let said = |schema: &serde_json::Value| {
        let hello = serde_json::json!({ "schema": schema, "name": "script", "proof": null });
        let text = serde_json::json!({ "protocol": 2, "sequence": 1, "micros": 0,
            "message": { "Hello": hello } });
        let read = decode::<ToBridge>(text.to_string().as_bytes(), Format::Json);
        read.map(|(_, message)| match message {
            ToBridge::Hello(hello) => hello.schema,
            other => panic!("{other:?}"),
        })
    };
    assert_eq!(said(schema), Ok(3));
    // As older clients wrote it.
    assert_eq!(said(&SCHEMA.into()), Ok(SCHEMA));
    assert_eq!(said(&format!("{SCHEMA:X}").into()), Ok(SCHEMA));
    for wrong in ["", "0x3", "schema", "10000000000000000"] {
        let error = said(&wrong.into()).unwrap_err().to_string();
        assert!(error.contains("hexadecimal"), "{error}");
    }
}

#[test]
fn what_is_no_message_is_refused_with_its_place() {
    let check = |bytes: &[u8], expect: &str| {
        let error = decode::<ToBridge>(bytes, Format::Binary).unwrap_err();
        assert!(error.to_string().contains(expect), "{error}");
    };
    let good = bytes(&ToBridge::Arm { epoch: 300 });
    let spoilt = |at: usize, value: u8| {
        let mut bytes = good.clone();
        bytes[at] = value;
        bytes
    };
    check(&good[..15], "message of 15 bytes: expected at least 16");
    check(&spoilt(0, b'X'), "bytes 0 and 1 are 0x4c58");
    check(&spoilt(2, 9), "protocol 9, expected 2");
    check(&spoilt(3, 6), "kind 6 is not one of this direction");
    check(&spoilt(3, 255), "body of kind 255");
    check(&good[..17], "body of kind 134");
    check(&[good.as_slice(), &[0]].concat(), "ends 1 bytes before");
    let old = br#"{"protocol":1,"sequence":1,"micros":1,"message":"Stop"}"#;
    let error = decode::<ToBridge>(old, Format::Json).unwrap_err();
    assert_eq!(error, MessageError::Protocol { found: 1 });
    let error = decode::<ToBridge>(b"{", Format::Json).unwrap_err();
    assert!(error.to_string().contains("line 1 column 1"), "{error}");
}

/// Checked against values made by Python's `hmac` and `hashlib`: `client` is `hmac.new(b"secret",
/// b"slamlab bridge 2", "sha256").digest()`, `stored` is `hashlib.sha256(client).digest()`, and the
/// proof is `client` xor `hmac.new(stored, bytes(range(16)), "sha256").digest()`.
#[test]
fn a_proof_is_that_of_scram() {
    let challenge: [u8; CHALLENGE_BYTES] = std::array::from_fn(|i| i as u8);
    let hex = |bytes: [u8; PROOF_BYTES]| bytes.map(|byte| format!("{byte:02x}")).concat();
    let shown = proof("secret\n", &challenge);
    assert_eq!(
        hex(shown),
        "45c9c45d6fc59f153d74aabfc6173cd12dd2db29af1deb370b27d20217532501"
    );
    let stored = Verifier::of("secret");
    assert_eq!(
        hex(stored.to_bytes()),
        "1cfd20c4cfc5eec9069855c419d7b7b86db6c7e34621d4af48d09695ad4f1f06"
    );
    let is_proved = |challenge: &_, shown: &[u8; PROOF_BYTES]| {
        stored.of_proof(challenge, shown) == stored.to_bytes()
    };
    assert!(is_proved(&challenge, &shown));
    assert!(!is_proved(&[0; CHALLENGE_BYTES], &shown), "replayed");
    assert!(!is_proved(&challenge, &proof("Secret", &challenge)));
    // Reading the file gives no token: its content proves nothing.
    let stolen = hex(stored.to_bytes());
    assert!(!is_proved(&challenge, &proof(&stolen, &challenge)));
    assert!(!is_proved(&challenge, &stored.to_bytes()));
}

#[test]
fn the_robot_of_the_hello_is_the_one_it_was_made_of() {
    for model in [RobotModel::rp6(), RobotModel::pioneer()] {
        let wider = RobotModel {
            track_width: 0.5,
            ..model
        };
        assert_eq!(RobotFigures::new(&wider, true).model(), Some(wider));
    }
    let mut unknown = RobotFigures::new(&RobotModel::rp6(), false);
    unknown.preset = "atlantis".into();
    assert_eq!(unknown.model(), None);
}

fn scan(ranges: Vec<f32>) -> Scan {
    Scan {
        stamp: Stamp(7),
        robot_from_sensor: Pose2::new(0.01, -0.02, 0.0),
        bearings: (0..ranges.len()).map(|i| i as f64 * 0.01).collect(),
        sigmas: vec![0.01; ranges.len()],
        ranges,
        bearing_sigma: 0.001,
        max_range: 6.0,
        sweep: 0.1,
        qualities: vec![],
    }
}

#[test]
fn odometry_keeps_every_entry_of_its_covariance() {
    let cov = nalgebra::Matrix3::new(1.0, 2.0, 3.0, 2.0, 5.0, 6.0, 3.0, 6.0, 9.0);
    let odometry = Odometry {
        from: Stamp(1),
        to: Stamp(2),
        motion: Pose2::new(0.5, -0.25, 0.0),
        cov,
    };
    assert_eq!(OdometryBody::new(0, &odometry).odometry(), Ok(odometry));
    let mut bad = OdometryBody::new(0, &odometry);
    bad.cov[3] = -1.0;
    assert!(bad.odometry().is_err());
}

#[test]
fn a_scan_that_is_none_is_refused() {
    let good = scan(vec![1.0, f32::INFINITY]);
    assert_eq!(ScanBody::new(3, &good).scan(), Ok(good.clone()));
    let mut uneven = ScanBody::new(3, &good);
    uneven.bearings.pop();
    assert!(uneven.scan().is_err());
}

proptest! {
    #[test]
    fn nothing_that_comes_makes_a_decoder_fail(noise in prop::collection::vec(any::<u8>(), 0..200)) {
        for format in BOTH {
            let _ = decode::<ToBridge>(&noise, format);
            let _ = decode::<FromBridge>(&noise, format);
        }
        let mut framed = bytes(&ToBridge::Stop);
        for kind in 0..=255 {
            framed[3] = kind;
            framed.truncate(16);
            framed.extend(&noise);
            let _ = decode::<ToBridge>(&framed, Format::Binary);
            let _ = decode::<FromBridge>(&framed, Format::Binary);
        }
    }

    /// A false length must not make the reader reserve that much memory.
    #[test]
    fn a_spoilt_message_is_refused_or_is_a_message(at in 0_usize..400, flip in 1_u8..=255, sample in 0_usize..17) {
        let mut spoilt = bytes(&from_bridge()[sample]);
        let at = at % spoilt.len();
        spoilt[at] ^= flip;
        if let Ok((_, message)) = decode::<FromBridge>(&spoilt, Format::Binary) {
            prop_assert!(encode(HEADER, &message, Format::Binary).is_ok());
        }
    }

    #[test]
    fn scans_come_back_to_the_bit(ranges in prop::collection::vec(prop_oneof![0.0_f32..30.0, Just(f32::INFINITY), Just(f32::NAN)], 1..400)) {
        let scan = scan(ranges);
        for format in BOTH {
            let written = encode(HEADER, &FromBridge::Scan(ScanBody::new(0, &scan)), format).unwrap();
            let (_, FromBridge::Scan(body)) = decode(&written, format).unwrap() else {
                return Err(TestCaseError::fail("another kind"));
            };
            let read = body.scan().unwrap();
            let bits = |ranges: &[f32]| ranges.iter().map(|r| if r.is_nan() { 0 } else { r.to_bits() }).collect::<Vec<_>>();
            prop_assert_eq!(bits(&read.ranges), bits(&scan.ranges));
            prop_assert_eq!(&read.bearings, &scan.bearings);
        }
    }
}

/// The signature was made by Python (`hmac.digest`, by the lines of [`MessageKey`]).
#[test]
fn a_message_is_signed_by_token_and_challenge_and_both_ends_make_the_same_key() {
    let token = "0123456789abcdef0123456789abcdef";
    let challenge = [1; CHALLENGE_BYTES];
    let key = MessageKey::of_token(token, &challenge);
    let signature = key.sign(b"drive");
    let written: String = signature.iter().map(|byte| format!("{byte:02x}")).collect();
    assert_eq!(
        written,
        "9b6032ab9b33865c553774f5e054ba3bd9c86181bf3e96b7330969cb67f05b81"
    );
    let shown = proof(token, &challenge);
    let at_bridge = Verifier::of(token).message_key(&challenge, &shown);
    assert!(at_bridge.has_signed(b"drive", &signature));
    assert!(!at_bridge.has_signed(b"drivf", &signature));
    assert!(!at_bridge.has_signed(b"drive", &signature[1..]));
    assert!(!at_bridge.has_signed(b"drive", b""));
    // Another challenge gives another key, and so does another token.
    for other in [
        MessageKey::of_token(token, &[2; CHALLENGE_BYTES]),
        MessageKey::of_token("another", &challenge),
    ] {
        assert!(!other.has_signed(b"drive", &signature));
    }
}
