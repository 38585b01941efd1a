//! A robot of a few frames: what it reports of its sweeps.

use crate::robot::Adc;
use crate::robot::Sharp;
use crate::wire::rp6::fixture::hello;
use crate::wire::rp6::{CommandResult, Decoder, Report as Said, State, encode};

use super::*;

const SWEEPING: State = State(1 << 3);
/// The host's time at the robot's time 0.
const HOST_AT_0: f64 = 10.0;

/// The device, and the robot at the other end of its line.
struct Pair {
    device: Rp6,
    millis: u32,
    sequence: u8,
    commands: Decoder<rp6::Command>,
    /// What the robot was given, and when.
    given: Vec<(u32, rp6::Command)>,
    reported: Vec<SourceEvent>,
}

impl Pair {
    /// A robot with four rangers that has answered.
    fn up() -> Self {
        let mut pair = Self {
            device: Rp6::new("rp6:test"),
            millis: 0,
            sequence: 0,
            commands: Decoder::default(),
            given: vec![],
            reported: vec![],
        };
        pair.device.opened(pair.now());
        for _ in 0..200 {
            pair.millis += 10;
            pair.device.tick(pair.now());
            pair.hear();
        }
        assert!(pair.device.robot.is_some());
        pair
    }

    /// Reads what was written, and acknowledges it.
    fn hear(&mut self) {
        while let Some(want) = self.device.next_want() {
            match want {
                Want::Write(bytes) => {
                    let frames: Vec<_> = self.commands.push(&bytes).collect();
                    for frame in frames {
                        self.answer(frame.sequence, frame.message);
                    }
                }
                Want::Report(event) => self.reported.push(event),
                _ => (),
            }
        }
    }

    fn answer(&mut self, of: u8, command: rp6::Command) {
        self.given.push((self.millis, command));
        self.say(&match command {
            rp6::Command::Greet { nonce } => Said::Hello(hello(nonce)),
            _ => Said::Ack {
                of,
                result: CommandResult::Done,
            },
        });
    }

    fn now(&self) -> Stamp {
        Stamp::from_seconds(HOST_AT_0 + 1e-3 * f64::from(self.millis))
    }

    fn say(&mut self, report: &Said) {
        self.sequence = self.sequence.wrapping_add(1);
        let bytes = encode(self.sequence, report);
        let now = self.now();
        self.device.receive(&bytes, now);
        self.device.tick(now);
    }

    fn telemetry(&mut self, state: State, counts: [i32; 2]) {
        self.millis += 20;
        self.say(&Said::Telemetry(Telemetry {
            time_ms: self.millis,
            counts,
            battery_adc: 750,
            state,
            ..Telemetry::default()
        }));
    }

    fn reading(&mut self, sweep: u8, servo_mrad: i16, range: f64) {
        self.millis += 5;
        self.say(&Said::Ranger(Ranger {
            time_ms: self.millis,
            servo_mrad,
            index: 0,
            adc: Adc::rp6().counts(Sharp::Long.volts_at(range)) as u16,
            sweep,
        }));
    }

    fn scans(&mut self) -> Vec<Scan> {
        self.hear();
        let reported = std::mem::take(&mut self.reported).into_iter();
        let scan = |event| match event {
            SourceEvent::Scan(scan) => Some(scan),
            _ => None,
        };
        reported.filter_map(scan).collect()
    }
}

#[test]
fn a_sweep_becomes_a_scan_on_the_bridges_clock_when_the_servo_rests() {
    let mut pair = Pair::up();
    pair.telemetry(State(0), [0, 0]);
    pair.telemetry(SWEEPING, [0, 0]);
    for (servo, range) in [(-100, 0.4), (0, 0.5), (100, 0.6)] {
        pair.reading(1, servo, range);
        pair.telemetry(SWEEPING, [0, 0]);
    }
    assert_eq!(pair.scans(), [], "the servo still turns");
    let last = pair.millis - 20;
    pair.telemetry(State(0), [0, 0]);
    let scans = pair.scans();
    let [scan] = scans.as_slice() else {
        panic!("{scans:?}")
    };
    for ((bearing, range), (truth, wall)) in
        scan.bearings
            .iter()
            .zip(&scan.ranges)
            .zip([(-0.1, 0.4), (0.0, 0.5), (0.1, 0.6)])
    {
        assert!((bearing - truth).abs() < 1e-9);
        assert!(
            (f64::from(*range) - wall).abs() < 0.05,
            "{range} for {wall}"
        );
    }
    // The line's own delay for a telemetry frame is known and subtracted; here it took none.
    let host = HOST_AT_0 + 1e-3 * f64::from(last);
    assert!(
        (scan.stamp.seconds() - host).abs() < 0.02,
        "{} for {host}",
        scan.stamp.seconds()
    );
}

