//! A person who holds a key down touches nothing.
#![cfg(not(target_family = "wasm"))]
#![allow(missing_docs, clippy::unwrap_used)] // a test binary has no public interface, and failing is its trade

use slamlab_core::experiment::{Experiment, ExperimentConfig};
use slamlab_core::pilot::Mode;
use slamlab_core::robot::RobotModel;
use slamlab_core::sim::{SensorModel, worlds};

/// Explores for some steps, then drives by hand for a long time, straight and in curves, at full
/// speed.
fn contacts_by_hand(world: &str, explored_steps: usize) -> u32 {
    let world = worlds::builtin(world).expect("a built-in world");
    let robot = RobotModel::rp6();
    let config = ExperimentConfig {
        mode: Mode::Explore,
        ..ExperimentConfig::new(world, robot, SensorModel::lidar(), 7)
    };
    let mut experiment = Experiment::new(config).expect("a good setup");
    let run = |experiment: &mut Experiment, steps: usize| {
        for _ in 0..steps {
            experiment.step().expect("a good scan");
        }
    };
    run(&mut experiment, explored_steps);
    for (forward, turn) in [
        (1.0, 0.0),
        (-1.0, 0.0),
        (1.0, 1.0),
        (1.0, 0.0),
        (-1.0, -0.5),
        (-1.0, 0.0),
    ] {
        experiment.drive(forward * robot.max_speed, turn * robot.max_turn_rate);
        run(&mut experiment, 300);
        experiment.drive(0.0, 0.0);
        run(&mut experiment, 20);
    }
    experiment.sim().contacts().total()
}

#[test]
fn full_speed_by_hand_never_touches_a_wall() {
    for world in ["arena", "office", "doors"] {
        for explored_steps in [0, 20, 40, 100, 300] {
            assert_eq!(
                contacts_by_hand(world, explored_steps),
                0,
                "{world}, by hand after {explored_steps} steps"
            );
        }
    }
}
