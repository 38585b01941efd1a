//! The envelope: header and body into bytes or text, and back.

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use super::{FromBridge, PROTOCOL, ToBridge};

/// First two bytes of a message: `SL`, little-endian.
pub const MAGIC: u16 = u16::from_le_bytes(*b"SL");

const HEADER_BYTES: usize = 16;

/// What precedes each message.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Header {
    /// Counts the messages of this connection and direction, from 1.
    pub sequence: u32,
    /// When the sender sent it, µs since it started.
    pub micros: u64,
}

/// How messages are written.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Format {
    /// Bytes.
    #[default]
    Binary,
    /// Text.
    Json,
}

/// Why a message cannot be read or written.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum MessageError {
    /// The header is cut off.
    #[error("message of {bytes} bytes: expected at least {HEADER_BYTES}")]
    Short {
        /// Length of the message.
        bytes: usize,
    },
    /// Not one of our messages.
    #[error("bytes 0 and 1 are {found:#06x}, expected {MAGIC:#06x}")]
    Magic {
        /// The two bytes.
        found: u16,
    },
    /// Of another version of the protocol.
    #[error("protocol {found}, expected {PROTOCOL}: bridge and client are of different versions")]
    Protocol {
        /// That version.
        found: u8,
    },
    /// A kind that is unknown here, or of the other direction.
    #[error("byte 3: kind {found} is not one of this direction")]
    Kind {
        /// That kind.
        found: u8,
    },
    /// The body is not of its kind.
    #[error("body of kind {kind}: {what}")]
    Body {
        /// Kind of the message.
        kind: u8,
        /// What is wrong.
        what: String,
    },
    /// The message is longer than its body.
    #[error("body of kind {kind} ends {bytes} bytes before the message does")]
    Trailing {
        /// Kind of the message.
        kind: u8,
        /// Number of bytes left over.
        bytes: usize,
    },
    /// The text is not a message.
    #[error("{what}")]
    Json {
        /// What is wrong, with line and column.
        what: String,
    },
}

/// The messages of one direction.
pub trait Packet: Serialize + DeserializeOwned {
    /// Added to the number of a variant, to distinguish the directions.
    const OFFSET: u8;
}

impl Packet for FromBridge {
    const OFFSET: u8 = 0;
}

impl Packet for ToBridge {
    const OFFSET: u8 = 128;
}

#[derive(Serialize, Deserialize)]
struct Text<M> {
    protocol: u8,
    sequence: u32,
    micros: u64,
    message: M,
}

/// Writes a message.
///
/// # Errors    [`MessageError`] if a value cannot be written; those of this module always can.
pub fn encode<M: Packet>(
    header: Header,
    message: &M,
    format: Format,
) -> Result<Vec<u8>, MessageError> {
    match format {
        Format::Binary => to_bytes(header, message),
        Format::Json => serde_json::to_vec(&Text {
            protocol: PROTOCOL,
            sequence: header.sequence,
            micros: header.micros,
            message,
        })
        .map_err(|error| in_text(&error)),
    }
}

/// Reads a complete message.
///
/// # Errors    [`MessageError`]: what is wrong, and where.
pub fn decode<M: Packet>(bytes: &[u8], format: Format) -> Result<(Header, M), MessageError> {
    match format {
        Format::Binary => from_bytes(bytes),
        Format::Json => {
            let text: Text<M> = serde_json::from_slice(bytes).map_err(|error| in_text(&error))?;
            if text.protocol != PROTOCOL {
                return Err(MessageError::Protocol {
                    found: text.protocol,
                });
            }
            let (sequence, micros) = (text.sequence, text.micros);
            Ok((Header { sequence, micros }, text.message))
        }
    }
}

fn to_bytes<M: Packet>(header: Header, message: &M) -> Result<Vec<u8>, MessageError> {
    let failed = |kind, error: postcard::Error| MessageError::Body {
        kind,
        what: error.to_string(),
    };
    // Postcard begins an enum with the number of its variant, one byte below 128: this byte is the
    // kind.
    let body = postcard::to_allocvec(message).map_err(|error| failed(M::OFFSET, error))?;
    let (variant, body) = body.split_first().unwrap_or((&0, &[]));
    let mut bytes = Vec::with_capacity(HEADER_BYTES + body.len());
    bytes.extend(MAGIC.to_le_bytes());
    bytes.extend([PROTOCOL, M::OFFSET | variant]);
    bytes.extend(header.sequence.to_le_bytes());
    bytes.extend(header.micros.to_le_bytes());
    bytes.extend(body);
    Ok(bytes)
}

fn from_bytes<M: Packet>(bytes: &[u8]) -> Result<(Header, M), MessageError> {
    let Some((head, rest)) = bytes.split_first_chunk::<HEADER_BYTES>() else {
        return Err(MessageError::Short { bytes: bytes.len() });
    };
    let &[m0, m1, protocol, kind, s0, s1, s2, s3, ref micros @ ..] = head;
    let found = u16::from_le_bytes([m0, m1]);
    if found != MAGIC {
        return Err(MessageError::Magic { found });
    }
    if protocol != PROTOCOL {
        return Err(MessageError::Protocol { found: protocol });
    }
    if kind & 128 != M::OFFSET {
        return Err(MessageError::Kind { found: kind });
    }
    let header = Header {
        sequence: u32::from_le_bytes([s0, s1, s2, s3]),
        micros: u64::from_le_bytes(*micros),
    };
    Ok((header, body(kind, rest)?))
}

fn body<M: Packet>(kind: u8, rest: &[u8]) -> Result<M, MessageError> {
    let mut bytes = Vec::with_capacity(1 + rest.len());
    bytes.push(kind & 127);
    bytes.extend(rest);
    let (message, left) =
        postcard::take_from_bytes(&bytes).map_err(|error| MessageError::Body {
            kind,
            what: error.to_string(),
        })?;
    match left.len() {
        0 => Ok(message),
        bytes => Err(MessageError::Trailing { kind, bytes }),
    }
}

fn in_text(error: &serde_json::Error) -> MessageError {
    MessageError::Json {
        what: error.to_string(),
    }
}
