//! Reads what the RP6 says under rp6cntrl, a control program for the RP6 with its M32 board.
//!
//! In: bytes. Out: readings, and lines of text between them. Nothing is ever sent.
//!
//! ```text
//! 01 | size | type | data …       size counts type and data: 02 for a byte, 03 for a word, low byte first
//! ```
//!
//! 1. Outside of a message any byte but 01 is text; a line ends with `\n`.
//! 2. There is no checksum. What can be checked is checked: the type must be one of the table, and the size that of the
//!    type. Else the 01 was none of a message: it is dropped, and reading goes on with the byte behind it.
//!
//! | type | reading | data | | type | reading | data |
//! |---|---|---|---|---|---|---|
//! | 02 | state: bit 0 left bumper, 1 right, 4 movement complete | u8 | | 0B, 0C | distance left, right | u16 |
//! | 03, 04 | LEDs of base, of M32 | u8 | | 0D, 0E | distance wanted | u16 |
//! | 05, 06 | light left, right | u16 | | 0F, 10 | motor current | u16 |
//! | 07, 08 | speed left, right | u8 | | 11 | directions, 2 bits each | u8 |
//! | 09, 0A | speed wanted | u8 | | 12 | battery | u16 |
//! | 13 | power of the obstacle detection | u8 | | 14, 15 | microphone, remote control | u16 |
//!
//! Source: R. Helmus, rp6cntrl, the message table of its `shared` header as its serial reader uses it; later versions add
//! types of their own, which count as unknown here.

use std::collections::VecDeque;

const START: u8 = 0x01;
/// A line of text that grows longer is cut.
const LONGEST_LINE: usize = 256;

/// Which figure of the robot.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Quantity {
    /// Bits of bumpers and obstacle detection.
    State,
    /// LEDs of the base.
    BaseLeds,
    /// LEDs of the M32 board.
    M32Leds,
    /// Left light sensor, converter counts.
    LightLeft,
    /// Right light sensor, converter counts.
    LightRight,
    /// Speed of the left track, counts per 0.2 s.
    SpeedLeft,
    /// Speed of the right track, counts per 0.2 s.
    SpeedRight,
    /// Speed wanted on the left.
    WantedSpeedLeft,
    /// Speed wanted on the right.
    WantedSpeedRight,
    /// Way of the left track, counts, modulo 65536; it grows in either direction.
    DistanceLeft,
    /// Way of the right track.
    DistanceRight,
    /// Way wanted on the left.
    WantedDistanceLeft,
    /// Way wanted on the right.
    WantedDistanceRight,
    /// Current of the left motor, converter counts.
    CurrentLeft,
    /// Current of the right motor, converter counts.
    CurrentRight,
    /// Directions: left, right, left wanted, right wanted, two bits each from the lowest; 0 is forwards.
    Directions,
    /// Battery, converter counts.
    Battery,
    /// Power of the obstacle detection.
    AcsPower,
    /// Peak of the microphone, converter counts.
    Microphone,
    /// Last code of a remote control.
    RemoteControl,
}

/// The quantities from type 02 on, and their bytes of data.
const TYPES: [(Quantity, usize); 20] = [
    (Quantity::State, 1),
    (Quantity::BaseLeds, 1),
    (Quantity::M32Leds, 1),
    (Quantity::LightLeft, 2),
    (Quantity::LightRight, 2),
    (Quantity::SpeedLeft, 1),
    (Quantity::SpeedRight, 1),
    (Quantity::WantedSpeedLeft, 1),
    (Quantity::WantedSpeedRight, 1),
    (Quantity::DistanceLeft, 2),
    (Quantity::DistanceRight, 2),
    (Quantity::WantedDistanceLeft, 2),
    (Quantity::WantedDistanceRight, 2),
    (Quantity::CurrentLeft, 2),
    (Quantity::CurrentRight, 2),
    (Quantity::Directions, 1),
    (Quantity::Battery, 2),
    (Quantity::AcsPower, 1),
    (Quantity::Microphone, 2),
    (Quantity::RemoteControl, 2),
];

/// What was read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Item {
    /// A reading.
    Reading {
        /// Of what.
        quantity: Quantity,
        /// The number.
        value: u16,
    },
    /// A line of text, without its end; bytes that are no ASCII stand as `?`.
    Text(String),
}

/// Reads a stream.
#[derive(Clone, Debug, Default)]
pub struct Reader {
    /// Bytes of a message that was begun.
    message: Vec<u8>,
    line: String,
    dropped_bytes: u64,
}

impl Reader {
    /// A reader of a stream that begins now.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Starts of messages that turned out to be none.
    #[must_use]
    pub fn dropped_bytes(&self) -> u64 {
        self.dropped_bytes
    }

