//! A SLAMTEC RPLIDAR A1: brought from any state to measuring, then watched; its faults are named.
//!
//! ```text
//! idle -opened-> stopping -0.1 s-> information -> health -good-> rate -> starting -readings-> measuring
//!                    ^                              | error, first time            silence 1 s | banner
//!                    +------------- resetting <-----+ second time: fault                       v
//!                    +-------------------------------------------------------------------- once more
//! ```
//!
//! 1. A sensor that is still scanning is stopped first, and what it sent before is thrown away.
//! 2. Each request is repeated twice. No answer at all and bytes that are no answer are different
//!    faults.
//! 3. Health status 2 is the sensor's protection stop. It is reset once; if the status comes again,
//!    it is a fault.
//! 4. While measuring, silence, a head that does not turn, and a banner (the sensor lost power)
//!    lead back to the start, at most [`MOST_RESTARTS`] times without a whole turn in between.
//!
//! Instants: the last reading of a piece of bytes counts as taken when the piece arrived, each one
//! before it a sample time earlier. So pieces should be passed on as soon as they arrive: if a USB
//! bridge holds bytes back, the scan is dated later than it was taken.
//! Source: SLAMTEC interface protocol, "Protection stop" and "Health"; Pilch 2016 fig. 2.6.

mod fault;

use crate::device::lidar::revolution::Figures;
use crate::device::lidar::{LidarProtocol, Output};
use crate::device::line::{Want, Weight};
use crate::robot::Stamp;
use crate::wire::Tally;
use crate::wire::message::DeviceState;
use crate::wire::rplidar::answer::{Health, Info, Rate, Status};
use crate::wire::rplidar::decoder::{Answer, Decoder};
use crate::wire::rplidar::express::{Capsule, READINGS};
use crate::wire::rplidar::node::Node;
use crate::wire::rplidar::request::Request;

pub use fault::RplidarFault;

/// What an A1 answers: 2 000 and 4 000 readings a second.
pub(super) const RATE_OF_A1: Rate = Rate {
    standard_micros: 500,
    express_micros: 250,
};
/// How often the sensor may fall silent or restart without a whole turn in between.
pub const MOST_RESTARTS: u32 = 3;
/// Tries of each request.
const TRIES: u32 = 3;
/// From stop to the next request, s.
const AFTER_STOP: f64 = 0.1;
/// From reset to the next request, s: the A1 writes its banner within half a second.
const AFTER_RESET: f64 = 1.0;
/// Time for an answer, s.
const FOR_ANSWER: f64 = 0.5;
/// Time for the first reading, s: the motor has to come up to speed.
const FOR_READINGS: f64 = 5.0;

/// How readings are sent.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ScanMode {
    /// One by one, with quality.
    #[default]
    Standard,
    /// 32 in a capsule: twice as many, checked by a sum, without quality. Firmware 1.17 and later.
    Express,
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

/// What is specific to an RPLIDAR.
#[derive(Debug)]
pub struct Rplidar {
    mode: ScanMode,
    decoder: Decoder,
    stage: Stage,
    /// End of the stage: it has lasted too long, or long enough.
    until: Stamp,
    tries: u32,
    restarts: u32,
    was_reset: bool,
    /// Byte count at the start of the current try, to tell silence from noise.
    bytes_before: u64,
    rate: Rate,
    last_capsule: Option<Box<Capsule>>,
}

impl Rplidar {
    /// A sensor of which nothing is known yet.
    #[must_use]
    pub fn new(mode: ScanMode) -> Self {
        Self {
            mode,
            decoder: Decoder::default(),
            stage: Stage::Idle,
            until: Stamp(0),
            tries: 0,
            restarts: 0,
            was_reset: false,
            bytes_before: 0,
            rate: RATE_OF_A1,
            last_capsule: None,
        }
    }

    fn answered(&mut self, answer: Answer, output: &mut Output, now: Stamp) {
        match (self.stage, answer) {
            (Stage::Starting | Stage::Measuring, Answer::Restarted) => {
                self.restart(&RplidarFault::LostPower, output, now);
            }
            (Stage::Asking(Request::Info), Answer::Info(info)) => {
                output.report.model = model(&info);
                self.ask(Request::Health, output, now);
            }
            (Stage::Asking(Request::Health), Answer::Health(health)) => {
                self.examined(health, output, now);
            }
            (Stage::Asking(Request::Rate), Answer::Rate(rate)) => {
                self.rate = rate;
                self.begin_scan(output, now);
            }
            // Late answers to an earlier try, the descriptor of the scan, the banner after a reset.
            _ => (),
        }
    }

