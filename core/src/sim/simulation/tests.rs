//! The simulated robot compared with closed forms, χ² and its own truth.

use std::f64::consts::{FRAC_PI_2, TAU};

use nalgebra::Vector3;

mod doors;
mod sensors;

use super::*;
use crate::geom::Length;
use crate::robot::{Odometry, OdometryBias, TrackOdometry};
use crate::sim::{Material, SensorKind, worlds};

fn simulation(name: &str, sensor: SensorModel, seed: u64) -> Simulation {
    let world = worlds::builtin(name).unwrap();
    Simulation::new(world, RobotModel::rp6(), sensor, seed).unwrap()
}

fn finish(sim: &mut Simulation, command: Command) {
    sim.command(command);
    while sim.is_busy() {
        sim.advance(TIME_STEP);
        assert!(sim.stamp().seconds() < 1e4);
    }
}

/// The true pose at the beginning and at the end of each of the next steps.
fn truths_of_steps(sim: &mut Simulation, steps: usize) -> Vec<Pose2> {
    let mut truths = vec![sim.truth()];
    for _ in 0..steps {
        sim.advance(TIME_STEP);
        truths.push(sim.truth());
    }
    truths
}

/// Drives like a cleaning robot: ahead until it touches something, then a turn; returns the dead
/// reckoning at the end.
fn bounce(sim: &mut Simulation, seconds: f64) -> Pose2 {
    let mut odometry = TrackOdometry::new(sim.robot());
    let mut reckoned = sim.world().start;
    odometry.update(sim.stamp(), sim.ticks());
    let mut leg = 0_u32;
    while sim.stamp().seconds() < seconds {
        let clear = sim
            .caster()
            .clearance(sim.truth() * nalgebra::Point2::new(0.25, 0.0), 0.2)
            >= 0.2;
        if clear {
            sim.command(Command::Velocity {
                forward: 0.25,
                turn: 0.0,
            });
            sim.advance(0.05);
        } else {
            leg += 1;
            let turn = 1.3 + 0.37 * f64::from(leg % 5);
            finish(sim, Command::Turn(turn));
        }
        reckoned = reckoned * odometry.update(sim.stamp(), sim.ticks()).motion;
    }
    reckoned
}

#[test]
fn same_seed_same_bits_and_sensor_does_not_change_the_motion() {
    let run = |sensor: SensorModel, seed| {
        let mut sim = simulation("arena", sensor, seed);
        sim.command(Command::Velocity {
            forward: 0.3,
            turn: 0.2,
        });
        sim.advance(3.0);
        let truth = sim.truth();
        (
            truth.x().to_bits(),
            truth.y().to_bits(),
            truth.heading().to_bits(),
            sim,
        )
    };
    let (mut first, mut again) = (run(SensorModel::lidar(), 5), run(SensorModel::lidar(), 5));
    assert_eq!((first.0, first.1, first.2), (again.0, again.1, again.2));
    let mut scans = 0;
    while let Some(scan) = first.3.take_scan() {
        let other = again.3.take_scan().unwrap();
        assert!(
            scan.ranges
                .iter()
                .zip(&other.ranges)
                .all(|(a, b)| a.to_bits() == b.to_bits())
        );
        scans += 1;
    }
    assert_eq!(scans, 16);
    let rangers = run(SensorModel::rangers(), 5);
    assert_eq!(
        (first.0, first.1, first.2),
        (rangers.0, rangers.1, rangers.2)
    );
    let other = run(SensorModel::lidar(), 6);
    assert_ne!(first.0, other.0);
}

#[test]
fn how_time_is_cut_does_not_matter() {
    let run = |part: f64, times: usize| {
        let mut sim = simulation("office", SensorModel::lidar(), 1);
        sim.command(Command::Velocity {
            forward: 0.2,
            turn: -0.1,
        });
        for _ in 0..times {
            sim.advance(part);
        }
        (sim.stamp(), sim.ticks(), sim.truth())
    };
    let whole = run(2.0, 1);
    assert_eq!(whole.0, Stamp(2_000_000));
    assert_eq!(whole, run(0.05, 40));
    assert_eq!(whole, run(0.001, 2000));
    let mut sim = simulation("office", SensorModel::lidar(), 1);
    for seconds in [f64::NAN, -1.0, f64::INFINITY] {
        sim.advance(seconds);
    }
    assert_eq!(sim.stamp(), Stamp(0));
}

