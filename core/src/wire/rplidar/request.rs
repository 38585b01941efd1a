//! Requests to the sensor, and their decoder for a simulated sensor.

use super::SYNC;
use super::configuration::{self, Question};
use crate::wire::inbox::{Inbox, Tally};

/// Requests to the sensor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Request {
    /// Stop scanning.
    Stop,
    /// Restart, as after power-on.
    Reset,
    /// Scan, one reading per node.
    Scan,
    /// Scan, 32 readings per capsule.
    ExpressScan,
    /// Model, versions, serial number.
    Info,
    /// Whether it can work.
    Health,
    /// Sample times.
    Rate,
    /// A question about the scan modes.
    Configuration(Question),
}

impl Request {
    /// Those whose bytes are always the same.
    const PLAIN: [Self; 7] = [
        Self::Stop,
        Self::Reset,
        Self::Scan,
        Self::ExpressScan,
        Self::Info,
        Self::Health,
        Self::Rate,
    ];

    /// The bytes to send.
    ///
    /// # Example
    /// ```
    /// use slamlab_core::wire::rplidar::request::Request;
    /// assert_eq!(Request::Scan.encode(), [0xA5, 0x20]);
    /// assert_eq!(Request::ExpressScan.encode(), [0xA5, 0x82, 5, 0, 0, 0, 0, 0, 0x22]);
    /// ```
    #[must_use]
    pub fn encode(self) -> Vec<u8> {
        let command = match self {
            Self::Stop => 0x25,
            Self::Reset => 0x40,
            Self::Scan => 0x20,
            Self::ExpressScan => 0x82,
            Self::Info => 0x50,
            Self::Health => 0x52,
            Self::Rate => 0x59,
            Self::Configuration(_) => configuration::COMMAND,
        };
        let mut bytes = vec![SYNC, command];
        let payload = match self {
            Self::ExpressScan => vec![0; 5],
            Self::Configuration(question) => question.payload(),
            _ => return bytes,
        };
        bytes.push(payload.len() as u8);
        bytes.extend(payload);
        bytes.push(xor(&bytes));
        bytes
    }
}

/// Decodes requests, as the sensor does.
#[derive(Clone, Debug, Default)]
pub struct RequestDecoder {
    inbox: Inbox,
}

impl RequestDecoder {
    /// Takes bytes as they arrive.
    pub fn extend(&mut self, bytes: &[u8]) {
        self.inbox.extend(bytes);
    }

    /// Counts of the bytes.
    #[must_use]
    pub fn tally(&self) -> Tally {
        self.inbox.tally()
    }
}

impl Iterator for RequestDecoder {
    type Item = Request;

    /// The next complete request.
    fn next(&mut self) -> Option<Request> {
        while self.inbox.len() > 0 {
            if let Some(read) = self.configuration() {
                match read {
                    Read::Whole(question) => return Some(Request::Configuration(question)),
                    Read::Waits => return None,
                    Read::Spoilt => continue,
                }
            }
            let mut all = Request::PLAIN
                .map(|request| (request, request.encode()))
                .into_iter();
            match all.find(|(_, bytes)| self.inbox.may_begin(bytes)) {
                Some((request, bytes)) if self.inbox.len() >= bytes.len() => {
                    self.inbox.accept(bytes.len());
                    return Some(request);
                }
                Some(_) => return None,
                None => self.inbox.discard(1),
            }
        }
        None
    }
}

/// The result of reading a question about the configuration.
enum Read {
    Whole(Question),
    Waits,
    Spoilt,
}

impl RequestDecoder {
    /// A question about the configuration, if one begins here.
    fn configuration(&mut self) -> Option<Read> {
        let [sync, command] = self.inbox.peek(0)?;
        if [sync, command] != [SYNC, configuration::COMMAND] {
            return None;
        }
        let Some([length]) = self.inbox.peek(2) else {
            return Some(Read::Waits);
        };
        let whole = 3 + usize::from(length) + 1;
        if self.inbox.len() < whole {
            return Some(Read::Waits);
        }
        let bytes: Vec<u8> = (0..whole)
            .filter_map(|at| self.inbox.peek(at).map(|[byte]| byte))
            .collect();
        let question = match bytes.split_last() {
            Some((check, rest)) if xor(rest) == *check => rest.get(3..).and_then(Question::of),
            _ => None,
        };
        Some(match question {
            Some(question) => {
                self.inbox.accept(whole);
                Read::Whole(question)
            }
            None => {
                self.inbox.reject();
                self.inbox.discard(1);
                Read::Spoilt
            }
        })
    }
}

pub(super) fn xor(bytes: &[u8]) -> u8 {
    bytes.iter().fold(0, |sum, byte| sum ^ byte)
}
