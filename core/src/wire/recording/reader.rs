//! Cuts a file into records, and resynchronises where it is damaged; see the module above.

use std::collections::BTreeMap;
use std::ops::Range;

use crc::{CRC_32_ISO_HDLC, Crc, Digest, Table};
use mcap::read::parse_record;
use mcap::records::{Record, op};

use super::super::message::{MAGIC as MESSAGE_MAGIC, PROTOCOL, SCHEMA};
use super::{CHANNEL, Damage, ENCODING, MAGIC, Recording, RecordingError, SCHEMA_KEY};

static CRC: Crc<u32, Table<16>> = Crc::<u32, Table<16>>::new(&CRC_32_ISO_HDLC);

/// Kind and length of a record.
const HEAD: usize = 9;
/// Channel, sequence and two times of a message.
const MESSAGE_HEAD: usize = 22;
/// Our records are never longer; one that claims to be is damaged.
const LONGEST: u64 = 64 << 20;
/// Bytes that identify one of our messages: heads of record and message, magic number and protocol.
const SIGN: usize = HEAD + MESSAGE_HEAD + MESSAGE_SIGN.len();
/// The first bytes of each message of the bridge.
const MESSAGE_SIGN: [u8; 3] = {
    let [m0, m1] = MESSAGE_MAGIC.to_le_bytes();
    [m0, m1, PROTOCOL]
};

/// Reads a recording piece by piece.
pub struct RecordingReader {
    /// Bytes that are not a complete record yet.
    waiting: Vec<u8>,
    /// Position of the first of them in the file.
    at: u64,
    phase: Phase,
    /// Nothing follows after the waiting bytes.
    is_all: bool,
    /// For each channel seen: its name, and whether its messages are ours.
    channels: BTreeMap<u16, (String, bool)>,
    sum: Digest<'static, u32, Table<16>>,
    recording: Recording,
}

enum Phase {
    Start,
    Records,
    /// Out of step since this byte, for this reason.
    Lost(u64, String),
    /// The data section is over.
    Ended,
}

impl std::fmt::Debug for RecordingReader {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("RecordingReader")
            .field("at", &self.at)
            .field("messages", &self.recording.len())
            .finish_non_exhaustive()
    }
}

impl Default for RecordingReader {
    fn default() -> Self {
        Self {
            waiting: vec![],
            at: 0,
            phase: Phase::Start,
            is_all: false,
            channels: BTreeMap::new(),
            sum: CRC.digest(),
            recording: Recording::default(),
        }
    }
}

impl RecordingReader {
    /// Takes the next bytes, any number of them.
    ///
    /// # Errors    [`RecordingError`]: this is not one of our files, or cannot be read here.
    pub fn push(&mut self, bytes: &[u8]) -> Result<(), RecordingError> {
        self.waiting.extend_from_slice(bytes);
        let waiting = std::mem::take(&mut self.waiting);
        let mut used = 0;
        while let Some(count) = self.take(waiting.get(used..).unwrap_or(&[]))? {
            used += count;
            self.at += count as u64;
        }
        self.waiting = waiting;
        self.waiting.drain(..used);
        Ok(())
    }

    /// The file is complete.
    ///
    /// # Errors    [`RecordingError`]: nothing in it is ours.
    pub fn finish(mut self) -> Result<Recording, RecordingError> {
        let end = self.at + self.waiting.len() as u64;
        self.is_all = true;
        self.push(&[])?;
        self.look_past_the_last()?;
        match std::mem::replace(&mut self.phase, Phase::Ended) {
            Phase::Start => return Err(RecordingError::Magic),
            Phase::Records => self.recording.damage.push(Damage::CutOff { at: end }),
            Phase::Lost(from, what) => self.damaged(from, end, what),
            Phase::Ended => (),
        }
        if self.recording.is_empty() {
            let channels = self.channels.into_values().map(|(name, _)| name).collect();
            return Err(RecordingError::NotOurs { channels });
        }
        Ok(self.recording)
    }

    /// A record longer than the rest of the file was cut off; or its length is damaged, and other
    /// records follow.
    fn look_past_the_last(&mut self) -> Result<(), RecordingError> {
        while matches!(self.phase, Phase::Records) && !self.waiting.is_empty() {
            let what = "a record that is longer than the rest of the file".to_owned();
            self.phase = Phase::Lost(self.at, what);
            // The record that does not fit looks like one of our messages itself: find the next
            // one.
            self.waiting.remove(0);
            self.at += 1;
            self.push(&[])?;
            if let Phase::Lost(..) = self.phase {
                self.phase = Phase::Records;
                break;
            }
        }
        Ok(())
    }

