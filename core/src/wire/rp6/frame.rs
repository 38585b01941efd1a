//! Frames: markers, byte stuffing and checksum around a message.
//!
//! In: bytes as they come. Out: frames, and counters of what was thrown away.
//!
//! 1. Bytes are kept until a zero; more than the longest frame are thrown away at once, so memory is bounded.
//! 2. What lies between two zeros is unstuffed in place, and its CRC compared.
//! 3. Kind, length and values must be those of the table; a checksum alone lets one wrong frame in 65536 pass.

use std::marker::PhantomData;

use super::message::Message;

/// Bytes of the longest frame to the robot, markers included.
pub const LONGEST_TO_ROBOT: usize = 31;

/// The CRC of the frames: 0x6F91 for "123456789".
const CRC: crc::Crc<u16> = crc::Crc::<u16>::new(&crc::CRC_16_MCRF4XX);
const MARKER: u8 = 0;

/// A message and the sequence it came with.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Frame<M> {
    /// Counts the frames of one direction, modulo 256.
    pub sequence: u8,
    /// What it says.
    pub message: M,
}

/// What a [`Decoder`] saw since it was made.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counters {
    /// Good frames.
    pub frames: u64,
    /// Bytes that belong to no good frame.
    pub dropped_bytes: u64,
    /// Pieces between two markers whose stuffing is impossible.
    pub bad_stuffing: u64,
    /// Pieces with a wrong checksum.
    pub bad_crc: u64,
    /// Pieces longer than the longest frame.
    pub overlong: u64,
    /// Right checksum, but no kind, length or value of the table: another version, or a chance.
    pub unknown: u64,
    /// Frames that are missing by the sequence numbers of those that came.
    pub missing: u64,
}

/// Finds the frames of one direction in a stream of bytes.
#[derive(Clone, Debug)]
pub struct Decoder<M> {
    piece: Vec<u8>,
    /// The present piece is longer than any frame.
    is_overlong: bool,
    last_sequence: Option<u8>,
    counters: Counters,
    direction: PhantomData<M>,
}

/// The bytes of a frame on the line, markers included.
#[must_use]
pub fn encode<M: Message>(sequence: u8, message: &M) -> Vec<u8> {
    let mut bytes = vec![message.kind(), sequence];
    message.put_payload(&mut bytes);
    bytes.extend_from_slice(&CRC.checksum(&bytes).to_le_bytes());
    cobs::encode_vec_including_sentinels(&bytes)
}

impl<M> Default for Decoder<M> {
    fn default() -> Self {
        Self {
            piece: Vec::new(),
            is_overlong: false,
            last_sequence: None,
            counters: Counters::default(),
            direction: PhantomData,
        }
    }
}

impl<M: Message> Decoder<M> {
    /// A decoder that waits for its first marker.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Counters since the decoder was made. Bytes that may still become a frame are not in them.
    #[must_use]
    pub fn counters(&self) -> Counters {
        self.counters
    }

    /// The frames that these bytes complete, in their order.
    pub fn push<'a>(&'a mut self, bytes: &'a [u8]) -> impl Iterator<Item = Frame<M>> + 'a {
        bytes.iter().filter_map(|&byte| self.push_byte(byte))
    }

    /// Takes one byte; gives the frame that it completes.
    pub fn push_byte(&mut self, byte: u8) -> Option<Frame<M>> {
        if byte != MARKER {
            self.keep(byte);
            return None;
        }
        let mut piece = std::mem::take(&mut self.piece);
        let was_overlong = std::mem::take(&mut self.is_overlong);
        let frame = match was_overlong || piece.is_empty() {
            true => None,
            false => self.open(&mut piece),
        };
        piece.clear();
        self.piece = piece;
        frame
    }

    /// Forgets a frame that was begun, as after a line that was cut.
    pub fn restart(&mut self) {
        self.counters.dropped_bytes += self.piece.len() as u64;
        self.piece.clear();
        self.is_overlong = false;
        self.last_sequence = None;
    }

    fn keep(&mut self, byte: u8) {
        if self.is_overlong {
            self.counters.dropped_bytes += 1;
            return;
        }
        self.piece.push(byte);
        // Both markers count as bytes of a frame.
        if self.piece.len() > M::LONGEST_FRAME - 2 {
            self.counters.dropped_bytes += self.piece.len() as u64;
            self.counters.overlong += 1;
            self.piece.clear();
            self.is_overlong = true;
        }
    }

    fn open(&mut self, piece: &mut [u8]) -> Option<Frame<M>> {
        let frame = self.check(piece);
        match &frame {
            Some(frame) => self.count(frame.sequence),
            None => self.counters.dropped_bytes += piece.len() as u64,
        }
        frame
    }

    fn check(&mut self, piece: &mut [u8]) -> Option<Frame<M>> {
        let Some(content) = unstuff(piece) else {
            self.counters.bad_stuffing += 1;
            return None;
        };
        let Some((message, crc)) = content.split_last_chunk::<2>() else {
            self.counters.bad_crc += 1;
            return None;
        };
        if CRC.checksum(message) != u16::from_le_bytes(*crc) {
            self.counters.bad_crc += 1;
            return None;
        }
        let parsed = match message {
            [kind, sequence, payload @ ..] => M::parse(*kind, payload).map(|message| Frame {
                sequence: *sequence,
                message,
            }),
            _ => None,
        };
        self.counters.unknown += u64::from(parsed.is_none());
        parsed
    }

    fn count(&mut self, sequence: u8) {
        self.counters.frames += 1;
        if let Some(last) = self.last_sequence.replace(sequence) {
            // A frame sent again has the same number, and nothing is missing between.
            let step = sequence.wrapping_sub(last);
            self.counters.missing += u64::from(step.saturating_sub(1));
        }
    }
}

/// Takes the stuffing out of a piece without zeros, in place.
fn unstuff(piece: &mut [u8]) -> Option<&[u8]> {
    let length = cobs::decode_in_place(piece).ok()?;
    piece.get(..length)
}
