//! Four rangers among people: the robot sees them while it drives.

use super::*;
use crate::geom::Pose2;
use crate::sim::{Mover, World};

/// A hall of 6 by 4 m in which somebody walks to and fro across the path of a robot that drives
/// from one end to the other.
#[test]
fn a_robot_with_rangers_does_not_drive_into_who_crosses_its_way() {
    let hall = [(0.0, 0.0), (6.0, 0.0), (6.0, 4.0), (0.0, 4.0)];
    let mut world = World::new("hall", Pose2::new(0.7, 2.0, 0.0)).with_room(&hall);
    world.movers = vec![Mover {
        waypoints: vec![Point2::new(2.9, 0.5), Point2::new(2.9, 3.5)],
        closed: true,
        speed: 0.8,
        radius: 0.22,
        pause: 4.0,
    }];
    let (mut ended, mut stopped) = (0, 0);
    for seed in 0..4 {
        let robot = world.robot.model();
        let sensor = SensorKind::Rangers.model();
        let mut config = ExperimentConfig::new(world.clone(), robot, sensor, seed);
        config.mode = Mode::GoTo(Point2::new(4.4, 0.0));
        let mut run = Experiment::new(config).unwrap();
        while !run.session().status().is_over() && run.seconds() < 900.0 {
            run.step().unwrap();
            stopped += i32::from(!run.session().slam().walkers().is_empty());
        }
        let contacts = run.sim().contacts();
        assert_eq!(
            (contacts.walls, contacts.drove_into_mover),
            (0, 0),
            "seed {seed}"
        );
        ended += i32::from(run.session().status().is_over());
    }
    assert!(stopped > 0, "nobody was ever seen on the move");
    assert!(ended >= 3, "only {ended} of 4 arrived");
}