    /// Takes one record, or bytes that can be skipped; returns their number, `None` if more bytes
    /// are needed.
    fn take(&mut self, bytes: &[u8]) -> Result<Option<usize>, RecordingError> {
        match &self.phase {
            Phase::Start => self.start(bytes),
            Phase::Records => self.record(bytes),
            Phase::Lost(..) => Ok(self.search(bytes)),
            Phase::Ended => Ok((!bytes.is_empty()).then_some(bytes.len())),
        }
    }

    fn start(&mut self, bytes: &[u8]) -> Result<Option<usize>, RecordingError> {
        let Some(found) = bytes.first_chunk::<{ MAGIC.len() }>() else {
            return Ok(None);
        };
        if *found != MAGIC {
            return Err(RecordingError::Magic);
        }
        self.sum.update(found);
        self.phase = Phase::Records;
        Ok(Some(MAGIC.len()))
    }

    fn record(&mut self, bytes: &[u8]) -> Result<Option<usize>, RecordingError> {
        let Some((kind, length)) = head(bytes) else {
            return Ok(None);
        };
        if !is_plausible(kind, length) {
            let what = format!("a record of kind {kind} and {length} bytes");
            self.phase = Phase::Lost(self.at, what);
            return Ok(Some(0));
        }
        let end = HEAD + length as usize;
        let Some(content) = bytes.get(HEAD..end) else {
            return Ok(None);
        };
        let record = match parse_record(kind, content) {
            Ok(record) => record,
            Err(error) => return Ok(self.lose(error.to_string())),
        };
        match self.leads_on(&record, bytes.get(end..).unwrap_or(&[])) {
            None if !self.is_all => return Ok(None),
            Some(false) if !self.is_whole_message(&record) => {
                return Ok(self.lose("a record whose length leads nowhere".to_owned()));
            }
            _ => (),
        }
        self.take_in(&record, self.at..self.at + end as u64)?;
        if kind != op::DATA_END {
            self.sum.update(bytes.get(..end).unwrap_or(&[]));
        }
        Ok(Some(end))
    }

    /// Whether `next` begins with something that can follow this record; `None` if that cannot be
    /// seen yet.
    fn leads_on(&self, record: &Record<'_>, next: &[u8]) -> Option<bool> {
        let ((kind, length), id) = (head(next)?, channel(next)?);
        let is_declared = match record {
            Record::Channel(channel) => channel.id == id,
            _ => false,
        };
        let is_known = kind != op::MESSAGE || is_declared || self.channels.contains_key(&id);
        Some(is_known && is_plausible(kind, length))
    }

    /// The record that begins here is not readable: the search for a readable one begins after its
    /// first byte.
    fn lose(&mut self, what: String) -> Option<usize> {
        self.phase = Phase::Lost(self.at, what);
        Some(1)
    }

    /// Whether this is a complete message. Then the damage is in the next record, not in the length
    /// of this one.
    fn is_whole_message(&self, record: &Record<'_>) -> bool {
        match record {
            Record::Message { header, data } => {
                self.is_ours(header.channel_id, data) && super::read(data, header.log_time).is_ok()
            }
            _ => false,
        }
    }

    fn take_in(&mut self, record: &Record<'_>, place: Range<u64>) -> Result<(), RecordingError> {
        match record {
            Record::Channel(channel) => {
                let is_ours = channel.topic == CHANNEL && channel.message_encoding == ENCODING;
                let theirs = channel.metadata.get(SCHEMA_KEY).filter(|_| is_ours);
                if let Some(theirs) = theirs.filter(|theirs| **theirs != format!("{SCHEMA:016x}"))
                    && !self.channels.contains_key(&channel.id)
                {
                    let theirs = theirs.clone();
                    self.recording.damage.push(Damage::Schema { theirs });
                }
                let entry = (channel.topic.clone(), is_ours);
                self.channels.insert(channel.id, entry);
            }
            Record::Message { header, data } if self.is_ours(header.channel_id, data) => {
                self.recording.keep(data, place.start, header.log_time);
            }
            Record::Chunk { header, data } => self.chunk(header, data, place)?,
            Record::DataEnd(end) => {
                self.phase = Phase::Ended;
                self.check(end.data_section_crc, place.start);
            }
            _ => (),
        }
        Ok(())
    }

    /// If the record that names the channel is damaged, the magic number must suffice.
    fn is_ours(&self, channel: u16, data: &[u8]) -> bool {
        match self.channels.get(&channel) {
            Some((_, is_ours)) => *is_ours,
            None => data.starts_with(&MESSAGE_SIGN),
        }
    }