    fn examined(&mut self, health: Health, output: &mut Output, now: Stamp) {
        match health.status {
            Status::Error if self.was_reset => {
                let error = health.error;
                self.give_up(&RplidarFault::Protection { error }, output, now);
            }
            Status::Error => {
                self.was_reset = true;
                output.report.write(Request::Reset.encode());
                self.decoder.expect_answer();
                self.enter(Stage::Resetting, output, now, AFTER_RESET);
            }
            Status::Warning => {
                output.warn(warning(health.error));
                self.ask(Request::Rate, output, now);
            }
            Status::Good => self.ask(Request::Rate, output, now),
        }
    }

    /// Completes the previous capsule, if nothing is missing between it and this one.
    fn unroll(&mut self, capsule: Box<Capsule>, follows: bool, nodes: &mut Vec<Node>) {
        if let Some(last) = self.last_capsule.take().filter(|_| follows) {
            nodes.extend(last.nodes(capsule.start_angle));
        }
        self.last_capsule = Some(capsule);
    }

    /// `after`: how many readings the sensor has taken since the last of these.
    fn measured(&mut self, nodes: &[Node], after: usize, output: &mut Output, now: Stamp) {
        if self.stage == Stage::Starting {
            output.watch(now);
            self.enter(Stage::Measuring, output, now, 0.0);
        }
        output.heard(now);
        let (micros, has_quality) = match self.mode {
            ScanMode::Standard => (self.rate.standard_micros, true),
            ScanMode::Express => (self.rate.express_micros, false),
        };
        let interval = f64::from(micros) * 1e-6;
        let end = now.seconds() - interval * after as f64;
        let reading = |node: &Node| {
            let quality = has_quality.then_some(node.quality);
            (node.radians(), node.metres(), quality)
        };
        if output.take(nodes.iter().map(reading), interval, end, now) {
            self.restarts = 0;
        }
    }

    fn restart(&mut self, fault: &RplidarFault, output: &mut Output, now: Stamp) {
        self.restarts += 1;
        if self.restarts > MOST_RESTARTS {
            self.give_up(fault, output, now);
        } else {
            output
                .report
                .note(Weight::Warning, format!("{fault}; it is brought up again"));
            output.report.detail = fault.to_string();
            self.bring_up(output, now);
        }
    }

    fn give_up(&mut self, fault: &RplidarFault, output: &mut Output, now: Stamp) {
        set_motor(output, false);
        self.enter(Stage::Fault, output, now, 0.0);
        output.fail(fault);
        output.report.want(Want::Reopen);
    }

    fn silence_after(&self, request: Request) -> RplidarFault {
        match self.decoder.tally().bytes - self.bytes_before {
            0 => RplidarFault::NoAnswer { request },
            bytes => RplidarFault::NotUnderstood { request, bytes },
        }
    }

    fn bring_up(&mut self, output: &mut Output, now: Stamp) {
        self.was_reset = false;
        self.bytes_before = self.decoder.tally().bytes;
        output.report.write(Request::Stop.encode());
        self.enter(Stage::Stopping, output, now, AFTER_STOP);
    }

    fn ask(&mut self, request: Request, output: &mut Output, now: Stamp) {
        self.tries = 0;
        self.repeat(request, output, now);
    }

    fn repeat(&mut self, request: Request, output: &mut Output, now: Stamp) {
        self.decoder.expect_answer();
        if self.tries == 0 {
            self.bytes_before = self.decoder.tally().bytes;
        }
        self.tries += 1;
        output.report.write(request.encode());
        self.enter(Stage::Asking(request), output, now, FOR_ANSWER);
    }

    fn begin_scan(&mut self, output: &mut Output, now: Stamp) {
        self.last_capsule = None;
        set_motor(output, true);
        self.decoder.expect_answer();
        let request = match self.mode {
            ScanMode::Standard => Request::Scan,
            ScanMode::Express => Request::ExpressScan,
        };
        output.report.write(request.encode());
        self.enter(Stage::Starting, output, now, FOR_READINGS);
    }

