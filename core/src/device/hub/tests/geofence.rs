//! A hub that maps, with a geofence: who sets it, what it holds back, and what an unknown pose
//! means.

use super::*;
use crate::geom::PoseEstimate;
use crate::wire::message::{PoseBody, PoseState, ZoneUse};

/// A square around the origin, m.
fn square(half: f64) -> Vec<ZoneBody> {
    vec![ZoneBody {
        kind: ZoneUse::KeepIn,
        corners: vec![[-half, -half], [half, -half], [half, half], [-half, half]],
    }]
}

/// An armed robot in a hub that maps; it stands at the origin of the map, at 20 ms.
fn mapped() -> (Hub, ClientId) {
    let (mut hub, driver) = armed();
    hub.maps();
    hub.event(at(20), ROBOT, odometry(10, 20, 0.0));
    found(&mut hub, 20, 0.0, PoseState::Localised);
    actions(&mut hub);
    (hub, driver)
}

/// The mapper finds the robot at `x`, at `millis`.
fn found(hub: &mut Hub, millis: u64, x: f64, state: PoseState) {
    let estimate = PoseEstimate::exact(Pose2::new(x, 0.0, 0.0));
    hub.pose(at(millis), &PoseBody::new(1000 * millis, &estimate, state));
}

fn set(hub: &mut Hub, millis: u64, client: ClientId, zones: Vec<ZoneBody>) -> Vec<Action> {
    let now = at(millis);
    hub.message(now, now, client, header(9), ToBridge::SetGeofence { zones });
    actions(hub)
}

fn forwards(actions: &[Action]) -> Vec<f64> {
    let forward = |action: &Action| match action {
        Action::Order { order, .. } => match order {
            Order::Command(Command::Velocity { forward, .. }) => Some(*forward),
            Order::Command(Command::Stop) => Some(0.0),
            _ => None,
        },
        _ => None,
    };
    actions.iter().filter_map(forward).collect()
}

fn states(actions: &[Action]) -> Vec<FenceState> {
    let state = |action: &Action| match action {
        Action::SendAll(FromBridge::Geofence(body)) => Some(body.state),
        _ => None,
    };
    actions.iter().filter_map(state).collect()
}

fn says(actions: &[Action], words: &str) -> bool {
    actions.iter().any(|action| match action {
        Action::Send(_, FromBridge::Notice(notice))
        | Action::SendAll(FromBridge::Notice(notice)) => notice.text.contains(words),
        _ => false,
    })
}

/// Drives ahead at full speed from 30 ms on, with a robot that obeys at once, until it is ordered
/// to stop; returns how far it came, and all actions.
fn ahead(hub: &mut Hub, driver: ClientId) -> (f64, Vec<Action>) {
    let (mut x, mut speed, mut all) = (0.0, 0.0, vec![]);
    for step in 3..600 {
        let now = at(10 * step);
        x += 0.01 * speed;
        hub.event(now, ROBOT, odometry(10 * step - 10, 10 * step, speed));
        hub.event(now, LIDAR, far_walls(Stamp(10_000 * step)));
        if step % 20 == 0 {
            found(hub, 10 * step, x, PoseState::Localised);
        }
        if step % 5 == 0 {
            let velocity = Command::Velocity {
                forward: 0.25,
                turn: 0.0,
            };
            hub.message(
                now,
                now,
                driver,
                header(step as u32),
                drive(1, now, velocity),
            );
        }
        let done = actions(hub);
        speed = forwards(&done).last().copied().unwrap_or(speed);
        all.extend(done);
    }
    (x, all)
}

#[test]
fn a_robot_is_held_back_at_the_border_and_all_are_told_once() {
    let (mut hub, driver) = mapped();
    let owner = hub.join("owner".to_owned(), of_role(Role::Owner));
    let told = set(&mut hub, 21, owner, square(0.6));
    assert_eq!(states(&told), [FenceState::Within]);
    assert!(told.contains(&Action::KeepGeofence(owner, square(0.6))));
    let (x, all) = ahead(&mut hub, driver);
    let radius = RobotModel::rp6().radius();
    assert!((0.5 - radius..0.6 - radius).contains(&x), "{x}");
    assert!(hub.safety.is_armed(), "it may be driven back");
    assert_eq!(states(&all), [FenceState::Held]);
    assert!(says(&all, "The geofence holds the robot back"));
    // It drives back.
    let now = at(6010);
    let back = Command::Velocity {
        forward: -0.2,
        turn: 0.0,
    };
    hub.message(now, now, driver, header(700), drive(1, now, back));
    assert!(forwards(&actions(&mut hub))[0] < -0.15);
}

#[test]
fn without_a_fence_nothing_is_held_back() {
    let (mut hub, driver) = mapped();
    let (x, all) = ahead(&mut hub, driver);
    assert!(x > 1.0, "{x}");
    assert!(states(&all).is_empty());
}

