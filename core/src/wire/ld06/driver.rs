//! Listens to an LD06, puts its packets together to scans, and names what is wrong.
//!
//! In: the sensor's bytes and the time. Out: [`Event`]s. The sensor takes no requests; there is nothing to bring up.
//!
//! 1. A packet's last reading was taken when the packet came; those before it each as much earlier as its spacing takes at
//!    the speed that it tells.
//! 2. Silence, bytes that are no packets, and a head that stands still (speed 0, or no whole turn) are faults; they end by
//!    themselves with the next scan.

use std::collections::VecDeque;

use super::{Decoder, Packet, READINGS};
use crate::robot::{Scan, Stamp};
use crate::wire::Tally;
use crate::wire::message::DeviceState;
use crate::wire::revolution::{Losses, RevolutionConfig, Revolutions, Sample};

/// Longest time without a whole turn, s. From power on the sensor's motor needs about 2 s.
const NO_TURN: f64 = 3.0;

/// Longest time without a byte that is no silence, s. The sensor sends 375 packets a second; a turn cut short by a pulled
/// plug is no motor that stands still.
const NO_BYTE: f64 = 1.0;

/// What the driver found.
#[derive(Clone, Debug, PartialEq)]
pub enum Event {
    /// The sensor's state changed.
    State(DeviceState),
    /// A whole turn.
    Scan(Scan),
    /// It does not work; the driver goes on listening.
    Fault(Fault),
}

/// Why the sensor does not work.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum Fault {
    /// Not a byte came.
    #[error(
        "the LD06 is silent: no power, or its data line (TX) is loose; check the plug and the 5 V supply"
    )]
    Silent,
    /// Bytes came, but no packet.
    #[error(
        "{bytes} bytes came, but no packet of an LD06: wrong baud rate or another device; it speaks at 230400 baud"
    )]
    NotUnderstood {
        /// How many bytes came.
        bytes: u64,
    },
    /// Packets come, but no whole turn.
    #[error(
        "the LD06 sends packets but no whole turn: its motor stands still; check its PWM line and that the head is free"
    )]
    DoesNotTurn,
}

/// An LD06, seen from the side of the host.
#[derive(Clone, Debug)]
pub struct Driver {
    decoder: Decoder,
    revolutions: Revolutions,
    events: VecDeque<Event>,
    state: DeviceState,
    /// Since when there was no scan, and the counts then.
    since: Stamp,
    before: Tally,
    /// When the last byte came.
    heard: Stamp,
}

impl Driver {
    /// A driver that begins to listen.
    #[must_use]
    pub fn new(config: RevolutionConfig, now: Stamp) -> Self {
        Self {
            decoder: Decoder::new(),
            revolutions: Revolutions::new(config),
            events: VecDeque::new(),
            state: DeviceState::Waiting,
            since: now,
            before: Tally::default(),
            heard: now,
        }
    }

    /// Takes bytes from the sensor, as they come.
    pub fn receive(&mut self, bytes: &[u8], now: Stamp) {
        if !bytes.is_empty() {
            self.heard = now;
        }
        self.decoder.extend(bytes);
        let packets: Vec<Packet> = self.decoder.by_ref().collect();
        let mut end = now.seconds() - packets.iter().map(duration).sum::<f64>();
        for packet in &packets {
            end += duration(packet);
            self.take(packet, end, now);
        }
    }

    /// Lets the driver see the time.
    pub fn tick(&mut self, now: Stamp) {
        if now.since(self.since) <= NO_TURN {
            return;
        }
        let fault = self.why_no_turn(now);
        self.revolutions.restart();
        self.begin_watch(now);
        self.enter(DeviceState::Fault);
        self.events.push_back(Event::Fault(fault));
    }

    /// The next thing to know.
    pub fn next_event(&mut self) -> Option<Event> {
        self.events.pop_front()
    }

    /// The sensor's state.
    #[must_use]
    pub fn state(&self) -> DeviceState {
        self.state
    }

    /// What became of the sensor's bytes.
    #[must_use]
    pub fn tally(&self) -> Tally {
        self.decoder.tally()
    }

    /// Which readings did not come through.
    #[must_use]
    pub fn losses(&self) -> Losses {
        self.revolutions.losses()
    }

    /// `end`: when the last reading of the packet was taken, s.
    fn take(&mut self, packet: &Packet, end: f64, now: Stamp) {
        if self.state == DeviceState::Waiting {
            self.enter(DeviceState::Connected);
        }
        let interval = interval(packet);
        for (i, (angle, range, quality)) in packet.polar().enumerate() {
            let sample = Sample {
                angle,
                range,
                quality: Some(quality),
                interval,
                stamp: Stamp::from_seconds(end - interval * (READINGS - 1 - i) as f64),
            };
            if let Some(scan) = self.revolutions.push(sample) {
                self.begin_watch(now);
                self.enter(DeviceState::Measuring);
                self.events.push_back(Event::Scan(scan));
            }
        }
    }

    fn why_no_turn(&self, now: Stamp) -> Fault {
        if now.since(self.heard) > NO_BYTE {
            return Fault::Silent;
        }
        let (tally, before) = (self.decoder.tally(), self.before);
        if tally.frames > before.frames {
            return Fault::DoesNotTurn;
        }
        let bytes = tally.bytes - before.bytes;
        Fault::NotUnderstood { bytes }
    }

    fn begin_watch(&mut self, now: Stamp) {
        self.since = now;
        self.before = self.decoder.tally();
    }

    fn enter(&mut self, state: DeviceState) {
        if self.state != state {
            self.state = state;
            self.events.push_back(Event::State(state));
        }
    }
}

/// Seconds from one reading to the next; 0 where the head stands still.
fn interval(packet: &Packet) -> f64 {
    if packet.speed == 0 {
        0.0
    } else {
        packet.spacing() / f64::from(packet.speed).to_radians()
    }
}

/// Seconds of a packet's readings.
fn duration(packet: &Packet) -> f64 {
    interval(packet) * READINGS as f64
}
