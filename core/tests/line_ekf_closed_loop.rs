//! Line EKF-SLAM against the simulator: rolling lidar scans, slipping tracks, a robot steered by
//! the truth along random errands. The filter sees only ticks and scans.

#![allow(clippy::unwrap_used)] // Helpers of tests may panic as tests do.

use std::collections::VecDeque;

use nalgebra::{Point2, Vector2};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use slamlab_core::estimation::{EkfConfig, EkfSlam, SweepTiming};
use slamlab_core::features::{LineConfig, LineExtractor};
use slamlab_core::geom::{Length, Pose2, wrap};
use slamlab_core::points::{PointConfig, Points};
use slamlab_core::robot::{Command, RobotModel, TrackOdometry};
use slamlab_core::sim::{SensorModel, Simulation, TIME_STEP, worlds};

#[path = "../examples/report/errand.rs"]
mod errand;

use errand::errand;

/// Figures of one run.
struct Outcome {
    position_error: f64,
    heading_error: f64,
    odometry_error: f64,
    /// Mean NEES of the pose over the scans after the first metre.
    nees: f64,
    nis: f64,
    confirmed: usize,
    features_per_scan: f64,
    matches_per_scan: f64,
    rejected_per_scan: f64,
    distance: f64,
}

/// Lets the robot run `errands` errands in a built-in world.
fn run(
    world: &str,
    seed: u64,
    errands: usize,
    config: EkfConfig,
    line_config: LineConfig,
) -> Outcome {
    let robot = RobotModel::rp6();
    let world = worlds::builtin(world).unwrap();
    let start = world.start;
    let mut sim = Simulation::new(world, robot, SensorModel::lidar(), seed).unwrap();
    let mut wheels = TrackOdometry::new(&robot);
    let mut slam = EkfSlam::new(config).unwrap();
    let mut extractor = LineExtractor::new(line_config);
    let mut lines = vec![];
    wheels.update(sim.stamp(), sim.ticks());
    let mut dead_reckoned = Pose2::identity();
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let (mut nees, mut nis, mut matched, mut seen, mut rejected, mut scans) =
        ((0.0, 0_u32), 0.0, 0, 0, 0, 0_u32);
    let mut distance = 0.0;
    let mut route = VecDeque::new();
    let (mut left, mut rest) = (errands, 0);
    let mut last = sim.truth().position();
    for _ in 0..40_000 {
        if route.is_empty() && left > 0 {
            left -= 1;
            route = errand(&sim, &mut rng);
        }
        if route.is_empty() {
            // Stand still for the last scans.
            sim.command(Command::Stop);
            rest += 1;
            if rest > 20 {
                break;
            }
        }
        steer(&mut sim, &mut route);
        let past: Vec<_> = (0..10)
            .map(|_| {
                sim.advance(TIME_STEP);
                (sim.stamp(), sim.ticks(), sim.truth())
            })
            .collect();
        distance += (sim.truth().position() - last).length();
        last = sim.truth().position();
        while let Some(scan) = sim.take_scan() {
            // A revolution of the lidar ends with a step.
            let (_, ticks, truth) = *past.iter().find(|(at, ..)| *at == scan.stamp).unwrap();
            let odometry = wheels.update(scan.stamp, ticks);
            slam.predict(&odometry).unwrap();
            dead_reckoned = dead_reckoned * odometry.motion;
            let span = odometry.to.since(odometry.from);
            let part = if span > 0.0 {
                (scan.sweep / span).min(1.0)
            } else {
                0.0
            };
            let before = odometry.motion.fraction(1.0 - part);
            let motion = before.inverse() * odometry.motion;
            let points = Points::from_scan(&scan, &motion, &PointConfig::default());
            extractor.extract(&points, &mut lines).unwrap();
            let report = slam
                .update(&lines, &SweepTiming::at(scan.stamp, &scan))
                .unwrap();
            (seen, matched, rejected) = (
                seen + lines.len(),
                matched + report.matches.len(),
                rejected + report.rejected(),
            );
            nis += report.nis;
            scans += 1;
            let truth = start.inverse() * truth;
            if distance > 1.0
                && let Some(value) = slam.estimate().nees(&truth)
            {
                nees = (nees.0 + value, nees.1 + 1);
            }
        }
    }
    let truth = start.inverse() * sim.truth();
    let end = wheels.update(sim.stamp(), sim.ticks());
    slam.predict(&end).unwrap();
    let pose = slam.estimate().pose;
    let per_scan = |count: usize| count as f64 / f64::from(scans);
    Outcome {
        position_error: (pose.position() - truth.position()).length(),
        heading_error: wrap(pose.heading() - truth.heading()).abs().to_degrees(),
        odometry_error: ((dead_reckoned * end.motion).position() - truth.position()).length(),
        nees: nees.0 / f64::from(nees.1),
        nis: nis / matched as f64,
        confirmed: slam.landmarks().filter(|l| l.is_confirmed).count(),
        features_per_scan: per_scan(seen),
        matches_per_scan: per_scan(matched),
        rejected_per_scan: per_scan(rejected),
        distance,
    }
}

