//! Inputs from inputs: flips, cuts, copies and joins, and unusual numbers and text.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Longest input, bytes: what the bridge accepts in one message.
const LONGEST: usize = 64 * 1024;
/// Bytes with a special meaning to codecs: stuffing, sync marks, signs, line ends.
const ODD_BYTES: [u8; 14] = [
    0x00, 0x01, 0x7F, 0x80, 0xFF, 0xFE, 0xA5, 0x5A, 0x54, 0x2C, b'\n', b'\r', b'#', b'"',
];
const ODD_WORDS: [&str; 16] = [
    "NaN",
    "inf",
    "-inf",
    "1e999",
    "-0",
    "1e-999",
    "0",
    "-1",
    "18446744073709551616",
    "99999999999",
    "0x",
    "",
    "\u{FFFD}",
    "\u{0}",
    "[[[[[[[[[[[[[[[[[[[[[[[[",
    "{}",
];

/// Mutations of one input, determined by its number.
pub(super) struct Mutator {
    rng: ChaCha8Rng,
}

impl Mutator {
    pub(super) fn new(number: u64) -> Self {
        Self {
            rng: ChaCha8Rng::seed_from_u64(number),
        }
    }

    /// One of the known inputs, mutated one to eight times.
    pub(super) fn change(&mut self, known: &[Vec<u8>]) -> Vec<u8> {
        let mut input = self.one_of(known);
        for _ in 0..=self.below(8) {
            self.step(&mut input, known);
        }
        input.truncate(LONGEST);
        input
    }

    fn step(&mut self, input: &mut Vec<u8>, known: &[Vec<u8>]) {
        let at = self.below(input.len() + 1);
        let span = at..(at + self.below(32)).min(input.len()).max(at);
        match self.below(9) {
            0 => {
                if let Some(byte) = input.get_mut(at) {
                    *byte ^= 1 << self.rng.random_range(0..8);
                }
            }
            1 => {
                let odd = ODD_BYTES[self.below(ODD_BYTES.len())];
                if let Some(byte) = input.get_mut(at) {
                    *byte = odd;
                }
            }
            2 => input.insert(at, self.rng.random()),
            3 => drop(input.drain(span)),
            4 => {
                let copy = input[span].to_vec();
                for _ in 0..=self.below(4) {
                    let copy = copy.iter().copied();
                    input.splice(at..at, copy);
                }
            }
            5 => input.truncate(at),
            6 => {
                let other = self.one_of(known);
                let from = self.below(other.len() + 1);
                input.truncate(at);
                input.extend_from_slice(&other[from..]);
            }
            7 => {
                let odd = ODD_WORDS[self.below(ODD_WORDS.len())];
                let word = word_at(input, at);
                input.splice(word, odd.bytes());
            }
            _ => {
                let number: u64 = self.rng.random();
                let bytes = number.to_le_bytes();
                for (byte, new) in input
                    .iter_mut()
                    .skip(at)
                    .zip(&bytes[..1 + self.rng.random_range(0..8)])
                {
                    *byte = *new;
                }
            }
        }
    }

    fn one_of(&mut self, known: &[Vec<u8>]) -> Vec<u8> {
        match known {
            [] => vec![],
            _ => known[self.below(known.len())].clone(),
        }
    }

    fn below(&mut self, most: usize) -> usize {
        match most {
            0 => 0,
            _ => self.rng.random_range(0..most),
        }
    }
}

/// The number or word at this position.
fn word_at(input: &[u8], at: usize) -> std::ops::Range<usize> {
    let is_part = |byte: &&u8| byte.is_ascii_alphanumeric() || matches!(byte, b'.' | b'-' | b'+');
    let before = input[..at].iter().rev().take_while(is_part).count();
    let behind = input[at..].iter().take_while(is_part).count();
    at - before..at + behind
}
