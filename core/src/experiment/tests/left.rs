//! A run that continues where the robot was left: it is localised there only if it really stands
//! there.

use std::sync::Arc;

use super::*;
use crate::estimation::{SavedMap, ScanMatcher, Start};
use crate::geom::{Length, Pose2};
use crate::sim::{Mover, World};
use crate::slam::Method;

/// A run by scan matching that nobody drives.
fn mapping(world: &World, sensor: SensorKind, seed: u64) -> Experiment {
    let robot = world.robot.model();
    let config = ExperimentConfig {
        method: Method::ScanMatching,
        mode: Mode::Manual,
        ..ExperimentConfig::new(world.clone(), robot, sensor.model(), seed)
    };
    Experiment::new(config).unwrap()
}

fn matcher(run: &Experiment) -> &ScanMatcher {
    run.session().slam().view().map.unwrap()
}

/// The map of a robot that drove this far ahead, stopped there and was left, and where it stands.
fn left_after(way: f64, world: &World, sensor: SensorKind, seed: u64) -> (Arc<SavedMap>, Pose2) {
    let mut run = mapping(world, sensor, seed);
    let begun = run.sim().truth();
    let gone = |run: &Experiment| (run.sim().truth().position() - begun.position()).length();
    while run.seconds() < 60.0 && gone(&run) < way {
        run.drive(0.3, 0.0);
        run.step().unwrap();
    }
    run.stop();
    let stopped = run.seconds();
    while run.seconds() < stopped + 2.0 {
        run.step().unwrap();
    }
    let map = matcher(&run).saved(vec![]);
    (Arc::new(map), run.sim().truth())
}

/// How the run continues for some seconds, for a robot that now stands at `place`.
fn goes_on(
    map: &Arc<SavedMap>,
    place: Pose2,
    world: &World,
    sensor: SensorKind,
    seed: u64,
) -> Experiment {
    let world = World {
        start: place,
        ..world.clone()
    };
    let mut run = mapping(&world, sensor, seed);
    run.go_on_in(crate::slam::EarlierMap {
        map: Arc::clone(map),
        start: Start::Left,
    })
    .unwrap();
    while run.seconds() < 2.0 {
        run.step().unwrap();
    }
    run
}

/// How far off the pose is, m.
fn off(run: &Experiment, begin: Pose2) -> f64 {
    let truth = begin.delta_to(&run.sim().truth());
    let estimate = run.session().estimate().pose;
    (estimate.position() - truth.position()).length()
}

const WORLDS: [&str; 4] = ["office", "corridor", "warehouse", "lab"];

/// It was taken to stand where it was left, or as near as the match pulls it in: the walls along
/// its path agree wherever it is.
#[test]
fn a_robot_that_was_carried_along_its_way_is_not_said_to_stand_where_it_was_left() {
    for name in WORLDS {
        let world = worlds::builtin(name).unwrap();
        let (map, left) = left_after(1.5, &world, SensorKind::Lidar, 1);
        let back = |way: f64| left * Pose2::new(-way, 0.0, 0.0);
        for place in [world.start, back(1.5), back(1.0), back(0.5), back(0.3)] {
            let run = goes_on(&map, place, &world, SensorKind::Lidar, 2);
            let (is_placed, off) = (matcher(&run).is_placed(), off(&run, world.start));
            assert!(!is_placed || off < 0.05, "{name}, {place:?}: {off}");
        }
    }
}

#[test]
fn a_robot_that_stands_where_it_was_left_goes_on_at_once() {
    for name in WORLDS {
        let world = worlds::builtin(name).unwrap();
        let (map, left) = left_after(1.5, &world, SensorKind::Lidar, 1);
        let mut peopled = world.clone();
        let standing = |place: Pose2| Mover {
            waypoints: vec![left * place.position()],
            closed: false,
            speed: 0.0,
            radius: 0.25,
            pause: 1000.0,
        };
        peopled.movers.push(standing(Pose2::new(1.1, 0.2, 0.0)));
        for (who, world) in [("alone", &world), ("with somebody", &peopled)] {
            let run = goes_on(&map, left, world, SensorKind::Lidar, 2);
            assert!(matcher(&run).is_placed(), "{name}, {who}");
            let off = off(&run, world.start);
            assert!(off < 0.05, "{name}, {who}: {off}");
        }
    }
}
