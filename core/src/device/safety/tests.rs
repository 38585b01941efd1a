//! The rules, one by one, and against a plain retelling of what must always hold.

use std::time::Duration;

use crate::robot::Command;
use crate::wire::message::{DisarmReason, DriveBody, Motion, RefusalReason, close};
use proptest::prelude::*;

use super::*;

const STOP: Output = Output::Order(Order::Command(Command::Stop));
const A: Client = Client {
    id: 1,
    may_drive: true,
};
const B: Client = Client {
    id: 2,
    may_drive: true,
};
const WATCHER: Client = Client {
    id: 3,
    may_drive: false,
};

fn at(millis: u64) -> Duration {
    Duration::from_millis(millis)
}

fn drive(epoch: u32, sequence: u32, seen: u64) -> Asked {
    Asked::Drive {
        sequence,
        body: DriveBody {
            epoch,
            seen: 1000 * seen,
            ttl_millis: 300,
            motion: RUN,
        },
    }
}

const RUN: Motion = Motion::Velocity {
    forward: 0.2,
    turn: 0.0,
};

fn hold(epoch: u32, sequence: u32, seen: u64) -> Asked {
    Asked::Hold {
        sequence,
        epoch,
        seen: at(seen),
        ttl: at(300),
    }
}

/// The rules, with a robot whose link is up.
fn with_robot() -> Safety {
    let mut safety = Safety::new(SafetyConfig::default());
    safety.on(at(0), Input::Robot(true));
    safety
}

fn ask(safety: &mut Safety, millis: u64, client: Client, asked: Asked) -> Vec<Output> {
    safety.on(at(millis), Input::Asks(client, asked))
}

/// A drives, at 0 ms, with epoch 1 and sequence 1.
fn driven() -> Safety {
    let mut safety = with_robot();
    ask(&mut safety, 0, A, Asked::Take { force: false });
    ask(&mut safety, 0, A, Asked::Arm { epoch: 1 });
    let out = ask(&mut safety, 0, A, drive(1, 1, 0));
    assert_eq!(out, [Output::Order(Order::Command(RUN.into()))]);
    safety
}

fn refused(reason: RefusalReason) -> Vec<Output> {
    vec![Output::Refused(A.id, reason)]
}

#[test]
fn nothing_moves_before_it_is_armed() {
    let mut safety = with_robot();
    ask(&mut safety, 0, A, Asked::Take { force: false });
    let out = ask(&mut safety, 1, A, drive(1, 1, 0));
    assert_eq!(out, refused(RefusalReason::Disarmed));
    let mut without_robot = Safety::new(SafetyConfig::default());
    ask(&mut without_robot, 0, A, Asked::Take { force: false });
    let out = ask(&mut without_robot, 1, A, Asked::Arm { epoch: 1 });
    assert_eq!(out, refused(RefusalReason::NoRobot));
}

#[test]
fn the_watchdog_stops_on_time_and_the_driver_goes_on_without_arming() {
    let mut safety = driven();
    assert_eq!(safety.deadline(), Some(at(200)));
    assert_eq!(safety.on(at(199), Input::Tick), []);
    assert_eq!(safety.on(at(200), Input::Tick), [STOP]);
    assert_eq!(safety.on(at(201), Input::Tick), []);
    let out = ask(&mut safety, 300, A, drive(1, 2, 200));
    assert_eq!(out, [Output::Order(Order::Command(RUN.into()))]);
}

#[test]
fn holding_keeps_a_leg_alive_but_starts_nothing() {
    let mut safety = driven();
    for millis in (100..2000).step_by(100) {
        let sequence = millis as u32 / 100 + 1;
        assert_eq!(ask(&mut safety, millis, A, hold(1, sequence, millis)), []);
        assert_eq!(safety.on(at(millis + 99), Input::Tick), []);
    }
    assert_eq!(safety.on(at(2100), Input::Tick), [STOP]);
    assert_eq!(ask(&mut safety, 2150, A, hold(1, 99, 2150)), []);
    assert_eq!(
        safety.on(at(2400), Input::Tick),
        [],
        "what stands is not stopped again"
    );
}

