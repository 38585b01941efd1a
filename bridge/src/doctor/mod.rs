//! Looks at serial ports and says what is there, how well it works, and what to do where it does not.
//!
//! In: ports by name, or all of the machine. Out: a [`Finding`] for each, to be printed.
//!
//! 1. Each port is opened at the rate of each device that is known, the robot first: opening may have reset it, and its boot
//!    loader must hear nothing foreign. What answers as itself is that device.
//! 2. The very same code as in `serve` then brings the device up and runs it for some seconds; faults it names with their
//!    cures, and what came is counted: scans, odometry, damaged frames, bytes that belong to none.
//! 3. The device is stopped and the port closed.

mod finding;
mod visit;
mod words;

use std::time::Duration;

use slamlab_core::wire::message::DeviceState;
use slamlab_core::wire::revolution::RevolutionConfig;
use slamlab_core::wire::rplidar::driver::DriverConfig;

pub use finding::{Finding, Kind, Measured, Problem};

use crate::serial::{Device, Ld06, OpenError, Rp6, Rplidar};
use visit::{Visit, visit};

/// For a device that answers to say so: greetings to a robot take longest.
const TO_ANSWER: Duration = Duration::from_millis(3_200);
/// For a sensor that speaks unasked.
const TO_SPEAK: Duration = Duration::from_millis(800);
/// For a device that answered to show how it works, or what is wrong.
const TO_WORK: Duration = Duration::from_secs(6);

/// Serial ports of this machine.
///
/// # Errors    Where the system does not tell.
pub fn ports() -> Result<Vec<String>, serialport::Error> {
    let mut names: Vec<String> = serialport::available_ports()?
        .into_iter()
        .map(|port| port.port_name)
        .collect();
    names.sort();
    Ok(names)
}

/// Looks at one port. Takes up to a quarter of a minute.
#[must_use]
pub fn examine(path: &str) -> Finding {
    let mut others = Others::default();
    for kind in [Kind::Rp6, Kind::Ld06, Kind::Rplidar] {
        let patience = if kind == Kind::Ld06 {
            TO_SPEAK
        } else {
            TO_ANSWER
        };
        let mut device = device_of(kind);
        let seen = visit(&mut *device, path, patience, TO_WORK);
        match seen {
            Err(error) => return closed(path, &error),
            Ok(seen) if !seen.model.is_empty() => return met(path, kind, &seen),
            Ok(seen) => others.add(&seen),
        }
        if others.boot_loader.is_some() {
            break;
        }
    }
    others.finding(path)
}

fn device_of(kind: Kind) -> Box<dyn Device> {
    match kind {
        Kind::Rp6 => Box::new(Rp6::new("doctor")),
        Kind::Ld06 => Box::new(Ld06::new("doctor", RevolutionConfig::ld06())),
        Kind::Rplidar => Box::new(Rplidar::new("doctor", DriverConfig::default())),
    }
}

/// A port that does not open.
fn closed(path: &str, error: &OpenError) -> Finding {
    Finding {
        path: path.into(),
        kind: None,
        model: String::new(),
        measured: Measured::default(),
        problems: vec![Problem(error.to_string())],
    }
}

/// A device that said what it is.
fn met(path: &str, kind: Kind, seen: &Visit) -> Finding {
    let mut problems = vec![];
    if let Some(error) = &seen.broken {
        problems.push(Problem(error.clone()));
    }
    if seen.state == DeviceState::Fault || !seen.detail.is_empty() {
        problems.push(Problem(seen.detail.clone()));
    }
    let measured = seen.measured();
    problems.extend(noise(&measured));
    if problems.is_empty() && measured.scans == 0 && measured.odometries == 0 {
        problems.push(Problem(words::SENDS_NOTHING.into()));
    }
    Finding {
        path: path.into(),
        kind: Some(kind),
        model: seen.model.clone(),
        measured,
        problems,
    }
}

/// More damage than a good line does.
fn noise(measured: &Measured) -> Option<Problem> {
    // Up to a whole frame is lost where one began to listen in its middle.
    let is_noisy = measured.damaged > 2 && measured.skipped > 200;
    is_noisy.then(|| Problem(words::noisy(measured)))
}

/// What came of a port on which nothing said what it is.
#[derive(Debug, Default)]
struct Others {
    bytes: u64,
    boot_loader: Option<String>,
    broken: Option<String>,
}

impl Others {
    fn add(&mut self, seen: &Visit) {
        self.bytes += seen.bytes;
        if self.broken.is_none() {
            self.broken.clone_from(&seen.broken);
        }
        if seen.detail.contains("boot loader") || seen.detail.contains("shut down") {
            self.boot_loader = Some(seen.detail.clone());
        }
    }

    fn finding(self, path: &str) -> Finding {
        let kind = self.boot_loader.as_ref().map(|_| Kind::Rp6);
        let problem = match (self.boot_loader, self.broken, self.bytes) {
            (Some(text), ..) => text,
            (None, Some(error), _) => error,
            (None, None, 0) => words::NOTHING_ANSWERS.into(),
            (None, None, bytes) => words::unknown(bytes),
        };
        Finding {
            path: path.into(),
            kind,
            model: String::new(),
            measured: Measured::default(),
            problems: vec![Problem(problem)],
        }
    }
}
