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

/// How long the line is waited for at a time: orders wait no longer either.
const TURN: Duration = Duration::from_millis(5);
/// For what must still be said before the line closes.
const LAST_WORDS: Duration = Duration::from_millis(100);

/// The first pause between tries to open a line; each is twice as long as the one before.
const FIRST_PAUSE: Duration = Duration::from_millis(250);
/// Up to this.
const LONGEST_PAUSE: Duration = Duration::from_secs(2);

/// The instant from which the stamps of all serial sources of this program count: scans and
/// odometry of different devices lie on one time line.
static EPOCH: OnceLock<Instant> = OnceLock::new();

/// A [`Device`] on a line that is opened again and again.
pub struct DeviceSource {
    device: Box<dyn Device>,
    open: Opener,
}

/// Opens the line; or says why not, with cause and cure.
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

/// A device with its way to the bridge.
struct Life {
    device: Box<dyn Device>,
    port: Port,
    began: Instant,
    pause: Duration,
}

impl Life {
    /// Serves an open line until it breaks or the bridge ends.
    fn serve(&mut self, line: &mut dyn Channel) -> Left {
        // Orders from before do not count: nothing moves by itself when a cable is put back.
        while let Waited::Order(_) = self.port.wait(Duration::ZERO) {}
        self.device.opened(self.now());
        loop {
            match line.receive(TURN) {
                Received::Bytes(bytes, came) => self.device.receive(&bytes, self.at(came)),
                Received::Nothing => (),
                Received::Broken(error) => return Left::Broken(error),
            }
            // What the device reports of the time before an order goes out before the order is
            // taken: each report says after which order it was made.
            self.device.tick(self.now());
            if let Err(left) = self.fulfil(line) {
                return left;
            }
            match self.port.wait(Duration::ZERO) {
                Waited::Order(order) => self.device.order(order, self.now()),
                Waited::Nothing => continue,
                Waited::Closed => {
                    self.device.close(self.now());
                    // A line that breaks now has nobody left to tell.
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

    /// Does what the device wants done.
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

    /// Waits before the next try; whether the bridge ended meanwhile. Orders are forgotten.
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
