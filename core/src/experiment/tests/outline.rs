//! A long robot drives where the disc around it does not fit, and touches nothing.

use super::*;
use crate::pilot::{Failure, Finish};
use crate::plan::{NoPath, Planner};
use crate::robot::{BodyShape, RobotModel};
use crate::sim::World;

/// Two rooms of 3 m by 3 m with a door of 46 cm between them; the robot is 50 cm long and 30 cm
/// wide, the disc around it 58 cm.
fn to_the_other_room(shape: BodyShape, seed: u64) -> Experiment {
    let world = World::new("two rooms", Pose2::new(1.0, 0.8, 0.4))
        .with_room(&[(0.0, 0.0), (6.0, 0.0), (6.0, 3.0), (0.0, 3.0)])
        .with_walls(&[(3.0, 0.0), (3.0, 1.27)])
        .with_walls(&[(3.0, 1.73), (3.0, 3.0)]);
    let robot = RobotModel {
        length: 0.5,
        width: 0.3,
        shape,
        ..RobotModel::rp6()
    };
    let goal = world.start.inverse() * Point2::new(4.8, 2.2);
    let config = ExperimentConfig {
        mode: Mode::GoTo(goal),
        ..ExperimentConfig::new(world, robot, SensorKind::Lidar.model(), seed)
    };
    Experiment::new(config).unwrap()
}

#[test]
fn a_door_that_the_disc_does_not_pass_is_passed_by_the_outline() {
    for seed in 1..=8 {
        let mut run = to_the_other_room(BodyShape::Rectangle, seed);
        let mut by_outline = false;
        while !run.session().status().is_over() && run.seconds() < 180.0 {
            run.step().unwrap();
            by_outline |= matches!(run.session().pilot().route(), Some(route) if route.by == Planner::Outline);
        }
        let (said, truth) = (run.session().status().to_string(), run.sim().truth());
        assert!(
            matches!(
                run.session().status(),
                Status::Finished(Finish::GoalReached { .. })
            ),
            "seed {seed}: {said} at {truth:?}"
        );
        assert!(by_outline && truth.x() > 4.0, "seed {seed}: {truth:?}");
        assert_eq!(run.sim().contacts().total(), 0, "seed {seed}");
    }
}

#[test]
fn the_disc_says_that_no_way_leads_there() {
    let mut run = to_the_other_room(BodyShape::Disc, 1);
    while !run.session().status().is_over() && run.seconds() < 180.0 {
        run.step().unwrap();
    }
    let said = run.session().status();
    let is_proved = matches!(
        said,
        Status::Failed(Failure::NoPath(NoPath::Unreachable { .. }))
    );
    assert!(is_proved, "{said}");
    assert_eq!(run.sim().contacts().total(), 0);
}
