//! How readers of text files name what they cannot read.

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
        field: impl Into<String>,
        found: &str,
        expected: impl Into<String>,
    ) -> Self {
        Self {
            line,
            field: field.into(),
            found: short(found),
            expected: expected.into(),
        }
    }

    /// A line with another number of fields than it needs.
    pub(super) fn count(line: usize, found: usize, expected: impl Into<String>) -> Self {
        Self::new(line, "the number of fields", &found.to_string(), expected)
    }
}

/// The beginning of a word: as much as an error repeats.
pub(super) fn short(word: &str) -> String {
    word.chars().take(24).collect()
}
