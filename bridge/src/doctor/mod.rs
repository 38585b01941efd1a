//! Examines serial ports and says what is there, how well it works, and what to do if it does not.
//!
//! In: ports by name, or all ports of the machine. Out: a [`Finding`] for each, to be printed.
//!
//! 1. Each port is opened at the baud rate of each known device, the robot's first: opening may
//!    have reset the robot, and its boot loader must receive no foreign bytes. A device is
//!    recognised when it answers in its own protocol.
//! 2. The same code as in `serve` then starts the device and runs it for some seconds. It names
//!    faults with their cures; scans, odometry, damaged frames and bytes outside frames are
//!    counted.
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

/// Time for a device to answer when asked: greeting a robot takes longest.
const TO_ANSWER: Duration = Duration::from_millis(3_200);
/// Time for a sensor that sends unasked to be heard.
const TO_SPEAK: Duration = Duration::from_millis(800);
/// Time for a device that answered to show how well it works, or what is wrong.
const TO_WORK: Duration = Duration::from_secs(6);

/// Serial ports of this machine.
///
/// # Errors    If the system does not list them.
pub fn ports() -> Result<Vec<String>, serialport::Error> {
    let ports = serialport::available_ports()?.into_iter();
    let mut names: Vec<String> = ports.map(|port| port.port_name).collect();
    names.sort();
    Ok(names)
}

/// Examines one port. Takes up to 15 s.
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

/// The adapter of a port, if it is one that usually comes with a known device.
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

/// The finding of a port that does not open.
fn closed(path: &str, error: &OpenError) -> Finding {
    Finding {
        path: path.into(),
        problems: vec![error.to_string()],
        ..Finding::default()
    }
}

/// The finding of a device that said what it is.
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

/// The problem to report if the line damages more than a good one does.
fn noise(measured: &Measured) -> Option<String> {
    // Up to a whole frame is lost if listening began in its middle.
    let is_noisy = measured.damaged > 2 && measured.skipped > 200;
    is_noisy.then(|| words::noisy(measured))
}

/// What came from a port on which no device said what it is.
#[derive(Debug, Default)]
struct Others {
    bytes: u64,
    /// A robot without firmware, and what its boot loader sent.
    boot_loader: Option<(&'static Kind, String)>,
    /// Text that was read, and the baud rate at which it was.
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
