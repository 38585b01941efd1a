//! A geofence of the bridge's map, whose frame differs from the run's.

use super::*;
use crate::geom::{Length, PoseEstimate};
use crate::pilot::Failure;
use crate::wire::message::{FenceState, GeofenceBody, PoseState, ZoneUse};

/// The bridge's map began elsewhere, with another heading of the robot.
fn bridge_from_run() -> Pose2 {
    Pose2::new(7.0, -3.0, 2.2)
}

/// Reports where the robot is in the bridge's map.
fn tell_pose(bridge: &mut Bridge, live: &mut Live) {
    let estimate = PoseEstimate::exact(bridge_from_run() * truth(bridge));
    let body = PoseBody::new(bridge.robot.stamp().0, &estimate, PoseState::Localised);
    bridge.tell(live, &FromBridge::Pose(body));
}

/// A square around the run's origin, to stay in, in the bridge's map.
fn tell_fence(bridge: &mut Bridge, live: &mut Live, half: f64) {
    let corners = [(-half, -half), (half, -half), (half, half), (-half, half)];
    let corners = corners.map(|(x, y)| bridge_from_run() * Point2::new(x, y));
    let zone = ZoneBody {
        kind: ZoneUse::KeepIn,
        corners: corners.map(|at| [at.x, at.y]).to_vec(),
    };
    let (zones, state) = (vec![zone], FenceState::Within);
    let body = GeofenceBody { zones, state };
    bridge.tell(live, &FromBridge::Geofence(body));
}

/// The outcome for a goal, and where the robot stands then, in the run's map.
fn driven(goal: (f64, f64), half: f64) -> (Status, Point2<f64>) {
    let (mut bridge, mut live) = (Bridge::new(SensorModel::lidar()), live());
    bridge.greet(&mut live);
    bridge.hear(&mut live);
    live.take_lease(bridge.micros(), false);
    for _ in 0..20 {
        bridge.step(&mut live);
    }
    tell_pose(&mut bridge, &mut live);
    tell_fence(&mut bridge, &mut live, half);
    live.set_mode(Mode::GoTo(Point2::new(goal.0, goal.1)));
    for _ in 0..1000 {
        bridge.step(&mut live);
        tell_pose(&mut bridge, &mut live);
        if live.session().pilot().status().is_over() {
            break;
        }
    }
    let status = live.session().pilot().status().clone();
    (status, truth(&bridge).position())
}

#[test]
fn the_fence_of_the_bridges_map_holds_in_that_of_the_run() {
    let (status, at) = driven((0.7, 0.0), 0.5);
    let goal = Point2::new(0.7, 0.0);
    assert_eq!(status, Status::Failed(Failure::GoalOutside(goal)));
    assert!(at.coords.length() < 0.01, "{at}");
    let (status, at) = driven((0.7, 0.0), 1.2);
    assert!(matches!(status, Status::Finished(_)), "{status}");
    assert!((at - goal).length() < 0.1, "{at}");
}