    /// Takes bytes in a piece of any size; gives what they complete.
    pub fn push(&mut self, bytes: &[u8]) -> Vec<Item> {
        let mut items = Vec::new();
        for &byte in bytes {
            let mut pending = VecDeque::from([byte]);
            while let Some(byte) = pending.pop_front() {
                items.extend(self.push_byte(byte, &mut pending));
            }
        }
        items
    }

    /// Takes one byte; bytes that have to be read again come to the front of `pending`.
    fn push_byte(&mut self, byte: u8, pending: &mut VecDeque<u8>) -> Option<Item> {
        if self.message.is_empty() && byte != START {
            return self.text(byte);
        }
        self.message.push(byte);
        match *self.message.as_slice() {
            [_] | [_, 2 | 3] => None,
            [_, size, kind] if size_of(kind) == Some(size) => None,
            [_, size, kind, ref data @ ..] if size_of(kind) == Some(size) => {
                let item = reading(kind, data)?;
                self.message.clear();
                Some(item)
            }
            _ => {
                self.dropped_bytes += 1;
                for byte in self.message.drain(1..).rev() {
                    pending.push_front(byte);
                }
                self.message.clear();
                None
            }
        }
    }

    fn text(&mut self, byte: u8) -> Option<Item> {
        match byte {
            b'\n' => Some(Item::Text(std::mem::take(&mut self.line))),
            b'\r' => None,
            _ if self.line.len() >= LONGEST_LINE => {
                self.dropped_bytes += 1;
                None
            }
            b' '..=b'~' => {
                self.line.push(char::from(byte));
                None
            }
            _ => {
                self.line.push('?');
                None
            }
        }
    }
}

fn type_of(kind: u8) -> Option<&'static (Quantity, usize)> {
    TYPES.get(usize::from(kind).checked_sub(2)?)
}

/// The size that a message of this type has, itself included.
fn size_of(kind: u8) -> Option<u8> {
    type_of(kind).map(|(_, data)| 1 + *data as u8)
}

/// The reading, once all of its data are there.
fn reading(kind: u8, data: &[u8]) -> Option<Item> {
    let (quantity, bytes) = *type_of(kind)?;
    let value = match *data {
        [low] if bytes == 1 => u16::from(low),
        [low, high] if bytes == 2 => u16::from_le_bytes([low, high]),
        _ => return None,
    };
    Some(Item::Reading { quantity, value })
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn reading(quantity: Quantity, value: u16) -> Item {
        Item::Reading { quantity, value }
    }

    #[test]
    fn words_are_little_endian_and_text_lies_between() {
        let stream = b"hello\n\x01\x03\x12\xd0\x02\x01\x02\x02\x11I2C ERROR\r\n";
        let items = Reader::new().push(stream);
        let expected = [
            Item::Text("hello".to_owned()),
            reading(Quantity::Battery, 720),
            reading(Quantity::State, 0x11),
            Item::Text("I2C ERROR".to_owned()),
        ];
        assert_eq!(items, expected);
    }

    #[test]
    fn a_start_that_is_none_costs_one_byte_and_no_message() {
        // Size 09, then type FF, then a size that is not the type's; a good message behind each.
        for noise in [&[1, 9][..], &[1, 2, 0xFF], &[1, 3, 0x02], &[1, 1], &[1]] {
            let mut stream = noise.to_vec();
            stream.extend([1, 3, 0x0B, 0x34, 0x12]);
            let mut reader = Reader::new();
            let items = reader.push(&stream);
            assert_eq!(
                items.last(),
                Some(&reading(Quantity::DistanceLeft, 0x1234)),
                "{noise:?}"
            );
            assert!(reader.dropped_bytes() >= 1, "{noise:?}");
        }
    }

    #[test]
    fn a_line_without_end_stays_bounded() {
        let mut reader = Reader::new();
        assert_eq!(reader.push(&[b'x'; 10_000]), []);
        assert!(reader.line.len() == LONGEST_LINE && reader.dropped_bytes() == 10_000 - 256);
    }

    proptest! {
        #[test]
        fn pieces_of_any_size_read_alike(bytes in proptest::collection::vec(any::<u8>(), 0..300), cut in 1..20_usize) {
            let whole = Reader::new().push(&bytes);
            let mut reader = Reader::new();
            let pieces: Vec<Item> = bytes.chunks(cut).flat_map(|piece| reader.push(piece)).collect();
            prop_assert_eq!(whole, pieces);
        }

        #[test]
        fn readings_come_back(readings in proptest::collection::vec((0..TYPES.len(), any::<u16>()), 0..50)) {
            let mut stream = Vec::new();
            let mut expected = Vec::new();
            for (index, value) in readings {
                let (quantity, bytes) = TYPES[index];
                let value = if bytes == 1 { value & 0xFF } else { value };
                stream.extend([START, 1 + bytes as u8, 2 + index as u8]);
                stream.extend(&value.to_le_bytes()[..bytes]);
                expected.push(reading(quantity, value));
            }
            prop_assert_eq!(Reader::new().push(&stream), expected);
        }
    }
}
