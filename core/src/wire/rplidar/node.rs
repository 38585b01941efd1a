//! One reading of a standard scan.

use std::f64::consts::PI;

/// 1/64° in rad.
const ANGLE_UNIT: f64 = PI / (180.0 * 64.0);
/// 1/4 mm in m.
const DISTANCE_UNIT: f64 = 0.25e-3;
/// 360° in 1/64°.
pub(super) const FULL_TURN: u16 = 360 * 64;

/// A reading in the units of the wire.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Node {
    /// Whether it is the first of a turn.
    pub starts: bool,
    /// Quality, 0 to 63.
    pub quality: u8,
    /// Angle, 1/64°, clockwise from ahead, less than 360°.
    pub angle: u16,
    /// Distance, 1/4 mm; 0 invalid.
    pub distance: u16,
}

impl Node {
    /// Its length on the wire, bytes.
    pub const LEN: usize = 5;

    /// The reading at `angle` (rad, clockwise) and `range` (m; anything that is not a positive
    /// number, or beyond 16.38 m, is invalid).
    #[must_use]
    pub fn new(angle: f64, range: f64, quality: u8) -> Self {
        let units = (angle / ANGLE_UNIT)
            .round()
            .rem_euclid(f64::from(FULL_TURN));
        let distance = (range / DISTANCE_UNIT).round();
        let is_valid = distance >= 1.0 && distance <= f64::from(u16::MAX);
        Self {
            starts: false,
            quality: if is_valid { quality.min(63) } else { 0 },
            angle: units as u16,
            distance: if is_valid { distance as u16 } else { 0 },
        }
    }

    /// Angle, rad, clockwise from ahead.
    #[must_use]
    pub fn radians(&self) -> f64 {
        f64::from(self.angle) * ANGLE_UNIT
    }

    /// Distance, m; 0 invalid.
    #[must_use]
    pub fn metres(&self) -> f64 {
        f64::from(self.distance) * DISTANCE_UNIT
    }

    /// The bytes that the sensor sends.
    #[must_use]
    pub fn encode(&self) -> [u8; Self::LEN] {
        let first = self.quality << 2 | if self.starts { 0b01 } else { 0b10 };
        let [b, c] = (self.angle << 1 | 1).to_le_bytes();
        let [d, e] = self.distance.to_le_bytes();
        [first, b, c, d, e]
    }

    /// Reads a node; `None` if its check bits or its angle are wrong.
    #[must_use]
    pub fn decode(bytes: [u8; Self::LEN]) -> Option<Self> {
        let node = Self::unchecked(bytes);
        let [first, second, ..] = bytes;
        let is_not_start = first & 2 != 0;
        (node.starts != is_not_start && second & 1 == 1 && node.angle < FULL_TURN).then_some(node)
    }

    /// Reads a node without checking its check bits or its angle.
    pub(in crate::wire) fn unchecked([first, b, c, d, e]: [u8; Self::LEN]) -> Self {
        Self {
            starts: first & 1 != 0,
            quality: first >> 2,
            angle: u16::from_le_bytes([b, c]) >> 1,
            distance: u16::from_le_bytes([d, e]),
        }
    }
}
