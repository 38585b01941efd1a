//! The servo and the rangers behind the multiplexer.

use anyhow::{Context, Result};
use nalgebra::Vector2;
use slamlab_core::geom::sin_cos;
use slamlab_core::robot::{self, Adc, Characteristic, Sharp, Variable};
use slamlab_core::sim::{Caster, worlds};
use slamlab_core::wire::rp6::Command;
use slamlab_firmware_tests::{Host, Rig};

#[test]
fn a_sweep_reads_every_ranger_at_every_angle_once() -> Result<()> {
    let (mut host, _) = Host::armed(Rig::new([0.0; 2])?)?;
    // Walls at four distances.
    let ranges = [0.3, 0.6, 0.9, 1.4];
    host.rig.ranger_volts = ranges.map(|range| Sharp::Long.volts_at(range));
    host.command(Command::Sweep {
        from_mrad: -700,
        to_mrad: 700,
        step_mrad: 100,
    })?;
    let seconds = host.finish(5.0)?;
    println!("15 angles in {seconds:.2} s");
    let angles: Vec<i16> = (-7..=7).map(|step| 100 * step).collect();
    let expected: Vec<(i16, u8)> = angles
        .iter()
        .flat_map(|&angle| (0..4).map(move |index| (angle, index)))
        .collect();
    let got: Vec<(i16, u8)> = host
        .rangers
        .iter()
        .map(|r| (r.servo_mrad, r.index))
        .collect();
    assert_eq!(got, expected);
    for reading in &host.rangers {
        let volts = host.rig.ranger_volts[usize::from(reading.index)];
        assert!(
            (reading.volts() - volts).abs() <= Adc::rp6().step(),
            "{reading:?}: {volts}"
        );
        assert_eq!(reading.sweep, 1);
    }
    // What a ranger says was measured where the servo stands: the servo's pulse and the slowest
    // cycle of a ranger.
    let times: Vec<u32> = host.rangers.iter().map(|r| r.time_ms).collect();
    assert!(
        times
            .chunks(4)
            .zip(times.chunks(4).skip(1))
            .all(|(a, b)| b[0] - a[3] >= 68),
        "{times:?}"
    );
    Ok(())
}

#[test]
fn a_sweep_runs_backwards_too_and_a_servo_command_ends_it() -> Result<()> {
    let (mut host, _) = Host::armed(Rig::new([0.0; 2])?)?;
    host.command(Command::Sweep {
        from_mrad: 700,
        to_mrad: -700,
        step_mrad: 350,
    })?;
    // 110 ms to the first angle, the way of the servo among them, 90 to the second.
    host.drive(0.25)?;
    host.command(Command::Servo { angle_mrad: 0 })?;
    host.drive(0.5)?;
    let angles: Vec<i16> = host
        .rangers
        .iter()
        .step_by(4)
        .map(|r| r.servo_mrad)
        .collect();
    assert!(
        angles.starts_with(&[700, 350]) && angles.len() < 5,
        "{angles:?}"
    );
    assert!(!host.telemetry.context("no telemetry")?.state.sweeping());
    Ok(())
}

#[test]
fn the_servos_pulse_is_a_millisecond_and_a_half_ahead_and_one_more_for_a_right_angle() -> Result<()>
{
    for (mrad, micros) in [
        (0, 1_500.0),
        (785, 2_000.0),
        (-785, 1_000.0),
        (300, 1_691.0),
    ] {
        let (mut host, _) = Host::armed(Rig::new([0.0; 2])?)?;
        host.command(Command::Servo { angle_mrad: mrad })?;
        host.run(0.1)?;
        // One pulse in 20 ms; telemetry goes on meanwhile.
        let (mut least, mut most) = (f64::INFINITY, 0.0_f64);
        for _ in 0..25 {
            host.run(0.02)?;
            let pulse = host.rig.chip.servo_pulse().context("no pulse")?;
            (least, most) = (least.min(pulse), most.max(pulse));
        }
        println!("{mrad} mrad: pulses of {least:.0} to {most:.0} us");
        // The interrupts of serial line and clock.
        assert!(
            least > micros - 20.0 && most < micros + 25.0,
            "{mrad}: {least} {most}"
        );
    }
    Ok(())
}

/// Servo pulse, multiplexer, ranger and converter together, against the walls of a world.
#[test]
fn a_sweep_in_the_arena_measures_its_walls() -> Result<()> {
    let world = worlds::builtin("arena").context("no arena")?;
    let walls = Caster::new(world.walls());
    let (mut host, hello) = Host::armed(Rig::in_world(&world)?)?;
    let fit = Characteristic::fit(&Sharp::Long.data_sheet(), Variable::PerVolt)?;
    host.command(Command::try_from(&robot::Command::Scan)?)?;
    host.finish(10.0)?;
    let pose = host.rig.pose();
    let (mut compared, mut worst) = (0, 0.0_f64);
    for reading in &host.rangers {
        let mount = 1e-3 * f64::from(hello.ranger_angles_mrad[usize::from(reading.index)]);
        let (sin, cos) = sin_cos(pose.heading() + reading.servo_angle() + mount);
        let hit = walls.cast(pose.position(), Vector2::new(cos, sin), 10.0);
        let Some(truth) = hit
            .map(|hit| hit.distance)
            .filter(|d| (0.25..1.3).contains(d))
        else {
            continue;
        };
        let error = fit.characteristic.range_at(reading.volts()) - truth;
        compared += 1;
        worst = worst.max(error.abs() / (truth * truth));
    }
    println!(
        "{} readings, {compared} of walls in reach, worst error {worst:.3} of d²",
        host.rangers.len()
    );
    assert_eq!(host.rangers.len(), 4 * 44);
    assert!(compared >= 10, "{compared}");
    // The characteristic's own residuals, a count of the converter, and the servo's microseconds at
    // a flat angle.
    assert!(worst < 0.12, "{worst}");
    Ok(())
}
