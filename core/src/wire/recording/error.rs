//! Why a recording cannot be opened, and what is wrong with one that can.

use super::super::message::{MessageError, SCHEMA};
use super::{CHANNEL, ENCODING};

/// Why a whole file cannot be used.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum RecordingError {
    /// It does not begin like an MCAP file.
    #[error("bytes 0 to 7 are not those of an MCAP file")]
    Magic,
    /// It is an MCAP file of another program, or ends before the first message.
    #[error(
        "the file holds no message in a channel `{CHANNEL}` with encoding `{ENCODING}`{}: it was not recorded by slamlab",
        among(channels)
    )]
    NotOurs {
        /// The channels that it has instead.
        channels: Vec<String>,
    },
    /// Another tool has compressed it.
    #[error(
        "byte {offset}: the chunk here is compressed by {how}; rewrite the file without, for instance by \
         `mcap compress --compression none`"
    )]
    Compressed {
        /// Place of the chunk.
        offset: u64,
        /// Name of the method.
        how: String,
    },
}

/// Damage of a recording that can otherwise be used.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum Damage {
    /// These bytes are not readable; what was there is lost.
    #[error("bytes {from} to {to} are damaged: {what}; what stood there is lost")]
    Bytes {
        /// First byte.
        from: u64,
        /// The first readable byte after it.
        to: u64,
        /// What is wrong.
        what: String,
    },
    /// The file ends in the middle of a record.
    #[error("the file ends at byte {at} without an end: it was cut off, and what followed is lost")]
    CutOff {
        /// Length of the file.
        at: u64,
    },
    /// A bit is wrong somewhere.
    #[error(
        "the sum over bytes 0 to {to} is {found:08x} and should be {expected:08x}: a reading may be wrong, which one cannot be told"
    )]
    Sum {
        /// Bytes that were summed.
        to: u64,
        /// Computed from these bytes.
        found: u32,
        /// As the file gives it.
        expected: u32,
    },
    /// Recorded by a bridge of another version.
    #[error(
        "it was recorded by a bridge that speaks another schema ({theirs}, here {SCHEMA:016x}): messages that changed since cannot \
         be read"
    )]
    Schema {
        /// The schema of that bridge.
        theirs: String,
    },
    /// A message that is there but cannot be read.
    #[error("byte {offset}: a message cannot be read: {error}")]
    Message {
        /// Place of its record.
        offset: u64,
        /// What is wrong with it.
        error: MessageError,
    },
}

fn among(channels: &[String]) -> String {
    match channels {
        [] => String::new(),
        channels => format!(" (there are {})", channels.join(", ")),
    }
}