    /// The records in a chunk; if one is damaged, the chunk from there to its end is reported as
    /// damage.
    fn chunk(
        &mut self,
        header: &mcap::records::ChunkHeader,
        data: &[u8],
        place: Range<u64>,
    ) -> Result<(), RecordingError> {
        if !header.compression.is_empty() {
            let (offset, how) = (place.start, header.compression.clone());
            return Err(RecordingError::Compressed { offset, how });
        }
        let mut rest = data;
        while let Some((kind, length)) = head(rest) {
            let end = HEAD.saturating_add(length as usize);
            let (Some(content), Some(next)) = (rest.get(HEAD..end), rest.get(end..)) else {
                break;
            };
            match parse_record(kind, content) {
                Ok(Record::Chunk { .. } | Record::DataEnd(_)) | Err(_) => break,
                Ok(record) => self.take_in(&record, place.clone())?,
            }
            rest = next;
        }
        if !rest.is_empty() {
            let from = place.end - rest.len() as u64;
            let what = "a chunk holds something else than records".to_owned();
            self.damaged(from, place.end, what);
        }
        Ok(())
    }

    fn damaged(&mut self, from: u64, to: u64, what: String) {
        let damage = Damage::Bytes { from, to, what };
        self.recording.damage.push(damage);
    }

    /// 0 stands for a checksum that was not computed; after damage none can match.
    fn check(&mut self, expected: u32, to: u64) {
        let found = self.sum.clone().finalize();
        if expected != 0 && found != expected && self.is_undamaged() {
            self.recording.damage.push(Damage::Sum {
                to,
                found,
                expected,
            });
        }
    }

    /// Whether every byte so far was readable; another schema is not damage of the file.
    fn is_undamaged(&self) -> bool {
        let damage = &self.recording.damage;
        damage
            .iter()
            .all(|damage| matches!(damage, Damage::Schema { .. }))
    }

    /// Searches for the next message that is certainly ours; returns the number of bytes to skip.
    fn search(&mut self, bytes: &[u8]) -> Option<usize> {
        let found = bytes.windows(SIGN).position(is_sign);
        let passed = found.unwrap_or(bytes.len().saturating_sub(SIGN - 1));
        if let (Some(at), Phase::Lost(from, what)) = (found, &mut self.phase) {
            let (from, what) = (*from, std::mem::take(what));
            self.damaged(from, self.at + passed as u64, what);
            self.phase = Phase::Records;
            let id = bytes.get(at..).and_then(channel);
            self.channels
                .extend(id.map(|id| (id, (CHANNEL.to_owned(), true))));
        }
        (found.is_some() || passed > 0).then_some(passed)
    }
}

/// Whether a record of the data section can have this length: no shorter than its fixed fields
/// (mcap.dev/spec, Records), and no longer than any writer's.
fn is_plausible(kind: u8, length: u64) -> bool {
    let least = match kind {
        op::FOOTER => return length == 20,
        op::DATA_END => return length == 4,
        op::HEADER | op::METADATA => 8,
        op::SCHEMA => 14,
        op::CHANNEL => 16,
        op::MESSAGE => MESSAGE_HEAD as u64,
        op::CHUNK => 40,
        op::MESSAGE_INDEX => 6,
        op::ATTACHMENT => 40,
        _ => return false,
    };
    (least..=LONGEST).contains(&length)
}

/// Whether one of our messages certainly begins here: both its times are equal, and the bytes after
/// them are those that begin each message of the bridge.
fn is_sign(bytes: &[u8]) -> bool {
    let at = |from: usize, to: usize| bytes.get(HEAD + from..HEAD + to);
    bytes.first() == Some(&op::MESSAGE)
        && at(6, 14) == at(14, 22)
        && at(MESSAGE_HEAD, MESSAGE_HEAD + MESSAGE_SIGN.len()) == Some(&MESSAGE_SIGN)
        && head(bytes).is_some_and(|(kind, length)| is_plausible(kind, length))
}

/// Kind and length of the record that begins here.
fn head(bytes: &[u8]) -> Option<(u8, u64)> {
    let (kind, rest) = bytes.split_first()?;
    Some((*kind, u64::from_le_bytes(*rest.first_chunk()?)))
}

/// Channel of the message whose record begins here.
fn channel(bytes: &[u8]) -> Option<u16> {
    Some(u16::from_le_bytes(*bytes.get(HEAD..)?.first_chunk()?))
}
