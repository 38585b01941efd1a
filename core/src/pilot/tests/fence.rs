//! Errands within a geofence: the toy robot obeys every command of the pilot, so only plans keep it
//! in.

use super::*;
use crate::geom::geofence::{Geofence, Zone, ZoneKind};

fn fence(kind: ZoneKind, corners: &[(f64, f64)]) -> Geofence {
    let corners = corners.iter().map(|&(x, y)| Point2::new(x, y)).collect();
    Geofence::new(vec![Zone { kind, corners }]).unwrap()
}

/// Runs an errand in `toy`; returns how near the robot's disc came to the border of the fence.
fn least(toy: &mut Toy, pilot: &mut Pilot, fence: &Geofence, seconds: f64) -> f64 {
    let mut least = f64::INFINITY;
    while toy.stamp().seconds() < seconds && !pilot.status().is_over() {
        toy.run(pilot, toy.stamp().seconds() + TICK);
        least = least.min(fence.clearance(toy.pose.position()));
    }
    least - toy.model.radius()
}

/// In an open hall the straight way leads through a keep-out zone.
#[test]
fn a_way_leads_around_what_is_to_be_kept_out_of() {
    let goal = Point2::new(4.0, 0.0);
    let carpet = [(1.5, -1.0), (2.5, -1.0), (2.5, 0.4), (1.5, 0.4)];
    let carpet = fence(ZoneKind::KeepOut, &carpet);
    for seed in 0..4 {
        for is_fenced in [false, true] {
            let hall = room(-1.0, -2.0, 6.0, 4.0);
            let mut toy = Toy::new(hall, Pose2::identity(), RobotModel::rp6());
            let mut pilot = pilot(toy.model, Mode::GoTo(goal), seed);
            if is_fenced {
                pilot.set_fence(carpet.clone());
            }
            let least = least(&mut toy, &mut pilot, &carpet, 120.0);
            let said = pilot.status().to_string();
            assert_eq!(said, "goal reached", "seed {seed}");
            assert_eq!(least > 0.0, is_fenced, "seed {seed}: {least}");
        }
    }
}

#[test]
fn a_goal_outside_of_the_fence_is_refused_and_so_is_a_robot_that_stands_outside() {
    let near = [(-0.9, -0.9), (2.0, -0.9), (2.0, 2.0), (-0.9, 2.0)];
    let near = fence(ZoneKind::KeepIn, &near);
    let check = |start: (f64, f64), goal: (f64, f64), expect: Failure| {
        let start = Pose2::new(start.0, start.1, 0.0);
        let mut toy = Toy::new(flat(), start, RobotModel::rp6());
        let mode = Mode::GoTo(Point2::new(goal.0, goal.1));
        let mut pilot = pilot(toy.model, mode, 1);
        pilot.set_fence(near.clone());
        toy.run(&mut pilot, 5.0);
        assert_eq!(*pilot.status(), Status::Failed(expect));
        assert!(toy.driven < 1e-9);
    };
    let goal = Point2::new(0.0, 4.0);
    check((0.0, 0.0), (0.0, 4.0), Failure::GoalOutside(goal));
    let at = Point2::new(2.4, 0.0);
    check((2.4, 0.0), (0.0, 0.0), Failure::Outside(at));
}

/// The flat's second room and its corridor stay unknown, and are not reported as unreachable.
#[test]
fn exploring_keeps_to_the_fence_and_calls_what_lies_beyond_no_failure() {
    let first_room = [(-1.0, -1.0), (3.0, -1.0), (3.0, 2.9), (-1.0, 2.9)];
    let first_room = fence(ZoneKind::KeepIn, &first_room);
    for seed in 0..4 {
        let start = Pose2::new(0.0, 0.0, seed as f64);
        let mut toy = Toy::new(flat(), start, RobotModel::rp6());
        let mut pilot = pilot(toy.model, Mode::Explore, seed);
        pilot.set_fence(first_room.clone());
        let least = least(&mut toy, &mut pilot, &first_room, 300.0);
        assert!(least > 0.0, "seed {seed}: {least}");
        let Status::Finished(Finish::Explored { unreached, .. }) = pilot.status() else {
            panic!("seed {seed}: {}", pilot.status());
        };
        let is_beyond = |at: &Point2<f64>| first_room.clearance(*at) < 0.0;
        assert!(
            !unreached.iter().any(is_beyond),
            "seed {seed}: {unreached:?}"
        );
    }
}

#[test]
fn a_fence_that_is_drawn_across_the_way_makes_it_be_planned_again() {
    let goal = Point2::new(4.0, 0.0);
    let hall = room(-1.0, -2.0, 6.0, 4.0);
    let mut toy = Toy::new(hall, Pose2::identity(), RobotModel::rp6());
    let mut pilot = pilot(toy.model, Mode::GoTo(goal), 1);
    toy.run(&mut pilot, 2.0);
    assert_eq!(*pilot.status(), Status::Driving);
    let carpet = [(1.8, -1.0), (2.5, -1.0), (2.5, 0.4), (1.8, 0.4)];
    let carpet = fence(ZoneKind::KeepOut, &carpet);
    pilot.set_fence(carpet.clone());
    let least = least(&mut toy, &mut pilot, &carpet, 120.0);
    assert_eq!(pilot.status().to_string(), "goal reached");
    assert!(least > 0.0, "{least}");
}
