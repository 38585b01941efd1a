//! What stops the motors, measured at the registers of the motors.

use anyhow::{Context, Result};
use slamlab_core::wire::rp6::{Command, CommandResult, Down, LinkEvent, Phase, ResetCause};
use slamlab_firmware_tests::{Host, Rig};

const AHEAD: Command = Command::Velocity {
    forward_mm_s: 200,
    turn_mrad_s: 0,
};

/// A robot that has been driving ahead for a second.
fn driving() -> Result<Host> {
    let (mut host, _) = Host::armed(Rig::new([0.0; 2])?)?;
    host.command(AHEAD)?;
    host.drive(1.0)?;
    assert!(host.rig.speeds()[0] > 0.15, "{:?}", host.rig.speeds());
    Ok(host)
}

fn is_off(host: &Host) -> bool {
    host.rig.chip.duties() == [0, 0]
}

#[test]
fn silence_switches_the_motors_off_within_400_ms_and_a_new_command_on() -> Result<()> {
    let mut worst: f64 = 0.0;
    // The last command at different phases of the controller's period and of telemetry.
    for phase in 0..8 {
        let mut host = driving()?;
        host.run(0.0013 * f64::from(phase))?;
        host.command(AHEAD)?;
        worst = worst.max(host.run_until(1.0, is_off)?);
        if phase > 0 {
            continue;
        }
        host.run(0.5)?;
        let state = host.telemetry.context("no telemetry")?.state;
        assert!(state.stopped_by_silence() && !state.moving());
        // A sign of life alone moves nothing; a command does.
        host.drive(0.5)?;
        assert!(is_off(&host) && host.rig.speeds() == [0.0; 2]);
        assert!(
            !host
                .telemetry
                .context("no telemetry")?
                .state
                .stopped_by_silence()
        );
        host.command(AHEAD)?;
        host.drive(0.5)?;
        assert!(host.rig.speeds()[0] > 0.1);
    }
    println!(
        "silence: motors off after {:.1} ms at most, the command's own time on the line included",
        1e3 * worst
    );
    assert!(worst <= 0.400, "{worst}");
    Ok(())
}

/// The motors are switched off by the clock's interrupt, and the loop looks at the silence once in
/// 10 ms. A sign of life in between fed the guard, and the loop went on with the speed from before.
#[test]
fn a_sign_of_life_just_after_the_motors_went_off_starts_nothing() -> Result<()> {
    for phase in 0..8 {
        let mut host = driving()?;
        host.run(0.0013 * f64::from(phase))?;
        host.command(AHEAD)?;
        host.run_until(1.0, is_off)?;
        host.command(Command::Alive)?;
        for _ in 0..500 {
            host.run(0.001)?;
            if (host.rig.seconds() * 1e3) as u64 % 100 == 0 {
                host.command(Command::Alive)?;
            }
            assert!(is_off(&host), "phase {phase}: {:?}", host.rig.chip.duties());
        }
    }
    Ok(())
}

/// A stop was a ramp once, with voltage on the motors for up to 0.18 s more: with the bridge's
/// patience of 0.2 s before it, more than the 0.25 s that are promised.
#[test]
fn a_stop_takes_the_voltage_at_once_and_the_robot_stands_soon() -> Result<()> {
    for command in [
        AHEAD,
        Command::Velocity {
            forward_mm_s: 0,
            turn_mrad_s: 600,
        },
    ] {
        let mut host = driving()?;
        host.command(command)?;
        host.drive(1.0)?;
        host.command(Command::Stop)?;
        let off = host.run_until(0.2, is_off)?;
        let before = host.rig.ways();
        for _ in 0..500 {
            host.run(0.001)?;
            assert!(is_off(&host), "{command:?}: {:?}", host.rig.chip.duties());
        }
        let way = (host.rig.ways()[1] - before[1]).abs();
        println!(
            "{command:?}: off after {:.1} ms, rolls {:.1} mm",
            1e3 * off,
            1e3 * way
        );
        assert!(off < 0.01, "{command:?}: {off}");
        assert!(
            way < 0.03 && host.rig.speeds() == [0.0; 2],
            "{command:?}: rolls {way} m"
        );
    }
    Ok(())
}

