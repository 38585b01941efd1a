//! `controller`: motors that differ from the ones the controller was designed for, loads, steps,
//! and the cost of the controller. About 10 s.
//!
//! 1. The right motor's magnet 30 % stronger, then weaker; 5 m straight on at 0.25 m/s: how far the
//!    heading deviates, closed loop and open loop.
//! 2. A load of a quarter of the motor's stall torque comes on one track, with any of these motors:
//!    mean errors of speed and heading over the last second.
//! 3. Overshoot of the faster track: ramps as every command makes them, at three speeds; and steps,
//!    at which both motors may saturate at the battery's voltage, at the two higher speeds. (A step
//!    to a fifth of the highest speed is a figure without a requirement: no command makes one.)
//! 4. A motor that makes no torque must be refused as uncontrollable.
//! 5. Simulated seconds for a second of one core: the robot in `office` with lidar, motors and
//!    controller at 1 kHz, driving; and motors and controller alone.

use std::time::Instant;

use anyhow::{Context, Result};
use slamlab_core::robot::controller::DesignError;
use slamlab_core::robot::{Command, RobotModel};
use slamlab_core::sim::response::{DRIVE_PERIOD, LoadStep, Loop, ResponseSample, Trial};
use slamlab_core::sim::{SensorModel, Simulation};

use super::{Args, Outcome};
use crate::ride::world_named;

const MISMATCHES: [f64; 3] = [0.0, 0.3, -0.3];
const LAST_SECOND: usize = 1_000;

pub(crate) fn measure(args: &Args) -> Result<Outcome> {
    let mut outcome = Outcome::default();
    let robot = RobotModel::rp6();
    straight(&mut outcome, &robot)?;
    load(&mut outcome, &robot)?;
    overshoot(&mut outcome, &robot)?;
    uncontrollable(&mut outcome, &robot);
    speed(&mut outcome, &robot, args.seeds.unwrap_or(1))?;
    Ok(outcome)
}

fn straight(outcome: &mut Outcome, robot: &RobotModel) -> Result<()> {
    let (mut closed_worst, mut closed_end, mut open_end) = (0.0_f64, 0.0_f64, f64::INFINITY);
    for mismatch in [0.3, -0.3] {
        let trial = Trial {
            seconds: 5.0 / 0.25 + 0.5,
            ..with_mismatch(robot, 0.25, mismatch)
        };
        let closed = trial.run(Loop::Closed)?;
        closed_worst = closed_worst.max(worst_heading(&closed));
        closed_end = closed_end.max(last(&closed)?.heading_error.abs().to_degrees());
        let open = last(&trial.run(Loop::Open)?)?;
        open_end = open_end.min(open.heading_error.abs().to_degrees());
    }
    outcome.at_most("closed_loop_heading_drift_over_5_m_deg", closed_end, 0.5);
    let key = "closed_loop_worst_heading_error_over_5_m_deg";
    outcome.at_most(key, closed_worst, 0.5);
    outcome.at_least("open_loop_heading_drift_over_5_m_deg", open_end, 10.0);
    Ok(())
}

fn load(outcome: &mut Outcome, robot: &RobotModel) -> Result<()> {
    let motor = robot.drive.left;
    let torque = 0.25 * motor.torque_constant * robot.drive.battery / motor.resistance;
    let (mut speed_error, mut heading_error, mut open_error) = (0.0_f64, 0.0_f64, f64::INFINITY);
    for mismatch in MISMATCHES {
        for (left, right) in [(torque, 0.0), (0.0, torque)] {
            let at = 2.0;
            let trial = Trial {
                loads: vec![LoadStep { at, left, right }],
                ..with_mismatch(robot, 0.2, mismatch)
            };
            let closed = trial.run(Loop::Closed)?;
            speed_error = speed_error.max(final_speed_error(&closed));
            heading_error = heading_error.max(final_heading(&closed).abs());
            open_error = open_error.min(final_speed_error(&trial.run(Loop::Open)?));
        }
    }
    // One encoder count per second, and the heading of one count.
    let tick = robot.metres_per_tick;
    outcome.at_most("speed_error_after_load_step_m_per_s", speed_error, tick);
    let count = (tick / robot.track_width).to_degrees();
    outcome.at_most("heading_error_after_load_step_deg", heading_error, count);
    outcome.figure("open_loop_speed_error_after_load_step_m_per_s", open_error);
    Ok(())
}

