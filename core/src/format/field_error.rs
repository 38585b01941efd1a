//! How readers of text files report what they cannot read.

use std::fmt::Display;
use std::str::FromStr;

/// A part of a text file that cannot be read.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("line {line}: {field} is `{found}`, expected {expected}")]
pub struct FieldError {
    /// Line, from 1.
    pub line: usize,
    /// Which part of the line.
    pub field: String,
    /// What was found, shortened.
    pub found: String,
    /// What was expected.
    pub expected: String,
}

impl FieldError {
    pub(super) fn new(
        line: usize,
        field: impl Display,
        found: &str,
        expected: impl Display,
    ) -> Self {
        Self {
            line,
            field: field.to_string(),
            found: short(found),
            expected: expected.to_string(),
        }
    }

    /// A line with the wrong number of fields.
    pub(super) fn count(line: usize, found: usize, expected: impl Display) -> Self {
        Self::new(line, "the number of fields", &found.to_string(), expected)
    }
}

/// The value of a word, if it fits.
pub(super) fn read<T: FromStr>(
    line: usize,
    field: impl Display,
    word: &str,
    expected: &str,
    fits: impl Fn(&T) -> bool,
) -> Result<T, FieldError> {
    let value = word.parse().ok().filter(fits);
    value.ok_or_else(|| FieldError::new(line, field, word, expected))
}

/// The finite number in a word.
pub(super) fn number(line: usize, field: impl Display, word: &str) -> Result<f64, FieldError> {
    read(line, field, word, "a finite number", |n: &f64| {
        n.is_finite()
    })
}

/// The beginning of a word, as much as an error repeats; control characters are escaped.
pub(super) fn short(word: &str) -> String {
    let mut text = String::new();
    for letter in word.chars().take(24) {
        match letter.is_control() {
            true => text.extend(letter.escape_default()),
            false => text.push(letter),
        }
    }
    text
}
