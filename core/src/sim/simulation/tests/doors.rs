//! Doors that open and shut, seen and driven through.

use nalgebra::Point2;

use super::*;
use crate::robot::OdometryNoise;
use crate::sim::{Door, reachable_area};

/// A room of 6 m x 2 m, divided at x = 3 by a wall with a door of 1 m in it; the robot stands in
/// the left half and faces right.
fn parted(is_open: bool, switches: &[f64]) -> World {
    let mut world = World::new("parted", Pose2::new(1.0, 1.0, 0.0))
        .with_room(&[(0.0, 0.0), (6.0, 0.0), (6.0, 2.0), (0.0, 2.0)])
        .with_walls(&[(3.0, 0.0), (3.0, 0.5)])
        .with_walls(&[(3.0, 1.5), (3.0, 2.0)]);
    world.doors.push(Door {
        leaf: Segment::new(Point2::new(3.0, 0.5), Point2::new(3.0, 1.5)),
        is_open,
        switches: switches.to_vec(),
    });
    world
}

fn run(world: World) -> Simulation {
    // Tracks that neither slip nor are worn: it drives straight ahead.
    let robot = RobotModel {
        odometry_bias: OdometryBias::default(),
        odometry_noise: OdometryNoise {
            per_metre: 0.0,
            lateral_per_metre: 0.0,
            heading_per_radian: 0.0,
        },
        ..RobotModel::rp6()
    };
    Simulation::new(world, robot, SensorModel::lidar(), 1).unwrap()
}

fn range_ahead(sim: &Simulation) -> f64 {
    let ahead = nalgebra::Vector2::new(1.0, 0.0);
    let hit = sim.caster().cast(Point2::new(1.0, 1.0), ahead, 10.0);
    hit.map_or(f64::INFINITY, |hit| hit.distance)
}

#[test]
fn a_door_moves_at_its_times_and_on_order() {
    let mut sim = run(parted(false, &[2.0, 4.0]));
    for (until, open, range) in [(1.9, false, 2.0), (2.1, true, 5.0), (4.1, false, 2.0)] {
        sim.advance(until - sim.stamp().seconds());
        assert_eq!(sim.doors_open().collect::<Vec<_>>(), [open], "{until} s");
        assert!((range_ahead(&sim) - range).abs() < 1e-9, "{until} s");
    }
    sim.set_door(0, true).unwrap();
    sim.advance(TIME_STEP);
    assert!((range_ahead(&sim) - 5.0).abs() < 1e-9);
    let error = sim.set_door(7, true).unwrap_err().to_string();
    assert_eq!(error, "there is no door 7; the world has 1");
}

#[test]
fn a_shut_door_stops_the_robot_and_an_open_one_lets_it_through() {
    for (open, through) in [(false, false), (true, true)] {
        let mut sim = run(parted(open, &[]));
        sim.command(Command::Velocity {
            forward: 0.3,
            turn: 0.0,
        });
        sim.advance(12.0);
        assert_eq!(sim.truth().x() > 3.2, through, "{:?}", sim.truth());
        assert_eq!(sim.contacts().walls > 0, !through);
    }
}

#[test]
fn a_door_waits_for_who_stands_in_it() {
    let mut sim = run(parted(true, &[7.0]));
    sim.command(Command::Forward(2.0));
    sim.advance(9.0);
    assert!((sim.truth().x() - 3.0).abs() < 0.1, "{:?}", sim.truth());
    assert!(sim.doors_open().all(|open| open));
    sim.command(Command::Forward(0.5));
    sim.advance(4.0);
    assert!(sim.doors_open().all(|open| !open));
    assert_eq!(sim.contacts().total(), 0);
}

#[test]
fn what_lies_behind_a_door_counts_if_it_ever_opens() {
    let area =
        |world: &World| reachable_area(world, 0.11, 0.05).centres().count() as f64 * 0.05 * 0.05;
    let never = area(&parted(false, &[]));
    let later = area(&parted(false, &[100.0]));
    assert!((later - area(&parted(true, &[]))).abs() < 1e-9);
    assert!(
        (5.0..6.0).contains(&never) && later > 10.0,
        "{never} {later}"
    );
}

#[test]
fn bad_doors_are_named() {
    let said = |world: World| {
        let robot = RobotModel::rp6();
        let error = Simulation::new(world, robot, SensorModel::lidar(), 1).unwrap_err();
        error.to_string()
    };
    assert!(said(parted(true, &[2.0, 1.0])).contains("door 0: switch is 1, expected rising times"));
    assert!(said(parted(true, &[f64::NAN])).contains("door 0: switch is NaN"));
    let mut world = parted(false, &[]);
    world.start = Pose2::new(2.95, 1.0, 0.0);
    assert!(said(world).contains("stands in door 0"));
    let mut world = parted(true, &[]);
    world.doors[0].leaf.b = world.doors[0].leaf.a;
    assert!(said(world).contains("door 0: width is 0"));
}
