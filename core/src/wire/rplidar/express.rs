//! Capsules of an express scan: 32 readings in 84 bytes, whose angles need the next capsule.

use super::node::{FULL_TURN, Node};
use super::request::xor;

/// Readings in a capsule.
pub const READINGS: usize = 32;
/// Quality given to a valid reading: a capsule has none.
pub const QUALITY: u8 = 47;
const CABINS: usize = READINGS / 2;

/// A capsule in the units of the wire.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Capsule {
    /// Whether the scan began here.
    pub starts: bool,
    /// Angle at which the first reading was taken, 1/64°, clockwise from ahead, less than 360°.
    pub start_angle: u16,
    /// Readings in the order in which they were taken.
    pub readings: [Reading; READINGS],
}

/// A reading of a [`Capsule`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Reading {
    /// Distance, 1/4 mm, a multiple of 4; 0 invalid.
    pub distance: u16,
    /// How far the reading lies before its evenly spaced place, 1/8°, 0 to 63.
    pub offset: u8,
}

impl Capsule {
    /// Its length on the wire, bytes.
    pub const LEN: usize = 84;

    /// The bytes that the sensor sends; bits of a distance or an offset that do not fit are cut
    /// off.
    #[must_use]
    pub fn encode(&self) -> [u8; Self::LEN] {
        let mut bytes = [0; Self::LEN];
        let start = (self.start_angle & 0x7FFF) | u16::from(self.starts) << 15;
        let mut body = start.to_le_bytes().to_vec();
        let (firsts, seconds) = (
            self.readings.iter().step_by(2),
            self.readings.iter().skip(1).step_by(2),
        );
        for (first, second) in firsts.zip(seconds) {
            body.extend(word(first).to_le_bytes());
            body.extend(word(second).to_le_bytes());
            body.push((first.offset & 0xF) | second.offset << 4);
        }
        let sum = xor(&body);
        let head = [0xA0 | (sum & 0xF), 0x50 | sum >> 4];
        for (byte, value) in bytes.iter_mut().zip(head.iter().chain(&body)) {
            *byte = *value;
        }
        bytes
    }

    /// Reads a capsule; `None` if its marks, its checksum or its angle are wrong.
    #[must_use]
    pub fn decode(bytes: &[u8; Self::LEN]) -> Option<Self> {
        let [first, second, low, high, cabins @ ..] = bytes;
        let sum = (first & 0xF) | second << 4;
        let start = u16::from_le_bytes([*low, *high]);
        let start_angle = start & 0x7FFF;
        let is_good =
            has_marks([*first, *second]) && xor(bytes.get(2..)?) == sum && start_angle < FULL_TURN;
        if !is_good {
            return None;
        }
        let mut readings = [Reading::default(); READINGS];
        for (pair, cabin) in readings.chunks_exact_mut(2).zip(cabins.chunks_exact(5)) {
            if let ([one, two], [a, b, c, d, low_bits]) = (pair, cabin) {
                *one = reading(u16::from_le_bytes([*a, *b]), low_bits & 0xF);
                *two = reading(u16::from_le_bytes([*c, *d]), low_bits >> 4);
            }
        }
        debug_assert_eq!(cabins.len(), CABINS * 5);
        Some(Self {
            starts: start & 0x8000 != 0,
            start_angle,
            readings,
        })
    }

    /// The readings as nodes, given the start angle of the capsule that followed without loss.
    ///
    /// # Source   Interface protocol, "Data processing of the express scan data": start + k Δ/32 -
    /// offset.
    pub fn nodes(&self, next_start_angle: u16) -> impl Iterator<Item = Node> + '_ {
        let full = u32::from(FULL_TURN);
        let start = u32::from(self.start_angle);
        let span = (u32::from(next_start_angle) + full - start) % full;
        self.readings.iter().zip(0..).map(move |(reading, k)| {
            // 1/8° is 8 of 1/64°; a full turn is added to keep it above 0, 16 rounds the division
            // by 32.
            let even = start + (k * span + 16) / READINGS as u32;
            let angle = (even + full - 8 * u32::from(reading.offset)) % full;
            Node {
                starts: self.starts && k == 0,
                quality: if reading.distance == 0 { 0 } else { QUALITY },
                angle: angle as u16,
                distance: reading.distance,
            }
        })
    }
}

/// Whether two bytes can begin a capsule.
pub(super) fn has_marks([first, second]: [u8; 2]) -> bool {
    first >> 4 == 0xA && second >> 4 == 0x5
}

fn word(reading: &Reading) -> u16 {
    (reading.distance & 0xFFFC) | u16::from(reading.offset >> 4 & 0b11)
}

fn reading(word: u16, low_bits: u8) -> Reading {
    Reading {
        distance: word & 0xFFFC,
        offset: low_bits | ((word & 0b11) as u8) << 4,
    }
}
