//! The hub, alone and with events, messages and time in any order, against a bystander that sees
//! what goes in and comes out.

mod any_order;
mod geofence;

use std::time::Duration;

use nalgebra::Matrix3;

use super::*;
use crate::geom::Pose2;
use crate::robot::{Command, Odometry, RobotModel, Scan, Stamp};
use crate::wire::message::{
    BatteryBody, BumpersBody, DriveBody, LinkBody, LinkState, ManoeuvreBody, RefusalReason,
};

const ROBOT: u8 = 0;
const LIDAR: u8 = 1;

fn at(millis: u64) -> Duration {
    Duration::from_millis(millis)
}

fn profiles() -> [Profile; 2] {
    let robot = Profile {
        name: "rp6:test".to_owned(),
        robot: Some(RobotModel::rp6()),
        takes_orders: true,
        scans_on_command: false,
    };
    [robot, Profile::of_sensor("lidar:test")]
}

fn of_role(role: Role) -> Right {
    let name = String::new();
    Right { role, name }
}

fn hub() -> Hub {
    Hub::new(&profiles().each_ref())
}

fn actions(hub: &mut Hub) -> Vec<Action> {
    std::iter::from_fn(|| hub.next_action()).collect()
}

fn link(state: LinkState) -> SourceEvent {
    SourceEvent::Link(LinkBody::new(state))
}

/// A sweep that sees distant walls all around.
fn far_walls(stamp: Stamp) -> SourceEvent {
    let beams = 90;
    SourceEvent::Scan(Scan {
        stamp,
        robot_from_sensor: Pose2::identity(),
        bearings: (0..beams).map(|i| f64::from(i) * 0.0698).collect(),
        ranges: vec![4.0; beams as usize],
        sigmas: vec![0.01; beams as usize],
        bearing_sigma: 0.001,
        max_range: 6.0,
        sweep: 0.0,
        qualities: vec![],
    })
}

fn odometry(from: u64, to: u64, speed: f64) -> SourceEvent {
    SourceEvent::Odometry(Odometry {
        from: Stamp(1000 * from),
        to: Stamp(1000 * to),
        motion: Pose2::new(speed * 0.001 * (to - from) as f64, 0.0, 0.0),
        cov: Matrix3::zeros(),
    })
}

fn drive(epoch: u32, seen: Duration, motion: Command) -> ToBridge {
    ToBridge::Drive(DriveBody {
        epoch,
        seen: seen.as_micros() as u64,
        ttl_millis: 300,
        motion,
    })
}

fn header(sequence: u32) -> Header {
    Header {
        sequence,
        micros: 0,
    }
}

/// A robot that stands in the open and a client that has armed it, at 10 ms.
fn armed() -> (Hub, ClientId) {
    let mut hub = hub();
    let now = at(10);
    for (source, event) in [
        (ROBOT, link(LinkState::Up)),
        (ROBOT, odometry(0, 10, 0.0)),
        (LIDAR, far_walls(Stamp(10_000))),
    ] {
        hub.event(now, source, event);
    }
    let driver = hub.join("driver".to_owned(), of_role(Role::Driver));
    hub.message(now, now, driver, header(1), ToBridge::Take { force: false });
    hub.message(now, now, driver, header(2), ToBridge::Arm { epoch: 1 });
    assert!(hub.safety.is_armed());
    actions(&mut hub);
    (hub, driver)
}

fn manoeuvres(actions: &[Action]) -> Vec<(u32, bool)> {
    let manoeuvre = |action: &Action| match action {
        Action::Send(_, FromBridge::Manoeuvre(body))
        | Action::SendAll(FromBridge::Manoeuvre(body)) => Some((body.sequence, body.busy)),
        _ => None,
    };
    actions.iter().filter_map(manoeuvre).collect()
}

