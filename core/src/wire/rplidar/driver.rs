//! Brings an RPLIDAR from whatever state it is in to measuring, keeps watch, and names what is wrong.
//!
//! In: the sensor's bytes and the time. Out: [`Event`]s: bytes to send, the motor's switch, scans, faults. No I/O.
//!
//! ```text
//! idle -start-> stopping -0.1 s-> information -> health -good-> rate -> starting -readings-> measuring
//!                   ^                              | error, first time            silence 1 s | banner
//!                   +------------- resetting <-----+ second time: fault                       v
//!                   +-------------------------------------------------------------------- once more
//! ```
//!
//! 1. A sensor that still scans is stopped first, and what it said before is thrown away.
//! 2. Each request is repeated twice. No answer at all, and bytes that are no answer, are different faults.
//! 3. Status 2 of health is the sensor's protection: it is reset once; if it comes again it is a fault.
//! 4. While measuring, silence, a head that does not turn, and a banner (it lost power) lead back to the start, at most
//!    [`MOST_RESTARTS`] times without a whole turn in between.
//!
//! Instants: the last reading of a piece of bytes was taken when the piece came, those before it each a sample time
//! earlier. So pieces should be handed over as soon as they come; what a USB bridge holds back makes a scan look later.
//!
//! Source: SLAMTEC interface protocol, "Protection stop" and "Health"; Pilch 2016 fig. 2.6.

use std::collections::VecDeque;

use super::answer::{Health, Info, Rate, Status};
use super::decoder::{Answer, Decoder};
use super::express::{Capsule, READINGS};
use super::node::Node;
use super::request::Request;
use crate::robot::{Scan, Stamp};
use crate::wire::Tally;
use crate::wire::message::DeviceState;
use crate::wire::revolution::{Losses, Revolutions, Sample};

mod config;
mod fault;

pub use config::{DriverConfig, ScanMode};
pub use fault::Fault;

/// Times that the sensor may fall silent or start anew without a whole turn in between.
pub const MOST_RESTARTS: u32 = 3;
/// Tries of each request.
const TRIES: u32 = 3;
/// From stop to the next request, s.
const AFTER_STOP: f64 = 0.1;
/// From reset to the next request, s: the A1 writes its banner within half a second.
const AFTER_RESET: f64 = 1.0;
/// For an answer, s.
const FOR_ANSWER: f64 = 0.5;
/// For the first reading, s: the motor has to come up to speed.
const FOR_READINGS: f64 = 5.0;
/// Longest silence while measuring, s.
const SILENCE: f64 = 1.0;
/// Longest turn while measuring, s: the slowest of the kin turns at 1 Hz.
const SLOWEST_TURN: f64 = 3.0;

/// What the driver wants done, and what it found.
#[derive(Clone, Debug, PartialEq)]
pub enum Event {
    /// Send these bytes.
    Send(Vec<u8>),
    /// Switch the motor: with the A1's board, on is DTR cleared.
    Motor(bool),
    /// The sensor's state changed.
    State(DeviceState),
    /// The sensor said what it is.
    Identified(Info),
    /// The sensor works, but warns; the code is the maker's own.
    Warning(u16),
    /// The sensor does not tell how long a reading takes (firmware before 1.17); that of an A1 is taken.
    RateUnknown,
    /// The sensor is brought up anew, for this reason.
    Restarting(Fault),
    /// A whole turn.
    Scan(Scan),
    /// It does not work, and trying again did not help. The driver stands still until [`Driver::start`].
    Fault(Fault),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Stage {
    Idle,
    Stopping,
    Resetting,
    Asking(Request),
    Starting,
    Measuring,
    Fault,
}

/// An RPLIDAR, seen from the side of the host.
#[derive(Clone, Debug)]
pub struct Driver {
    config: DriverConfig,
    decoder: Decoder,
    revolutions: Revolutions,
    events: VecDeque<Event>,
    stage: Stage,
    /// When the stage has lasted too long, or long enough.
    until: Stamp,
    tries: u32,
    restarts: u32,
    was_reset: bool,
    /// Bytes at the start of the try under way, to tell silence from noise.
    bytes_before: u64,
    rate: Rate,
    last_capsule: Option<Box<Capsule>>,
    last_reading: Stamp,
    last_turn: Stamp,
}

impl Driver {
    /// A driver that stands still.
    #[must_use]
    pub fn new(config: DriverConfig) -> Self {
        Self {
            revolutions: Revolutions::new(config.revolution.clone()),
            config,
            decoder: Decoder::new(),
            events: VecDeque::new(),
            stage: Stage::Idle,
            until: Stamp(0),
            tries: 0,
            restarts: 0,
            was_reset: false,
            bytes_before: 0,
            rate: config::RATE_OF_A1,
            last_capsule: None,
            last_reading: Stamp(0),
            last_turn: Stamp(0),
        }
    }