#[test]
fn a_cut_cable_stops_the_robot_and_the_link_comes_back_disarmed() -> Result<()> {
    let mut host = driving()?;
    host.is_connected = false;
    let off = host.run_until(1.0, is_off)?;
    assert!(off <= 0.400, "{off}");
    host.run(1.5)?;
    assert_ne!(host.link.phase(), Phase::Running);
    host.is_connected = true;
    host.run_until(4.0, |host| host.link.phase() == Phase::Running)?;
    assert!(
        host.events.contains(&LinkEvent::Down(Down::Silence)),
        "{:?}",
        host.events
    );
    assert!(!host.link.is_armed() && host.command(AHEAD).is_err());
    host.link.arm()?;
    host.command(AHEAD)?;
    host.drive(0.5)?;
    assert!(host.rig.speeds()[0] > 0.1);
    Ok(())
}

#[test]
fn an_emergency_stop_is_at_once_and_latched_and_its_reset_moves_nothing() -> Result<()> {
    let mut host = driving()?;
    host.events.clear();
    host.command(Command::EStop)?;
    let off = host.run_until(0.1, is_off)?;
    println!(
        "emergency stop: motors off after {:.2} ms, 7 bytes on the line included",
        1e3 * off
    );
    assert!(off < 0.005, "{off}");
    host.run(0.1)?;
    for command in [
        AHEAD,
        Command::Forward { way_um: 100_000 },
        Command::Turn {
            angle_urad: 500_000,
        },
    ] {
        host.command(command)?;
        host.drive(0.4)?;
        assert!(is_off(&host), "{command:?}");
    }
    assert!(host.telemetry.context("no telemetry")?.state.latched());
    let results = host.results();
    assert_eq!(results[0], (Command::EStop, CommandResult::Done));
    assert!(
        results[1..]
            .iter()
            .all(|(_, result)| *result == CommandResult::Latched),
        "{results:?}"
    );
    // The robot stands by now; the reset leaves it standing.
    let stood = host.rig.ways();
    host.command(Command::Reset)?;
    host.drive(1.0)?;
    assert!(is_off(&host) && host.rig.ways() == stood);
    assert!(!host.telemetry.context("no telemetry")?.state.latched());
    host.command(AHEAD)?;
    host.drive(0.5)?;
    assert!(host.rig.speeds()[0] > 0.1);
    Ok(())
}

#[test]
fn a_program_that_hangs_is_reset_by_the_watchdog_and_comes_back_disarmed() -> Result<()> {
    let mut host = driving()?;
    host.events.clear();
    let before = host.rig.seconds();
    // Longer than the interrupt that guards against silence would need, did it still come.
    host.rig.chip.hang(0.3)?;
    let after = host.rig.seconds() - before;
    println!("hang: reset after {:.0} ms", 1e3 * after);
    assert!(is_off(&host) && after < 0.15, "{after}");
    let is_up = |event: &LinkEvent| matches!(event, LinkEvent::Up(_));
    host.run_until(2.0, |host| host.events.iter().any(is_up))?;
    assert_eq!(host.events.first(), Some(&LinkEvent::Down(Down::Restarted)));
    let cause = host.events.iter().find_map(|event| match event {
        LinkEvent::Up(hello) => Some(hello.cause),
        _ => None,
    });
    assert_eq!(cause, Some(ResetCause::Watchdog));
    assert!(!host.link.is_armed() && is_off(&host));
    Ok(())
}

#[test]
fn greeting_a_robot_that_drives_stops_it() -> Result<()> {
    let mut host = driving()?;
    // A bridge that was killed and started again: it listens, then greets.
    // All but 0.05 of its half second of listening is over.
    let opened = slamlab_core::robot::Stamp::from_seconds(host.rig.seconds() - 0.45);
    host.link = slamlab_core::wire::rp6::Link::new(opened, 77);
    let off = host.run_until(1.0, is_off)?;
    assert!(off < 0.1, "{off}");
    host.run_until(1.0, |host| host.link.phase() == Phase::Running)?;
    let cause = host.events.iter().find_map(|event| match event {
        LinkEvent::Up(hello) => Some(hello.cause),
        _ => None,
    });
    assert_eq!(cause, Some(ResetCause::PowerOn));
    Ok(())
}

#[test]
fn noise_on_the_line_moves_nothing_and_is_survived() -> Result<()> {
    let (mut host, _) = Host::armed(Rig::new([0.0; 2])?)?;
    let mut state = 7_u64;
    for _ in 0..4_000 {
        state = state
            .wrapping_mul(6364136223846793005)
            .wrapping_add(1442695040888963407);
        host.rig.chip.receive((state >> 56) as u8);
        host.run(0.000_3)?;
        assert!(is_off(&host));
    }
    // It may have broken the link; the robot itself answers.
    host.run_until(4.0, |host| host.link.phase() == Phase::Running)?;
    host.link.arm()?;
    host.command(AHEAD)?;
    host.drive(0.5)?;
    assert!(host.rig.speeds()[0] > 0.1);
    Ok(())
}