#[test]
fn what_is_stale_is_refused() {
    let mut safety = driven();
    for (asked, reason) in [
        (drive(1, 1, 100), RefusalReason::StaleSequence),
        (drive(0, 2, 100), RefusalReason::StaleEpoch),
        (drive(2, 2, 100), RefusalReason::StaleEpoch),
        (drive(1, 2, 101), RefusalReason::FromTheFuture),
    ] {
        assert_eq!(
            ask(&mut safety, 100, A, asked),
            refused(reason),
            "{asked:?}"
        );
    }
    // 300 ms is what the sender allows itself.
    assert_eq!(safety.on(at(200), Input::Tick), [STOP]);
    assert_eq!(
        ask(&mut safety, 301, A, drive(1, 2, 0)),
        refused(RefusalReason::TooOld)
    );
    assert_eq!(ask(&mut safety, 300, A, drive(1, 2, 0)).len(), 1);
    // Whatever it allows itself, 500 ms is the most.
    let Asked::Drive { sequence, mut body } = drive(1, 3, 0) else {
        unreachable!()
    };
    body.ttl_millis = u16::MAX;
    let out = ask(&mut safety, 501, A, Asked::Drive { sequence, body });
    assert_eq!(out, [STOP, Output::Refused(A.id, RefusalReason::TooOld)]);
}

#[test]
fn taking_over_stops_first_and_needs_force() {
    let mut safety = driven();
    let out = ask(&mut safety, 10, B, Asked::Take { force: false });
    assert_eq!(out, [Output::Refused(B.id, RefusalReason::Held)]);
    let out = ask(&mut safety, 20, B, Asked::Take { force: true });
    let lease = Lease {
        epoch: 2,
        millis: 2000,
    };
    let expect = [
        STOP,
        Output::Changed,
        Output::Close(A.id, close::TAKEN_OVER),
        Output::Granted(B.id, lease),
        Output::Changed,
    ];
    assert_eq!(out, expect);
    assert!(!safety.is_armed());
    assert_eq!(
        ask(&mut safety, 30, A, drive(1, 2, 30)),
        refused(RefusalReason::StaleEpoch)
    );
}

#[test]
fn a_lease_ends_when_it_is_not_used() {
    let mut safety = with_robot();
    ask(&mut safety, 0, A, Asked::Take { force: false });
    ask(&mut safety, 1500, A, Asked::Renew { epoch: 1 });
    assert_eq!(safety.on(at(3499), Input::Tick), []);
    assert_eq!(safety.on(at(3500), Input::Tick), [STOP, Output::Changed]);
    assert_eq!(
        (safety.driver(), safety.reason()),
        (None, DisarmReason::LeaseExpired)
    );
    let out = ask(&mut safety, 3501, A, Asked::Renew { epoch: 1 });
    assert_eq!(out, refused(RefusalReason::StaleEpoch));
}

#[test]
fn everybody_may_stop_and_a_watcher_nothing_else() {
    let mut safety = driven();
    for asked in [
        Asked::Take { force: true },
        Asked::Renew { epoch: 1 },
        Asked::Release { epoch: 1 },
        Asked::Arm { epoch: 1 },
        drive(1, 9, 0),
        hold(1, 9, 0),
        Asked::ResetEmergencyStop { epoch: 1 },
    ] {
        let out = ask(&mut safety, 1, WATCHER, asked);
        assert_eq!(
            out,
            [Output::Close(WATCHER.id, close::NO_RIGHT)],
            "{asked:?}"
        );
    }
    assert!(safety.is_armed());
    assert_eq!(
        ask(&mut safety, 2, WATCHER, Asked::Stop),
        [STOP, Output::Changed]
    );
    assert_eq!(
        (safety.is_armed(), safety.reason()),
        (false, DisarmReason::Stop)
    );
    assert_eq!(safety.driver(), Some(A.id), "the lease stays where it is");
}