#[test]
fn forward_and_turn_end_within_a_few_counts_of_what_was_asked_for() {
    let mut sim = simulation("office", SensorModel::lidar(), 3);
    let tick = sim.robot().metres_per_tick;
    finish(&mut sim, Command::Forward(0.6));
    let count = (0.6 / tick).round() as i64;
    let ends = sim.ticks();
    assert!(ends.iter().all(|end| (end - count).abs() <= 2), "{ends:?}");
    finish(&mut sim, Command::Turn(-FRAC_PI_2));
    let [left, right] = [0, 1].map(|side: usize| sim.ticks()[side] - ends[side]);
    let turned = (right - left) as f64 * tick / sim.robot().track_width;
    assert!((turned + FRAC_PI_2).abs() <= 4.0 * tick / sim.robot().track_width);
    assert_eq!(sim.contacts().total(), 0);
}

#[test]
fn dead_reckoning_is_honest_about_its_error() {
    // Odometry over a small displacement, composed as it arrives, for many seeds: NEES is χ² with 3
    // degrees of freedom.
    for (forward, turn) in [
        (0.25, 0.0),
        (0.2, 0.5),
        (-0.2, 0.3),
        (0.1, -1.0),
        (0.02, 1.2),
    ] {
        let runs = 600;
        let (mut sum, mut outer_five_percent) = (0.0, 0);
        for seed in 0..runs {
            let mut robot = RobotModel::rp6();
            // Random errors only: systematic errors are in no covariance.
            robot.odometry_bias = OdometryBias::default();
            let office = worlds::builtin("office").unwrap();
            let mut sim = Simulation::new(office, robot, SensorModel::rangers(), seed).unwrap();
            let mut odometry = TrackOdometry::new(sim.robot());
            sim.command(Command::Velocity { forward, turn });
            // Up to speed first; then the odometry restarts.
            sim.advance(0.7);
            odometry.update(sim.stamp(), sim.ticks());
            let before = sim.truth();
            let mut reckoned = Odometry::standing(sim.stamp());
            for _ in 0..8 {
                sim.advance(0.05);
                reckoned = reckoned.then(&odometry.update(sim.stamp(), sim.ticks()));
            }
            let truth = before.delta_to(&sim.truth());
            let error = Vector3::new(
                truth.x() - reckoned.motion.x(),
                truth.y() - reckoned.motion.y(),
                truth.heading() - reckoned.motion.heading(),
            );
            let nees = error.dot(&reckoned.cov.cholesky().unwrap().solve(&error));
            sum += nees;
            // 95 % quantile of χ² with 3 degrees of freedom.
            outer_five_percent += u32::from(nees > 7.815);
        }
        let n = runs as f64;
        // The mean of χ²(3) is 3, its variance 6; the part beyond the quantile is binomial.
        let mean = sum / n;
        assert!(
            (mean - 3.0).abs() < 4.0 * (6.0 / n).sqrt(),
            "{forward} {turn}: mean NEES {mean}"
        );
        let beyond = f64::from(outer_five_percent) / n;
        assert!(
            (beyond - 0.05).abs() < 4.0 * (0.05 * 0.95 / n).sqrt(),
            "{forward} {turn}: {beyond} beyond 95 %"
        );
    }
}

#[test]
fn a_worn_robot_turns_by_the_closed_form_of_its_wear() {
    // Without random errors, only wear: five turns on the spot fall short or go too far by the same
    // part, between half and one and a half times the figure of the model, to either side.
    let mut parts = vec![];
    for seed in 0..20 {
        let mut robot = RobotModel::rp6();
        robot.odometry_noise = crate::robot::OdometryNoise {
            per_metre: 0.0,
            lateral_per_metre: 0.0,
            heading_per_radian: 0.0,
        };
        let arena = worlds::builtin("arena").unwrap();
        let mut sim = Simulation::new(arena, robot, SensorModel::rangers(), seed).unwrap();
        let from = sim.truth().heading();
        finish(&mut sim, Command::Turn(1.0));
        let turned = crate::geom::wrap(sim.truth().heading() - from);
        parts.push((1.0 / turned - 1.0) / robot.odometry_bias.track_width);
    }
    assert!(
        parts.iter().all(|part| (0.45..1.55).contains(&part.abs())),
        "{parts:?}"
    );
    assert!(parts.iter().any(|part| *part > 0.0) && parts.iter().any(|part| *part < 0.0));
}