fn overshoot(outcome: &mut Outcome, robot: &RobotModel) -> Result<()> {
    let (mut ramps, mut steps, mut slow_steps) = (0.0_f64, 0.0_f64, 0.0_f64);
    let mut most_volts = 0.0_f64;
    for mismatch in MISMATCHES {
        for part in [0.9, 0.5, 0.2] {
            let forward = part * robot.max_speed;
            for ramp in [1.0, f64::INFINITY] {
                let trial = Trial {
                    ramp,
                    ..with_mismatch(robot, forward, mismatch)
                };
                let samples = trial.run(Loop::Closed)?;
                let speeds = samples.iter().flat_map(|s| s.speeds);
                let over = 100.0 * (speeds.fold(0.0, f64::max) / forward - 1.0);
                let worst = match (ramp.is_finite(), part < 0.5) {
                    (true, _) => &mut ramps,
                    (false, false) => &mut steps,
                    (false, true) => &mut slow_steps,
                };
                *worst = worst.max(over);
                let volts = samples.iter().flat_map(|s| s.voltages);
                most_volts = volts.map(f64::abs).fold(most_volts, f64::max);
            }
        }
    }
    outcome.at_most("ramp_overshoot_percent", ramps, 10.0);
    outcome.at_most("step_overshoot_percent", steps, 10.0);
    outcome.figure("slow_step_overshoot_percent", slow_steps);
    outcome.at_least("highest_voltage_v", most_volts, robot.drive.battery - 1e-9);
    Ok(())
}

fn uncontrollable(outcome: &mut Outcome, robot: &RobotModel) {
    let mut trial = Trial::straight(robot, 0.2, 1.0);
    trial.robot.drive.right.torque_constant = 0.0;
    let error = trial.run(Loop::Closed).err();
    let is_named = matches!(error, Some(DesignError::Uncontrollable { .. }));
    let text = error.map_or("no error".to_owned(), |error| error.to_string());
    outcome.require(is_named, || format!("a motor without torque: {text}"));
    outcome.figure("motor_without_torque", text);
}

fn speed(outcome: &mut Outcome, robot: &RobotModel, seeds: u64) -> Result<()> {
    let office = world_named("office")?;
    let (mut simulated, mut spent) = (0.0, 0.0);
    for seed in 0..seeds {
        let mut sim = Simulation::new(office.clone(), *robot, SensorModel::lidar(), seed)?;
        let begin = Instant::now();
        for turn in 0..60_u32 {
            // In small circles, to the left and to the right.
            let turn = if turn % 2 == 0 { 1.0 } else { -1.0 };
            sim.command(Command::Velocity { forward: 0.2, turn });
            for _ in 0..200 {
                sim.advance(0.05);
                sim.take_scan();
            }
        }
        spent += begin.elapsed().as_secs_f64();
        simulated += sim.stamp().seconds();
    }
    outcome.at_least("simulation_real_time_factor", simulated / spent, 100.0);
    let trial = Trial {
        seconds: 100.0,
        ..with_mismatch(robot, 0.2, 0.3)
    };
    let begin = Instant::now();
    let samples = trial.run(Loop::Closed)?.len() as f64;
    let factor = samples * DRIVE_PERIOD / begin.elapsed().as_secs_f64();
    outcome.figure("motors_and_controller_real_time_factor", factor);
    Ok(())
}

fn with_mismatch(robot: &RobotModel, forward: f64, mismatch: f64) -> Trial {
    let mut trial = Trial::straight(robot, forward, 6.0);
    trial.motors.right = robot.drive.right.with_stronger_magnet(mismatch);
    trial
}

fn last(samples: &[ResponseSample]) -> Result<ResponseSample> {
    samples.last().copied().context("no samples")
}

fn worst_heading(samples: &[ResponseSample]) -> f64 {
    let errors = samples.iter().map(|s| s.heading_error.abs());
    errors.fold(0.0, f64::max).to_degrees()
}

/// The larger error of the tracks' mean speeds over the last second, m/s.
fn final_speed_error(samples: &[ResponseSample]) -> f64 {
    let tail = &samples[samples.len().saturating_sub(LAST_SECOND + 1)..];
    let (Some(from), Some(to)) = (tail.first(), tail.last()) else {
        return f64::NAN;
    };
    let error = |side: usize| {
        let mean = (to.ways[side] - from.ways[side]) / (to.seconds - from.seconds);
        (mean - to.wished[side]).abs()
    };
    error(0).max(error(1))
}

/// Mean heading error over the last second, degrees.
fn final_heading(samples: &[ResponseSample]) -> f64 {
    let tail = &samples[samples.len().saturating_sub(LAST_SECOND)..];
    let sum: f64 = tail.iter().map(|s| s.heading_error).sum();
    (sum / tail.len() as f64).to_degrees()
}
