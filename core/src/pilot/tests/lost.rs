//! A lost robot ends its errand; one that soon knows its pose again does not.

use super::*;

/// Explores the flat with the position uncertainty that `sigma` gives at each second.
fn explored(sigma: impl Fn(f64) -> f64) -> (Toy, Pilot) {
    explored_by(sigma, false)
}

fn explored_by(sigma: impl Fn(f64) -> f64, drives_unsure: bool) -> (Toy, Pilot) {
    let mut toy = Toy::new(flat(), Pose2::identity(), RobotModel::rp6());
    let mut pilot = pilot(toy.model, Mode::Explore, 1);
    while toy.stamp().seconds() < 60.0 && !pilot.status().is_over() {
        let sigma = sigma(toy.stamp().seconds());
        let mut cov = Matrix3::identity() * 1e-6;
        cov[(1, 1)] = sigma * sigma;
        let estimate = PoseEstimate {
            pose: toy.pose,
            cov,
        };
        let situation = Situation {
            drives_unsure,
            ..toy.situation(&estimate)
        };
        let command = pilot.steer(&situation);
        toy.step(command);
    }
    (toy, pilot)
}

fn is_lost(pilot: &Pilot) -> bool {
    matches!(pilot.status(), Status::Failed(Failure::Lost { .. }))
}

#[test]
fn a_place_that_stays_unsure_ends_the_errand_in_words_and_the_robot_stands() {
    let (mut toy, mut pilot) = explored(|at| if at < 5.0 { 0.05 } else { 1.5 });
    assert!(is_lost(&pilot), "{}", pilot.status());
    let PilotConfig { lost_after, .. } = PilotConfig::default();
    let at = toy.stamp().seconds();
    assert!((at - 5.0 - lost_after).abs() < 0.2, "{at}");
    let said = pilot.status().to_string();
    assert!(
        said.starts_with("lost: for 20 s it has known where it is to 1.5 m only"),
        "{said}"
    );
    let estimate = PoseEstimate {
        pose: toy.pose,
        cov: Matrix3::identity() * 2.25,
    };
    let command = pilot.steer(&toy.situation(&estimate));
    assert_eq!(command, Some(Command::Stop));
    // People may drive it to where it recognises the walls.
    pilot.drive(0.1, 0.0);
    toy.run(&mut pilot, at + 1.0);
    assert_eq!(*pilot.status(), Status::Driving);
}

#[test]
fn no_number_is_unsure_and_a_doubt_that_passes_is_none() {
    let (_, pilot) = explored(|_| f64::NAN);
    assert!(is_lost(&pilot), "{}", pilot.status());
    // A method that searches for the robot needs it to drive.
    let (_, pilot) = explored_by(|_| 9.0, true);
    assert!(!is_lost(&pilot), "{}", pilot.status());
    // A loop closes every 15 s.
    let (_, pilot) = explored(|at| if at % 15.0 < 13.0 { 1.5 } else { 0.1 });
    assert!(!is_lost(&pilot), "{}", pilot.status());
}

#[test]
fn far_from_where_the_map_began_a_robot_is_not_lost_in_the_map_around_it() {
    let mut toy = Toy::new(flat(), Pose2::identity(), RobotModel::rp6());
    let mut pilot = pilot(toy.model, Mode::Explore, 1);
    while toy.stamp().seconds() < 60.0 && !pilot.status().is_over() {
        let estimate = PoseEstimate {
            pose: toy.pose,
            cov: Matrix3::identity() * 9.0,
        };
        let situation = Situation {
            known_in_map: Matrix3::identity() * 1e-6,
            ..toy.situation(&estimate)
        };
        let command = pilot.steer(&situation);
        toy.step(command);
    }
    assert!(!is_lost(&pilot), "{}", pilot.status());
}
