//! Frames: markers, byte stuffing and checksum around a message.
//!
//! In: bytes as they arrive. Out: frames, and counters of what was thrown away.
//!
//! 1. Bytes are kept until a zero. Pieces longer than the longest frame are thrown away at once, so
//!    memory is bounded.
//! 2. The bytes between two zeros are unstuffed in place, and their CRC is checked.
//! 3. Kind, length and values must be those of the table: a checksum alone accepts one wrong frame
//!    in 65536.

use std::marker::PhantomData;

use super::message::Message;
use crate::wire::Tally;

/// Bytes of the longest frame to the robot, markers included.
pub const LONGEST_TO_ROBOT: usize = 31;

/// The CRC of the frames: 0x6F91 for "123456789".
const CRC: crc::Crc<u16> = crc::Crc::<u16>::new(&crc::CRC_16_MCRF4XX);
const MARKER: u8 = 0;

/// A message and its sequence.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Frame<M> {
    /// Counts the frames of one direction, modulo 256.
    pub sequence: u8,
    /// The message.
    pub message: M,
}

/// Finds the frames of one direction in a stream of bytes.
#[derive(Clone, Debug)]
pub struct Decoder<M> {
    piece: Vec<u8>,
    /// The current piece is longer than any frame.
    is_overlong: bool,
    tally: Tally,
    direction: PhantomData<M>,
}

/// The bytes of a frame on the line, including markers.
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
            tally: Tally::default(),
            direction: PhantomData,
        }
    }
}

impl<M: Message> Decoder<M> {
    /// Counts of the bytes since the decoder was made. Frames that are too long are rejected.
    #[must_use]
    pub fn tally(&self) -> Tally {
        self.tally
    }

    /// The frames that these bytes complete, in order.
    pub fn push<'a>(&'a mut self, bytes: &'a [u8]) -> impl Iterator<Item = Frame<M>> + 'a {
        bytes.iter().filter_map(|&byte| self.push_byte(byte))
    }

    /// Takes one byte; returns the frame that it completes.
    pub fn push_byte(&mut self, byte: u8) -> Option<Frame<M>> {
        self.tally.bytes += 1;
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

    /// Drops an incomplete frame, as after a break of the line.
    pub fn restart(&mut self) {
        self.tally.discarded += self.piece.len() as u64;
        self.piece.clear();
        self.is_overlong = false;
    }

    fn keep(&mut self, byte: u8) {
        if self.is_overlong {
            self.tally.discarded += 1;
            return;
        }
        self.piece.push(byte);
        // Both markers count as bytes of a frame.
        if self.piece.len() > M::LONGEST_FRAME - 2 {
            self.tally.discarded += self.piece.len() as u64;
            self.tally.rejected += 1;
            self.piece.clear();
            self.is_overlong = true;
        }
    }

    fn open(&mut self, piece: &mut [u8]) -> Option<Frame<M>> {
        let frame = check(piece);
        match frame {
            Some(_) => self.tally.frames += 1,
            None => {
                self.tally.rejected += 1;
                self.tally.discarded += piece.len() as u64;
            }
        }
        frame
    }
}

/// The frame in a piece between two markers; `None` if stuffing, checksum, kind, length or a value
/// is wrong.
fn check<M: Message>(piece: &mut [u8]) -> Option<Frame<M>> {
    let (message, crc) = unstuff(piece)?.split_last_chunk::<2>()?;
    let [kind, sequence, payload @ ..] = message else {
        return None;
    };
    if CRC.checksum(message) != u16::from_le_bytes(*crc) {
        return None;
    }
    Some(Frame {
        sequence: *sequence,
        message: M::parse(*kind, payload)?,
    })
}

/// Removes the stuffing of a piece without zeros, in place.
fn unstuff(piece: &mut [u8]) -> Option<&[u8]> {
    let length = cobs::decode_in_place(piece).ok()?;
    piece.get(..length)
}
