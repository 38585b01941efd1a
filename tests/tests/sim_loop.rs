//! Whole runs in the simulated worlds, judged by the truth that only the simulation knows.
//!
//! Few seeds, so that the suite stays quick; `--example simulate` runs any others.
#![cfg(not(target_family = "wasm"))]
#![allow(missing_docs, clippy::unwrap_used)] // a test binary has no public interface, and failing is its trade

use slamlab_core::experiment::{Experiment, ExperimentConfig, Figures};
use slamlab_core::geom::Pose2;
use slamlab_core::pilot::{Mode, Status};
use slamlab_core::points::{PointConfig, Points};
use slamlab_core::robot::RobotModel;
use slamlab_core::sim::{SensorKind, SensorModel, Simulation, World, reachable_area, worlds};

/// Simulated seconds after which an errand counts as endless.
const ENDLESS: f64 = 1800.0;

/// Runs the errand to its end.
fn run(world: &World, sensor: SensorModel, mode: Mode, seed: u64) -> (Experiment, Figures) {
    let robot = RobotModel::rp6();
    let area = reachable_area(world, robot.radius(), 0.05);
    let config = ExperimentConfig {
        mode,
        ..ExperimentConfig::new(world.clone(), robot, sensor, seed)
    };
    let mut experiment = Experiment::new(config).unwrap();
    while !experiment.session().status().is_over() && experiment.seconds() < ENDLESS {
        experiment.step().unwrap();
    }
    let figures = experiment.figures(&area);
    (experiment, figures)
}

fn lidar_explores(name: &str, seed: u64) {
    let world = worlds::builtin(name).unwrap();
    let (experiment, figures) = run(&world, SensorModel::lidar(), Mode::Explore, seed);
    let said = format!(
        "{name}, seed {seed}: {}, {figures:?}",
        experiment.session().status()
    );
    assert!(
        matches!(experiment.session().status(), Status::Finished(_)),
        "{said}"
    );
    assert!(figures.explored_fraction > 0.98, "{said}");
    assert_eq!(figures.contacts.total(), 0, "{said}");
    assert!(figures.position_error < 0.10, "{said}");
    assert!(figures.heading_error.to_degrees() < 2.0, "{said}");
    // The mean of a single run scatters widely around 3: beyond this, the filter is broken.
    assert!(figures.nees_mean.is_some_and(|n| n < 8.0), "{said}");
}

#[test]
fn lidar_explores_the_arena_to_its_end() {
    lidar_explores("arena", 1);
}

#[test]
fn lidar_explores_rooms_with_doors_to_their_end() {
    lidar_explores("doors", 1);
}

/// A regression: walls 2 m apart, seen at flat angles from 12 m, leaked while each sweep was placed
/// by odometry alone. New frontiers appeared for ever, and the robot still drove to and fro after
/// an hour.
#[test]
fn lidar_explores_a_bare_corridor_to_its_end() {
    lidar_explores("corridor", 1);
}

/// A regression, as in the corridor; and later the exploration ended with half of the ring unknown,
/// because a frontier behind a corner had been the target too often before the robot saw it.
#[test]
fn lidar_explores_a_ring_to_its_end() {
    lidar_explores("loop", 7);
}

#[test]
fn rangers_bring_the_robot_near_its_goal() {
    let world = worlds::builtin("arena").unwrap();
    let goal = world.start.inverse() * world.goal.unwrap();
    let mut nees = vec![];
    for seed in 1..=4 {
        let (experiment, figures) = run(&world, SensorModel::rangers(), Mode::GoTo(goal), seed);
        let off = (experiment.truth().position() - goal).norm();
        let said = format!(
            "seed {seed}: {}, {off:.3} m off",
            experiment.session().status()
        );
        assert!(
            matches!(experiment.session().status(), Status::Finished(_)),
            "{said}"
        );
        // Of 120 errands the worst ended 0.37 m off; whether the robot knows its error is checked
        // by the NEES.
        assert!(off < 0.40, "{said}");
        assert_eq!(figures.contacts.total(), 0, "{said}");
        nees.extend(figures.nees_mean);
    }
    let mean = nees.iter().sum::<f64>() / nees.len() as f64;
    assert!(mean > 0.5 && mean < 6.0, "mean NEES {mean}, 3 is honest");
}

/// A SICK that sees nothing reports its greatest range: that is free space, not a wall.
#[test]
fn greatest_range_of_a_sick_is_no_wall() {
    let mut world = worlds::builtin("corridor").unwrap();
    world.start = Pose2::new(1.0, 1.0, 0.0);
    let mut sim = Simulation::new(world, RobotModel::rp6(), SensorKind::Sick.model(), 3).unwrap();
    sim.advance(1.0);
    let scan = sim.take_scan().unwrap();
    let points = Points::from_scan(&scan, &Pose2::identity(), &PointConfig::default());
    let far: Vec<_> = points.beams.iter().filter(|b| b.range >= 20.0).collect();
    assert!(!far.is_empty() && far.iter().all(|b| !b.is_hit), "{far:?}");
}