    fn enter(&mut self, stage: Stage, output: &mut Output, now: Stamp, seconds: f64) {
        self.stage = stage;
        self.until = now.plus(seconds);
        match stage {
            Stage::Idle | Stage::Stopping | Stage::Resetting | Stage::Asking(Request::Info) => {
                output.enter(DeviceState::Waiting);
            }
            Stage::Asking(_) | Stage::Starting => output.enter(DeviceState::Connected),
            // Only a whole turn shows that it works; a fault reports its reason itself.
            Stage::Measuring | Stage::Fault => (),
        }
    }
}

impl LidarProtocol for Rplidar {
    /// That of the A1.
    const BAUD_RATE: u32 = 115_200;

    /// SLAMTEC RPLIDAR A1: 0.15 to 12 m, σ rounded up from the 1 % of its data sheet, as in `sim`.
    const FIGURES: Figures = Figures {
        min_range: 0.15,
        max_range: 12.0,
        sigma: 0.01,
        sigma_per_metre: 0.005,
    };

    fn opened(&mut self, output: &mut Output, now: Stamp) {
        *self = Self::new(self.mode);
        self.bring_up(output, now);
    }

    fn receive(&mut self, bytes: &[u8], output: &mut Output, now: Stamp) {
        self.decoder.extend(bytes);
        let (mut nodes, mut after) = (vec![], 0);
        while let Some(answer) = self.decoder.next() {
            match answer {
                Answer::Node(node) => nodes.push(node),
                Answer::Capsule { capsule, follows } => {
                    after = READINGS;
                    self.unroll(capsule, follows, &mut nodes);
                }
                other => self.answered(other, output, now),
            }
        }
        if matches!(self.stage, Stage::Starting | Stage::Measuring) && !nodes.is_empty() {
            self.measured(&nodes, after, output, now);
        }
    }

    fn tick(&mut self, output: &mut Output, now: Stamp) {
        if self.stage == Stage::Measuring {
            if output.is_silent(now) {
                self.restart(&RplidarFault::Silent, output, now);
            } else if output.does_not_turn(now) {
                self.restart(&RplidarFault::DoesNotTurn, output, now);
            }
        }
        if now < self.until {
            return;
        }
        match self.stage {
            Stage::Idle | Stage::Measuring | Stage::Fault => (),
            Stage::Stopping | Stage::Resetting => self.ask(Request::Info, output, now),
            Stage::Asking(Request::Rate) if self.tries >= TRIES => {
                let text = "does not tell its rate; 500 µs a reading are taken".to_owned();
                output.report.note(Weight::Info, text);
                self.begin_scan(output, now);
            }
            Stage::Asking(request) if self.tries >= TRIES => {
                self.give_up(&self.silence_after(request), output, now);
            }
            Stage::Asking(request) => self.repeat(request, output, now),
            Stage::Starting => self.restart(&RplidarFault::NoReadings, output, now),
        }
    }

    fn close(&mut self, output: &mut Output, now: Stamp) {
        output.report.write(Request::Stop.encode());
        set_motor(output, false);
        self.enter(Stage::Idle, output, now, 0.0);
    }

    fn tally(&self) -> Tally {
        self.decoder.tally()
    }
}

/// The A1's board runs the motor while DTR is cleared.
fn set_motor(output: &mut Output, is_on: bool) {
    output.report.want(Want::Dtr(!is_on));
}

/// The lidar's own warning in words.
#[must_use]
pub fn warning(code: u16) -> String {
    format!("the lidar warns ({code:#06x}): it may soon stop; check its supply")
}

/// The sensor's description of itself. The high digit of a model is the series, the low one the
/// model within it (maker's driver).
fn model(info: &Info) -> String {
    let (series, member) = (info.model >> 4, info.model & 0xF);
    let name = match series {
        1 => format!("RPLIDAR A1M{member}"),
        2 => format!("RPLIDAR A2M{member}"),
        3 => format!("RPLIDAR A3M{member}"),
        _ => format!("RPLIDAR, model {:#04x}", info.model),
    };
    let [major, minor] = info.firmware;
    format!(
        "{name}, firmware {major}.{minor:02}, hardware {}",
        info.hardware
    )
}

#[cfg(test)]
mod tests;
