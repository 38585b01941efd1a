//! The same run gives the same bits natively and in the browser: this file runs in both.
//!
//! Each run is compared with one number: the hash of its whole final state. When the algorithms
//! change, so do the numbers. `tests/same_run.sh` writes the new native ones into `same_run.txt`;
//! the browser must then agree.
#![allow(missing_docs, clippy::unwrap_used)] // a test binary has no public interface, and failing is its trade

use slamlab_core::experiment::{Experiment, ExperimentConfig, Link};
use slamlab_core::format::carmen::CarmenLog;
use slamlab_core::hash::StateHash;
use slamlab_core::replay::{Log, Replay};
use slamlab_core::robot::RobotModel;
use slamlab_core::sim::{SensorKind, worlds};
use slamlab_core::slam::Method;
use slamlab_tests::recorded_loop::recorded_loop;
#[cfg(target_family = "wasm")]
use wasm_bindgen_test::wasm_bindgen_test as test;

#[cfg(target_family = "wasm")]
wasm_bindgen_test::wasm_bindgen_test_configure!(run_in_dedicated_worker);

/// The state at the end of each run, as `same_run.txt` holds it.
const EXPECTED: &str = include_str!("same_run.txt");

fn check(run: &str, found: u64) {
    let found = format!("{run} {found:016x}");
    assert!(
        EXPECTED.lines().any(|line| line == found),
        "the run ends in another state; if it was meant to change, write this line into same_run.txt: {found}"
    );
}

/// 20 s of simulated time.
const STEPS: usize = 400;

fn explore(world: &str, sensor: SensorKind, method: Method) -> Experiment {
    let world = worlds::builtin(world).unwrap();
    let mut config = ExperimentConfig::new(world, RobotModel::rp6(), sensor.model(), 7);
    config.method = method;
    let mut experiment = Experiment::new(config).unwrap();
    for _ in 0..STEPS {
        experiment.step().unwrap();
    }
    experiment
}

#[test]
fn exploring_by_lidar_with_the_line_filter_is_the_same_run_everywhere() {
    let run = explore("arena", SensorKind::Lidar, Method::LineEkf);
    check("lidar-line-ekf", run.state_hash());
}

#[test]
fn exploring_by_lidar_with_scan_matching_is_the_same_run_everywhere() {
    let run = explore("office", SensorKind::Lidar, Method::ScanMatching);
    check("lidar-scan-matching", run.state_hash());
}

/// The page made the link, from a run in a world that it was given as a file; `link.test.ts`
/// follows it there.
#[test]
fn a_run_in_a_drawn_world_is_done_again_by_its_link_everywhere() {
    let link = Link::read(include_str!("../drawn_link.txt")).unwrap();
    let (config, _) = link.config().unwrap();
    assert_eq!(config.world.name, "Studio & hall");
    let mut run = Experiment::new(config).unwrap();
    run.follow(link.actions);
    let (until, hash) = link.result.unwrap();
    while run.periods() < until {
        run.step().unwrap();
    }
    assert_eq!(format!("{:016x}", run.state_hash()), format!("{hash:016x}"));
}

#[test]
fn exploring_by_rangers_is_the_same_run_everywhere() {
    let run = explore("arena", SensorKind::Rangers, Method::LineEkf);
    check("rangers-line-ekf", run.state_hash());
}

#[test]
fn a_recording_of_a_loop_gives_the_same_way_and_map_everywhere() {
    let log = CarmenLog::parse(recorded_loop().as_bytes()).unwrap();
    let log = Log::from(log);
    let mut replay = Replay::new(log.clone(), Method::ScanMatching, &log.settings()).unwrap();
    while replay.step().unwrap() {}
    assert!(
        replay.session().slam().view().loop_closures > 0,
        "the loop is not closed"
    );
    let mut hash = StateHash::new();
    hash.integer(replay.state_hash());
    replay.session().slam().add_to(&mut hash);
    check("recorded-loop", hash.finish());
}