#[test]
fn a_sweep_while_the_tracks_run_is_no_scan() {
    let mut pair = Pair::up();
    pair.telemetry(SWEEPING, [0, 0]);
    pair.reading(1, -100, 0.4);
    pair.telemetry(SWEEPING, [0, 300]);
    pair.reading(1, 100, 0.4);
    pair.telemetry(State(0), [0, 300]);
    assert_eq!(pair.scans(), []);
}

/// Partial scans that were reported.
fn partial_scans(pair: &mut Pair) -> Vec<Scan> {
    pair.hear();
    let reported = std::mem::take(&mut pair.reported).into_iter();
    let partial = |event| match event {
        SourceEvent::PartialScan(scan) => Some(scan),
        _ => None,
    };
    reported.filter_map(partial).collect()
}

/// Where the servo was sent since the last call, mrad.
fn pointed(pair: &mut Pair) -> Vec<i16> {
    pair.hear();
    let given = std::mem::take(&mut pair.given).into_iter();
    let at = |(_, command)| match command {
        rp6::Command::Sweep {
            from_mrad, to_mrad, ..
        } if from_mrad == to_mrad => Some(from_mrad),
        _ => None,
    };
    given.filter_map(at).collect()
}

#[test]
fn a_robot_that_drives_makes_partial_scans_to_and_fro_which_are_no_scans() {
    let mut pair = Pair::up();
    pair.telemetry(State(0), [0, 0]);
    assert!(pointed(&mut pair).is_empty(), "it stands");
    order(&mut pair, Command::Forward(0.5));
    let moving_and_sweeping = State(MOVING.0 | SWEEPING.0);
    let mut servo: Vec<i16> = vec![];
    for k in 0..5_i32 {
        pair.telemetry(MOVING, [100 * k; 2]);
        let to = pointed(&mut pair);
        servo.extend(&to);
        pair.telemetry(moving_and_sweeping, [100 * k + 50; 2]);
        pair.reading(k as u8 + 1, to[0], 0.5);
    }
    assert_eq!(servo, [0, 524, 0, -524, 0]);
    pair.telemetry(MOVING, [500; 2]);
    let reported = partial_scans(&mut pair);
    assert_eq!(reported.len(), 5);
    for (scan, bearing) in reported.iter().zip([0.0, 0.524, 0.0, -0.524, 0.0]) {
        assert!((scan.bearings[0] - bearing).abs() < 1e-9 && scan.len() == 1);
        assert!((f64::from(scan.ranges[0]) - 0.5).abs() < 0.05);
    }
    // It stands, and sweeps all round: readings still coming from a partial scan do not belong to
    // that sweep, and it does not matter where the tracks were then.
    let _ = pointed(&mut pair);
    pair.telemetry(moving_and_sweeping, [500; 2]);
    order(&mut pair, Command::Stop);
    pair.telemetry(SWEEPING, [540; 2]);
    pair.reading(6, 524, 0.7);
    order(&mut pair, Command::Scan);
    pair.hear();
    pair.reading(7, -785, 0.4);
    pair.telemetry(SWEEPING, [540; 2]);
    pair.telemetry(State(0), [540; 2]);
    let scans = pair.scans();
    assert_eq!(scans.len(), 1);
    assert_eq!(scans[0].len(), 1);
    assert!((scans[0].bearings[0] + 0.785).abs() < 1e-9);
    assert!(pointed(&mut pair).is_empty(), "it stands");
}

const MOVING: State = State(1 << 2);

/// What was reported of being busy since the last call, each change once.
fn busy(pair: &mut Pair) -> Vec<bool> {
    pair.hear();
    let reported = std::mem::take(&mut pair.reported).into_iter();
    let mut busy: Vec<_> = reported
        .filter_map(|event| match event {
            SourceEvent::Busy { busy, .. } => Some(busy),
            _ => None,
        })
        .collect();
    busy.dedup();
    busy
}

fn order(pair: &mut Pair, command: Command) {
    let now = pair.now();
    pair.device.order(Order::Command(command), now);
}