#[test]
fn dead_reckoning_is_lost_after_a_few_tens_of_metres() {
    let errors = |name: &str, seconds: f64| {
        let mut errors: Vec<f64> = (0..20)
            .map(|seed| {
                let mut sim = simulation(name, SensorModel::rangers(), seed);
                let reckoned = bounce(&mut sim, seconds);
                (reckoned.position() - sim.truth().position()).length()
            })
            .collect();
        errors.sort_by(f64::total_cmp);
        errors
    };
    for (name, seconds) in [("arena", 120.0), ("doors", 240.0), ("office", 400.0)] {
        let errors = errors(name, seconds);
        assert!(errors[10] > 0.5, "{name}: median {}", errors[10]);
    }
}

#[test]
fn driving_at_the_wall_makes_one_contact_and_no_hole_and_currents_rise_and_volts_sag() {
    let mut sim = simulation("corridor", SensorModel::lidar(), 2);
    sim.command(Command::Turn(FRAC_PI_2));
    sim.advance(3.0);
    sim.command(Command::Velocity {
        forward: 0.3,
        turn: 0.0,
    });
    let mean_currents_and_volts = |sim: &mut Simulation| {
        let (mut sum, mut volts) = (0.0, 0.0);
        for _ in 0..100 {
            sim.advance(TIME_STEP);
            sum += 0.5 * sim.motor_currents().iter().sum::<f64>();
            volts += sim.battery_volts();
        }
        (sum / 100.0, volts / 100.0)
    };
    sim.advance(1.5);
    assert_eq!(sim.contacts().total(), 0);
    let (free, free_volts) = mean_currents_and_volts(&mut sim);
    sim.advance(7.5);
    let (pushing, pushing_volts) = mean_currents_and_volts(&mut sim);
    // Ten seconds of driving take millivolts off a full battery; pushing takes far more.
    assert!(
        pushing_volts < free_volts - 0.02,
        "{free_volts} V free, {pushing_volts} V pushing"
    );
    // Both tracks push with nearly all their grip.
    let drive = sim.robot().drive;
    let more = drive.grip * drive.metres_per_radian / drive.left.torque_constant;
    let rise = (pushing - free) / more;
    assert!(
        (0.6..1.2).contains(&rise),
        "{free} A free, {pushing} A pushing"
    );
    assert_eq!(sim.contacts().total(), 1);
    assert!(sim.bumpers().left || sim.bumpers().right);
    let touch = 2.0 - sim.robot().radius();
    assert!(
        sim.truth().y() <= touch && sim.truth().y() > touch - 1e-3,
        "{:?}",
        sim.truth()
    );
    // The encoders do not notice it.
    assert!(sim.ticks()[0] as f64 * sim.robot().metres_per_tick > 2.0);
}

#[test]
fn mover_is_seen_waits_for_the_robot_and_is_not_driven_through() {
    let mut world = worlds::builtin("corridor").unwrap();
    world.movers.push(super::super::Mover {
        waypoints: vec![
            nalgebra::Point2::new(5.0, 1.0),
            nalgebra::Point2::new(0.5, 1.0),
        ],
        closed: false,
        speed: 0.5,
        radius: 0.25,
        pause: 0.0,
    });
    let mut sim = Simulation::new(world, RobotModel::rp6(), SensorModel::lidar(), 1).unwrap();
    sim.advance(10.0);
    let gap = |sim: &Simulation| {
        let mover = sim.movers()[0];
        (mover.centre - sim.truth().position()).length() - mover.radius - sim.robot().radius()
    };
    assert!(
        gap(&sim) > 0.09 && sim.contacts().total() == 0,
        "{}",
        gap(&sim)
    );
    let scan = std::iter::from_fn(|| sim.take_scan()).last().unwrap();
    assert!(
        scan.ranges.iter().any(|r| *r < 0.3),
        "the mover is not seen"
    );
    sim.command(Command::Velocity {
        forward: 0.3,
        turn: 0.0,
    });
    sim.advance(3.0);
    assert!(
        gap(&sim) > -1e-6 && sim.contacts().total() == 1,
        "{} {}",
        gap(&sim),
        sim.contacts().total()
    );
}