    /// Brings the sensor up, whatever it does now.
    pub fn start(&mut self, now: Stamp) {
        self.restarts = 0;
        self.was_reset = false;
        self.bytes_before = self.decoder.tally().bytes;
        self.send_stop(now);
    }

    /// Stops sensor and motor.
    pub fn stop(&mut self, now: Stamp) {
        self.send(Request::Stop);
        self.motor(false);
        self.enter(Stage::Idle, now, 0.0);
    }

    /// Takes bytes from the sensor, as they come.
    pub fn receive(&mut self, bytes: &[u8], now: Stamp) {
        self.decoder.extend(bytes);
        let (mut nodes, mut after) = (vec![], 0);
        while let Some(answer) = self.decoder.next() {
            match answer {
                Answer::Node(node) => nodes.push(node),
                Answer::Capsule { capsule, follows } => {
                    after = READINGS;
                    self.unroll(capsule, follows, &mut nodes);
                }
                other => self.take(other, now),
            }
        }
        if matches!(self.stage, Stage::Starting | Stage::Measuring) && !nodes.is_empty() {
            self.take_nodes(&nodes, after, now);
        }
    }

    /// Lets the driver see the time; at least every 50 ms, or its waits are longer.
    pub fn tick(&mut self, now: Stamp) {
        if self.stage == Stage::Measuring {
            self.watch(now);
        }
        if now < self.until {
            return;
        }
        match self.stage {
            Stage::Idle | Stage::Measuring | Stage::Fault => (),
            Stage::Stopping | Stage::Resetting => self.ask(Request::Info, now),
            Stage::Asking(Request::Rate) if self.tries >= TRIES => {
                self.events.push_back(Event::RateUnknown);
                self.begin_scan(now);
            }
            Stage::Asking(request) if self.tries >= TRIES => {
                let fault = self.silence_after(request);
                self.give_up(fault, now);
            }
            Stage::Asking(request) => self.repeat(request, now),
            Stage::Starting => self.restart(Fault::NoReadings, now),
        }
    }

    /// The next thing to do or to know.
    pub fn next_event(&mut self) -> Option<Event> {
        self.events.pop_front()
    }

