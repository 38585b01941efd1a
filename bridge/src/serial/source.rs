//! The life of a device on a line: open, serve, close, wait, open again.

use std::sync::OnceLock;
use std::time::{Duration, Instant};

use slamlab_core::robot::Stamp;

use super::line::{Channel, Line, LineError, Received};
use super::open::PortSettings;
use super::{Device, Want, note};
use crate::source::{Port, Profile, Source, Waited};
use crate::udp::UdpAddress;

#[cfg(test)]
mod tests;

/// How long one read waits for bytes; so orders wait no longer than this either.
const TURN: Duration = Duration::from_millis(5);
/// Time for the last bytes to be sent before the line closes.
const LAST_WORDS: Duration = Duration::from_millis(100);

/// The first pause between tries to open a line; each is twice as long as the one before.
const FIRST_PAUSE: Duration = Duration::from_millis(250);
/// The longest pause.
const LONGEST_PAUSE: Duration = Duration::from_secs(2);

/// The instant from which the stamps of all serial sources of this program count: scans and
/// odometry of different devices share one time line.
static EPOCH: OnceLock<Instant> = OnceLock::new();

/// A [`Device`] on a line that is opened again and again.
pub struct DeviceSource {
    device: Box<dyn Device>,
    open: Opener,
}

/// Opens the line, or says why it cannot, with cause and cure.
type Opener = Box<dyn Fn() -> Result<Box<dyn Channel>, String> + Send>;

/// Why a line was left.
enum Left {
    Broken(LineError),
    Reopen,
    Closed,
}

impl DeviceSource {
    /// A device at this serial port.
    #[must_use]
    pub fn at_port(device: Box<dyn Device>, path: impl Into<String>) -> Self {
        let settings = PortSettings {
            path: path.into(),
            baud_rate: device.baud_rate(),
        };
        Self::new(device, move || Line::open(&settings))
    }

    /// A device behind this UDP server.
    #[must_use]
    pub fn by_udp(device: Box<dyn Device>, address: UdpAddress) -> Self {
        Self::new(device, move || address.open())
    }

    fn new<C: Channel + 'static, E: ToString>(
        device: Box<dyn Device>,
        open: impl Fn() -> Result<C, E> + Send + 'static,
    ) -> Self {
        let open: Opener = Box::new(move || match open() {
            Ok(line) => Ok(Box::new(line)),
            Err(why) => Err(why.to_string()),
        });
        Self { device, open }
    }
}

impl Source for DeviceSource {
    fn profile(&self) -> Profile {
        self.device.profile()
    }

    fn run(self: Box<Self>, port: Port) {
        let Self { device, open } = *self;
        let mut life = Life {
            device,
            port,
            began: *EPOCH.get_or_init(Instant::now),
            pause: FIRST_PAUSE,
        };
        loop {
            match open() {
                Ok(mut line) => match life.serve(&mut *line) {
                    Left::Closed => return,
                    Left::Broken(error) => life.device.broken(error.to_string()),
                    Left::Reopen => (),
                },
                Err(why) => life.device.broken(why),
            }
            life.report();
            if life.rest() {
                return;
            }
        }
    }
}

/// A device with its port to the bridge.
struct Life {
    device: Box<dyn Device>,
    port: Port,
    began: Instant,
    pause: Duration,
}

impl Life {
    /// Serves an open line until it breaks or the bridge ends.
    fn serve(&mut self, line: &mut dyn Channel) -> Left {
        // Drop earlier orders: nothing moves by itself when a cable is put back.
        while let Waited::Order(_) = self.port.wait(Duration::ZERO) {}
        self.device.opened(self.now());
        loop {
            match line.receive(TURN) {
                Received::Bytes(bytes, came) => self.device.receive(&bytes, self.at(came)),
                Received::Nothing => (),
                Received::Broken(error) => return Left::Broken(error),
            }
            // Send the device's reports before taking the next order: each report says after which
            // order it was made.
            self.device.tick(self.now());
            if let Err(left) = self.fulfil(line) {
                return left;
            }
            match self.port.wait(Duration::ZERO) {
                Waited::Order(order) => self.device.order(order, self.now()),
                Waited::Nothing => continue,
                Waited::Closed => {
                    self.device.close(self.now());
                    // Nobody is left to be told of a line that breaks now.
                    let _ = self.fulfil(line);
                    std::thread::sleep(LAST_WORDS);
                    return Left::Closed;
                }
            }
            if let Err(left) = self.fulfil(line) {
                return left;
            }
        }
    }

    /// Carries out what the device wants.
    fn fulfil(&mut self, line: &mut dyn Channel) -> Result<(), Left> {
        while let Some(want) = self.device.next_want() {
            match want {
                Want::Write(bytes) => line.send(bytes).map_err(Left::Broken)?,
                Want::Dtr(is_set) => line.set_dtr(is_set),
                Want::Report(event) => self.port.send(event),
                Want::Well => self.pause = FIRST_PAUSE,
                Want::Reopen => return Err(Left::Reopen),
                Want::Note(weight, text) => note(&self.device.profile().name, weight, &text),
            }
        }
        Ok(())
    }

    /// Reports to the bridge, with no line to write to.
    fn report(&mut self) {
        while let Some(want) = self.device.next_want() {
            match want {
                Want::Report(event) => self.port.send(event),
                Want::Note(weight, text) => note(&self.device.profile().name, weight, &text),
                _ => (),
            }
        }
    }

    /// Waits before the next try; true if the bridge ended meanwhile. Orders are dropped.
    fn rest(&mut self) -> bool {
        let until = Instant::now() + self.pause;
        self.pause = (2 * self.pause).min(LONGEST_PAUSE);
        loop {
            let left = until.saturating_duration_since(Instant::now());
            if left.is_zero() {
                return false;
            }
            if self.port.wait(left) == Waited::Closed {
                return true;
            }
        }
    }

    fn now(&self) -> Stamp {
        self.at(Instant::now())
    }

    fn at(&self, instant: Instant) -> Stamp {
        Stamp(instant.saturating_duration_since(self.began).as_micros() as u64)
    }
}
