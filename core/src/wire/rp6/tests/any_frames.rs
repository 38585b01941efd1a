//! Frames of any content, in pieces of any size, and any bytes at all.

use proptest::prelude::*;

use super::*;
use crate::wire::Tally;

fn command() -> impl Strategy<Value = Command> {
    prop_oneof![
        any::<u8>().prop_map(|nonce| Command::Greet { nonce }),
        any::<(i16, i16)>().prop_map(|(forward_mm_s, turn_mrad_s)| Command::Velocity {
            forward_mm_s,
            turn_mrad_s
        }),
        any::<i32>().prop_map(|way_um| Command::Forward { way_um }),
        any::<i32>().prop_map(|angle_urad| Command::Turn { angle_urad }),
        Just(Command::Stop),
        Just(Command::EStop),
        Just(Command::Reset),
        Just(Command::Alive),
        any::<i16>().prop_map(|angle_mrad| Command::Servo { angle_mrad }),
        any::<(i16, i16, i16)>().prop_map(|(from_mrad, to_mrad, step_mrad)| Command::Sweep {
            from_mrad,
            to_mrad,
            step_mrad
        }),
        any::<u16>().prop_map(|period_ms| Command::SetRate { period_ms }),
    ]
}

fn report() -> impl Strategy<Value = Report> {
    let ints = any::<(u32, [i32; 2], [i16; 2], [u16; 2], u16, u8, u8)>();
    let telemetry = ints.prop_map(
        |(time_ms, counts, speeds, currents_adc, battery_adc, state, fault)| {
            let fault = match fault {
                0 => Fault::None,
                1 => Fault::LeftEncoder,
                2 => Fault::RightEncoder,
                3 => Fault::Overcurrent,
                4 => Fault::BatteryLow,
                other => Fault::Other(other),
            };
            Report::Telemetry(Telemetry {
                time_ms,
                counts,
                speeds,
                currents_adc,
                battery_adc,
                state: State(state),
                fault,
            })
        },
    );
    let angles = proptest::collection::vec(any::<i16>(), 0..=16);
    let hello = (any::<[u8; 4]>(), any::<[u16; 4]>(), any::<u32>(), angles).prop_map(
        |(small, sizes, count_nm, ranger_angles_mrad)| {
            Report::Hello(Hello {
                protocol: small[0],
                firmware: [small[1], small[2]],
                nonce: small[3],
                cause: ResetCause::Watchdog,
                capabilities: small[0],
                length_mm: sizes[0],
                width_mm: sizes[1],
                track_width_mm: sizes[2],
                count_nm,
                max_speed_mm_s: sizes[3],
                ranger_angles_mrad,
            })
        },
    );
    let ranger =
        any::<(u32, i16, u8, u16, u8)>().prop_map(|(time_ms, servo_mrad, index, adc, sweep)| {
            Report::Ranger(Ranger {
                time_ms,
                servo_mrad,
                index,
                adc,
                sweep,
            })
        });
    let ack = any::<u8>().prop_map(|of| Report::Ack {
        of,
        result: CommandResult::Stale,
    });
    prop_oneof![telemetry, hello, ranger, ack]
}

/// All frames of the stream, passed in pieces of the given size.
fn decode<M: Message>(stream: &[u8], piece: usize) -> (Vec<Frame<M>>, Tally) {
    let mut decoder = Decoder::default();
    let mut frames = Vec::new();
    for piece in stream.chunks(piece) {
        frames.extend(decoder.push(piece));
    }
    (frames, decoder.tally())
}

proptest! {
    #[test]
    fn commands_come_back_in_pieces_of_any_size(commands in proptest::collection::vec(command(), 0..20), piece in 1..40_usize) {
        let stream: Vec<u8> = commands.iter().zip(0..).flat_map(|(c, n)| encode(n, c)).collect();
        let (frames, counters) = decode::<Command>(&stream, piece);
        prop_assert_eq!(frames.into_iter().map(|f| f.message).collect::<Vec<_>>(), commands);
        prop_assert_eq!(counters.discarded, 0);
    }

    #[test]
    fn reports_come_back_in_pieces_of_any_size(reports in proptest::collection::vec(report(), 0..20), piece in 1..40_usize) {
        let stream: Vec<u8> = reports.iter().zip(0..).flat_map(|(r, n)| encode(n, r)).collect();
        let (frames, _) = decode::<Report>(&stream, piece);
        prop_assert_eq!(frames.into_iter().map(|f| f.message).collect::<Vec<_>>(), reports);
    }

    #[test]
    fn frames_to_the_robot_fit_its_buffer(command in command(), sequence in any::<u8>()) {
        prop_assert!(encode(sequence, &command).len() <= LONGEST_TO_ROBOT);
    }

    #[test]
    fn reports_fit_their_longest_frame(report in report(), sequence in any::<u8>()) {
        prop_assert!(encode(sequence, &report).len() <= Report::LONGEST_FRAME);
    }

    /// Noise without markers before each frame: the frame's own first marker ends the noise.
    #[test]
    fn noise_between_frames_costs_no_frame(
        pieces in proptest::collection::vec((proptest::collection::vec(1..=255_u8, 0..80), command()), 1..15),
        piece in 1..40_usize,
    ) {
        let stream: Vec<u8> = pieces.iter().zip(0..).flat_map(|((noise, c), n)| [noise.clone(), encode(n, c)].concat()).collect();
        let (frames, counters) = decode::<Command>(&stream, piece);
        let noise: usize = pieces.iter().map(|(noise, _)| noise.len()).sum();
        prop_assert_eq!(frames.into_iter().map(|f| f.message).collect::<Vec<_>>(), pieces.into_iter().map(|p| p.1).collect::<Vec<_>>());
        prop_assert_eq!(counters.discarded, noise as u64);
    }

    #[test]
    fn any_bytes_are_taken_without_harm_and_alike_in_any_pieces(bytes in proptest::collection::vec(any::<u8>(), 0..2_000), piece in 1..100_usize) {
        prop_assert_eq!(decode::<Command>(&bytes, piece), decode::<Command>(&bytes, 1));
        prop_assert_eq!(decode::<Report>(&bytes, piece), decode::<Report>(&bytes, 1));
        let mut link = Link::new(Stamp(0), 1);
        for (piece, now) in bytes.chunks(piece).zip(0..) {
            link.receive(piece, Stamp(now * 10_000));
            link.tick(Stamp(now * 10_000));
        }
    }
}
