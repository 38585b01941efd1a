//! The bytes of the protocol, their damage, and their meaning for the core.

mod any_frames;

use super::*;
use crate::geom::Pose2;
use crate::robot::{self, RobotModel, Stamp};

fn hex(bytes: &[u8]) -> String {
    let digits: Vec<String> = bytes.iter().map(|b| format!("{b:02x}")).collect();
    digits.join(" ")
}

fn telemetry() -> Telemetry {
    Telemetry {
        time_ms: 123_456,
        counts: [1_000, -1],
        speeds: [250, -250],
        currents_adc: [40, 42],
        battery_adc: 737,
        state: State(0b10_0101),
        fault: Fault::RightEncoder,
    }
}

fn hello() -> Hello {
    Hello {
        firmware: [1, 2],
        cause: ResetCause::External,
        capabilities: 0x1F,
        ..fixture::hello(9)
    }
}

/// Checksums by bit-by-bit polynomial division, written without the crate.
fn crc_by_hand(bytes: &[u8]) -> u16 {
    let mut crc = 0xFFFF_u16;
    for byte in bytes {
        crc ^= u16::from(*byte);
        for _ in 0..8 {
            crc = (crc >> 1) ^ if crc & 1 == 1 { 0x8408 } else { 0 };
        }
    }
    crc
}

/// Golden bytes: made by an encoder of a few lines of Python, not by this one.
#[test]
fn bytes_of_commands_are_these() {
    let check = |sequence, command: Command, expected: &str| {
        let bytes = encode(sequence, &command);
        assert_eq!(hex(&bytes), expected, "{command:?}");
        assert!(bytes.len() <= LONGEST_TO_ROBOT);
    };
    check(7, Command::Stop, "00 05 05 07 bf fa 00");
    check(1, Command::Greet { nonce: 9 }, "00 06 01 01 09 f6 e7 00");
    let velocity = Command::Velocity {
        forward_mm_s: 200,
        turn_mrad_s: -500,
    };
    check(2, velocity, "00 04 02 02 c8 05 0c fe fe 7f 00");
    check(
        3,
        Command::Forward { way_um: 1_000_000 },
        "00 06 03 03 40 42 0f 03 70 3f 00",
    );
    let turn = Command::Turn {
        angle_urad: -1_570_796,
    };
    check(4, turn, "00 09 04 04 14 08 e8 ff 62 6a 00");
    check(5, Command::EStop, "00 05 06 05 c5 f3 00");
    check(0, Command::Reset, "00 02 07 03 b0 bd 00");
    check(
        8,
        Command::Servo { angle_mrad: -785 },
        "00 07 08 08 ef fc 89 77 00",
    );
    let sweep = Command::Sweep {
        from_mrad: -785,
        to_mrad: 751,
        step_mrad: 35,
    };
    check(9, sweep, "00 08 09 09 ef fc ef 02 23 03 2a 7c 00");
    check(
        10,
        Command::SetRate { period_ms: 50 },
        "00 04 0a 0a 32 03 e7 29 00",
    );
    check(11, Command::Alive, "00 05 0b 0b c3 aa 00");
}

#[test]
fn bytes_of_reports_are_these() {
    let check = |sequence, report: Report, expected: &str| {
        assert_eq!(hex(&encode(sequence, &report)), expected, "{report:?}");
    };
    check(
        0,
        Report::Hello(hello()),
        "00 02 81 08 01 01 02 09 02 1f bd 02 71 02 c5 04 80 a9 03 04 2c 01 04 01 09 23 06 46 0c dd f9 b5 05 00",
    );
    let ack = Report::Ack {
        of: 7,
        result: CommandResult::Latched,
    };
    check(1, ack, "00 07 82 01 07 04 c9 46 00");
    check(
        2,
        Report::Telemetry(telemetry()),
        "00 06 83 02 40 e2 01 03 e8 03 01 06 ff ff ff ff fa 04 06 ff 28 02 2a 07 e1 02 25 02 d2 5f 00",
    );
    let ranger = Ranger {
        time_ms: 70_000,
        servo_mrad: -700,
        index: 2,
        adc: 513,
        sweep: 5,
    };
    check(
        3,
        Report::Ranger(ranger),
        "00 06 84 03 70 11 01 09 44 fd 02 01 02 05 76 20 00",
    );
}

