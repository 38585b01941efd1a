//! Why a log cannot be replayed.

use crate::format::FieldError;

/// Why bytes are not a CARMEN log that can be replayed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum CarmenError {
    /// The file has no bytes, or only empty lines.
    #[error("the file is empty; expected a CARMEN log with FLASER, RLASER or ROBOTLASER1 messages")]
    Empty,
    /// Bytes that are not text.
    #[error(
        "line {line}: byte {column} is 0x{byte:02x}, which is not text; expected a CARMEN log, one message per line"
    )]
    Binary {
        /// Line, from 1.
        line: usize,
        /// Byte in the line, from 1.
        column: usize,
        /// The byte.
        byte: u8,
    },
    /// A line that does not end.
    #[error(
        "line {line} is longer than {limit} bytes; expected a CARMEN log, one message per line"
    )]
    LineTooLong {
        /// Line, from 1.
        line: usize,
        /// The limit.
        limit: usize,
    },
    /// A field that cannot be read, or a number of fields other than the message announces.
    #[error(transparent)]
    Field(#[from] FieldError),
    /// The file ends within a message.
    #[error("line {line}: the file is cut off within its last message ({reason})")]
    CutOff {
        /// Line, from 1.
        line: usize,
        /// What is missing.
        reason: String,
    },
    /// Text, but no laser message.
    #[error(
        "no laser message in {lines} lines; expected a CARMEN log with FLASER, RLASER or ROBOTLASER1 messages"
    )]
    NoLaser {
        /// Number of lines read.
        lines: usize,
    },
}