#[test]
fn a_manoeuvre_is_over_when_the_robot_stands_that_has_acknowledged_it() {
    let mut pair = Pair::up();
    pair.telemetry(State(0), [0, 0]);
    let _ = busy(&mut pair);
    order(&mut pair, Command::Forward(0.3));
    assert_eq!(busy(&mut pair), [true]);
    // Telemetry measured before it began says nothing about it.
    pair.telemetry(State(0), [0, 0]);
    assert!(busy(&mut pair).is_empty());
    for step in 1..=30 {
        pair.telemetry(MOVING, [10 * step; 2]);
        pair.hear();
    }
    assert!(!busy(&mut pair).contains(&false));
    pair.telemetry(State(0), [300; 2]);
    assert_eq!(busy(&mut pair), [false]);
}

#[test]
fn a_manoeuvre_ends_with_the_order_that_takes_its_place_and_with_the_link() {
    let mut pair = Pair::up();
    let _ = busy(&mut pair);
    order(&mut pair, Command::Turn(1.0));
    order(&mut pair, Command::Stop);
    assert_eq!(busy(&mut pair), [true, false]);
    order(&mut pair, Command::Turn(1.0));
    assert_eq!(busy(&mut pair), [true]);
    for _ in 0..500 {
        pair.millis += 10;
        let now = pair.now();
        pair.device.tick(now);
    }
    assert!(pair.device.robot.is_none(), "it fell silent");
    assert_eq!(busy(&mut pair).last(), Some(&false));
}

/// A driver who armed a robot that had just come back and held a key at once could not drive until
/// the key was let go.
#[test]
fn who_holds_a_key_at_once_drives_and_who_held_it_all_along_does_not() {
    let ahead = Command::Velocity {
        forward: 0.1,
        turn: 0.0,
    };
    let drives = |pair: &mut Pair| {
        pair.given.clear();
        for _ in 0..20 {
            order(pair, ahead);
            pair.telemetry(State(0), [0; 2]);
            pair.hear();
        }
        pair.given.iter().any(|(_, command)| command.moves())
    };
    for is_held in [false, true] {
        let mut pair = Pair::up();
        order(&mut pair, ahead);
        let step = |pair: &mut Pair| {
            pair.millis += 10;
            let now = pair.now();
            if is_held {
                pair.device.order(Order::Command(ahead), now);
            }
            pair.device.tick(now);
        };
        // It falls silent, and is greeted when it sends again.
        for _ in 0..150 {
            step(&mut pair);
        }
        assert!(pair.device.robot.is_none());
        for _ in 0..500 {
            if pair.device.robot.is_none() {
                step(&mut pair);
                pair.hear();
            }
        }
        assert!(pair.device.robot.is_some());
        assert_eq!(drives(&mut pair), !is_held);
    }
}

#[test]
fn a_manoeuvre_that_comes_too_early_is_not_reported_as_over_at_once() {
    let mut pair = Pair::up();
    let _ = busy(&mut pair);
    if let Some(robot) = &mut pair.device.robot {
        (robot.is_calm, robot.calm_since) = (
            false,
            Stamp::from_seconds(HOST_AT_0 + 1e-3 * f64::from(pair.millis)),
        );
    }
    order(&mut pair, Command::Turn(1.0));
    for _ in 0..40 {
        pair.telemetry(State(0), [0; 2]);
    }
    assert_eq!(
        busy(&mut pair),
        [true],
        "for longer than orders must have ceased"
    );
    for _ in 0..20 {
        pair.telemetry(State(0), [0; 2]);
    }
    assert_eq!(busy(&mut pair).last(), Some(&false));
    order(&mut pair, Command::Turn(1.0));
    assert_eq!(
        pair.device.robot.as_ref().map(|robot| robot.is_calm),
        Some(true)
    );
}

/// The rules stop a robot whose driver is silent. If the program that runs them hangs, this keeps
/// the motors from running on keep-alives for much longer.
#[test]
fn a_speed_that_is_not_given_anew_is_ended_after_a_quarter_of_a_second() {
    let mut pair = Pair::up();
    let begun = pair.millis;
    let ahead = Command::Velocity {
        forward: 0.1,
        turn: 0.0,
    };
    pair.device.order(Order::Command(ahead), pair.now());
    pair.hear();
    for _ in 0..60 {
        pair.millis += 10;
        pair.device.tick(pair.now());
        pair.hear();
    }
    let last = pair.given.last().copied();
    assert_eq!(last, Some((begun + 260, rp6::Command::Stop)));
}