#[test]
fn a_client_learns_what_there_is_before_anything_else() {
    let (mut hub, _) = armed();
    let client = hub.join("late".to_owned(), of_role(Role::Watcher));
    let kinds: Vec<_> = actions(&mut hub)
        .into_iter()
        .map(|action| match action {
            Action::Send(to, message) if to == client => message,
            other => panic!("{other:?}"),
        })
        .collect();
    let [
        FromBridge::Welcome(welcome),
        FromBridge::Devices(devices),
        FromBridge::Safety(safety),
    ] = &kinds[..]
    else {
        panic!("{kinds:?}")
    };
    assert!(!welcome.may_drive && devices.len() == 2);
    assert!(safety.armed && safety.driver_name == "driver");
}

#[test]
fn heartbeats_come_each_second_and_ten_times_a_second_to_the_driver() {
    let (mut hub, driver) = armed();
    let watcher = hub.join("watcher".to_owned(), of_role(Role::Watcher));
    let mut counts = BTreeMap::new();
    for millis in (20..10_020).step_by(10) {
        let renew = ToBridge::Renew { epoch: 1 };
        hub.message(at(millis), at(millis), driver, header(0), renew.clone());
        hub.event(at(millis), ROBOT, odometry(millis - 10, millis, 0.0));
        hub.tick(at(millis));
        for action in actions(&mut hub) {
            if let Action::Send(client, FromBridge::Heartbeat(heartbeat)) = action {
                assert_eq!(heartbeat.robot_micros, 1000 * millis);
                *counts.entry(client).or_insert(0) += 1;
            }
        }
    }
    assert_eq!(counts[&watcher], 10);
    assert_eq!(counts[&driver], 110);
}

/// Only a robot that may move has faults: one that is carried about disarmed presses its bumpers,
/// and nobody needs to know.
#[test]
fn a_fault_counts_while_the_robot_is_armed() {
    let bump = |hub: &mut Hub| {
        for left in [false, true] {
            let bumpers = SourceEvent::Bumpers(BumpersBody {
                source: ROBOT,
                stamp: 20_000,
                left,
                right: false,
            });
            hub.event(at(20), ROBOT, bumpers);
        }
        actions(hub)
    };
    let is_notice = |action: &Action| matches!(action, Action::SendAll(FromBridge::Notice(_)));
    let (mut armed, _) = armed();
    let after = bump(&mut armed);
    assert!(!armed.safety.is_armed() && after.iter().any(is_notice));
    assert_eq!(armed.safety.reason(), DisarmReason::Bumper);
    let mut standing = hub();
    standing.event(at(10), ROBOT, link(LinkState::Up));
    let after = bump(&mut standing);
    assert!(!after.iter().any(is_notice), "{after:?}");
    assert_eq!(standing.safety.reason(), DisarmReason::Start);
}

#[test]
fn a_manoeuvre_is_over_when_the_robot_rests_after_its_order_and_not_before() {
    let (mut hub, driver) = armed();
    let turn = drive(1, at(10), Command::Turn(1.0));
    hub.message(at(20), at(20), driver, header(3), turn);
    let out = actions(&mut hub);
    assert_eq!(manoeuvres(&out), [(3, true)]);
    let ordered = out.iter().find_map(|action| match action {
        Action::Order { order, number, .. } if order.is_manoeuvre() => Some(*number),
        _ => None,
    });
    let after = ordered.unwrap();
    for (busy, after, expect) in [
        (false, after - 1, vec![]),
        (true, after, vec![]),
        (false, after, vec![(3, false)]),
        (false, after, vec![]),
    ] {
        hub.event(at(30), ROBOT, SourceEvent::Busy { busy, after });
        assert_eq!(manoeuvres(&actions(&mut hub)), expect);
    }
    // A lidar is not busy either, and that means nothing.
    hub.message(
        at(40),
        at(40),
        driver,
        header(4),
        drive(1, at(30), Command::Turn(1.0)),
    );
    let after = u64::MAX;
    hub.event(at(50), LIDAR, SourceEvent::Busy { busy: false, after });
    assert_eq!(manoeuvres(&actions(&mut hub)), [(4, true)]);
    hub.event(at(60), ROBOT, link(LinkState::Down));
    assert_eq!(manoeuvres(&actions(&mut hub)), [(4, false)]);
}

