//! A bridge without network or threads, for one client in the same program: a page that opened the
//! serial ports itself.
//!
//! In: bytes of the lines, messages of the client ([`crate::wire::message::ToBridge`]), and the
//! time. Out: what the devices want done with their lines ([`Want`]), and messages for the client.
//! A [`Hub`] provides the same rules, state and messages as in any bridge.
//!
//! 1. Devices and their lines have numbers, in the order given; the first with a robot takes the
//!    orders.
//! 2. The client may drive and needs no token. [`LocalBridge::begin`] begins a new conversation and
//!    ends the one before, and with it the lease.
//! 3. What a device wants to log becomes a notice, because the page's log is the only one.
//!
//! Time starts anywhere; it is the same for all devices.

use std::collections::VecDeque;
use std::time::Duration;

use crate::robot::Stamp;
use crate::wire::message::{
    BridgeHello, CHALLENGE_BYTES, Format, FromBridge, Header, MessageError, RefusalReason, Right,
    Role, Severity, ToBridge, Watching, decode, encode,
};

use super::hub::{Action, Hub, hello};
use super::safety::ClientId;
use super::source::{Order, Profile, SourceEvent, robot_figures};
use super::{Device, Want, Weight};

/// Robot, sensors and rules for one client.
pub struct LocalBridge {
    lines: Vec<Line>,
    hub: Hub,
    hello: BridgeHello,
    /// The client, once it has said hello; before that, only the bridge's hello is sent.
    client: Option<ClientId>,
    now: Duration,
    sequence: u32,
    outgoing: Vec<Vec<u8>>,
}

/// A device and its line.
struct Line {
    device: Box<dyn Device>,
    name: String,
    /// A device at a closed line gets no ticks: silence means nothing there.
    is_open: bool,
    /// Number of the newest order.
    ordered: u64,
    /// What the device wanted before that order.
    waiting: VecDeque<Want>,
}

impl Line {
    /// Gives an order. What the device wanted before comes first, and counts as said before the
    /// order.
    fn order(&mut self, order: Order, number: u64, now: Stamp) {
        while let Some(want) = self.want_of_device() {
            self.waiting.push_back(want);
        }
        self.ordered = number;
        self.device.order(order, now);
    }

    fn next_want(&mut self) -> Option<Want> {
        self.waiting.pop_front().or_else(|| self.want_of_device())
    }

    fn want_of_device(&mut self) -> Option<Want> {
        let mut want = self.device.next_want()?;
        if let Want::Report(SourceEvent::Busy { after, .. }) = &mut want {
            *after = self.ordered;
        }
        Some(want)
    }
}

impl LocalBridge {
    /// A bridge with these devices, numbered as their lines; no line is open yet.
    #[must_use]
    pub fn new(devices: Vec<Box<dyn Device>>) -> Self {
        let profiles: Vec<Profile> = devices.iter().map(|device| device.profile()).collect();
        let sources: Vec<&Profile> = profiles.iter().collect();
        let robot = robot_figures(&sources);
        let line = |(device, profile): (Box<dyn Device>, &Profile)| Line {
            device,
            name: profile.name.clone(),
            is_open: false,
            ordered: 0,
            waiting: VecDeque::new(),
        };
        Self {
            hub: Hub::new(&sources),
            hello: hello([0; CHALLENGE_BYTES], Watching::Anyone, robot),
            lines: devices.into_iter().zip(&profiles).map(line).collect(),
            client: None,
            now: Duration::ZERO,
            sequence: 0,
            outgoing: vec![],
        }
    }

    /// Baud rate of a line; none if there is no such line.
    #[must_use]
    pub fn baud_rate(&self, line: usize) -> Option<u32> {
        self.lines.get(line).map(|line| line.device.baud_rate())
    }

    /// Says hello to a client that connects, or starts again.
    pub fn begin(&mut self, now: Duration) {
        self.now = now;
        if let Some(client) = self.client.take() {
            self.hub.leave(now, client);
            self.act();
        }
        let hello = FromBridge::Hello(self.hello.clone());
        self.send(&hello);
    }

    /// A line was opened.
    pub fn opened(&mut self, now: Duration, line: usize) {
        self.at(now, line, |line, stamp| {
            line.is_open = true;
            line.device.opened(stamp);
        });
    }

    /// Takes bytes that arrived on a line at `came`, which is before now if the program was busy
    /// meanwhile; it dates the readings.
    pub fn received(&mut self, now: Duration, came: Duration, line: usize, bytes: &[u8]) {
        self.at(now, line, |line, stamp| {
            line.device.receive(bytes, stamp_of(came.min(now)));
            line.device.tick(stamp);
        });
    }