/// Steers for a point of the route some distance ahead, by the true pose.
fn steer(sim: &mut Simulation, route: &mut VecDeque<Point2<f64>>) {
    let pose = sim.truth();
    while route.len() > 1
        && route
            .front()
            .is_some_and(|p| (p - pose.position()).length() < 0.25)
    {
        route.pop_front();
    }
    let Some(&goal) = route.front() else { return };
    if (goal - pose.position()).length() < 0.1 {
        route.pop_front();
        sim.command(Command::Stop);
        return;
    }
    let ahead: Vector2<f64> = (pose.inverse() * goal).coords;
    let error = libm::atan2(ahead.y, ahead.x);
    let forward = if error.abs() > 0.6 { 0.0 } else { 0.25 };
    sim.command(Command::Velocity {
        forward,
        turn: (2.5 * error).clamp(-1.0, 1.0),
    });
}

fn summarize(world: &str, outcomes: &[Outcome]) {
    let seeds = outcomes.len();
    let mean = |f: &dyn Fn(&Outcome) -> f64| outcomes.iter().map(f).sum::<f64>() / seeds as f64;
    let max = |f: &dyn Fn(&Outcome) -> f64| outcomes.iter().map(f).fold(0.0, f64::max);
    println!(
        "{world}: error {:.3} m (max {:.3}), {:.2} deg (max {:.2}), odometry {:.2} m, NEES {:.2} (max {:.1}), NIS {:.2}, {:.0} walls, {:.1} lines, {:.1} matched, {:.2} rejected a scan, {:.0} m",
        mean(&|o| o.position_error),
        max(&|o| o.position_error),
        mean(&|o| o.heading_error),
        max(&|o| o.heading_error),
        mean(&|o| o.odometry_error),
        mean(&|o| o.nees),
        max(&|o| o.nees),
        mean(&|o| o.nis),
        mean(&|o| o.confirmed as f64),
        mean(&|o| o.features_per_scan),
        mean(&|o| o.matches_per_scan),
        mean(&|o| o.rejected_per_scan),
        mean(&|o| o.distance),
    );
}

/// Runs 5 seeds in `world`; each must be within `metres` and `degrees`, and all together must have
/// an honest covariance.
fn check(world: &str, metres: f64, degrees: f64) {
    let outcomes: Vec<_> = (0..5)
        .map(|seed| run(world, seed, 4, EkfConfig::default(), LineConfig::default()))
        .collect();
    summarize(world, &outcomes);
    for (seed, outcome) in outcomes.iter().enumerate() {
        let (error, turn) = (outcome.position_error, outcome.heading_error);
        assert!(error < metres, "{world} {seed}: {error} m");
        assert!(turn < degrees, "{world} {seed}: {turn} degrees");
    }
    let nees = outcomes.iter().map(|o| o.nees).sum::<f64>() / outcomes.len() as f64;
    // The 95 % band of a mean of five values of χ² with 3 degrees of freedom.
    assert!(
        (1.25..5.50).contains(&nees),
        "{world}: NEES {nees}, 3 is honest"
    );
}

/// Errands in `office` lead through doors into rooms and back over 44 m; the worst of five ends
/// 0.104 m off, and its covariance says so.
#[test]
fn pose_is_found_to_centimetres_and_two_degrees_with_honest_covariance() {
    for (world, metres) in [("arena", 0.05), ("doors", 0.05), ("office", 0.12)] {
        check(world, metres, 2.0);
    }
}

/// Odometry alone is lost by 19 m here. Random errands do not always close the ring, and then
/// nothing but the filter's own covariance bounds the error: seed 4 ends 0.35 m off. That the
/// covariance is honest on closed laps is measured by `report -- ekf-consistency`, over 100 seeds.
#[test]
fn ring_of_sixty_metres_is_followed_to_forty_centimetres_and_two_degrees() {
    check("loop", 0.40, 2.0);
}
