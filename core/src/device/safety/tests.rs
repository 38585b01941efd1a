//! The rules, one by one.

mod any_order;

use std::time::Duration;

use crate::robot::Command;
use crate::wire::message::{DisarmReason, DriveBody, RefusalReason, Role, ToBridge, close};

use super::*;

const STOP: Output = Output::Order(Order::Command(Command::Stop));
const A: Client = Client {
    id: 1,
    role: Role::Driver,
};
const B: Client = Client {
    id: 2,
    role: Role::Driver,
};
const WATCHER: Client = Client {
    id: 3,
    role: Role::Watcher,
};
const OWNER: Client = Client {
    id: 4,
    role: Role::Owner,
};

fn at(millis: u64) -> Duration {
    Duration::from_millis(millis)
}

/// A message and its sequence, which counts for driving only.
#[derive(Clone, Debug)]
struct Asked(u32, ToBridge);

impl From<ToBridge> for Asked {
    fn from(message: ToBridge) -> Self {
        Self(0, message)
    }
}

fn drive(epoch: u32, sequence: u32, seen: u64) -> Asked {
    let body = DriveBody {
        epoch,
        seen: 1000 * seen,
        ttl_millis: 300,
        motion: RUN,
    };
    Asked(sequence, ToBridge::Drive(body))
}

const RUN: Command = Command::Velocity {
    forward: 0.2,
    turn: 0.0,
};

fn hold(epoch: u32, sequence: u32, seen: u64) -> Asked {
    let message = ToBridge::Hold {
        epoch,
        seen: 1000 * seen,
        ttl_millis: 300,
    };
    Asked(sequence, message)
}

/// The rules, with a robot whose link is up.
fn with_robot() -> Safety {
    let mut safety = Safety::default();
    safety.on(at(0), Input::Robot(true));
    safety
}

fn ask(safety: &mut Safety, millis: u64, client: Client, asked: impl Into<Asked>) -> Vec<Output> {
    let Asked(sequence, message) = asked.into();
    safety.on(at(millis), Input::Asks(client, sequence, message))
}

/// A is driving, at 0 ms, with epoch 1 and sequence 1.
fn driven() -> Safety {
    let mut safety = with_robot();
    ask(&mut safety, 0, A, ToBridge::Take { force: false });
    ask(&mut safety, 0, A, ToBridge::Arm { epoch: 1 });
    let out = ask(&mut safety, 0, A, drive(1, 1, 0));
    assert_eq!(out, [Output::Order(Order::Command(RUN))]);
    safety
}

fn refused(reason: RefusalReason) -> Vec<Output> {
    vec![Output::Refused(A.id, reason)]
}

#[test]
fn nothing_moves_before_it_is_armed() {
    let mut safety = with_robot();
    ask(&mut safety, 0, A, ToBridge::Take { force: false });
    let out = ask(&mut safety, 1, A, drive(1, 1, 0));
    assert_eq!(out, refused(RefusalReason::Disarmed));
    let mut without_robot = Safety::default();
    ask(&mut without_robot, 0, A, ToBridge::Take { force: false });
    let out = ask(&mut without_robot, 1, A, ToBridge::Arm { epoch: 1 });
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
    assert_eq!(out, [Output::Order(Order::Command(RUN))]);
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
            ask(&mut safety, 100, A, asked.clone()),
            refused(reason),
            "{asked:?}"
        );
    }
    // The sender allows 300 ms.
    assert_eq!(safety.on(at(200), Input::Tick), [STOP]);
    assert_eq!(
        ask(&mut safety, 301, A, drive(1, 2, 0)),
        refused(RefusalReason::TooOld)
    );
    assert_eq!(ask(&mut safety, 300, A, drive(1, 2, 0)).len(), 1);
    // Whatever the sender allows, 500 ms is the most.
    let Asked(sequence, ToBridge::Drive(mut body)) = drive(1, 3, 0) else {
        unreachable!()
    };
    body.ttl_millis = u16::MAX;
    let out = ask(&mut safety, 501, A, Asked(sequence, ToBridge::Drive(body)));
    assert_eq!(out, [STOP, Output::Refused(A.id, RefusalReason::TooOld)]);
}