    /// A line broke, or could not be opened; `why` names cause and cure.
    pub fn broken(&mut self, now: Duration, line: usize, why: &str) {
        self.at(now, line, |line, _| {
            line.is_open = false;
            line.device.broken(why.to_owned());
        });
    }

    /// The lines are about to be closed: what the devices want next stops the robot.
    pub fn close(&mut self, now: Duration) {
        self.now = now;
        self.hub.shut_down(now);
        self.act();
        for line in &mut self.lines {
            line.device.close(stamp_of(now));
        }
    }

    /// To be called some hundred times a second.
    pub fn tick(&mut self, now: Duration) {
        self.now = now;
        for line in self.lines.iter_mut().filter(|line| line.is_open) {
            line.device.tick(stamp_of(now));
        }
        self.hub.tick(now);
        self.act();
    }

    /// What the device at a line wants done next with its line.
    pub fn next_want(&mut self, number: usize) -> Option<Want> {
        loop {
            let line = self.lines.get_mut(number)?;
            match line.next_want()? {
                Want::Report(event) => self.hub.event(self.now, number as u8, event),
                Want::Note(weight, text) => {
                    let text = format!("{}: {text}", line.name);
                    match weight {
                        Weight::Detail | Weight::Info => (),
                        Weight::Warning => self.hub.notify(Severity::Warning, text),
                        Weight::Error => self.hub.notify(Severity::Error, text),
                    }
                }
                Want::Reopen => {
                    line.is_open = false;
                    return Some(Want::Reopen);
                }
                other => return Some(other),
            }
            self.act();
        }
    }

    /// Takes a message of the client.
    ///
    /// # Errors    [`MessageError`] if it is not a message.
    pub fn message(&mut self, now: Duration, bytes: &[u8]) -> Result<(), MessageError> {
        self.now = now;
        let (header, message) = decode::<ToBridge>(bytes, Format::Binary)?;
        match (self.client, message) {
            (None, ToBridge::Hello(hello)) => {
                // Whoever holds the cable is the owner.
                let right = Right {
                    role: Role::Owner,
                    name: String::new(),
                };
                self.client = Some(self.hub.join(hello.name, right));
            }
            (Some(client), message) => self.hub.message(now, now, client, header, message),
            (None, _) => (),
        }
        self.act();
        Ok(())
    }

    /// The person stops the robot, bypassing a client that may be busy; with `cut_off` the motors
    /// are cut off and stay off.
    pub fn stop(&mut self, now: Duration, cut_off: bool) {
        self.now = now;
        self.hub.stop(now, cut_off);
        self.act();
    }

    /// Messages for the client, in order; they are taken out of the bridge.
    pub fn take_outgoing(&mut self) -> Vec<Vec<u8>> {
        std::mem::take(&mut self.outgoing)
    }

    fn at(&mut self, now: Duration, line: usize, does: impl FnOnce(&mut Line, Stamp)) {
        self.now = now;
        if let Some(line) = self.lines.get_mut(line) {
            does(line, stamp_of(now));
        }
    }

    /// Carries out the hub's actions.
    fn act(&mut self) {
        while let Some(action) = self.hub.next_action() {
            match action {
                Action::Order {
                    source,
                    order,
                    number,
                } => {
                    if let Some(line) = self.lines.get_mut(source) {
                        line.order(order, number, stamp_of(self.now));
                    }
                }
                Action::Send(client, message) if self.client == Some(client) => self.send(&message),
                Action::SendAll(message) if self.client.is_some() => self.send(&message),
                // Here, only the page maps.
                Action::ResetMap(_) | Action::KeepGeofence(..) => {
                    self.send(&FromBridge::Refused(RefusalReason::NoMap))
                }
                // Nobody is connected; and the only client, which may drive, is never disconnected.
                Action::Send(..) | Action::SendAll(_) | Action::Close(..) => (),
            }
        }
    }

    fn send(&mut self, message: &FromBridge) {
        self.sequence += 1;
        let header = Header {
            sequence: self.sequence,
            micros: self.now.as_micros() as u64,
        };
        // A message that could not be written leaves a gap in the sequence.
        self.outgoing
            .extend(encode(header, message, Format::Binary).ok());
    }
}

fn stamp_of(time: Duration) -> Stamp {
    Stamp(time.as_micros() as u64)
}