    /// The sensor's state.
    #[must_use]
    pub fn state(&self) -> DeviceState {
        match self.stage {
            Stage::Idle | Stage::Stopping | Stage::Resetting => DeviceState::Waiting,
            Stage::Asking(Request::Info) => DeviceState::Waiting,
            Stage::Asking(_) | Stage::Starting => DeviceState::Connected,
            Stage::Measuring => DeviceState::Measuring,
            Stage::Fault => DeviceState::Fault,
        }
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

    fn take(&mut self, answer: Answer, now: Stamp) {
        match (self.stage, answer) {
            (Stage::Starting | Stage::Measuring, Answer::Restarted) => {
                self.restart(Fault::LostPower, now);
            }
            (Stage::Asking(Request::Info), Answer::Info(info)) => {
                self.events.push_back(Event::Identified(info));
                self.ask(Request::Health, now);
            }
            (Stage::Asking(Request::Health), Answer::Health(health)) => {
                self.take_health(health, now);
            }
            (Stage::Asking(Request::Rate), Answer::Rate(rate)) => {
                self.rate = rate;
                self.begin_scan(now);
            }
            // Late answers of an earlier try, the descriptor of the scan, the banner after a reset.
            _ => (),
        }
    }

    fn take_health(&mut self, health: Health, now: Stamp) {
        match health.status {
            Status::Error if self.was_reset => {
                let error = health.error;
                self.give_up(Fault::Protection { error }, now);
            }
            Status::Error => {
                self.was_reset = true;
                self.send(Request::Reset);
                self.decoder.expect_answer();
                self.enter(Stage::Resetting, now, AFTER_RESET);
            }
            Status::Warning => {
                self.events.push_back(Event::Warning(health.error));
                self.ask(Request::Rate, now);
            }
            Status::Good => self.ask(Request::Rate, now),
        }
    }

    /// Completes the capsule before this one, if nothing is missing between them.
    fn unroll(&mut self, capsule: Box<Capsule>, follows: bool, nodes: &mut Vec<Node>) {
        if let Some(last) = self.last_capsule.take().filter(|_| follows) {
            nodes.extend(last.nodes(capsule.start_angle));
        }
        self.last_capsule = Some(capsule);
    }

    /// `after`: how many readings the sensor has taken since the last of these.
    fn take_nodes(&mut self, nodes: &[Node], after: usize, now: Stamp) {
        if self.stage == Stage::Starting {
            self.last_turn = now;
            self.enter(Stage::Measuring, now, 0.0);
        }
        self.last_reading = now;
        let interval = self.interval();
        for (left, node) in (0..nodes.len()).rev().zip(nodes) {
            let age = interval * (left + after) as f64;
            let sample = Sample {
                angle: node.radians(),
                range: node.metres(),
                quality: (self.config.mode == ScanMode::Standard).then_some(node.quality),
                interval,
                stamp: Stamp::from_seconds(now.seconds() - age),
            };
            if let Some(scan) = self.revolutions.push(sample) {
                self.restarts = 0;
                self.last_turn = now;
                self.events.push_back(Event::Scan(scan));
            }
        }
    }

    /// Seconds of one reading.
    fn interval(&self) -> f64 {
        let micros = match self.config.mode {
            ScanMode::Standard => self.rate.standard_micros,
            ScanMode::Express => self.rate.express_micros,
        };
        f64::from(micros) * 1e-6
    }

    fn watch(&mut self, now: Stamp) {
        if now.since(self.last_reading) > SILENCE {
            self.restart(Fault::Silent, now);
        } else if now.since(self.last_turn) > SLOWEST_TURN {
            self.restart(Fault::DoesNotTurn, now);
        }
    }

    fn restart(&mut self, fault: Fault, now: Stamp) {
        self.restarts += 1;
        if self.restarts > MOST_RESTARTS {
            self.give_up(fault, now);
        } else {
            self.events.push_back(Event::Restarting(fault));
            self.was_reset = false;
            self.bytes_before = self.decoder.tally().bytes;
            self.send_stop(now);
        }
    }

    fn give_up(&mut self, fault: Fault, now: Stamp) {
        self.motor(false);
        self.enter(Stage::Fault, now, 0.0);
        self.events.push_back(Event::Fault(fault));
    }

    fn silence_after(&self, request: Request) -> Fault {
        match self.decoder.tally().bytes - self.bytes_before {
            0 => Fault::NoAnswer { request },
            bytes => Fault::NotUnderstood { request, bytes },
        }
    }

    fn send_stop(&mut self, now: Stamp) {
        self.send(Request::Stop);
        self.enter(Stage::Stopping, now, AFTER_STOP);
    }

    fn ask(&mut self, request: Request, now: Stamp) {
        self.tries = 0;
        self.repeat(request, now);
    }

    fn repeat(&mut self, request: Request, now: Stamp) {
        self.decoder.expect_answer();
        if self.tries == 0 {
            self.bytes_before = self.decoder.tally().bytes;
        }
        self.tries += 1;
        self.send(request);
        self.enter(Stage::Asking(request), now, FOR_ANSWER);
    }

    fn begin_scan(&mut self, now: Stamp) {
        self.revolutions.restart();
        self.last_capsule = None;
        self.motor(true);
        self.decoder.expect_answer();
        self.send(match self.config.mode {
            ScanMode::Standard => Request::Scan,
            ScanMode::Express => Request::ExpressScan,
        });
        self.enter(Stage::Starting, now, FOR_READINGS);
    }

    fn motor(&mut self, is_on: bool) {
        self.events.push_back(Event::Motor(is_on));
        if let Some(duty) = self.config.motor_duty {
            self.send(Request::MotorDuty(if is_on { duty } else { 0 }));
        }
    }

    fn send(&mut self, request: Request) {
        self.events.push_back(Event::Send(request.encode()));
    }

    fn enter(&mut self, stage: Stage, now: Stamp, seconds: f64) {
        let before = self.state();
        self.stage = stage;
        self.until = now.plus(seconds);
        if self.state() != before {
            self.events.push_back(Event::State(self.state()));
        }
    }
}

#[cfg(test)]
mod tests;
