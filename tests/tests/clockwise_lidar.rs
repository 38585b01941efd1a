//! Real lidars turn clockwise: their bearings fall while time rises. Everything that takes scans
//! must handle that.
//!
//! Mirrored, a lidar that turns counter-clockwise turns clockwise. So a mirrored run of the
//! simulated robot (y, angles and turns change sign, the order in time does not) is a run with a
//! real lidar in the mirrored world, and must be estimated as well as the run itself.
#![cfg(not(target_family = "wasm"))] // nothing here depends on the platform
#![allow(missing_docs)] // a test binary has no public interface
#![allow(clippy::unwrap_used)] // helpers of tests, which clippy does not count as tests

use nalgebra::Matrix3;
use slamlab_core::geom::Pose2;
use slamlab_core::robot::{Command, Odometry, RobotModel, Scan};
use slamlab_core::sim::{SensorModel, Simulation, worlds};
use slamlab_core::slam::{Method, Slam, SlamConfig};

fn mirrored_pose(pose: &Pose2) -> Pose2 {
    Pose2::new(pose.x(), -pose.y(), -pose.heading())
}

fn mirrored_odometry(odometry: &Odometry) -> Odometry {
    let mirror = Matrix3::from_diagonal(&[1.0, -1.0, -1.0].into());
    Odometry {
        motion: mirrored_pose(&odometry.motion),
        cov: mirror * odometry.cov * mirror,
        ..*odometry
    }
}

fn mirrored_scan(scan: &Scan) -> Scan {
    Scan {
        robot_from_sensor: mirrored_pose(&scan.robot_from_sensor),
        bearings: scan.bearings.iter().map(|bearing| -bearing).collect(),
        ..scan.clone()
    }
}

/// Drives around in `arena` for a minute; returns the errors of the last poses, in the original run
/// and in the mirrored one, m.
fn errors(method: Method) -> [f64; 2] {
    let world = worlds::builtin("arena").unwrap();
    let map_from_world = world.start.inverse();
    let mut sim = Simulation::new(world, RobotModel::rp6(), SensorModel::lidar(), 4).unwrap();
    let mut slams = [(); 2].map(|()| Slam::new(method, SlamConfig::default()).unwrap());
    for reading in 0..6000_u32 {
        if reading % 5 == 0 {
            sim.command(away_from_walls(&sim));
        }
        sim.advance(0.01);
        let odometry = sim.odometry();
        slams[0].odometry(&odometry).unwrap();
        slams[1].odometry(&mirrored_odometry(&odometry)).unwrap();
        if let Some(scan) = sim.take_scan() {
            slams[0].scan(&scan).unwrap();
            slams[1].scan(&mirrored_scan(&scan)).unwrap();
        }
    }
    let truth = map_from_world * sim.truth();
    let error =
        |slam: &Slam, truth: &Pose2| (slam.estimate().pose.position() - truth.position()).norm();
    [
        error(&slams[0], &truth),
        error(&slams[1], &mirrored_pose(&truth)),
    ]
}

fn away_from_walls(sim: &Simulation) -> Command {
    let ahead = sim.truth() * nalgebra::Point2::new(0.3, 0.0);
    let is_free = sim.caster().clearance(ahead, 0.25) >= 0.25;
    Command::Velocity {
        forward: if is_free { 0.2 } else { 0.0 },
        turn: if is_free { 0.3 } else { 0.8 },
    }
}

#[test]
fn a_clockwise_lidar_is_as_good_as_a_counter_clockwise_one() {
    for method in [Method::LineEkf, Method::ScanMatching] {
        let [as_it_is, clockwise] = errors(method);
        println!("{method:?}: {as_it_is:.4} m counter-clockwise, {clockwise:.4} m clockwise");
        assert!(as_it_is < 0.06, "{method:?}: {as_it_is} m");
        assert!(clockwise < 0.06, "{method:?}: {clockwise} m");
    }
}