#[test]
fn the_emergency_stop_is_latched_and_its_reset_moves_nothing() {
    let mut safety = driven();
    let emergency = Output::Order(Order::EmergencyStop);
    assert_eq!(
        ask(&mut safety, 1, WATCHER, Asked::EmergencyStop),
        [emergency, Output::Changed]
    );
    assert_eq!(
        ask(&mut safety, 2, A, Asked::Arm { epoch: 1 }),
        refused(RefusalReason::Emergency)
    );
    assert_eq!(
        ask(&mut safety, 3, A, drive(1, 2, 3)),
        refused(RefusalReason::Emergency)
    );
    // A robot that was reset meanwhile is told again.
    safety.on(at(4), Input::Robot(false));
    // A reset would not reach it.
    assert_eq!(
        ask(&mut safety, 4, A, Asked::ResetEmergencyStop { epoch: 1 }),
        refused(RefusalReason::NoRobot)
    );
    assert!(safety.is_emergency());
    assert!(safety.on(at(5), Input::Robot(true)).contains(&emergency));
    let out = ask(&mut safety, 6, A, Asked::ResetEmergencyStop { epoch: 1 });
    assert_eq!(
        out,
        [Output::Order(Order::ResetEmergencyStop), Output::Changed]
    );
    assert!(!safety.is_armed());
    assert_eq!(
        ask(&mut safety, 7, A, drive(1, 3, 7)),
        refused(RefusalReason::Disarmed)
    );
}

#[test]
fn whatever_happens_to_driver_or_robot_disarms() {
    for (input, reason) in [
        (Input::Gone(A.id), DisarmReason::DriverGone),
        (Input::Robot(false), DisarmReason::Link),
        (Input::Fault(DisarmReason::Bumper), DisarmReason::Bumper),
        (Input::Fault(DisarmReason::Silence), DisarmReason::Silence),
        (Input::Shutdown, DisarmReason::Shutdown),
        (
            Input::Asks(A, Asked::Release { epoch: 1 }),
            DisarmReason::Released,
        ),
    ] {
        let mut safety = driven();
        let out = safety.on(at(10), input);
        assert_eq!(out, [STOP, Output::Changed], "{input:?}");
        assert_eq!(
            (safety.is_armed(), safety.reason()),
            (false, reason),
            "{input:?}"
        );
    }
    let mut safety = driven();
    let out = safety.on(at(10), Input::Fault(DisarmReason::Runaway));
    assert_eq!(out[0], Output::Order(Order::EmergencyStop));
    assert!(safety.is_emergency());
    let mut safety = driven();
    assert_eq!(safety.on(at(10), Input::Gone(B.id)), [], "a watcher may go");
}

#[test]
fn what_is_no_number_is_refused() {
    let mut safety = driven();
    let Asked::Drive { sequence, mut body } = drive(1, 2, 0) else {
        unreachable!()
    };
    for motion in [
        Motion::Forward(f64::NAN),
        Motion::Turn(f64::INFINITY),
        Motion::Velocity {
            forward: 0.0,
            turn: f64::NAN,
        },
    ] {
        body.motion = motion;
        let out = ask(&mut safety, 1, A, Asked::Drive { sequence, body });
        assert_eq!(out, refused(RefusalReason::NotFinite));
    }
}

fn any_asked() -> impl Strategy<Value = Asked> {
    let epoch = || 0_u32..6;
    prop_oneof![
        1 => any::<bool>().prop_map(|force| Asked::Take { force }),
        1 => epoch().prop_map(|epoch| Asked::Renew { epoch }),
        1 => epoch().prop_map(|epoch| Asked::Release { epoch }),
        8 => epoch().prop_map(|epoch| Asked::Arm { epoch }),
        // The sequence and what was seen are set to fitting ones below, most of the time.
        20 => (epoch(), 0_u32..3, 0_u64..700).prop_map(|(e, s, seen)| drive(e, s, seen)),
        3 => (epoch(), 0_u32..3, 0_u64..700).prop_map(|(e, s, seen)| hold(e, s, seen)),
        1 => Just(Asked::Stop),
        1 => Just(Asked::EmergencyStop),
        3 => epoch().prop_map(|epoch| Asked::ResetEmergencyStop { epoch }),
    ]
}

