//! Looks at serial ports and says what is there, how well it works, and what to do where it does
//! not.
//!
//! In: ports by name, or all of the machine. Out: a [`Finding`] for each, to be printed.
//!
//! 1. Each port is opened at the rate of each device that is known, the robot first: opening may
//!    have reset it, and its boot loader must hear nothing foreign. What answers as itself is that
//!    device.
//! 2. The very same code as in `serve` then brings the device up and runs it for some seconds;
//!    faults it names with their cures, and what came is counted: scans, odometry, damaged frames,
//!    bytes that belong to none.
//! 3. The device is stopped and the port closed.

mod finding;
mod visit;
mod words;

use std::time::Duration;

use serialport::SerialPortType;
use slamlab_core::device::{KINDS, Kind, Probe, Role, UsbAdapter};
use slamlab_core::geom::Pose2;
use slamlab_core::wire::message::DeviceState;

pub use finding::{Finding, Measured};

use crate::serial::OpenError;
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
    let ports = serialport::available_ports()?.into_iter();
    let mut names: Vec<String> = ports.map(|port| port.port_name).collect();
    names.sort();
    Ok(names)
}

/// Looks at one port. Takes up to a quarter of a minute.
#[must_use]
pub fn examine(path: &str) -> Finding {
    Finding {
        adapter: adapter(path),
        ..find(path)
    }
}

fn find(path: &str) -> Finding {
    let mut others = Others::default();
    for kind in Kind::in_order_of_trial() {
        let patience = match kind.probe {
            Probe::Listen => TO_SPEAK,
            Probe::Ask | Probe::ByName => TO_ANSWER,
        };
        let mut device = (kind.open)("doctor".into(), Pose2::identity());
        match visit(&mut *device, path, patience, TO_WORK) {
            Err(error) => return closed(path, &error),
            Ok(seen) if !seen.model.is_empty() => return met(path, kind, &seen),
            Ok(seen) => others.add(kind, &seen),
        }
        if others.boot_loader.is_some() {
            break;
        }
    }
    others.finding(path)
}

/// The adapter of a port, where it is one that usually comes with a device that is known.
fn adapter(path: &str) -> Option<UsbAdapter> {
    let ports = serialport::available_ports().ok()?;
    let port = ports.into_iter().find(|port| port.port_name == path)?;
    let SerialPortType::UsbPort(usb) = port.port_type else {
        return None;
    };
    let mut known = KINDS.iter().flat_map(|kind| kind.adapters);
    known
        .find(|adapter| (adapter.vendor, adapter.product) == (usb.vid, usb.pid))
        .copied()
}

/// A port that does not open.
fn closed(path: &str, error: &OpenError) -> Finding {
    Finding {
        path: path.into(),
        problems: vec![error.to_string()],
        ..Finding::default()
    }
}

/// A device that said what it is.
fn met(path: &str, kind: &'static Kind, seen: &Visit) -> Finding {
    let mut problems: Vec<String> = seen.broken.iter().cloned().collect();
    if seen.state == DeviceState::Fault || !seen.detail.is_empty() {
        problems.push(seen.detail.clone());
    }
    let measured = seen.measured();
    problems.extend(noise(&measured));
    if problems.is_empty() && measured.scans == 0 && measured.odometries == 0 {
        problems.push(words::SENDS_NOTHING.into());
    }
    Finding {
        path: path.into(),
        kind: Some(kind),
        model: seen.model.clone(),
        measured,
        problems,
        ..Finding::default()
    }
}

/// More damage than a good line does.
fn noise(measured: &Measured) -> Option<String> {
    // Up to a whole frame is lost where one began to listen in its middle.
    let is_noisy = measured.damaged > 2 && measured.skipped > 200;
    is_noisy.then(|| words::noisy(measured))
}

/// What came of a port on which nothing said what it is.
#[derive(Debug, Default)]
struct Others {
    bytes: u64,
    /// A robot without a program, and what was heard of it.
    boot_loader: Option<(&'static Kind, String)>,
    /// Text that was read, and at which rate.
    text: Option<(u32, String)>,
    broken: Option<String>,
}

impl Others {
    fn add(&mut self, kind: &'static Kind, seen: &Visit) {
        self.bytes += seen.bytes;
        if self.broken.is_none() {
            self.broken.clone_from(&seen.broken);
        }
        if kind.role == Role::Robot
            && (seen.detail.contains("boot loader") || seen.detail.contains("shut down"))
        {
            self.boot_loader = Some((kind, seen.detail.clone()));
        }
        let text = seen.text().map(|text| (kind.baud_rate, text));
        self.text = self.text.take().or(text);
    }

    fn finding(self, path: &str) -> Finding {
        let kind = self.boot_loader.as_ref().map(|(kind, _)| *kind);
        let problem = match (self.boot_loader, self.broken, self.text, self.bytes) {
            (Some((_, text)), ..) => text,
            (None, Some(error), ..) => error,
            (None, None, Some((rate, text)), _) => words::speaks_text(rate, &text),
            (None, None, None, 0) => words::nothing_answers(&words::rates(), &words::listeners()),
            (None, None, None, bytes) => words::unknown(bytes, &words::rates_of_kinds()),
        };
        Finding {
            path: path.into(),
            kind,
            problems: vec![problem],
            ..Finding::default()
        }
    }
}
