//! Bags of ROS 1, version 2.0, cut into records.
//!
//! 1. The magic line is followed by records: length of a header, header, length of the data, data.
//!    A header is a list of fields, each a length and `name=value`.
//! 2. A chunk (`op` 5) holds connections (7) and messages (2), uncompressed or packed by bz2 or
//!    lz4. The index at the end is ignored: a bag that was cut off has none.
//!
//! Source: wiki.ros.org/Bags/Format/2.0.

use super::unpack::unpack;
use super::{Collector, Encoding, RosError, RosLog, Waiting};

/// First bytes of a bag.
pub const BAG_MAGIC: &[u8] = b"#ROSBAG V2.0\n";
/// First bytes of a bag of any version.
pub const ANY_BAG: &[u8] = b"#ROSBAG V";

/// No recorder writes longer headers; a connection's header holds the definition of its message.
const LONGEST_HEADER: usize = 4 << 20;
/// No recorder writes longer records.
const LONGEST_DATA: usize = 1 << 30;

const MESSAGE: u8 = 2;
const CHUNK: u8 = 5;
const CONNECTION: u8 = 7;

/// At most this many digits and points of a version are reported.
const LONGEST_VERSION: usize = 8;

/// Reads a bag piece by piece.
#[derive(Debug, Default)]
pub(super) struct BagReader {
    waiting: Waiting,
    collector: Collector,
    has_begun: bool,
    /// Whether a record could not be read, which ended the reading.
    ended: bool,
}

/// A record, and how many bytes it takes.
struct Cut<'a> {
    header: &'a [u8],
    data: &'a [u8],
    length: usize,
}

impl BagReader {
    /// `None` if the file is not a bag.
    pub(super) fn of(begun: &[u8]) -> Result<Option<Self>, RosError> {
        if begun.starts_with(BAG_MAGIC) {
            return Ok(Some(Self::default()));
        }
        let Some(rest) = begun.strip_prefix(ANY_BAG) else {
            return Ok(None);
        };
        // Other characters may be anything, of any length.
        let digits = rest
            .iter()
            .take_while(|b| b.is_ascii_digit() || **b == b'.');
        let version = digits.take(LONGEST_VERSION).map(|b| char::from(*b));
        Err(RosError::Version(version.collect()))
    }

    pub(super) fn push(&mut self, bytes: &[u8]) {
        let Self {
            waiting,
            collector,
            has_begun,
            ended,
        } = self;
        waiting.push(bytes, |rest, at| {
            if *ended {
                return Some(rest.len());
            }
            if !*has_begun {
                *has_begun = true;
                return Some(BAG_MAGIC.len());
            }
            match cut(rest) {
                Ok(None) => None,
                Ok(Some(record)) => {
                    take(&record, at, collector);
                    Some(record.length)
                }
                Err(what) => {
                    let what = format!("{what}; what follows is lost");
                    collector.damaged(at, &what);
                    *ended = true;
                    Some(rest.len())
                }
            }
        });
    }

    pub(super) fn finish(mut self) -> RosLog {
        if !self.waiting.bytes.is_empty() {
            let what =
                "the bag ends in the middle of a record: it was cut off, and what followed is lost";
            self.collector.damaged(self.waiting.at, what);
        }
        self.collector.log
    }
}

/// The record that begins here; `None` if it is incomplete.
fn cut(bytes: &[u8]) -> Result<Option<Cut<'_>>, String> {
    let Some((header, rest)) = part(bytes, LONGEST_HEADER, "a header")? else {
        return Ok(None);
    };
    let Some((data, rest)) = part(rest, LONGEST_DATA, "a record")? else {
        return Ok(None);
    };
    let length = bytes.len() - rest.len();
    Ok(Some(Cut {
        header,
        data,
        length,
    }))
}

/// A part, and what follows it.
type Parts<'a> = (&'a [u8], &'a [u8]);

/// As many bytes as the length before them says, and what follows.
fn part<'a>(bytes: &'a [u8], longest: usize, what: &str) -> Result<Option<Parts<'a>>, String> {
    let Some((length, rest)) = bytes.split_first_chunk::<4>() else {
        return Ok(None);
    };
    let length = u32::from_le_bytes(*length) as usize;
    if length > longest {
        return Err(format!("{what} of {length} bytes, more than any has"));
    }
    Ok(rest.split_at_checked(length))
}

/// Takes in the content of a record; index records are ignored.
fn take(record: &Cut<'_>, at: u64, collector: &mut Collector) {
    match number(record.header, "op") {
        Some([CHUNK]) => chunk(record, at, collector),
        Some([CONNECTION]) => connection(record, at, collector),
        Some([MESSAGE]) => message(record, at, collector),
        Some(_) => {}
        None => collector.damaged(at, "a record does not say what it is"),
    }
}

fn chunk(record: &Cut<'_>, at: u64, collector: &mut Collector) {
    let how = field(record.header, "compression").unwrap_or(b"");
    let how = String::from_utf8_lossy(how);
    let claimed = number(record.header, "size").map_or(0, u32::from_le_bytes);
    let unpacked = match unpack(&how, record.data, u64::from(claimed)) {
        Ok(unpacked) => unpacked,
        Err(error) => return collector.damaged(at, &format!("{error}; it is left out")),
    };
    let mut rest = unpacked.as_slice();
    while !rest.is_empty() {
        match cut(rest) {
            // Chunks cannot be nested.
            Ok(Some(record)) if number(record.header, "op") != Some([CHUNK]) => {
                take(&record, at, collector);
                rest = rest.get(record.length..).unwrap_or(&[]);
            }
            _ => {
                let what = "a chunk holds something else than records; the rest of it is left out";
                return collector.damaged(at, what);
            }
        }
    }
}

fn connection(record: &Cut<'_>, at: u64, collector: &mut Collector) {
    let id = number(record.header, "conn").map(u32::from_le_bytes);
    let (Some(id), Some(topic), Some(type_name)) = (
        id,
        field(record.header, "topic"),
        field(record.data, "type"),
    ) else {
        return collector.damaged(at, "a connection without number, topic or type");
    };
    let (topic, type_name) = (
        String::from_utf8_lossy(topic),
        String::from_utf8_lossy(type_name),
    );
    collector.channel(id, &topic, &type_name, Some(Encoding::Ros1));
}

fn message(record: &Cut<'_>, at: u64, collector: &mut Collector) {
    let id = number(record.header, "conn").map(u32::from_le_bytes);
    let time = number(record.header, "time").map(u64::from_le_bytes);
    let (Some(id), Some(time)) = (id, time) else {
        return collector.damaged(at, "a message without connection or time");
    };
    // Seconds in the lower half, ns in the upper.
    let recorded = (time & 0xffff_ffff) * 1_000_000_000 + (time >> 32);
    collector.message(id, recorded, record.data, at);
}

/// A field of a header by its name.
fn field<'a>(header: &'a [u8], name: &str) -> Option<&'a [u8]> {
    let mut rest = header;
    while let Ok(Some((field, next))) = part(rest, LONGEST_HEADER, "") {
        let value = field.strip_prefix(name.as_bytes());
        if let Some(value) = value.and_then(|value| value.strip_prefix(b"=")) {
            return Some(value);
        }
        rest = next;
    }
    None
}

/// A field of a fixed length.
fn number<const N: usize>(header: &[u8], name: &str) -> Option<[u8; N]> {
    field(header, name)?.try_into().ok()
}
