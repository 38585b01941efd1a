//! A robot that is told where the walls are.

use nalgebra::Point2;

use super::*;
use crate::estimation::KnownLine;
use crate::experiment::{Experiment, ExperimentConfig};
use crate::format::building;
use crate::format::map_server::{self, MapImage, MapMode, OccupancyMap};
use crate::geom::Segment;
use crate::sim::{SensorModel, worlds};

/// A configuration with which every method can begin.
pub(super) fn config() -> SlamConfig {
    let wall = Segment::new(Point2::new(2.0, -1.0), Point2::new(2.0, 1.0));
    SlamConfig {
        known: KnownMap {
            lines: KnownLine::both_faces(&wall),
            ..KnownMap::default()
        },
        ..SlamConfig::default()
    }
}

/// Greatest error of the pose on a drive through `doors`, m, and that of the wheels alone.
fn drive(known: KnownMap, seconds: f64) -> (f64, f64, Experiment) {
    let world = worlds::builtin("doors").unwrap();
    let robot = world.robot.model();
    let mut config = ExperimentConfig::new(world, robot, SensorModel::lidar(), 5);
    config.method = Method::KnownMap;
    config.slam.known = known;
    let mut experiment = Experiment::new(config).unwrap();
    while experiment.seconds() < seconds && !experiment.status().is_over() {
        experiment.step().unwrap();
    }
    let samples = experiment.record().samples();
    let most = |errors: &mut dyn Iterator<Item = f64>| errors.fold(0.0, f64::max);
    let error = most(
        &mut samples
            .iter()
            .map(|s| (s.estimate.pose.position() - s.truth.position()).norm()),
    );
    let wheels = most(
        &mut samples
            .iter()
            .map(|s| (s.odometry.position() - s.truth.position()).norm()),
    );
    (error, wheels, experiment)
}

#[test]
fn a_robot_that_knows_the_walls_knows_where_it_is() {
    let (error, wheels, _) = drive(KnownMap::default(), 120.0);
    assert!(wheels > 0.2, "the wheels alone are off by {wheels}");
    assert!(error < 0.06, "{error}");
}

#[test]
fn a_map_that_was_saved_is_a_map_to_be_found_in() {
    // Drawn by a robot that knew the walls, written and read as files of map_server.
    let (_, _, first) = drive(KnownMap::default(), 120.0);
    let map = OccupancyMap::of_grid(first.slam().grid(), MapMode::Trinary).unwrap();
    let files = map_server::write(&map, MapMode::Trinary, MapImage::Png, "map.png").unwrap();
    let map = map_server::read(files.yaml.as_bytes(), &files.image).unwrap();
    let outlines = building::walls_of_map(&map).unwrap();
    let lines: Vec<KnownLine> = building::sides(&outlines)
        .filter_map(|side| KnownLine::left_face(&side))
        .collect();
    let (error, wheels, _) = drive(
        KnownMap {
            lines,
            sigma: map.resolution / 3.0,
        },
        120.0,
    );
    // Cells are 5 cm, and the greatest error is that of a moment in which few walls are in sight.
    assert!(wheels > 0.2 && error < 0.2, "{error} against {wheels}");
}

#[test]
fn without_a_map_there_is_nothing_to_be_found_in() {
    let error = Slam::new(Method::KnownMap, SlamConfig::default()).unwrap_err();
    assert_eq!(error, SlamError::NoKnownMap);
}
