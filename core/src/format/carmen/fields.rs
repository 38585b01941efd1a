//! One line of a log: text, cut into the fields of its message, counted for the error message.

use std::fmt::Display;
use std::str::FromStr;

use super::CarmenError;
use crate::format::field_error::read;
use crate::format::left_out::is_no_range;
use crate::format::{FieldError, LeftOut, Tally};
use crate::geom::Pose2;

pub(super) fn check_text(bytes: &[u8], line: usize) -> Result<&str, CarmenError> {
    let trimmed = bytes.trim_ascii_start();
    let is_comment = trimmed.starts_with(b"#");
    // Comments and robot names may be in any encoding.
    let is_free = is_comment || trimmed.starts_with(b"PARAM");
    let bad = bytes.iter().enumerate().find(|&(_, &b)| {
        (b.is_ascii_control() && !matches!(b, b'\t' | b'\r' | 0x0c | 0x1a))
            || (!b.is_ascii() && !is_free)
    });
    if let Some((at, &byte)) = bad {
        let column = at + 1;
        return Err(CarmenError::Binary { line, column, byte });
    }
    // Comments are not read, and numbers are pure ASCII.
    let is_read = !is_comment && bytes.is_ascii();
    Ok(std::str::from_utf8(if is_read { bytes } else { b"" }).unwrap_or(""))
}

/// The fields of one message, counted for the error message.
pub(super) struct Fields<'a> {
    line: usize,
    text: &'a str,
    message: &'static str,
    field: usize,
    words: std::str::SplitAsciiWhitespace<'a>,
    /// Ranges so far that were not valid.
    no_ranges: Tally,
    /// Invalid numbers so far that make the line useless.
    unusable: Tally,
}

impl<'a> Fields<'a> {
    /// The fields of a line after the name of its message.
    pub(super) fn of(line: usize, text: &'a str, message: &'static str) -> Self {
        let mut words = text.split_ascii_whitespace();
        words.next();
        Self {
            line,
            text,
            message,
            field: 1,
            words,
            no_ranges: Tally::default(),
            unusable: Tally::default(),
        }
    }

    /// Whether the line can be used, now that all of it was read. What cannot be used is added to
    /// `left_out`.
    pub(super) fn finish(self, left_out: &mut LeftOut) -> bool {
        if self.unusable.count > 0 {
            left_out.lines.append(Tally {
                count: 1,
                ..self.unusable
            });
            return false;
        }
        left_out.ranges.append(self.no_ranges);
        true
    }

    fn word(&mut self) -> Result<&'a str, FieldError> {
        let Some(word) = self.words.next() else {
            return Err(self.wrong_count("more".to_owned()));
        };
        self.field += 1;
        Ok(word)
    }

    /// The value of a word, which is the field read last, if it fits.
    fn read<T: FromStr>(
        &self,
        word: &str,
        expected: &str,
        fits: impl Fn(&T) -> bool,
    ) -> Result<T, FieldError> {
        let name = format_args!("field {} of {}", self.field, self.message);
        read(self.line, name, word, expected, fits)
    }

    fn wrong_count(&self, expected: String) -> FieldError {
        let found = self.text.split_ascii_whitespace().count();
        let name = format!("the number of fields of {}", self.message);
        FieldError::new(self.line, name, &found.to_string(), expected)
    }

    pub(super) fn expect_total(
        &self,
        expected: usize,
        announced: impl Display,
    ) -> Result<(), FieldError> {
        if self.text.split_ascii_whitespace().count() != expected {
            return Err(self.wrong_count(format!("{expected}, {announced}")));
        }
        Ok(())
    }

    /// A number that may be NaN or infinite, because it is not used.
    pub(super) fn number(&mut self) -> Result<f64, FieldError> {
        let word = self.word()?;
        self.read(word, "a number", |_| true)
    }

    /// Skips as many numbers, which are not used.
    pub(super) fn skip(&mut self, count: usize) -> Result<(), FieldError> {
        (0..count).try_for_each(|_| self.number().map(drop))
    }

    /// A number small enough that its sums and squares stay finite; without it the line is useless.
    fn bounded(&mut self, most: f64, expected: &str) -> Result<f64, FieldError> {
        let word = self.word()?;
        let number: f64 = self.read(word, expected, |_| true)?;
        // NaN fails this comparison.
        self.read(word, expected, |n: &f64| n.abs() <= most)
            .or_else(|error| {
                self.unusable.add(|| error);
                Ok(number)
            })
    }

    pub(super) fn seconds(&mut self) -> Result<f64, FieldError> {
        self.bounded(1e12, "a time in seconds, within ±1e12")
    }

    pub(super) fn angle(&mut self) -> Result<f64, FieldError> {
        self.bounded(1e4, "an angle in radians, within ±10000")
    }

    fn coordinate(&mut self) -> Result<f64, FieldError> {
        self.bounded(1e9, "a coordinate in metres, within ±1e9")
    }

    /// A range, m. A number that is not a valid range becomes 0, which means "not measured".
    pub(super) fn range(&mut self) -> Result<f32, FieldError> {
        let word = self.word()?;
        let expected = "a range in metres, finite and at least 0";
        let fits = |r: &f32| r.is_finite() && *r >= 0.0;
        self.read(word, expected, fits).or_else(|error| {
            if is_no_range(word) {
                self.no_ranges.add(|| error);
                return Ok(0.0);
            }
            Err(error)
        })
    }

    /// How many fields of a kind follow, from `least` to 100 000.
    pub(super) fn count(&mut self, least: usize, expected: &str) -> Result<usize, FieldError> {
        let word = self.word()?;
        self.read(word, expected, |n| (least..=100_000).contains(n))
    }

    pub(super) fn pose(&mut self) -> Result<Pose2, FieldError> {
        let (x, y) = (self.coordinate()?, self.coordinate()?);
        Ok(Pose2::new(x, y, self.angle()?))
    }
}
