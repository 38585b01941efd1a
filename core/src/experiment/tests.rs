//! The cycle: the same bits stage by stage, every stage in its turn, and every sensor that can scan
//! reaches its goal.

mod beside;
mod kidnap;
mod left;
mod link;
mod lost;
mod outline;
mod people;
mod refinding;
mod turning;

use nalgebra::Point2;

use super::*;
use crate::geom::Length;
use crate::pilot::{Stage, Status};
use crate::sim::{SensorKind, SensorModel, worlds};

fn in_cycle(world: &str, sensor: SensorKind, mode: Mode, seed: u64) -> Experiment {
    let world = worlds::builtin(world).unwrap();
    let robot = world.robot.model();
    let config = ExperimentConfig {
        mode,
        cycle: true,
        ..ExperimentConfig::new(world, robot, sensor.model(), seed)
    };
    Experiment::new(config).unwrap()
}

#[test]
fn stage_by_stage_is_the_same_run_to_the_bit() {
    for sensor in [SensorKind::Lidar, SensorKind::Rangers] {
        let goal = Mode::GoTo(Point2::new(2.0, 1.0));
        let mut by_stage = in_cycle("arena", sensor, goal, 3);
        let mut whole = in_cycle("arena", sensor, goal, 3);
        let mut stages = vec![];
        // Ten stages end in the middle of a period, with reports not shown yet; then it continues
        // without pausing.
        for _ in 0..10 {
            stages.extend(by_stage.next_stage().unwrap());
        }
        assert_eq!(stages.len(), 10, "{stages:?}");
        while whole.seconds() < by_stage.seconds() {
            whole.step().unwrap();
        }
        for _ in 0..400 {
            whole.step().unwrap();
        }
        while by_stage.seconds() < whole.seconds() {
            by_stage.step().unwrap();
        }
        assert_eq!(by_stage.state_hash(), whole.state_hash(), "{sensor:?}");
        assert_eq!(
            by_stage.record().samples().len(),
            whole.record().samples().len()
        );
    }
}

#[test]
fn stages_come_in_the_order_of_the_source() {
    let goal = Mode::GoTo(Point2::new(2.0, 1.0));
    let mut run = in_cycle("arena", SensorKind::Rangers, goal, 1);
    let first: Vec<Stage> = (0..6).map_while(|_| run.next_stage().unwrap()).collect();
    let expected = [
        Stage::Scan,
        Stage::Lines,
        Stage::Localise,
        Stage::Map,
        Stage::Plan,
        Stage::Truncate,
    ];
    assert_eq!(first, expected);
    assert!(run.session().pilot().stages().report(Stage::Init).is_some());
    let mut last = Stage::Truncate;
    for _ in 0..60 {
        let Some(stage) = run.next_stage().unwrap() else {
            break;
        };
        let follows = match stage {
            Stage::Init => false,
            // After a leg, after a turn that is followed by a scan, and if there is no path.
            Stage::Scan => matches!(last, Stage::Go | Stage::Turn | Stage::Plan),
            // A turn may need a second one.
            Stage::Turn => matches!(last, Stage::Truncate | Stage::Turn),
            Stage::Go => matches!(last, Stage::Truncate | Stage::Turn | Stage::Go),
            _ => stage.index() == last.index() + 1,
        };
        assert!(follows, "{stage:?} after {last:?}");
        last = stage;
    }
}

#[test]
fn a_lidar_that_is_heard_standing_only_reaches_its_goal() {
    for seed in 1..=3 {
        let goal = Point2::new(2.0, 1.0);
        let mut run = in_cycle("arena", SensorKind::Lidar, Mode::GoTo(goal), seed);
        let mut moving_scans = 0;
        while run.seconds() < 900.0 && !run.session().status().is_over() {
            let before = run.truth();
            if run.step().unwrap() {
                let way = before.delta_to(&run.truth());
                moving_scans += usize::from(way.position().coords.length() > 1e-3);
            }
        }
        assert!(
            matches!(run.session().status(), Status::Finished(_)),
            "{}",
            run.session().status()
        );
        assert!(
            (run.truth().position() - goal).length() < 0.15,
            "seed {seed}"
        );
        assert_eq!(
            (run.sim().contacts().total(), moving_scans),
            (0, 0),
            "seed {seed}"
        );
    }
}

#[test]
fn scans_of_a_standing_twin_show_the_noise_of_the_sensor_and_leave_the_run_alone() {
    use crate::points::{Growth, estimate_sigma};
    use crate::sim::sensors::LidarModel;
    let world = worlds::builtin("office").unwrap();
    // An error of the bearing adds to the range along a slanting wall.
    let lidar = SensorModel::Lidar(LidarModel {
        bearing_sigma: 0.0,
        ..LidarModel::default()
    });
    let config = ExperimentConfig::new(world.clone(), world.robot.model(), lidar, 4);
    let mut run = Experiment::new(config).unwrap();
    while run.seconds() < 5.0 {
        run.step().unwrap();
    }
    let before = run.state_hash();
    let scans = run.standing_scans(100);
    assert_eq!((scans.len(), run.state_hash()), (100, before));
    let fit = estimate_sigma(&[&scans], Growth::Linear).unwrap();
    let SensorModel::Lidar(lidar) = run.sim().sensor() else {
        panic!("not a lidar");
    };
    for range in [1.0, 3.0] {
        let (found, truth) = (fit.at(range), lidar.sigma_at(range));
        let terms = nalgebra::Vector2::new(1.0, range);
        let error = terms.dot(&(fit.cov * terms)).sqrt();
        assert!(
            (found - truth).abs() < 4.0 * error + 3e-4,
            "{range} m: {found} {truth}"
        );
    }
}
