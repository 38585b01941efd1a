//! Reads what the RP6 says under RP6 Remotrol, a remote-control program for the PC.
//!
//! In: bytes. Out: records of named numbers. Nothing is ever sent.
//!
//! ```text
//! [DATA]
//! Bat:720
//! SpeedL:40
//! …
//! [/DATA]
//! ```
//!
//! 1. Lines end with `\n`, `\r\n` too. What stands outside of a record (heartbeats, debug text) is passed over.
//! 2. A record that begins before the last one ended replaces it: its end was lost.
//! 3. A line inside that is not `Key:number` is counted and left out; the rest of the record stands.
//!
//! Keys seen in its source: `Bat`, `SpeedL`, `SpeedR`, `PowerL`, `PowerR`, `LightL`, `LightR`, `BumpL`, `BumpR`, `ObsL`, `ObsR`,
//! `ADC0_Base`, `Distance`, `Mic` and more: counts of the converter, and counts per 0.2 s for the speeds.

use std::collections::BTreeMap;

/// Lines and records that grow longer are not of this protocol.
const LONGEST_LINE: usize = 64;
const MOST_KEYS: usize = 64;

/// One record: a number for each key.
pub type Record = BTreeMap<String, i32>;

/// Reads a stream.
#[derive(Clone, Debug, Default)]
pub struct Reader {
    line: Vec<u8>,
    is_overlong: bool,
    record: Option<Record>,
    bad_lines: u64,
}

impl Reader {
    /// A reader of a stream that begins now.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Lines inside of records that could not be read, and records without an end.
    #[must_use]
    pub fn bad_lines(&self) -> u64 {
        self.bad_lines
    }

    /// Takes bytes in a piece of any size; gives the records that they complete.
    pub fn push(&mut self, bytes: &[u8]) -> Vec<Record> {
        bytes
            .iter()
            .filter_map(|&byte| self.push_byte(byte))
            .collect()
    }

    fn push_byte(&mut self, byte: u8) -> Option<Record> {
        if byte != b'\n' {
            self.is_overlong |= self.line.len() >= LONGEST_LINE;
            if !self.is_overlong {
                self.line.push(byte);
            }
            return None;
        }
        let line = std::mem::take(&mut self.line);
        match std::mem::take(&mut self.is_overlong) {
            false => self.take(line.trim_ascii()),
            true => {
                self.bad_lines += u64::from(self.record.is_some());
                None
            }
        }
    }

    fn take(&mut self, line: &[u8]) -> Option<Record> {
        match line {
            b"[DATA]" => {
                self.bad_lines += u64::from(self.record.is_some());
                self.record = Some(Record::new());
            }
            b"[/DATA]" => return self.record.take(),
            _ => {
                let record = self.record.as_mut()?;
                match field(line).filter(|_| record.len() < MOST_KEYS) {
                    Some((key, value)) => {
                        record.insert(key.to_owned(), value);
                    }
                    None => self.bad_lines += 1,
                }
            }
        }
        None
    }
}

fn field(line: &[u8]) -> Option<(&str, i32)> {
    let (key, value) = std::str::from_utf8(line).ok()?.split_once(':')?;
    let is_key = !key.is_empty() && key.bytes().all(|b| b.is_ascii_alphanumeric() || b == b'_');
    Some((key, value.trim().parse().ok()?)).filter(|_| is_key)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn record(fields: &[(&str, i32)]) -> Record {
        let owned = |(key, value): &(&str, i32)| ((*key).to_owned(), *value);
        fields.iter().map(owned).collect()
    }

    #[test]
    fn a_record_is_read_between_its_marks() {
        let stream = b"*\n[DATA]\nBat:720\nSpeedL:-40\r\n[/DATA]\nnoise\n[DATA]\n[/DATA]\n";
        let expected = [record(&[("Bat", 720), ("SpeedL", -40)]), record(&[])];
        assert_eq!(Reader::new().push(stream), expected);
    }

    #[test]
    fn what_is_broken_is_left_out_and_counted() {
        let mut reader = Reader::new();
        // No number, no colon, no key, too large; a record that never ends; a line that never ends.
        let stream = b"[DATA]\nBat:x\nBat\n:4\nA:99999999999\nMic:3\n[/DATA]\n[DATA]\nBat:1\n[DATA]\nBat:2\n";
        assert_eq!(reader.push(stream), [record(&[("Mic", 3)])]);
        assert_eq!(reader.bad_lines(), 5);
        reader.push(&[b'y'; 5_000]);
        assert!(reader.line.len() <= LONGEST_LINE);
        assert_eq!(reader.push(b"\n[/DATA]\n"), [record(&[("Bat", 2)])]);
        assert_eq!(reader.bad_lines(), 6);
    }

    proptest! {
        #[test]
        fn pieces_of_any_size_read_alike(
            fields in proptest::collection::btree_map("[A-Za-z][A-Za-z0-9_]{0,9}", any::<i32>(), 0..20),
            noise in "[ -~]{0,40}",
            cut in 1..30_usize,
        ) {
            let mut text = format!("{noise}\n[DATA]\n");
            for (key, value) in &fields {
                text += &format!("{key}:{value}\n");
            }
            text += "[/DATA]\n";
            let mut reader = Reader::new();
            let records: Vec<Record> = text.as_bytes().chunks(cut).flat_map(|piece| reader.push(piece)).collect();
            prop_assert_eq!(records, [fields]);
        }
    }
}
