//! LDROBOT LD06 and LD19: 230400 baud, 8N1, little-endian, from the sensor only.
//!
//! In: bytes, in pieces of any size. Out: packets of 12 readings. The sensor measures from
//! power-on; its motor has a control wire of its own.
//!
//! | byte | | |
//! |---|---|---|
//! | 0 | `54` | |
//! | 1 | `2C` | type 1, 12 readings |
//! | 2 | speed u16 | °/s |
//! | 4 | start angle u16 | 0.01°, clockwise from ahead |
//! | 6 + 3i | distance u16, intensity u8, of reading i = 0 … 11 | mm; 0 invalid |
//! | 42 | end angle u16, that of the last reading | 0.01° |
//! | 44 | time u16 | ms, back to 0 after 30000 |
//! | 46 | CRC-8 of bytes 0 … 45 | polynomial 4D, from 0 |
//!
//! Reading i lies at start + i (end - start) / 11.
//!
//! Source: LDROBOT, "LD19 development manual" v2.3, with its worked example.

use std::f64::consts::PI;

use crc::{Algorithm, Crc};

use super::inbox::{Inbox, Tally};

/// Readings in a packet.
pub const READINGS: usize = 12;
/// Length of a packet, bytes.
pub const LEN: usize = 47;
const HEADER: [u8; 2] = [0x54, 0x2C];
/// 360° in 0.01°.
const FULL_TURN: u16 = 36_000;
/// 0.01° in rad.
const ANGLE_UNIT: f64 = PI / 18_000.0;

/// A packet in the units of the wire.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Packet {
    /// Speed, °/s.
    pub speed: u16,
    /// Angle of the first reading, 0.01°, clockwise from ahead, less than 360°.
    pub start_angle: u16,
    /// Readings in the order in which they were taken.
    pub readings: [Reading; READINGS],
    /// Angle of the last reading, 0.01°.
    pub end_angle: u16,
    /// Time, ms, back to 0 after 30000.
    pub millis: u16,
}

/// A reading of a [`Packet`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Reading {
    /// Distance, mm; 0 invalid.
    pub distance: u16,
    /// Intensity of the echo.
    pub intensity: u8,
}

impl Packet {
    /// The bytes that the sensor sends.
    #[must_use]
    pub fn encode(&self) -> [u8; LEN] {
        let mut body = HEADER.to_vec();
        body.extend(self.speed.to_le_bytes());
        body.extend(self.start_angle.to_le_bytes());
        for reading in &self.readings {
            body.extend(reading.distance.to_le_bytes());
            body.push(reading.intensity);
        }
        body.extend(self.end_angle.to_le_bytes());
        body.extend(self.millis.to_le_bytes());
        body.push(CRC.checksum(&body));
        let mut bytes = [0; LEN];
        for (byte, value) in bytes.iter_mut().zip(body) {
            *byte = value;
        }
        bytes
    }

    /// Reads a packet; `None` if header, checksum or angles are wrong.
    #[must_use]
    pub fn decode(bytes: &[u8; LEN]) -> Option<Self> {
        let [body @ .., sum] = bytes;
        let [h0, h1, s0, s1, a0, a1, middle @ .., e0, e1, t0, t1] = body;
        let (start_angle, end_angle) = (
            u16::from_le_bytes([*a0, *a1]),
            u16::from_le_bytes([*e0, *e1]),
        );
        let is_good = [*h0, *h1] == HEADER
            && CRC.checksum(body) == *sum
            && start_angle < FULL_TURN
            && end_angle < FULL_TURN;
        let mut readings = [Reading::default(); READINGS];
        for (reading, triple) in readings.iter_mut().zip(middle.chunks_exact(3)) {
            if let [low, high, intensity] = triple {
                *reading = Reading {
                    distance: u16::from_le_bytes([*low, *high]),
                    intensity: *intensity,
                };
            }
        }
        is_good.then_some(Self {
            speed: u16::from_le_bytes([*s0, *s1]),
            start_angle,
            readings,
            end_angle,
            millis: u16::from_le_bytes([*t0, *t1]),
        })
    }

    /// Angle from one reading to the next, rad.
    #[must_use]
    pub fn spacing(&self) -> f64 {
        let span = (u32::from(self.end_angle) + u32::from(FULL_TURN) - u32::from(self.start_angle))
            % u32::from(FULL_TURN);
        f64::from(span) * ANGLE_UNIT / (READINGS - 1) as f64
    }

    /// Angle (rad, clockwise from ahead), range (m; 0 invalid) and intensity of each reading.
    pub fn polar(&self) -> impl ExactSizeIterator<Item = (f64, f64, u8)> + '_ {
        let (start, spacing) = (f64::from(self.start_angle) * ANGLE_UNIT, self.spacing());
        self.readings.iter().enumerate().map(move |(i, reading)| {
            let range = f64::from(reading.distance) * 1e-3;
            (start + spacing * i as f64, range, reading.intensity)
        })
    }
}

/// Finds packets in a stream of bytes.
#[derive(Clone, Debug, Default)]
pub struct Decoder {
    inbox: Inbox,
}

impl Decoder {
    /// Takes bytes as they arrive.
    pub fn extend(&mut self, bytes: &[u8]) {
        self.inbox.extend(bytes);
    }

    /// What became of the bytes.
    #[must_use]
    pub fn tally(&self) -> Tally {
        self.inbox.tally()
    }
}

impl Iterator for Decoder {
    type Item = Packet;

    /// The next packet that is complete.
    fn next(&mut self) -> Option<Packet> {
        loop {
            if self.inbox.peek(0)? != [HEADER[0]] || self.inbox.peek(1)? != [HEADER[1]] {
                self.inbox.discard(1);
                continue;
            }
            let bytes = self.inbox.peek(0)?;
            if let Some(packet) = Packet::decode(&bytes) {
                self.inbox.accept(LEN);
                return Some(packet);
            }
            self.inbox.reject();
            self.inbox.discard(1);
        }
    }
}

/// CRC-8 with polynomial x⁸ + x⁶ + x³ + x² + 1 (4D), from 0, not reflected.
static CRC: Crc<u8> = Crc::<u8>::new(&Algorithm {
    width: 8,
    poly: 0x4D,
    init: 0,
    refin: false,
    refout: false,
    xorout: 0,
    check: 0xC3,
    residue: 0,
});

#[cfg(test)]
mod tests;
