//! How readers of text files name what they cannot read.

use std::fmt::Display;
use std::str::FromStr;

/// A part of a text file that is not what it should be.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("line {line}: {field} is `{found}`, expected {expected}")]
pub struct FieldError {
    /// Line, from 1.
    pub line: usize,
    /// Which part of the line.
    pub field: String,
    /// What stands there, shortened.
    pub found: String,
    /// What may stand there.
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

    /// A line with another number of fields than it needs.
    pub(super) fn count(line: usize, found: usize, expected: impl Display) -> Self {
        Self::new(line, "the number of fields", &found.to_string(), expected)
    }
}

/// What a word says, if it fits.
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

/// The finite number that a word says.
pub(super) fn number(line: usize, field: impl Display, word: &str) -> Result<f64, FieldError> {
    read(line, field, word, "a finite number", |n: &f64| {
        n.is_finite()
    })
}

/// The beginning of a word, as much as an error repeats; what a terminal would obey is escaped.
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
