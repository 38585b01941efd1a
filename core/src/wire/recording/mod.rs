//! Recordings of the bridge (MCAP files), read back.
//!
//! In: the bytes of a file, in pieces of any size. Out: a [`Recording`]: every message that crossed
//! the bridge, in order, and a list of the damage in the file.
//!
//! 1. The bytes are cut into records as they arrive: kind (1 byte), length (8 bytes,
//!    little-endian), content. Only messages of the channel [`CHANNEL`] are kept, as bytes. They
//!    are decoded one by one on request, so an hour of driving takes no more memory than its file.
//! 2. Chunks are opened: our bridge writes none, but other tools rewrite files with them.
//!    Compressed ones are refused, because there is no decompressor here.
//! 3. An impossible record is [`Damage`]. Reading goes on at the next message that is certainly
//!    ours, which begins with the magic number of [`super::message`]. The crate's own readers would
//!    stop at the first damaged byte.
//! 4. A file that was cut off (the bridge was killed, the disk was full) ends with its last
//!    complete message. The checksum over the whole data section reveals a flipped bit that no
//!    length and no magic number shows.
//!
//! Source: the MCAP format specification, mcap.dev/spec.

mod error;
#[cfg(test)]
pub(crate) mod fixture;
mod reader;
#[cfg(test)]
mod tests;
mod writer;

use super::message::{
    Format, FromBridge, Header, MessageError, Packet, RobotFigures, ToBridge, decode,
};

pub use error::{Damage, RecordingError};
pub use reader::RecordingReader;

/// Name of the channel that holds every message.
pub const CHANNEL: &str = "slamlab";
/// Encoding of its messages: binary, as in [`super::message`]; the number is not their version.
pub const ENCODING: &str = "slamlab-1";
/// Key of the channel's metadata that holds the schema of its messages, in hexadecimal.
pub const SCHEMA_KEY: &str = "schema";
/// First bytes of every MCAP file.
pub const MAGIC: [u8; 8] = *b"\x89MCAP0\r\n";

/// Kind bytes of odometry and scans, see [`super::message`]; checked by a test.
const ODOMETRY_KIND: u8 = 3;
const SCAN_KIND: u8 = 4;
const KIND_AT: usize = 3;

/// What a bridge recorded.
#[derive(Clone, Debug, Default)]
pub struct Recording {
    bytes: Vec<u8>,
    spans: Vec<Span>,
    damage: Vec<Damage>,
}

/// Where a message is in [`Recording::bytes`], and in the file.
#[derive(Clone, Copy, Debug)]
struct Span {
    start: usize,
    end: usize,
    offset: u64,
    nanos: u64,
}

/// One message.
#[derive(Clone, Debug, PartialEq)]
pub struct Recorded {
    /// When it was recorded, ns since 1970 by the bridge's clock.
    pub nanos: u64,
    /// `micros` is the bridge's time.
    pub header: Header,
    /// The message, and its direction.
    pub said: Said,
}

/// Both directions are in one channel.
#[derive(Clone, Debug, PartialEq)]
pub enum Said {
    /// To the clients connected.
    ByBridge(FromBridge),
    /// To the robot, as the message that would have caused it.
    ToRobot(ToBridge),
}

impl Recording {
    /// Reads a file that is all in memory.
    ///
    /// # Errors    [`RecordingError`]: nothing in it can be used.
    pub fn parse(bytes: &[u8]) -> Result<Self, RecordingError> {
        let mut reader = RecordingReader::default();
        reader.push(bytes)?;
        reader.finish()
    }

    /// Number of messages, readable or not.
    #[must_use]
    pub fn len(&self) -> usize {
        self.spans.len()
    }

    /// Whether there are none; a recording that was read has some.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.spans.is_empty()
    }

    /// Message number `index`, from 0; `None` after the last.
    ///
    /// # Errors    [`Damage`], with its place in the file: the message cannot be read.
    pub fn message(&self, index: usize) -> Option<Result<Recorded, Damage>> {
        let span = *self.spans.get(index)?;
        let bytes = self.bytes.get(span.start..span.end)?;
        Some(read(bytes, span.nanos).map_err(|error| Damage::Message {
            offset: span.offset,
            error,
        }))
    }

    /// All messages in order.
    pub fn messages(&self) -> impl Iterator<Item = Result<Recorded, Damage>> {
        (0..self.len()).filter_map(|index| self.message(index))
    }

    /// Damage of the file itself, in the order of places. Messages that cannot be read are only
    /// found on request.
    #[must_use]
    pub fn damage(&self) -> &[Damage] {
        &self.damage
    }

    /// Number of scans in it.
    #[must_use]
    pub fn scans(&self) -> usize {
        self.of_kind(SCAN_KIND).count()
    }

    /// Whether a robot reported its motion.
    #[must_use]
    pub fn has_odometry(&self) -> bool {
        self.of_kind(ODOMETRY_KIND).next().is_some()
    }

    /// From the first message to the last, s.
    #[must_use]
    pub fn duration(&self) -> f64 {
        let nanos = |span: Option<&Span>| span.map_or(0, |span| span.nanos);
        nanos(self.spans.last()).saturating_sub(nanos(self.spans.first())) as f64 * 1e-9
    }

    /// The robot that it was recorded with; none if there were only sensors, and in recordings of
    /// bridges before 0.1.
    #[must_use]
    pub fn robot(&self) -> Option<RobotFigures> {
        let mut hellos = self.of_kind(FromBridge::OFFSET);
        hellos.find_map(|index| match self.message(index)?.ok()?.said {
            Said::ByBridge(FromBridge::Hello(hello)) => hello.robot,
            _ => None,
        })
    }

    fn of_kind(&self, kind: u8) -> impl Iterator<Item = usize> {
        let spans = self.spans.iter().enumerate();
        spans
            .filter(move |(_, span)| self.bytes.get(span.start + KIND_AT) == Some(&kind))
            .map(|(index, _)| index)
    }

    fn keep(&mut self, bytes: &[u8], offset: u64, nanos: u64) {
        let start = self.bytes.len();
        self.bytes.extend_from_slice(bytes);
        let end = self.bytes.len();
        self.spans.push(Span {
            start,
            end,
            offset,
            nanos,
        });
    }
}

fn read(bytes: &[u8], nanos: u64) -> Result<Recorded, MessageError> {
    let is_order = bytes
        .get(KIND_AT)
        .is_some_and(|kind| *kind >= ToBridge::OFFSET);
    let (header, said) = if is_order {
        let (header, order) = decode(bytes, Format::Binary)?;
        (header, Said::ToRobot(order))
    } else {
        let (header, message) = decode(bytes, Format::Binary)?;
        (header, Said::ByBridge(message))
    };
    Ok(Recorded {
        nanos,
        header,
        said,
    })
}