#[test]
fn taking_over_stops_first_and_needs_force() {
    let mut safety = driven();
    let out = ask(&mut safety, 10, B, ToBridge::Take { force: false });
    assert_eq!(out, [Output::Refused(B.id, RefusalReason::Held)]);
    let out = ask(&mut safety, 20, B, ToBridge::Take { force: true });
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
    ask(&mut safety, 0, A, ToBridge::Take { force: false });
    ask(&mut safety, 1500, A, ToBridge::Renew { epoch: 1 });
    assert_eq!(safety.on(at(3499), Input::Tick), []);
    assert_eq!(safety.on(at(3500), Input::Tick), [STOP, Output::Changed]);
    assert_eq!(
        (safety.driver(), safety.reason()),
        (None, DisarmReason::LeaseExpired)
    );
    let out = ask(&mut safety, 3501, A, ToBridge::Renew { epoch: 1 });
    assert_eq!(out, refused(RefusalReason::StaleEpoch));
}

#[test]
fn everybody_may_stop_and_a_watcher_nothing_else() {
    let mut safety = driven();
    for asked in [
        ToBridge::Take { force: true }.into(),
        ToBridge::Renew { epoch: 1 }.into(),
        ToBridge::Release { epoch: 1 }.into(),
        ToBridge::Arm { epoch: 1 }.into(),
        drive(1, 9, 0),
        hold(1, 9, 0),
        ToBridge::ResetEmergencyStop { epoch: 1 }.into(),
        ToBridge::ResetMap.into(),
    ] {
        let out = ask(&mut safety, 1, WATCHER, asked.clone());
        assert_eq!(
            out,
            [Output::Close(WATCHER.id, close::NO_RIGHT)],
            "{asked:?}"
        );
    }
    assert!(safety.is_armed());
    assert_eq!(
        ask(&mut safety, 2, WATCHER, ToBridge::Stop),
        [STOP, Output::Changed]
    );
    assert_eq!(
        (safety.is_armed(), safety.reason()),
        (false, DisarmReason::Stop)
    );
    assert_eq!(safety.driver(), Some(A.id), "the lease stays where it is");
}

/// A client that sent hundreds at once made the bridge tell everyone hundreds of times, until it
/// closed all connections, the driver's too.
#[test]
fn a_stop_that_changes_nothing_is_passed_over_for_a_while() {
    let (stop, cut_off) = (ToBridge::Stop, ToBridge::EmergencyStop);
    let emergency = Output::Order(Order::EmergencyStop);
    let mut safety = driven();
    assert_eq!(
        ask(&mut safety, 10, WATCHER, stop.clone()),
        [STOP, Output::Changed]
    );
    for millis in 10..110 {
        assert_eq!(ask(&mut safety, millis, WATCHER, stop.clone()), []);
        assert_eq!(ask(&mut safety, millis, B, stop.clone()), []);
    }
    // The sender may see that the robot still runs.
    assert_eq!(
        ask(&mut safety, 110, B, stop.clone()),
        [STOP, Output::Changed]
    );
    // A stop that changes something never waits.
    assert_eq!(
        ask(&mut safety, 111, WATCHER, cut_off.clone()),
        [emergency, Output::Changed]
    );
    assert_eq!(ask(&mut safety, 112, WATCHER, cut_off), []);
    assert_eq!(ask(&mut safety, 113, WATCHER, stop.clone()), []);
    ask(
        &mut safety,
        114,
        A,
        ToBridge::ResetEmergencyStop { epoch: 1 },
    );
    ask(&mut safety, 115, A, ToBridge::Arm { epoch: 1 });
    assert!(safety.is_armed());
    assert_eq!(
        ask(&mut safety, 115, WATCHER, stop),
        [STOP, Output::Changed],
        "the first after it was armed"
    );
}

