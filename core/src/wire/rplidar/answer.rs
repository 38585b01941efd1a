//! Descriptors and single answers: information, health, rate.

use super::{SYNC, SYNC_OF_ANSWER};

/// Begins an answer: its type, its length, and whether it is endless.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Descriptor {
    /// Endless 5-byte nodes.
    Scan,
    /// Endless 84-byte capsules.
    Express,
    /// 20 bytes of [`Info`].
    Info,
    /// 3 bytes of [`Health`].
    Health,
    /// 4 bytes of [`Rate`].
    Rate,
}

impl Descriptor {
    /// Its length on the wire, bytes.
    pub const LEN: usize = 7;
    const ALL: [Self; 5] = [
        Self::Scan,
        Self::Express,
        Self::Info,
        Self::Health,
        Self::Rate,
    ];

    /// The bytes that the sensor sends.
    #[must_use]
    pub fn encode(self) -> [u8; Self::LEN] {
        let (length, is_endless, kind) = match self {
            Self::Scan => (5, 0x40, 0x81),
            Self::Express => (84, 0x40, 0x82),
            Self::Info => (Info::LEN as u8, 0, 0x04),
            Self::Health => (Health::LEN as u8, 0, 0x06),
            Self::Rate => (Rate::LEN as u8, 0, 0x15),
        };
        [SYNC, SYNC_OF_ANSWER, length, 0, 0, is_endless, kind]
    }

    /// The descriptor in these bytes; `None` if it is not a known one.
    #[must_use]
    pub fn decode(bytes: [u8; Self::LEN]) -> Option<Self> {
        Self::ALL
            .into_iter()
            .find(|descriptor| descriptor.encode() == bytes)
    }
}

/// The sensor's description of itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Info {
    /// Number of the model: 0x18 is an A1.
    pub model: u8,
    /// Firmware: major, minor.
    pub firmware: [u8; 2],
    /// Version of the hardware.
    pub hardware: u8,
    /// Serial number.
    pub serial: [u8; 16],
}

impl Info {
    /// Its length on the wire, bytes.
    pub const LEN: usize = 20;

    /// The bytes that the sensor sends.
    #[must_use]
    pub fn encode(&self) -> [u8; Self::LEN] {
        let mut bytes = [0; Self::LEN];
        let [major, minor] = self.firmware;
        let head = [self.model, minor, major, self.hardware];
        for (byte, value) in bytes.iter_mut().zip(head.iter().chain(&self.serial)) {
            *byte = *value;
        }
        bytes
    }

    /// Reads what the sensor sent; any bytes are valid.
    #[must_use]
    pub fn decode(bytes: [u8; Self::LEN]) -> Self {
        let [model, minor, major, hardware, serial @ ..] = bytes;
        Self {
            model,
            firmware: [major, minor],
            hardware,
            serial,
        }
    }
}

/// Whether the sensor can work.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Health {
    /// Its status.
    pub status: Status,
    /// Code of the error or warning, as the maker defines it.
    pub error: u16,
}

/// Status of a [`Health`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// All is well.
    Good,
    /// It works, but may soon stop.
    Warning,
    /// It has stopped to protect itself; a reset may help.
    Error,
}

impl Health {
    /// Its length on the wire, bytes.
    pub const LEN: usize = 3;

    /// The bytes that the sensor sends.
    #[must_use]
    pub fn encode(&self) -> [u8; Self::LEN] {
        let [low, high] = self.error.to_le_bytes();
        [self.status as u8, low, high]
    }

    /// Reads what the sensor sent; `None` if the status is none of the three.
    #[must_use]
    pub fn decode([status, low, high]: [u8; Self::LEN]) -> Option<Self> {
        let status = match status {
            0 => Status::Good,
            1 => Status::Warning,
            2 => Status::Error,
            _ => return None,
        };
        Some(Self {
            status,
            error: u16::from_le_bytes([low, high]),
        })
    }
}

/// How long a reading takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rate {
    /// In a standard scan, µs.
    pub standard_micros: u16,
    /// In an express scan, µs.
    pub express_micros: u16,
}

impl Rate {
    /// Its length on the wire, bytes.
    pub const LEN: usize = 4;

    /// The bytes that the sensor sends.
    #[must_use]
    pub fn encode(&self) -> [u8; Self::LEN] {
        let ([a, b], [c, d]) = (
            self.standard_micros.to_le_bytes(),
            self.express_micros.to_le_bytes(),
        );
        [a, b, c, d]
    }

    /// Reads what the sensor sent.
    #[must_use]
    pub fn decode([a, b, c, d]: [u8; Self::LEN]) -> Self {
        Self {
            standard_micros: u16::from_le_bytes([a, b]),
            express_micros: u16::from_le_bytes([c, d]),
        }
    }
}
