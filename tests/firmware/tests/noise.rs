//! A line on which bits flip, while a driver goes.

use anyhow::Result;
use slamlab_core::wire::rp6::{Command, Phase};
use slamlab_firmware_tests::{Host, Rig};
use slamlab_tests::devices::Faults;

const TURN: Command = Command::Velocity {
    forward_mm_s: 0,
    turn_mrad_s: 600,
};
const TRIALS: u32 = 60;
/// From one speed to the next, s.
const BEAT: f64 = 0.05;

fn is_off(host: &Host) -> bool {
    host.rig.chip.duties() == [0, 0]
}

fn turn(host: &mut Host, beats: u32) -> Result<()> {
    for beat in 0..beats {
        if beat % 2 == 0 {
            host.command(Command::Alive)?;
        }
        host.command(TURN)?;
        host.run(BEAT)?;
    }
    Ok(())
}

/// Bits flip both ways, the driver is gone and the bridge stops the robot: it stops in time, and
/// whatever the noise makes of what is still on the line, it does not run again.
#[test]
fn a_robot_that_was_stopped_over_a_noisy_line_stays_stopped() -> Result<()> {
    let (mut host, _) = Host::armed(Rig::new([0.0; 2])?)?;
    let mut worst: f64 = 0.0;
    let mut numbers = slamlab_tests::numbers();
    for trial in 0..TRIALS {
        host.run_until(10.0, |host| host.link.phase() == Phase::Running)?;
        host.link.arm()?;
        turn(&mut host, 8)?;
        let wait = numbers.next().unwrap_or(0.0);
        host.run(BEAT * wait)?;
        assert!(!is_off(&host), "trial {trial}: it does not turn");
        host.faults = Faults {
            flipped_bits: 1e-3,
            ..Faults::default()
        };
        host.command(Command::Stop)?;
        let off = host.run_until(1.0, is_off)?;
        // While it brakes, the duty may pass through 0.
        let (mut last, start) = (off, host.rig.seconds() - off);
        let end = host.rig.seconds() + 1.0;
        while host.rig.seconds() < end {
            host.run(0.001)?;
            if !is_off(&host) {
                last = host.rig.seconds() - start;
            }
        }
        worst = worst.max(last);
        host.faults = Faults::default();
    }
    println!(
        "stop over a line with one bit in 1000 flipped: motors off for good after {:.0} ms at most",
        1e3 * worst
    );
    assert!(worst < 0.4, "{worst}");
    Ok(())
}