#[test]
fn the_checksum_is_that_of_the_catalogue_and_of_a_division_by_hand() {
    let crc = crc::Crc::<u16>::new(&crc::CRC_16_MCRF4XX);
    assert_eq!(crc.checksum(b"123456789"), 0x6F91);
    assert_eq!(crc_by_hand(b"123456789"), 0x6F91);
    // Stop, sequence 7: no zero inside, so the stuffing is one byte in front.
    let bytes = encode(7, &Command::Stop);
    let [low, high] = crc_by_hand(&[5, 7]).to_le_bytes();
    assert_eq!(bytes, [0, 5, 5, 7, low, high, 0]);
}

#[test]
fn damage_costs_the_frame_it_hits_and_no_other() {
    let good = encode(2, &Command::Alive);
    for at in 0..good.len() {
        for bit in 0..8 {
            let mut stream = encode(1, &Command::Stop);
            let mut hit = good.clone();
            hit[at] ^= 1 << bit;
            stream.extend(&hit);
            stream.extend(encode(3, &Command::Reset));
            let mut decoder = Decoder::<Command>::default();
            let frames: Vec<_> = decoder.push(&stream).map(|f| f.message).collect();
            // There are two markers between two frames, so losing one does no harm.
            let is_marker = at == 0 || at == good.len() - 1;
            match is_marker {
                true => assert!(frames.len() >= 2, "byte {at} bit {bit}: {frames:?}"),
                false => assert_eq!(
                    frames,
                    [Command::Stop, Command::Reset],
                    "byte {at} bit {bit}"
                ),
            }
            assert!(is_marker || decoder.tally().discarded > 0);
        }
    }
}

#[test]
fn every_pair_of_flipped_bits_is_noticed() {
    let command = Command::Velocity {
        forward_mm_s: 200,
        turn_mrad_s: -500,
    };
    for good in [
        encode(2, &command),
        encode(3, &Command::Forward { way_um: 256 }),
        encode(4, &Command::EStop),
    ] {
        let bits = 8 * good.len();
        for first in 0..bits {
            for second in 0..first {
                let mut hit = good.clone();
                hit[first / 8] ^= 1 << (first % 8);
                hit[second / 8] ^= 1 << (second % 8);
                // A marker of the next frame, in case this frame's own was damaged.
                hit.push(0);
                let whole: Vec<Frame<Command>> = Decoder::default().push(&good).collect();
                let got: Vec<Frame<Command>> = Decoder::default().push(&hit).collect();
                let is_leading_marker = first < 8 && second < 8;
                assert!(
                    got.is_empty() || is_leading_marker && got == whole,
                    "{first} {second}: {got:?}"
                );
            }
        }
    }
}

#[test]
fn a_wrong_checksum_passes_no_oftener_than_chance() {
    // Random pieces of the length of a frame: about one in 65536 has a correct checksum, and few of
    // those match the table.
    let mut state = 1_u64;
    let mut random = move || {
        state = state
            .wrapping_mul(6364136223846793005)
            .wrapping_add(1442695040888963407);
        (state >> 56) as u8
    };
    let mut decoder = Decoder::<Command>::default();
    let pieces = 400_000_u64;
    for _ in 0..pieces {
        let piece: Vec<u8> = (0..9).map(|_| random().max(1)).collect();
        let _ = decoder.push(&piece).count() + decoder.push(&[0]).count();
    }
    let tally = decoder.tally();
    // 6.1 are expected to have a correct checksum; those with impossible stuffing do not get that
    // far. More than 20 would be 5 sigma off.
    assert!(tally.frames <= 20, "{tally:?}");
    assert_eq!(tally.frames + tally.rejected, pieces);
}

#[test]
fn a_stream_without_markers_takes_no_memory_and_is_counted() {
    let mut decoder = Decoder::<Command>::default();
    assert_eq!(decoder.push(&[0x55; 100_000]).count(), 0);
    assert_eq!(decoder.tally().rejected, 1);
    assert_eq!(decoder.tally().discarded, 100_000);
    let mut next = vec![0];
    next.extend(encode(1, &Command::Stop));
    assert_eq!(decoder.push(&next).count(), 1);
}

