//! MCAP files of ROS, cut into records.
//!
//! 1. Records are a kind (1 byte), a length (8 bytes, little-endian) and content; they are read by
//!    the crate's own types.
//! 2. Chunks are decompressed here: the crate uses C libraries for it, which a page cannot have.
//! 3. Only channels with CDR, or with messages of ROS 1, are read. Reading ends with the data
//!    section, because the rest only repeats its content.
//!
//! Recordings of the bridge are MCAP files too, but are read by [`crate::wire::recording`]. That
//! reader resynchronises after damage by a pattern with which all its messages begin; messages of
//! ROS have no such pattern.
//!
//! Source: the MCAP format specification, mcap.dev/spec.

use std::collections::BTreeMap;

use ::mcap::MAGIC;
use ::mcap::read::parse_record;
use ::mcap::records::{ChunkHeader, Record};
use crc::{CRC_32_ISO_HDLC, Crc, Table};

use super::unpack::unpack;
use super::{Collector, Encoding, RosLog, Waiting};

static CRC: Crc<u32, Table<16>> = Crc::<u32, Table<16>>::new(&CRC_32_ISO_HDLC);

/// Kind and length of a record.
const HEAD: usize = 9;
/// No recorder writes longer records.
const LONGEST: u64 = 1 << 30;

/// Reads an MCAP file piece by piece.
#[derive(Debug, Default)]
pub(super) struct McapReader {
    waiting: Waiting,
    contents: Contents,
    has_begun: bool,
}

#[derive(Debug, Default)]
struct Contents {
    collector: Collector,
    /// Name of each schema.
    schemas: BTreeMap<u16, String>,
    /// The data section is over, or the rest cannot be read.
    has_ended: bool,
}

impl McapReader {
    pub(super) fn push(&mut self, bytes: &[u8]) {
        let Self {
            waiting,
            contents,
            has_begun,
        } = self;
        waiting.push(bytes, |rest, at| {
            if contents.has_ended {
                return Some(rest.len());
            }
            if !*has_begun {
                *has_begun = true;
                return Some(MAGIC.len());
            }
            let (kind, length) = head(rest)?;
            if length > LONGEST {
                let what = format!(
                    "a record of kind {kind} and {length} bytes, more than any has; what follows is lost"
                );
                contents.collector.damaged(at, &what);
                contents.has_ended = true;
                return Some(rest.len());
            }
            let end = HEAD + length as usize;
            let content = rest.get(HEAD..end)?;
            match parse_record(kind, content) {
                Ok(Record::Chunk { header, data }) => contents.chunk(&header, &data, at),
                Ok(record) => contents.take(&record, at),
                Err(error) => {
                    let what = format!("a record of kind {kind} cannot be read: {error}");
                    contents.collector.damaged(at, &what);
                }
            }
            Some(end)
        });
    }

    pub(super) fn finish(mut self) -> RosLog {
        if !self.contents.has_ended {
            let what = "the file ends without an end: it was cut off, and what followed is lost";
            let end = self.waiting.at + self.waiting.bytes.len() as u64;
            self.contents.collector.damaged(end, what);
        }
        self.contents.collector.log
    }
}

impl Contents {
    fn chunk(&mut self, header: &ChunkHeader, data: &[u8], at: u64) {
        let unpacked = match unpack(&header.compression, data, header.uncompressed_size) {
            Ok(unpacked) => unpacked,
            Err(error) => {
                return self
                    .collector
                    .damaged(at, &format!("{error}; it is left out"));
            }
        };
        // 0 means that no checksum was computed.
        let (found, expected) = (CRC.checksum(&unpacked), header.uncompressed_crc);
        if expected != 0 && found != expected {
            let what = format!(
                "the sum over a chunk is {found:08x} and should be {expected:08x}; it is left out"
            );
            return self.collector.damaged(at, &what);
        }
        let mut rest = unpacked.as_slice();
        while let Some((kind, length)) = head(rest) {
            let end = HEAD.saturating_add(length.min(LONGEST + 1) as usize);
            let (Some(content), Some(next)) = (rest.get(HEAD..end), rest.get(end..)) else {
                break;
            };
            match parse_record(kind, content) {
                Ok(Record::Chunk { .. } | Record::DataEnd(_)) | Err(_) => break,
                Ok(record) => self.take(&record, at),
            }
            rest = next;
        }
        if !rest.is_empty() {
            let what = "a chunk holds something else than records; the rest of it is left out";
            self.collector.damaged(at, what);
        }
    }

    fn take(&mut self, record: &Record<'_>, at: u64) {
        match record {
            Record::Schema { header, .. } => {
                self.schemas.insert(header.id, header.name.clone());
            }
            Record::Channel(channel) => {
                let type_name = self.schemas.get(&channel.schema_id);
                let encoding = match channel.message_encoding.as_str() {
                    "cdr" => Some(Encoding::Cdr),
                    "ros1" => Some(Encoding::Ros1),
                    _ => None,
                };
                let type_name = type_name.map_or(channel.message_encoding.as_str(), String::as_str);
                self.collector
                    .channel(u32::from(channel.id), &channel.topic, type_name, encoding);
            }
            Record::Message { header, data } => {
                let id = u32::from(header.channel_id);
                self.collector.message(id, header.log_time, data, at);
            }
            Record::DataEnd(_) | Record::Footer(_) => self.has_ended = true,
            _ => {}
        }
    }
}

/// Kind and length of the record that begins here.
fn head(bytes: &[u8]) -> Option<(u8, u64)> {
    let (kind, rest) = bytes.split_first()?;
    Some((*kind, u64::from_le_bytes(*rest.first_chunk()?)))
}
