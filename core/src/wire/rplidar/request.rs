//! Requests to the sensor, and the reader of them that a simulated sensor needs.

use super::SYNC;
use crate::wire::inbox::{Inbox, Tally};

/// Bit of a command that has a payload.
const HAS_PAYLOAD: u8 = 0x80;

/// What the sensor can be asked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Request {
    /// Stop scanning.
    Stop,
    /// Restart, as from power on.
    Reset,
    /// Scan, one node a reading.
    Scan,
    /// Scan, 32 readings a capsule.
    ExpressScan,
    /// Model, versions, serial number.
    Info,
    /// Whether it can work.
    Health,
    /// Time of a reading.
    Rate,
}

impl Request {
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
        let mut bytes = vec![SYNC, self.command()];
        let payload: &[u8] = match &self {
            Self::ExpressScan => &[0; 5],
            _ => return bytes,
        };
        bytes.push(payload.len() as u8);
        bytes.extend(payload);
        bytes.push(xor(&bytes));
        bytes
    }

    fn command(self) -> u8 {
        match self {
            Self::Stop => 0x25,
            Self::Reset => 0x40,
            Self::Scan => 0x20,
            Self::ExpressScan => 0x82,
            Self::Info => 0x50,
            Self::Health => 0x52,
            Self::Rate => 0x59,
        }
    }

    fn from_wire(command: u8, payload: &[u8]) -> Option<Self> {
        Some(match (command, payload) {
            (0x25, []) => Self::Stop,
            (0x40, []) => Self::Reset,
            (0x20, []) => Self::Scan,
            (0x50, []) => Self::Info,
            (0x52, []) => Self::Health,
            (0x59, []) => Self::Rate,
            (0x82, [0, ..]) if payload.len() == 5 => Self::ExpressScan,
            _ => return None,
        })
    }
}

/// Reads requests, as the sensor does.
#[derive(Clone, Debug, Default)]
pub struct RequestDecoder {
    inbox: Inbox,
}

impl RequestDecoder {
    /// A decoder that has seen nothing.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Takes bytes as they come.
    pub fn extend(&mut self, bytes: &[u8]) {
        self.inbox.extend(bytes);
    }

    /// What became of the bytes.
    #[must_use]
    pub fn tally(&self) -> Tally {
        self.inbox.tally()
    }

    /// The length of the request at the front, with its parts; `None` while bytes are missing.
    fn front(&self) -> Option<Result<(usize, Request), ()>> {
        let [sync, command] = self.inbox.peek(0)?;
        if sync != SYNC {
            return Some(Err(()));
        }
        if command & HAS_PAYLOAD == 0 {
            return Some(
                Request::from_wire(command, &[])
                    .map(|request| (2, request))
                    .ok_or(()),
            );
        }
        let [length] = self.inbox.peek(2)?;
        let length = usize::from(length);
        // No request known here has more than 5 bytes of payload: a damaged length must not swallow
        // what follows.
        if length > 5 {
            return Some(Err(()));
        }
        let mut bytes = vec![];
        for at in 0..length + 4 {
            let [byte] = self.inbox.peek(at)?;
            bytes.push(byte);
        }
        let (sum, body) = bytes.split_last()?;
        let payload = body.get(3..)?;
        let request = Request::from_wire(command, payload).filter(|_| xor(body) == *sum);
        Some(request.map(|request| (length + 4, request)).ok_or(()))
    }
}

impl Iterator for RequestDecoder {
    type Item = Request;

    /// The next request that is complete.
    fn next(&mut self) -> Option<Request> {
        loop {
            match self.front()? {
                Ok((length, request)) => {
                    self.inbox.accept(length);
                    return Some(request);
                }
                Err(()) => {
                    self.inbox.discard(1);
                }
            }
        }
    }
}

pub(super) fn xor(bytes: &[u8]) -> u8 {
    bytes.iter().fold(0, |sum, byte| sum ^ byte)
}