#[test]
fn the_emergency_stop_is_latched_and_its_reset_moves_nothing() {
    let mut safety = driven();
    let emergency = Output::Order(Order::EmergencyStop);
    assert_eq!(
        ask(&mut safety, 1, WATCHER, ToBridge::EmergencyStop),
        [emergency, Output::Changed]
    );
    assert_eq!(
        ask(&mut safety, 2, A, ToBridge::Arm { epoch: 1 }),
        refused(RefusalReason::Emergency)
    );
    assert_eq!(
        ask(&mut safety, 3, A, drive(1, 2, 3)),
        refused(RefusalReason::Emergency)
    );
    // A robot that was reset meanwhile gets the emergency stop again.
    safety.on(at(4), Input::Robot(false));
    // A reset would not reach it.
    assert_eq!(
        ask(&mut safety, 4, A, ToBridge::ResetEmergencyStop { epoch: 1 }),
        refused(RefusalReason::NoRobot)
    );
    assert!(safety.is_emergency());
    assert!(safety.on(at(5), Input::Robot(true)).contains(&emergency));
    let out = ask(&mut safety, 6, A, ToBridge::ResetEmergencyStop { epoch: 1 });
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
fn a_robot_that_comes_for_the_first_time_was_not_lost() {
    let mut safety = Safety::default();
    for (is_up, reason) in [
        (true, DisarmReason::Start),
        (false, DisarmReason::Link),
        (true, DisarmReason::Link),
    ] {
        // It is ordered to stop all the same.
        assert!(safety.on(at(1), Input::Robot(is_up)).contains(&STOP));
        assert_eq!(safety.reason(), reason);
    }
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
            Input::Asks(A, 0, ToBridge::Release { epoch: 1 }),
            DisarmReason::Released,
        ),
    ] {
        let mut safety = driven();
        let out = safety.on(at(10), input.clone());
        assert_eq!(out, [STOP, Output::Changed], "{input:?}");
        assert_eq!(
            (safety.is_armed(), safety.reason()),
            (false, reason),
            "{input:?}"
        );
    }
    let mut safety = driven();
    let ask = |message| Input::Asks(A, 0, message);
    let _ = safety.on(at(10), ask(ToBridge::Stop));
    let _ = safety.on(at(20), ask(ToBridge::Release { epoch: 1 }));
    assert_eq!(
        safety.reason(),
        DisarmReason::Stop,
        "it stood already when the lease was given back"
    );
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
    let Asked(sequence, ToBridge::Drive(mut body)) = drive(1, 2, 0) else {
        unreachable!()
    };
    for motion in [
        Command::Forward(f64::NAN),
        Command::Turn(f64::INFINITY),
        Command::Velocity {
            forward: 0.0,
            turn: f64::NAN,
        },
    ] {
        body.motion = motion;
        let out = ask(&mut safety, 1, A, Asked(sequence, ToBridge::Drive(body)));
        assert_eq!(out, refused(RefusalReason::NotFinite));
    }
}

#[test]
fn an_owner_takes_from_anybody_and_nobody_else_from_an_owner() {
    let force = || ToBridge::Take { force: true };
    let mut safety = driven();
    let out = ask(&mut safety, 10, OWNER, ToBridge::Take { force: false });
    assert_eq!(out, [Output::Refused(OWNER.id, RefusalReason::Held)]);
    ask(&mut safety, 20, OWNER, force());
    assert_eq!(safety.driver(), Some(OWNER.id));
    let out = ask(&mut safety, 30, A, force());
    assert_eq!(out, refused(RefusalReason::Held));
    assert_eq!(safety.driver(), Some(OWNER.id));
    // Among drivers, anyone may take it, as before.
    let mut safety = driven();
    ask(&mut safety, 10, B, force());
    assert_eq!(safety.driver(), Some(B.id));
}

#[test]
fn a_right_that_is_taken_away_stops_the_robot_and_ends_the_lease() {
    let mut safety = driven();
    assert_eq!(safety.on(at(10), Input::Revoked(B.id)), []);
    assert!(safety.is_armed());
    let out = safety.on(at(20), Input::Revoked(A.id));
    assert_eq!(out, [STOP, Output::Changed]);
    assert_eq!(safety.driver(), None);
    assert_eq!(safety.reason(), DisarmReason::Revoked);
    let out = ask(&mut safety, 30, A, drive(1, 2, 20));
    assert_eq!(out, refused(RefusalReason::StaleEpoch));
}

/// Every role and every message, written out a second time by hand.
#[test]
fn each_role_may_do_what_the_table_says_and_nothing_else() {
    let Asked(_, driving) = drive(1, 1, 0);
    let Asked(_, holding) = hold(1, 1, 0);
    let anyone = [
        ToBridge::Heartbeat,
        ToBridge::Probe { token: 1 },
        ToBridge::Stop,
        ToBridge::EmergencyStop,
    ];
    let drivers = [
        ToBridge::Take { force: true },
        ToBridge::Renew { epoch: 1 },
        ToBridge::Release { epoch: 1 },
        ToBridge::Arm { epoch: 1 },
        driving,
        holding,
        ToBridge::ResetEmergencyStop { epoch: 1 },
        ToBridge::ResetMap,
    ];
    let all = (anyone.iter().map(|message| (message, true)))
        .chain(drivers.iter().map(|message| (message, false)));
    for (message, is_for_all) in all {
        for client in [WATCHER, A, OWNER] {
            let out = ask(&mut with_robot(), 0, client, message.clone());
            let is_shown_out = out.contains(&Output::Close(client.id, close::NO_RIGHT));
            let may = is_for_all || client.role != Role::Watcher;
            assert_eq!(is_shown_out, !may, "{:?}: {message:?}", client.role);
        }
    }
}