fn any_input() -> impl Strategy<Value = Input> {
    let client = prop_oneof![4 => Just(A), 2 => Just(B), 1 => Just(WATCHER)];
    prop_oneof![
        20 => (client, any_asked()).prop_map(|(client, asked)| Input::Asks(client, asked)),
        1 => (1_u32..4).prop_map(Input::Gone),
        1 => any::<bool>().prop_map(Input::Robot),
        1 => Just(Input::Fault(DisarmReason::Bumper)),
        4 => Just(Input::Tick),
    ]
}

/// Makes most driving messages good ones: with the epoch of the lease, the next sequence, and seen not long ago.
fn likely(input: Input, lease: Option<u32>, sequence: u32, now: Duration) -> Input {
    let seen_at = |ago: u64| now.saturating_sub(at(ago));
    let epoch_of = |epoch: u32| {
        if epoch > 1 {
            lease.unwrap_or(epoch)
        } else {
            epoch
        }
    };
    let Input::Asks(client, asked) = input else {
        return input;
    };
    let asked = match asked {
        Asked::Arm { epoch } => Asked::Arm {
            epoch: epoch_of(epoch),
        },
        Asked::ResetEmergencyStop { epoch } => Asked::ResetEmergencyStop {
            epoch: epoch_of(epoch),
        },
        Asked::Drive {
            sequence: s,
            mut body,
        } => {
            body.epoch = epoch_of(body.epoch);
            body.seen = seen_at(body.seen / 1000).as_micros() as u64;
            Asked::Drive {
                sequence: sequence + s,
                body,
            }
        }
        Asked::Hold {
            sequence: s,
            epoch,
            seen,
            ttl,
        } => Asked::Hold {
            sequence: sequence + s,
            epoch: epoch_of(epoch),
            seen: seen_at(seen.as_millis() as u64),
            ttl,
        },
        other => other,
    };
    Input::Asks(client, asked)
}

/// What a bystander knows who sees inputs and outputs only.
#[derive(Default)]
struct Bystander {
    lease: Option<(ClientId, u32)>,
    highest_epoch: u32,
    is_armed: bool,
    is_emergency: bool,
    is_up: bool,
    /// When the robot was last told to run or go on, until it was told to stop.
    runs_since: Option<Duration>,
    sequence: u32,
    moves: u32,
}

impl Bystander {
    fn see(&mut self, now: Duration, input: Input, out: &[Output]) -> Result<(), TestCaseError> {
        if let Input::Robot(is_up) = input {
            self.is_up = is_up;
        }
        for output in out {
            self.output(now, input, output)?;
        }
        let is_good_hold = matches!(input, Input::Asks(_, Asked::Hold { .. })) && out.is_empty();
        if let Input::Asks(client, Asked::Arm { epoch }) = input
            && out.contains(&Output::Changed)
            && self.lease == Some((client.id, epoch))
        {
            self.is_armed = true;
        }
        if is_good_hold && self.runs_since.is_some() {
            self.runs_since = Some(now);
        }
        if let Some(since) = self.runs_since {
            prop_assert!(
                now < since + at(200),
                "it runs {:?} after its last message",
                now - since
            );
        }
        Ok(())
    }

