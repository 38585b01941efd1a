//! A simulated RP6 on a pseudo-terminal: the real firmware in a simulated controller, in a simulated world, in real time.
//!
//! In: the name of a built-in world (default `arena`). Out: the path of the serial port, on the first line; then it runs until it is
//! ended. Whoever opens the port finds a robot that was switched on before.
//!
//!     cargo run --manifest-path tests/firmware/Cargo.toml --bin rp6_sim -- arena

use std::fs::File;
use std::io::{ErrorKind, Read, Write};
use std::time::{Duration, Instant};

use anyhow::{Context, Result};
use rustix::fs::{Mode, OFlags};
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use rustix::termios::{OptionalActions, tcgetattr, tcsetattr};
use slamlab_core::sim::worlds;
use slamlab_firmware_tests::Rig;

/// How far real time may run ahead before the simulation stops trying to catch up.
const MOST_BEHIND: Duration = Duration::from_millis(500);

fn main() -> Result<()> {
    let name = std::env::args().nth(1).unwrap_or_else(|| "arena".into());
    let world = worlds::builtin(&name).with_context(|| format!("no built-in world `{name}`"))?;
    let (mut line, path, _slave) = open_line()?;
    println!("{path}");
    std::io::stdout().flush()?;
    run(&mut Rig::in_world(&world)?, &mut line)
}

fn run(rig: &mut Rig, line: &mut File) -> Result<()> {
    let mut began = Instant::now();
    let mut offset = rig.seconds();
    loop {
        let due = offset + began.elapsed().as_secs_f64();
        if due - rig.seconds() > MOST_BEHIND.as_secs_f64() {
            (began, offset) = (Instant::now(), rig.seconds());
        }
        while rig.seconds() < due {
            rig.step()?;
        }
        let sent = rig.chip.take_sent();
        // A full line loses bytes, as a real one does.
        match line.write(&sent) {
            Err(error) if error.kind() != ErrorKind::WouldBlock => return Err(error.into()),
            _ => (),
        }
        let mut bytes = [0; 64];
        match line.read(&mut bytes) {
            Ok(count) => bytes
                .iter()
                .take(count)
                .for_each(|&byte| rig.chip.receive(byte)),
            Err(error) if error.kind() == ErrorKind::WouldBlock => (),
            Err(error) => return Err(error.into()),
        }
        std::thread::sleep(Duration::from_millis(2));
    }
}

/// The controller's end of a line, the path of the other end, and that end held open: or reading here would fail whenever
/// nobody else has it.
fn open_line() -> Result<(File, String, File)> {
    let controller = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY)?;
    grantpt(&controller)?;
    unlockpt(&controller)?;
    let path = ptsname(&controller, Vec::new())?.into_string()?;
    let flags = OFlags::RDWR | OFlags::NOCTTY;
    let slave = rustix::fs::open(path.as_str(), flags, Mode::empty())?;
    // Bytes as they are: no echo, no line ends made of others.
    let mut raw = tcgetattr(&slave)?;
    raw.make_raw();
    tcsetattr(&slave, OptionalActions::Now, &raw)?;
    rustix::fs::fcntl_setfl(&controller, OFlags::NONBLOCK)?;
    Ok((controller.into(), path, slave.into()))
}