#[test]
fn a_robot_that_is_found_outside_is_stopped_and_armed_again_goes_back_only() {
    let (mut hub, driver) = mapped();
    let owner = hub.join("owner".to_owned(), of_role(Role::Owner));
    set(&mut hub, 21, owner, square(0.6));
    let drives = |hub: &mut Hub, millis: u64, forward: f64| {
        let (now, turn) = (at(millis), 0.0);
        let velocity = Command::Velocity { forward, turn };
        let sequence = millis as u32;
        hub.message(now, now, driver, header(sequence), drive(1, now, velocity));
        actions(hub)
    };
    assert!(forwards(&drives(&mut hub, 30, 0.2))[0] > 0.1);
    // A loop closure moves the pose elsewhere.
    hub.event(at(40), ROBOT, odometry(20, 40, 0.2));
    found(&mut hub, 40, 0.9, PoseState::Localised);
    let all = actions(&mut hub);
    assert_eq!(states(&all), [FenceState::Outside]);
    assert!(!hub.safety.is_armed());
    assert_eq!(hub.safety.reason(), DisarmReason::Geofence);
    assert!(says(&all, "has left its geofence"));

    hub.message(
        at(50),
        at(50),
        driver,
        header(50),
        ToBridge::Arm { epoch: 1 },
    );
    assert!(hub.safety.is_armed());
    actions(&mut hub);
    assert_eq!(forwards(&drives(&mut hub, 60, 0.2)), [0.0]);
    assert!(forwards(&drives(&mut hub, 70, -0.2))[0] < -0.15);
    // Within again; it was last held back a second ago.
    let within = PoseEstimate::exact(Pose2::new(0.3, 0.0, 0.0));
    let body = PoseBody::new(40_000, &within, PoseState::Localised);
    hub.pose(at(1200), &body);
    assert_eq!(states(&actions(&mut hub)), [FenceState::Within]);
}

#[test]
fn a_pose_that_is_not_to_be_believed_or_too_old_lets_nothing_move_and_nobody_arm() {
    for lose in [PoseState::Lost, PoseState::Ambiguous, PoseState::Unplaced] {
        let (mut hub, driver) = mapped();
        let owner = hub.join("owner".to_owned(), of_role(Role::Owner));
        set(&mut hub, 21, owner, square(2.0));
        let ahead = Command::Velocity {
            forward: 0.2,
            turn: 0.0,
        };
        hub.message(at(30), at(30), driver, header(30), drive(1, at(30), ahead));
        actions(&mut hub);
        found(&mut hub, 30, 0.0, lose);
        let all = actions(&mut hub);
        assert_eq!(forwards(&all), [0.0], "{lose}");
        assert_eq!(states(&all), [FenceState::NoPose]);
        assert!(says(&all, "not known where it is"));
        // It may be armed again once its pose is known again, and not before.
        hub.message(at(40), at(40), driver, header(40), ToBridge::Stop);
        hub.message(
            at(50),
            at(50),
            driver,
            header(50),
            ToBridge::Arm { epoch: 1 },
        );
        let refused = Action::Send(driver, FromBridge::Refused(RefusalReason::NoPose));
        assert!(actions(&mut hub).contains(&refused));
        found(&mut hub, 20, 0.0, PoseState::Localised);
        hub.message(
            at(60),
            at(60),
            driver,
            header(60),
            ToBridge::Arm { epoch: 1 },
        );
        assert!(hub.safety.is_armed());
    }
    // The mapper falls silent: after two seconds of odometry the pose is too old.
    let (mut hub, _) = mapped();
    let owner = hub.join("owner".to_owned(), of_role(Role::Owner));
    set(&mut hub, 21, owner, square(2.0));
    let mut gone = None;
    for step in 3..300 {
        hub.event(
            at(10 * step),
            ROBOT,
            odometry(10 * step - 10, 10 * step, 0.0),
        );
        if states(&actions(&mut hub)) == [FenceState::NoPose] {
            gone = gone.or(Some(10 * step));
        }
    }
    assert!(matches!(gone, Some(2000..2100)), "{gone:?}");
}

#[test]
fn an_owner_sets_it_what_is_none_is_refused_and_a_driver_lifts_it_in_no_way() {
    let (mut hub, driver) = mapped();
    let watcher = hub.join("watcher".to_owned(), of_role(Role::Watcher));
    let owner = hub.join("owner".to_owned(), of_role(Role::Owner));
    set(&mut hub, 21, owner, square(2.0));
    let all = set(&mut hub, 22, watcher, vec![]);
    assert_eq!(all, [Action::Close(watcher, close::NO_RIGHT)]);
    // The driver goes on driving.
    let refused = Action::Send(driver, FromBridge::Refused(RefusalReason::NoRight));
    assert_eq!(set(&mut hub, 22, driver, vec![]), [refused]);
    // The fence would be lost with the map.
    hub.message(at(23), at(23), driver, header(23), ToBridge::ResetMap);
    let fenced = Action::Send(driver, FromBridge::Refused(RefusalReason::Fenced));
    assert_eq!(actions(&mut hub), [fenced]);
    hub.message(at(24), at(24), owner, header(24), ToBridge::ResetMap);
    assert_eq!(actions(&mut hub), [Action::ResetMap(owner)]);

    let mut bow_tie = square(2.0);
    bow_tie[0].corners.swap(0, 1);
    let all = set(&mut hub, 25, owner, bow_tie);
    assert!(says(&all, "cross each other"), "{all:?}");
    assert!(all.contains(&Action::Send(
        owner,
        FromBridge::Refused(RefusalReason::BadFence)
    )));
    // A client that joins later gets the fence in force.
    let late = hub.join("late".to_owned(), of_role(Role::Watcher));
    let body = GeofenceBody {
        zones: square(2.0),
        state: FenceState::Within,
    };
    assert!(actions(&mut hub).contains(&Action::Send(late, FromBridge::Geofence(body))));
    let off = set(&mut hub, 26, owner, vec![]);
    assert_eq!(states(&off), [FenceState::Off]);

    // A hub without a map has no fence.
    let (mut hub, _) = armed();
    let owner = hub.join("owner".to_owned(), of_role(Role::Owner));
    actions(&mut hub);
    let all = set(&mut hub, 20, owner, square(2.0));
    let no_map = Action::Send(owner, FromBridge::Refused(RefusalReason::NoMap));
    assert_eq!(all, [no_map]);
}
