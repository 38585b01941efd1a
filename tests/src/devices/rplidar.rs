//! An RPLIDAR A1 that sees a world of `core::sim`: requests in, answers, nodes and capsules out.

use std::f64::consts::TAU;

use slamlab_core::wire::rplidar::answer::{Descriptor, Health, Info, Rate, Status};
use slamlab_core::wire::rplidar::configuration::{self, Kind, Question};
use slamlab_core::wire::rplidar::express::{Capsule, READINGS, Reading};
use slamlab_core::wire::rplidar::node::Node;
use slamlab_core::wire::rplidar::request::{Request, RequestDecoder};

use super::{Device, View};

/// Readings per revolution in a standard scan; an express scan has twice as many.
const READINGS_OF_A_TURN: u64 = 360;
const RATE: Rate = Rate {
    standard_micros: 500,
    express_micros: 250,
};

/// Maximum range of an A1, m.
const MAX_METRES: u32 = 12;

/// The simulated lidar.
#[derive(Clone, Debug)]
pub struct Rplidar {
    /// What it sees.
    pub view: View,
    /// The health that it reports; an error also keeps it from scanning.
    pub status: Status,
    /// Whether a reset cures it.
    pub is_cured_by_reset: bool,
    /// Whether its head is blocked.
    pub is_blocked: bool,
    requests: RequestDecoder,
    scan: Scan,
    /// Readings since the start of the scan.
    readings: u64,
    /// Time not yet used for a reading, s.
    pending: f64,
    said: Vec<u8>,
    /// All requests that it received.
    pub asked: Vec<Request>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Scan {
    None,
    Standard,
    Express,
}

impl Rplidar {
    /// A healthy one.
    #[must_use]
    pub fn new(view: View) -> Self {
        Self {
            view,
            status: Status::Good,
            is_cured_by_reset: false,
            is_blocked: false,
            requests: RequestDecoder::default(),
            scan: Scan::None,
            readings: 0,
            pending: 0.0,
            said: vec![],
            asked: vec![],
        }
    }

    fn answer(&mut self, request: Request) {
        self.asked.push(request);
        match request {
            Request::Stop => self.scan = Scan::None,
            Request::Reset => {
                if self.is_cured_by_reset {
                    self.status = Status::Good;
                }
                self.power_on();
            }
            Request::Scan => self.begin(Scan::Standard, Descriptor::Scan),
            Request::ExpressScan => self.begin(Scan::Express, Descriptor::Express),
            Request::Info => {
                let info = Info {
                    model: 0x18,
                    firmware: [1, 29],
                    hardware: 7,
                    serial: *b"simulated lidar!",
                };
                self.single(Descriptor::Info, &info.encode());
            }
            Request::Health => {
                let error = if self.status == Status::Good {
                    0
                } else {
                    0x0102
                };
                let health = Health {
                    status: self.status,
                    error,
                };
                self.single(Descriptor::Health, &health.encode());
            }
            Request::Rate => self.single(Descriptor::Rate, &RATE.encode()),
            Request::Configuration(question) => self.said.extend(configured(question)),
            // An A1's motor is switched by DTR, which a pseudo-terminal does not have.
            _ => (),
        }
    }

    fn single(&mut self, descriptor: Descriptor, bytes: &[u8]) {
        self.said.extend(descriptor.encode());
        self.said.extend(bytes);
    }

    fn begin(&mut self, scan: Scan, descriptor: Descriptor) {
        if self.status == Status::Error {
            return;
        }
        self.scan = scan;
        self.readings = 0;
        self.pending = 0.0;
        self.said.extend(descriptor.encode());
    }

    /// Angle of a reading in 1/64°, clockwise.
    fn angle(&self, reading: u64, of_a_turn: u64) -> u16 {
        let reading = if self.is_blocked {
            40
        } else {
            reading % of_a_turn
        };
        (reading * 360 * 64 / of_a_turn) as u16
    }

    fn node(&self, reading: u64) -> Node {
        let angle = f64::from(self.angle(reading, READINGS_OF_A_TURN)) / (360.0 * 64.0) * TAU;
        let range = self.view.range(-angle).unwrap_or(0.0);
        Node {
            starts: reading.is_multiple_of(READINGS_OF_A_TURN),
            ..Node::new(angle, range, 15)
        }
    }

    /// The capsule that begins with this reading. Offsets are 0: every reading lies where even
    /// spacing puts it.
    fn capsule(&self, first: u64) -> Capsule {
        let of_a_turn = 2 * READINGS_OF_A_TURN;
        let mut readings = [Reading::default(); READINGS];
        for (reading, k) in readings.iter_mut().zip(first..) {
            let angle = f64::from(self.angle(k, of_a_turn)) / (360.0 * 64.0) * TAU;
            let millimetres = (self.view.range(-angle).unwrap_or(0.0) * 1e3).round();
            reading.distance = (millimetres as u16) << 2;
        }
        Capsule {
            starts: first == 0,
            start_angle: self.angle(first, of_a_turn),
            readings,
        }
    }

    fn scan(&mut self, seconds: f64) {
        self.pending += seconds;
        let (micros, at_once) = match self.scan {
            Scan::None => return,
            Scan::Standard => (RATE.standard_micros, 1),
            Scan::Express => (RATE.express_micros, READINGS as u64),
        };
        let each = f64::from(micros) * 1e-6 * at_once as f64;
        while self.pending >= each {
            self.pending -= each;
            if self.scan == Scan::Standard {
                self.said.extend(self.node(self.readings).encode());
            } else {
                self.said.extend(self.capsule(self.readings).encode());
            }
            self.readings += at_once;
        }
    }
}

/// The answer to a question about its two modes, standard and express; none for other modes.
fn configured(question: Question) -> Vec<u8> {
    let is_express = question.mode == 1;
    let micros = match is_express {
        true => RATE.express_micros,
        false => RATE.standard_micros,
    };
    let name: &[u8] = if is_express {
        b"Express\0"
    } else {
        b"Standard\0"
    };
    let is_of_mode = |kind| !matches!(kind, Kind::ModeCount | Kind::TypicalMode);
    match question.known() {
        Some(kind) if is_of_mode(kind) && question.mode > 1 => vec![],
        Some(kind) => {
            let value = match kind {
                Kind::ModeCount => 2_u16.to_le_bytes().to_vec(),
                Kind::TypicalMode => 1_u16.to_le_bytes().to_vec(),
                Kind::SampleTime => (256 * u32::from(micros)).to_le_bytes().to_vec(),
                Kind::MaxDistance => (256 * MAX_METRES).to_le_bytes().to_vec(),
                Kind::AnswerType => vec![if is_express { 0x82 } else { 0x81 }],
                Kind::ModeName => name.to_vec(),
            };
            configuration::answer(kind, &value)
        }
        None => vec![],
    }
}

impl Device for Rplidar {
    fn baud_rate(&self) -> u32 {
        115_200
    }

    fn power_on(&mut self) {
        self.requests = RequestDecoder::default();
        self.scan = Scan::None;
        self.said = b"RP LIDAR System.\r\nFirmware Ver 1.29, HW Ver 7\r\nModel: 18\r\n".to_vec();
    }

    fn receive(&mut self, bytes: &[u8]) {
        self.requests.extend(bytes);
        while let Some(request) = self.requests.next() {
            self.answer(request);
        }
    }

    fn advance(&mut self, seconds: f64) -> Vec<u8> {
        self.scan(seconds);
        std::mem::take(&mut self.said)
    }
}
