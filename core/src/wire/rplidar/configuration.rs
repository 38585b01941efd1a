//! Questions about a sensor's scan modes (`84`, firmware 1.24 and later): other programs ask them
//! before they scan. The bridge does not; its simulated sensor answers.
//!
//! Question: `A5 84 length | u32: kind | u16: scan mode, if the kind needs one | xor`; the maker's
//! driver pads it with zeros. Answer: `A5 5A length 00 00 00 20 | u32: kind | value`.
//!
//! Source: SLAMTEC, "RPLIDAR interface protocol and application notes", rev. 2.1 (2019), "Get lidar
//! configuration"; its driver, `sl_lidar_cmd.h`.

use super::{SYNC, SYNC_OF_ANSWER};

/// Command byte of a question.
pub(super) const COMMAND: u8 = 0x84;
/// Type byte of the answers.
const ANSWER: u8 = 0x20;

/// A question.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Question {
    /// Number of the kind, one of [`Kind`] or another.
    pub kind: u32,
    /// Number of the scan mode; 0 if the kind needs none.
    pub mode: u16,
}

/// Kinds of questions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum Kind {
    /// How many scan modes there are, u16.
    ModeCount = 0x70,
    /// Time of a reading in a mode, u32, 1/256 µs.
    SampleTime = 0x71,
    /// Greatest range in a mode, u32, 1/256 m.
    MaxDistance = 0x74,
    /// Type of the data that a mode sends, u8: that of its descriptor.
    AnswerType = 0x75,
    /// The recommended mode, u16.
    TypicalMode = 0x7C,
    /// Name of a mode, ASCII that ends with a zero.
    ModeName = 0x7F,
}

impl Kind {
    /// All of them.
    pub const ALL: [Self; 6] = [
        Self::ModeCount,
        Self::SampleTime,
        Self::MaxDistance,
        Self::AnswerType,
        Self::TypicalMode,
        Self::ModeName,
    ];
}

impl Question {
    /// Its kind; none if it is not known here.
    #[must_use]
    pub fn known(&self) -> Option<Kind> {
        Kind::ALL.into_iter().find(|kind| *kind as u32 == self.kind)
    }

    pub(super) fn payload(self) -> Vec<u8> {
        [&self.kind.to_le_bytes()[..], &self.mode.to_le_bytes()].concat()
    }

    /// Reads a payload; none if it is too short for a question.
    pub(super) fn of(payload: &[u8]) -> Option<Self> {
        let (kind, rest) = payload.split_first_chunk()?;
        let mode = rest.first_chunk().copied().unwrap_or_default();
        Some(Self {
            kind: u32::from_le_bytes(*kind),
            mode: u16::from_le_bytes(mode),
        })
    }
}

/// The bytes of an answer: descriptor, kind, value. A value longer than 250 bytes is cut.
#[must_use]
pub fn answer(kind: Kind, value: &[u8]) -> Vec<u8> {
    let value = value.get(..250).unwrap_or(value);
    let length = 4 + value.len() as u8;
    let mut bytes = vec![SYNC, SYNC_OF_ANSWER, length, 0, 0, 0, ANSWER];
    bytes.extend((kind as u32).to_le_bytes());
    bytes.extend(value);
    bytes
}