#[test]
fn another_length_or_kind_than_the_table_has_is_unknown() {
    struct Raw(u8, Vec<u8>);
    impl Message for Raw {
        const LONGEST_FRAME: usize = 64;
        fn kind(&self) -> u8 {
            self.0
        }
        fn put_payload(&self, out: &mut Vec<u8>) {
            out.extend(&self.1);
        }
        fn parse(_: u8, _: &[u8]) -> Option<Self> {
            None
        }
    }
    for (kind, length) in [(0x05, 1), (0x02, 3), (0x02, 5), (0x7F, 0), (0x81, 3)] {
        let mut decoder = Decoder::<Command>::default();
        let bytes = encode(1, &Raw(kind, vec![1; length]));
        assert_eq!(decoder.push(&bytes).count(), 0);
        assert_eq!(decoder.tally().rejected, 1, "{kind:02x} {length}");
    }
}

#[test]
fn commands_of_the_core_become_those_of_the_wire() {
    let convert = |command: robot::Command| Command::try_from(&command);
    let velocity = robot::Command::Velocity {
        forward: 0.1234,
        turn: -0.5,
    };
    let expected = Command::Velocity {
        forward_mm_s: 123,
        turn_mrad_s: -500,
    };
    assert_eq!(convert(velocity), Ok(expected));
    assert_eq!(
        convert(robot::Command::Forward(-1.5)),
        Ok(Command::Forward { way_um: -1_500_000 })
    );
    assert_eq!(
        convert(robot::Command::Turn(std::f64::consts::FRAC_PI_2)),
        Ok(Command::Turn {
            angle_urad: 1_570_796
        })
    );
    let message = |command| convert(command).unwrap_err().to_string();
    let far = message(robot::Command::Forward(3_000.0));
    assert!(
        far.starts_with("RP6 command: way, m is 3000, expected -2147.48"),
        "{far}"
    );
    assert!(message(robot::Command::Turn(f64::NAN)).contains("NaN"));
    let fast = robot::Command::Velocity {
        forward: f64::INFINITY,
        turn: 0.0,
    };
    assert!(message(fast).contains("forward speed, m/s is inf"));
}

#[test]
fn telemetry_becomes_odometry_by_the_models_figures() {
    let model = RobotModel::rp6();
    let mut odometer = Odometer::new(&model);
    let at = |time_ms, counts| Telemetry {
        time_ms,
        counts,
        ..telemetry()
    };
    // Clock and counts both wrap between the first and the second.
    let first = at(u32::MAX - 49, [i32::MAX - 99, i32::MIN + 99]);
    let second = at(
        50,
        [
            i32::MAX.wrapping_add(901),
            i32::MIN.wrapping_add(99 - 1_000),
        ],
    );
    assert_eq!(
        odometer.update(&first).map(|o| o.motion),
        Some(Pose2::identity())
    );
    let motion = odometer.update(&second).map(|o| {
        assert!(o.to.0 - o.from.0 == 100_000);
        assert!(o.cov[(2, 2)] > 0.0 && o.validate().is_ok());
        o.motion
    });
    // 1000 counts forwards on the left, 1000 back on the right: a turn on the spot to the right.
    let turn = -2_000.0 * model.metres_per_tick / model.track_width;
    let motion = motion.expect("later telemetry moves");
    assert!((motion.heading() - turn).abs() < 1e-9 && motion.x().abs() < 1e-12);
    // The same again, and an earlier one.
    assert_eq!(odometer.update(&second), None);
    assert_eq!(odometer.update(&first), None);
    let later = odometer.update(&at(150, second.counts));
    assert_eq!(later.map(|o| o.motion), Some(Pose2::identity()));
}

#[test]
fn the_robots_own_geometry_replaces_the_models() {
    let mut said = hello();
    said.track_width_mm = 200;
    said.count_nm = 250_000;
    said.max_speed_mm_s = 0;
    let model = said.model();
    assert_eq!((model.track_width, model.max_speed), (0.2, 0.30));
    assert!((model.metres_per_tick - 0.000_25).abs() < 1e-18);
    // 737 counts of 10 V / 1024.
    assert!((telemetry().battery_volts() - 7.2).abs() < 0.01);
}