/// The manoeuvre under way goes on, and nobody else hears of the refused one.
#[test]
fn a_manoeuvre_that_is_refused_is_over_at_once() {
    let (mut hub, driver) = armed();
    hub.message(
        at(20),
        at(20),
        driver,
        header(3),
        drive(1, at(10), Command::Turn(1.0)),
    );
    actions(&mut hub);
    let stale = drive(9, at(20), Command::Turn(-1.0));
    hub.message(at(30), at(30), driver, header(4), stale);
    let refused = ManoeuvreBody {
        client: driver,
        sequence: 4,
        busy: false,
    };
    let expect = [
        Action::Send(driver, FromBridge::Refused(RefusalReason::StaleEpoch)),
        Action::Send(driver, FromBridge::Manoeuvre(refused)),
    ];
    assert_eq!(actions(&mut hub), expect);
    assert!(hub.manoeuvre.is_some());
}

#[test]
fn whoever_stands_at_the_machine_stops_the_robot_without_being_a_client() {
    for cut_off in [false, true] {
        let (mut hub, _) = armed();
        hub.stop(at(20), cut_off);
        assert!(!hub.safety.is_armed());
        assert_eq!(hub.safety.is_emergency(), cut_off);
        let order = match cut_off {
            true => Order::EmergencyStop,
            false => Order::Command(Command::Stop),
        };
        let is_it =
            |action: &Action| matches!(action, Action::Order { order: it, .. } if *it == order);
        assert!(actions(&mut hub).iter().any(is_it));
    }
}

#[test]
fn everybody_is_told_of_changes_only_and_an_arming_driver_in_any_case() {
    let (mut hub, driver) = armed();
    let watcher = hub.join("watcher".to_owned(), of_role(Role::Watcher));
    actions(&mut hub);
    let mut told = 0;
    for sequence in 1..400 {
        let now = at(20 + u64::from(sequence) / 10);
        let asked = match sequence % 3 {
            0 => ToBridge::EmergencyStop,
            _ => ToBridge::Stop,
        };
        hub.message(now, now, watcher, header(sequence), asked);
        let out = actions(&mut hub);
        told += out.len();
        if sequence == 1 {
            assert!(matches!(
                out[..],
                [Action::Order { .. }, Action::SendAll(FromBridge::Safety(_))]
            ));
        }
    }
    assert_eq!(told, 4, "a stop and an emergency stop, each told once");
    let now = at(100);
    let asks = [
        ToBridge::ResetEmergencyStop { epoch: 1 },
        ToBridge::Arm { epoch: 1 },
        ToBridge::Arm { epoch: 1 },
    ];
    for (sequence, asked) in (3..).zip(asks) {
        actions(&mut hub);
        hub.message(now, now, driver, header(sequence), asked);
    }
    let again = actions(&mut hub);
    assert!(
        matches!(&again[..], [Action::Send(to, FromBridge::Safety(state))] if *to == driver && state.armed),
        "{again:?}"
    );
}

#[test]
fn sensors_alone_get_no_orders() {
    let lidar = Profile::of_sensor("lidar:test");
    let mut hub = Hub::new(&[&lidar]);
    let client = hub.join("client".to_owned(), of_role(Role::Driver));
    hub.message(at(1), at(1), client, header(1), ToBridge::Stop);
    let is_order = |action: &Action| matches!(action, Action::Order { .. });
    assert!(!actions(&mut hub).iter().any(is_order));
}

fn refused(hub: &mut Hub) -> Option<RefusalReason> {
    actions(hub).into_iter().find_map(|action| match action {
        Action::Send(_, FromBridge::Refused(reason)) => Some(reason),
        _ => None,
    })
}

