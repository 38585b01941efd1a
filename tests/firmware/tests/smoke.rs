//! The firmware starts, answers and reports.

use anyhow::{Context, Result};
use slamlab_core::robot::Adc;
use slamlab_core::wire::rp6::{Command, CommandResult, Fault, PROTOCOL, ResetCause};
use slamlab_firmware_tests::{Host, Rig};

#[test]
fn it_says_who_it_is_with_the_models_figures() -> Result<()> {
    let (host, hello) = Host::armed(Rig::new([0.0; 2])?)?;
    assert_eq!(
        (hello.protocol, hello.cause),
        (PROTOCOL, ResetCause::PowerOn)
    );
    assert_eq!(hello.capabilities & 0x1F, 0x1F);
    assert_eq!(hello.ranger_angles_mrad, [0, 1571, 3142, -1571]);
    let (reported, model) = (hello.model(), host.rig.model());
    assert!((reported.track_width - model.track_width).abs() < 1e-9);
    assert!((reported.metres_per_tick - model.metres_per_tick).abs() < 1e-15);
    Ok(())
}

#[test]
fn telemetry_tells_time_voltages_and_bumpers() -> Result<()> {
    let (mut host, _) = Host::armed(Rig::new([0.0; 2])?)?;
    host.rig.press_bumpers([true, false]);
    host.run(0.2)?;
    let telemetry = host.telemetry.context("no telemetry")?;
    let age = host.rig.seconds() - 1e-3 * f64::from(telemetry.time_ms);
    assert!((0.0..0.07).contains(&age), "{age}");
    assert!(
        (telemetry.battery_volts() - 7.2).abs() < 0.02,
        "{telemetry:?}"
    );
    let [left, right] = telemetry
        .currents_adc
        .map(|adc| Adc::rp6().volts(adc.into()));
    assert!((left - 0.100).abs() < 0.01 && (right - 0.120).abs() < 0.01);
    assert!(telemetry.state.bumper_left() && !telemetry.state.bumper_right());
    assert!(!telemetry.state.moving() && telemetry.fault == Fault::None);
    host.rig.press_bumpers([false, true]);
    host.run(0.2)?;
    let state = host.telemetry.context("no telemetry")?.state;
    assert!(!state.bumper_left() && state.bumper_right());
    // 5.4 V behind the divider.
    host.rig.chip.set_millivolts(7, 2_700);
    host.run(0.2)?;
    let telemetry = host.telemetry.context("no telemetry")?;
    assert_eq!(telemetry.fault, Fault::BatteryLow);
    Ok(())
}

#[test]
fn the_rate_is_as_set_and_what_it_cannot_do_is_refused() -> Result<()> {
    let (mut host, _) = Host::armed(Rig::new([0.0; 2])?)?;
    let fast = Command::SetRate { period_ms: 20 };
    let wrong = [
        Command::SetRate { period_ms: 5 },
        Command::Servo { angle_mrad: 2_000 },
        Command::Forward {
            way_um: 2_000_000_000,
        },
    ];
    host.command(fast)?;
    for command in wrong {
        host.command(command)?;
    }
    host.run(0.5)?;
    let mut expected = vec![(fast, CommandResult::Done)];
    expected.extend(wrong.map(|command| (command, CommandResult::BadValue)));
    assert_eq!(host.results(), expected);
    let before = host.link.tally();
    host.run(1.0)?;
    let frames = host.link.tally().frames - before.frames;
    assert!((49..=51).contains(&frames), "{frames}");
    assert_eq!(host.link.tally().discarded, 0);
    Ok(())
}
