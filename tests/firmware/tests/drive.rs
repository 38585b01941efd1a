//! The firmware drives: ways, turns and speeds, against what the tracks really ran.

use std::f64::consts::FRAC_PI_2;

use anyhow::{Context, Result};
use slamlab_core::robot;
use slamlab_core::wire::rp6::{Command, Fault, Odometer};
use slamlab_firmware_tests::{Host, Rig};

fn command(command: robot::Command) -> Result<Command> {
    Ok(Command::try_from(&command)?)
}

/// Motors as the model has them; both weaker and stronger; one of each.
const MOTORS: [[f64; 2]; 3] = [[0.0, 0.0], [0.1, -0.1], [-0.1, -0.1]];

#[test]
fn a_metre_forwards_is_a_metre_whatever_the_motors() -> Result<()> {
    for (mismatch, way) in MOTORS.into_iter().zip([1.0, 1.0, -0.5]) {
        let (mut host, _) = Host::armed(Rig::new(mismatch)?)?;
        host.command(command(robot::Command::Forward(way))?)?;
        let seconds = host.finish(10.0)?;
        let pose = host.rig.pose();
        println!(
            "motors {mismatch:?}: {way} m is {:.4} m, {:.2} mm aside, {:.2} mrad, in {seconds:.1} s",
            pose.x(),
            1e3 * pose.y(),
            1e3 * pose.heading()
        );
        assert!((pose.x() - way).abs() < 0.003, "{mismatch:?}: {}", pose.x());
        assert!(
            pose.y().abs() < 0.005 && pose.heading().abs() < 0.012,
            "{mismatch:?}: {pose:?}"
        );
        // Full speed but for gathering and losing it: 1 m at 0.3 m/s and 0.6 m/s².
        assert!(seconds < way.abs() / 0.3 + 1.5, "{seconds}");
    }
    Ok(())
}

#[test]
fn a_right_angle_is_one_whatever_the_motors() -> Result<()> {
    for (mismatch, angle) in MOTORS.into_iter().zip([FRAC_PI_2, -FRAC_PI_2, 3.0]) {
        let (mut host, _) = Host::armed(Rig::new(mismatch)?)?;
        host.command(command(robot::Command::Turn(angle))?)?;
        let seconds = host.finish(10.0)?;
        let pose = host.rig.pose();
        println!(
            "motors {mismatch:?}: {angle:.4} rad is {:.4} rad in {seconds:.1} s",
            pose.heading()
        );
        assert!(
            (pose.heading() - angle).abs() < 0.02,
            "{mismatch:?}: {}",
            pose.heading()
        );
        assert!(
            pose.position().coords.norm() < 0.005,
            "{mismatch:?}: {pose:?}"
        );
    }
    Ok(())
}

#[test]
fn a_speed_is_held_against_a_load_on_one_track() -> Result<()> {
    let (mut host, _) = Host::armed(Rig::new([0.1, -0.1])?)?;
    let arc = robot::Command::Velocity {
        forward: 0.2,
        turn: 0.3,
    };
    host.command(command(arc)?)?;
    host.drive(2.0)?;
    host.rig.brakes = [0.05, 0.0];
    host.drive(2.0)?;
    let (before, start) = (host.rig.ways(), host.rig.seconds());
    host.drive(2.0)?;
    let seconds = host.rig.seconds() - start;
    let [left, right] = [0, 1].map(|side: usize| (host.rig.ways()[side] - before[side]) / seconds);
    let half = 0.5 * host.rig.model().track_width;
    println!(
        "left {left:.4} of {:.4} m/s, right {right:.4} of {:.4} m/s",
        0.2 - 0.3 * half,
        0.2 + 0.3 * half
    );
    assert!((left - (0.2 - 0.3 * half)).abs() < 0.002, "{left}");
    assert!((right - (0.2 + 0.3 * half)).abs() < 0.002, "{right}");
    Ok(())
}

#[test]
fn turning_round_counts_both_ways_right() -> Result<()> {
    let (mut host, _) = Host::armed(Rig::new([0.1, -0.1])?)?;
    host.run(0.2)?;
    let mut odometer = Odometer::new(host.rig.model());
    odometer.update(&host.telemetry.context("no telemetry")?);
    for forward in [0.3, -0.3, 0.25, -0.2] {
        host.command(command(robot::Command::Velocity { forward, turn: 0.0 })?)?;
        host.drive(1.5)?;
    }
    host.command(Command::Stop)?;
    host.finish(3.0)?;
    let odometry = odometer
        .update(&host.telemetry.context("no telemetry")?)
        .context("no motion")?;
    let truth = host.rig.pose();
    println!(
        "odometry {:.4} m, truth {:.4} m",
        odometry.motion.x(),
        truth.x()
    );
    // Each change of direction may cost a count or two: a track that coasts is counted as it was
    // driven.
    assert!(
        (odometry.motion.x() - truth.x()).abs() < 0.004,
        "{odometry:?} {truth:?}"
    );
    Ok(())
}

#[test]
fn a_motor_whose_encoder_is_silent_is_switched_off_and_named() -> Result<()> {
    let (mut host, _) = Host::armed(Rig::new([0.0; 2])?)?;
    host.rig.encoders_on = [true, false];
    host.command(command(robot::Command::Forward(2.0))?)?;
    host.drive(2.5)?;
    let telemetry = host.telemetry.context("no telemetry")?;
    assert_eq!(telemetry.fault, Fault::RightEncoder);
    assert_eq!(host.rig.chip.duties(), [0, 0]);
    Ok(())
}
