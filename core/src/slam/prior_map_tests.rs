//! A robot that knows where the walls are.

use nalgebra::Point2;

use super::*;
use crate::experiment::{Experiment, ExperimentConfig};
use crate::format::building::BuildingFile;
use crate::format::map_server::{self, MapImage, MapMode, OccupancyMap};
use crate::geom::{Length, Segment};
use crate::sim::{SensorModel, worlds};

/// A configuration with which every method can begin.
pub(super) fn config() -> SlamConfig {
    let wall = Segment::new(Point2::new(2.0, -1.0), Point2::new(2.0, 1.0));
    SlamConfig {
        prior_map: PriorMap::of_walls([wall].into_iter(), &Pose2::identity()),
        ..SlamConfig::default()
    }
}

/// Greatest error of the pose on a drive through `doors`, m, and that of dead reckoning.
fn drive(known: PriorMap, seconds: f64) -> (f64, f64, Experiment) {
    drive_by(PriorMapMatching::default(), known, seconds)
}

fn drive_by(by: PriorMapMatching, known: PriorMap, seconds: f64) -> (f64, f64, Experiment) {
    let world = worlds::builtin("doors").unwrap();
    let robot = world.robot.model();
    let mut config = ExperimentConfig::new(world, robot, SensorModel::lidar(), 5);
    config.method = Method::PriorMap;
    config.slam.prior_map = known;
    config.slam.prior_map_matching = by;
    let mut experiment = Experiment::new(config).unwrap();
    while experiment.seconds() < seconds && !experiment.session().status().is_over() {
        experiment.step().unwrap();
    }
    let samples = experiment.record().samples();
    let most = |errors: &mut dyn Iterator<Item = f64>| errors.fold(0.0, f64::max);
    let error = most(
        &mut samples
            .iter()
            .map(|s| (s.estimate.pose.position() - s.truth.position()).length()),
    );
    let wheels = most(
        &mut samples
            .iter()
            .map(|s| (s.odometry.position() - s.truth.position()).length()),
    );
    (error, wheels, experiment)
}

#[test]
fn a_robot_that_knows_the_walls_knows_where_it_is() {
    for by in [PriorMapMatching::Lines, PriorMapMatching::Surfaces] {
        let (error, wheels, experiment) = drive_by(by, PriorMap::default(), 120.0);
        assert!(wheels > 0.2, "the wheels alone are off by {wheels}");
        assert!(error < 0.06, "{by:?}: {error}");
        // 3 is honest; a turning lidar's uncertainty of the heading counts.
        let nees = experiment.record().nees_mean().unwrap();
        assert!((1.0..6.0).contains(&nees), "{by:?}: {nees}");
    }
}

#[test]
fn a_map_that_was_saved_is_a_map_to_be_found_in() {
    // Drawn by a robot that knew the walls, written and read as map_server files.
    let (_, _, first) = drive(PriorMap::default(), 120.0);
    let map = OccupancyMap::of_grid(first.session().slam().grid(), MapMode::Trinary).unwrap();
    let files = map_server::write(&map, MapMode::Trinary, MapImage::Png, "map.png").unwrap();
    let map = map_server::read(files.yaml.as_bytes(), &files.image).unwrap();
    let walls = BuildingFile::Map(map).prior_walls().unwrap();
    let known = PriorMap::of_faces(&walls.faces, walls.sigma, &Pose2::identity());
    let (error, wheels, _) = drive(known, 120.0);
    // Cells are 5 cm, and the greatest error occurs at a moment with few walls in sight. With walls
    // at the fronts of their cells it was 8 cm.
    assert!(wheels > 0.2 && error < 0.04, "{error} against {wheels}");
}

/// The walls of a world as in a file with another origin: the robot begins there at
/// `file_from_robot`.
fn in_another_frame(world: &str, file_from_robot: &Pose2) -> PriorMap {
    let world = worlds::builtin(world).unwrap();
    let file_from_world = *file_from_robot * world.start.inverse();
    let both = |s: Segment| [s, Segment::new(s.b, s.a)];
    let walls = world.walls();
    let walls = walls.iter().flat_map(|wall| both(wall.segment));
    let faces: Vec<Segment> = walls.map(|s| file_from_world * s).collect();
    PriorMap::of_faces(&faces, 0.01, file_from_robot)
}

#[test]
fn where_the_origin_of_the_file_lies_does_not_matter() {
    let (error, _, experiment) = drive(
        in_another_frame("doors", &Pose2::new(-37.0, 21.0, 2.3)),
        60.0,
    );
    assert!(error < 0.06, "{error}");
    let fit = experiment.session().slam().view().prior_map_fit.unwrap();
    assert!(fit.part().unwrap() > 0.8 && !fit.is_misfit(), "{fit:?}");
}

#[test]
fn a_start_that_is_roughly_known_becomes_exact() {
    // The stated start is wrong: by 15 cm and 4 degrees.
    let truth = Pose2::new(3.0, -2.0, 0.5);
    let said = truth * Pose2::new(0.12, -0.09, 0.07);
    let mut known = in_another_frame("doors", &truth);
    let exact = PriorMap::of_faces(&[], 0.01, &said);
    let to = said.inverse() * truth;
    for face in &mut known.faces {
        *face = to * *face;
    }
    known = PriorMap {
        start_sigmas: [0.1, 0.05],
        faces: known.faces,
        ..exact
    };
    let (_, _, experiment) = drive(known, 60.0);
    // The map frame begins at the stated start, but the robot was elsewhere.
    let truth_in_map = to * experiment.truth();
    let off = (experiment.session().estimate().pose.position() - truth_in_map.position()).length();
    assert!(off < 0.05, "{off}");
    assert!(
        !experiment
            .session()
            .slam()
            .view()
            .prior_map_fit
            .unwrap()
            .is_misfit()
    );
}

#[test]
fn a_map_of_another_building_or_place_does_not_fit() {
    let office = in_another_frame("office", &worlds::builtin("office").unwrap().start);
    let start = worlds::builtin("doors").unwrap().start;
    let mut elsewhere = in_another_frame("doors", &start);
    let by = Pose2::new(1.3, 0.8, 0.6);
    for face in &mut elsewhere.faces {
        *face = by * *face;
    }
    let fit = |by, known: &PriorMap| {
        let (_, _, experiment) = drive_by(by, known.clone(), 20.0);
        experiment
            .session()
            .slam()
            .view()
            .prior_map_fit
            .unwrap()
            .clone()
    };
    for (by, known) in [
        (PriorMapMatching::Lines, &office),
        (PriorMapMatching::Surfaces, &office),
        (PriorMapMatching::Lines, &elsewhere),
    ] {
        let fit = fit(by, known);
        assert!(fit.is_misfit(), "{by:?}: {:?}", fit.part());
    }
    // Whole scans find the robot's place in the right map.
    let found = fit(PriorMapMatching::Surfaces, &elsewhere);
    assert!(!found.is_misfit(), "{:?}", found.part());
    let plain = Slam::new(Method::LineEkf, config()).unwrap();
    assert!(plain.view().prior_map_fit.is_none());
}

#[test]
fn without_a_map_there_is_nothing_to_be_found_in() {
    let error = Slam::new(Method::PriorMap, SlamConfig::default()).unwrap_err();
    assert_eq!(error, SlamError::NoPriorMap);
}