    fn output(
        &mut self,
        now: Duration,
        input: Input,
        output: &Output,
    ) -> Result<(), TestCaseError> {
        match *output {
            Output::Order(Order::Command(Command::Stop)) => self.runs_since = None,
            Output::Order(Order::Command(_)) => {
                let Input::Asks(client, Asked::Drive { sequence, body }) = input else {
                    return Err(TestCaseError::fail(format!("{input:?} moved the robot")));
                };
                prop_assert_eq!(self.lease, Some((client.id, body.epoch)));
                prop_assert!(client.may_drive && self.is_armed && !self.is_emergency && self.is_up);
                prop_assert!(sequence > self.sequence);
                prop_assert!(now - Duration::from_micros(body.seen) <= at(300));
                self.sequence = sequence;
                self.runs_since = Some(now);
                self.moves += 1;
            }
            Output::Order(Order::EmergencyStop) => {
                (self.is_emergency, self.is_armed, self.runs_since) = (true, false, None);
            }
            Output::Order(Order::ResetEmergencyStop) => self.is_emergency = false,
            Output::Granted(client, lease) => {
                prop_assert!(lease.epoch > self.highest_epoch, "an epoch was used twice");
                prop_assert!(self.runs_since.is_none(), "taking over must stop first");
                (self.lease, self.highest_epoch) = (Some((client, lease.epoch)), lease.epoch);
                (self.sequence, self.is_armed) = (0, false);
            }
            _ => (),
        }
        Ok(())
    }

    /// What the rules say of themselves must be what the bystander saw.
    fn compare(&mut self, safety: &Safety) -> Result<(), TestCaseError> {
        self.is_armed &= safety.is_armed();
        prop_assert_eq!(self.is_armed, safety.is_armed());
        prop_assert_eq!(self.is_emergency, safety.is_emergency());
        let is_ready = safety.driver().is_some() && self.is_up && !self.is_emergency;
        prop_assert!(!safety.is_armed() || is_ready);
        prop_assert!(
            self.runs_since.is_none() || safety.is_armed(),
            "disarmed, and it runs"
        );
        if safety.driver().is_none() {
            self.lease = None;
        }
        Ok(())
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(1000))]

    #[test]
    fn in_any_order_of_things_nothing_moves_that_may_not(
        inputs in prop::collection::vec((any_input(), 0_u64..120), 1..120)
    ) {
        let mut safety = Safety::new(SafetyConfig::default());
        let mut bystander = Bystander::default();
        let mut now = at(0);
        for input in [Input::Robot(true), Input::Asks(A, Asked::Take { force: false }), Input::Asks(A, Asked::Arm { epoch: 1 })] {
            let out = safety.on(now, input);
            bystander.see(now, input, &out)?;
        }
        for (input, pause) in inputs {
            let until = now + at(pause);
            // As the hub does: what runs out before is dealt with when it does.
            while let Some(due) = safety.deadline().filter(|due| *due <= until) {
                now = now.max(due);
                let out = safety.on(now, Input::Tick);
                bystander.see(now, Input::Tick, &out)?;
                bystander.compare(&safety)?;
            }
            now = until;
            let input = likely(input, bystander.lease.map(|lease| lease.1), bystander.sequence, now);
            let out = safety.on(now, input);
            bystander.see(now, input, &out)?;
            bystander.compare(&safety)?;
        }
    }
}

/// The property above would hold as well if nothing ever moved.
#[test]
fn the_random_inputs_do_move_the_robot() {
    use proptest::strategy::ValueTree;
    use proptest::test_runner::TestRunner;
    let mut runner = TestRunner::deterministic();
    let mut moves = 0;
    for _ in 0..100 {
        let inputs = prop::collection::vec(any_input(), 60)
            .new_tree(&mut runner)
            .unwrap()
            .current();
        let mut safety = driven();
        let mut bystander = Bystander {
            lease: Some((A.id, 1)),
            highest_epoch: 1,
            is_armed: true,
            is_up: true,
            sequence: 1,
            ..Bystander::default()
        };
        for (millis, input) in inputs.into_iter().enumerate() {
            let now = at(millis as u64);
            let input = likely(
                input,
                bystander.lease.map(|lease| lease.1),
                bystander.sequence,
                now,
            );
            let out = safety.on(now, input);
            bystander.see(now, input, &out).unwrap();
            bystander.compare(&safety).unwrap();
        }
        moves += bystander.moves;
    }
    assert!(moves > 50, "{moves} moves in 100 runs");
}
