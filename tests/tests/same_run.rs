//! The same run gives the same bits natively and in the browser: this file runs in both.
//!
//! Each run is held to one number: the hash of all the state it ends in. When the algorithms
//! change, so do the numbers. `tests/same_run.sh` writes the new ones, as found natively, into
//! `same_run.txt`; the browser must then agree.
#![allow(missing_docs, clippy::unwrap_used)] // a test binary has no public interface, and failing is its trade

use slamlab_core::experiment::{Experiment, ExperimentConfig};
use slamlab_core::format::carmen::CarmenLog;
use slamlab_core::geom::Pose2;
use slamlab_core::hash::StateHash;
use slamlab_core::replay::{Log, Replay};
use slamlab_core::robot::RobotModel;
use slamlab_core::sim::{Caster, SensorKind, worlds};
use slamlab_core::slam::Method;
use slamlab_tests::numbers;
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

#[test]
fn exploring_by_rangers_is_the_same_run_everywhere() {
    let run = explore("arena", SensorKind::Rangers, Method::LineEkf);
    check("rangers-line-ekf", run.state_hash());
}

#[test]
fn a_recording_of_a_loop_gives_the_same_way_and_map_everywhere() {
    let log = CarmenLog::parse(recording().as_bytes()).unwrap();
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

/// A CARMEN log of one lap and a bit in the ring corridor, with odometry that drifts and a laser
/// that is a little noisy.
fn recording() -> String {
    let corners: [(f64, f64); 4] = [(1.0, 1.0), (20.0, 1.0), (20.0, 14.0), (1.0, 14.0)];
    let caster = Caster::new(worlds::builtin("loop").unwrap().walls());
    let mut noise = numbers().map(|u| 2.0 * u - 1.0);
    let mut noise = || noise.next().unwrap_or(0.0);
    let mut text = String::new();
    let mut odometry = Pose2::identity();
    let mut last: Option<Pose2> = None;
    let mut seconds = 0.0;
    for side in 0..5_u8 {
        let heading = std::f64::consts::FRAC_PI_2 * f64::from(side % 4);
        let [from, to] = [side, side + 1].map(|corner| corners[usize::from(corner % 4)]);
        let length = (to.0 - from.0).abs() + (to.1 - from.1).abs();
        let drives = (0..(length / 0.3) as u32).map(|step| (f64::from(step) * 0.3, 0.0));
        let turns = (1..6).map(|step| (length, 0.25 * f64::from(step)));
        for (along, turn) in drives.chain(turns) {
            let start = Pose2::new(from.0, from.1, heading);
            let truth = start * Pose2::new(along, 0.0, turn);
            if let Some(last) = last {
                let moved = last.inverse() * truth;
                let turned = 1.01 * moved.heading() + 0.002 * noise();
                odometry = odometry * Pose2::new(1.02 * moved.x(), moved.y(), turned);
            }
            last = Some(truth);
            seconds += 0.5;
            text += "FLASER 180";
            for beam in 0..180 {
                let bearing = (f64::from(beam) - 90.0).to_radians();
                let world_from_beam = truth * Pose2::new(0.0, 0.0, bearing);
                let (cos, sin) = world_from_beam.cos_sin();
                let origin = [truth.x(), truth.y()].into();
                let hit = caster.cast(origin, [cos, sin].into(), 80.0);
                let range = hit.map_or(81.83, |hit| hit.distance + 0.01 * noise());
                text += &format!(" {range:.2}");
            }
            let at = format!(
                "{:.4} {:.4} {:.4}",
                odometry.x(),
                odometry.y(),
                odometry.heading()
            );
            text += &format!(" {at} {at} {seconds:.2} host {seconds:.2}\n");
        }
    }
    text
}