/// Takes the lease and arms; returns the reason if that is refused.
fn arm(hub: &mut Hub, now: Duration, client: ClientId) -> Option<RefusalReason> {
    actions(hub);
    let force = false;
    hub.message(now, now, client, header(1), ToBridge::Take { force });
    let mut taken = actions(hub).into_iter();
    let epoch = taken.find_map(|action| match action {
        Action::Send(_, FromBridge::Granted(lease)) => Some(lease.epoch),
        _ => None,
    });
    let epoch = epoch.unwrap_or_default();
    hub.message(now, now, client, header(2), ToBridge::Arm { epoch });
    refused(hub)
}

#[test]
fn a_part_of_the_bridge_arms_only_what_a_lost_link_disarmed() {
    let (mut hub, driver) = armed();
    let own = hub.join_own("bridge".to_owned(), of_role(Role::Driver));
    assert_eq!(hub.client_count(), 1);
    hub.leave(at(20), driver);
    assert_eq!(arm(&mut hub, at(30), own), None);
    assert!(hub.safety.is_armed());
    let watcher = hub.join("watcher".to_owned(), of_role(Role::Watcher));
    hub.message(at(40), at(40), watcher, header(1), ToBridge::Stop);
    // Its own lease runs out meanwhile, which does not undo a stop.
    hub.tick(at(3000));
    assert_eq!(hub.safety.reason(), DisarmReason::LeaseExpired);
    hub.event(at(3000), LIDAR, far_walls(Stamp(3_000_000)));
    assert_eq!(
        arm(&mut hub, at(3010), own),
        Some(RefusalReason::Stopped),
        "a person arms it again"
    );

    // Nor does it undo the stop when a driver leaves after it, although the reason then shows only
    // that.
    let driver = hub.join("driver".to_owned(), of_role(Role::Driver));
    let take = ToBridge::Take { force: true };
    hub.message(at(3020), at(3020), driver, header(1), take.clone());
    assert_eq!(arm(&mut hub, at(3030), driver), None);
    hub.message(at(3040), at(3040), watcher, header(3), ToBridge::Stop);
    hub.leave(at(3050), driver);
    assert_eq!(hub.safety.reason(), DisarmReason::DriverGone);
    assert_eq!(
        arm(&mut hub, at(3060), own),
        Some(RefusalReason::Stopped),
        "it stood already when the driver went"
    );

    // If a right is taken away, what was done by it ends.
    let driver = hub.join("driver".to_owned(), of_role(Role::Driver));
    hub.message(at(3070), at(3070), driver, header(1), take);
    assert_eq!(arm(&mut hub, at(3080), driver), None);
    hub.leave(at(3090), driver);
    assert_eq!(arm(&mut hub, at(3100), own), None);
    hub.give(at(3110), own, Role::Watcher);
    assert!(!hub.safety.is_armed() && hub.safety.driver().is_none());
}

#[test]
fn an_empty_battery_and_a_silent_lidar_keep_a_robot_from_being_armed() {
    let battery = |volts| {
        SourceEvent::Battery(BatteryBody {
            source: ROBOT,
            stamp: 0,
            volts,
        })
    };
    let (mut hub, driver) = armed();
    hub.message(at(20), at(20), driver, header(3), ToBridge::Stop);
    for millis in (100..=2500).step_by(100) {
        hub.event(at(millis), ROBOT, battery(5.5));
        hub.event(at(millis), LIDAR, far_walls(Stamp(1000 * millis)));
    }
    assert_eq!(
        arm(&mut hub, at(2510), driver),
        Some(RefusalReason::BatteryLow)
    );
    hub.event(at(2600), ROBOT, battery(7.2));
    assert_eq!(
        arm(&mut hub, at(4600), driver),
        Some(RefusalReason::NoScan),
        "the last one came 2.1 s ago"
    );
    hub.event(at(4700), LIDAR, far_walls(Stamp(4_700_000)));
    assert_eq!(arm(&mut hub, at(4710), driver), None);
    assert!(hub.safety.is_armed());
}
