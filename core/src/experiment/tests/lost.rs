//! A robot with nothing but sonars at smooth walls: the filter knows that it is lost, and the pilot
//! says so.

use super::*;
use crate::geom::Length;
use crate::pilot::Failure;

#[test]
fn a_sonar_alone_ends_as_lost() {
    let world = worlds::builtin("arena").unwrap();
    let robot = world.robot.model();
    let config = ExperimentConfig::new(world, robot, SensorKind::Sonar.model(), 1);
    let mut run = Experiment::new(config).unwrap();
    run.set_mode(Mode::Explore);
    while !run.session().status().is_over() && run.seconds() < 1500.0 {
        run.step().unwrap();
    }
    let said = run.session().status();
    let Status::Failed(Failure::Lost { sigma, .. }) = *said else {
        panic!("{said}");
    };
    // Its error is as large as it says, by the truth that only the simulation knows.
    let truth = run.truth();
    let off = (run.session().estimate().pose.position() - truth.position()).length();
    assert!(off < 3.0 * sigma, "{off} m off by σ = {sigma} m");
}
