//! Cuts lines of a text log from chunks of any size; and the errors of such logs.
//!
//! Only an unfinished line is kept, so a large log is never held as text. Empty lines and comments
//! (`#`) are counted but ignored.

use super::{FieldError, LeftOut};

/// A line longer than this is not a line of a log, bytes.
const MAX_LINE: usize = 1 << 20;

/// Why bytes are not a text log of the kind that they look like.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum TextLogError {
    /// Bytes that are not text.
    #[error("line {line}: byte {column} is 0x{byte:02x}, which is not text; expected {expected}")]
    Binary {
        /// Line, from 1.
        line: usize,
        /// Byte in the line, from 1.
        column: usize,
        /// The byte.
        byte: u8,
        /// What such a log consists of.
        expected: &'static str,
    },
    /// A line that does not end.
    #[error("line {line} is longer than {MAX_LINE} bytes; expected {expected}")]
    LineTooLong {
        /// Line, from 1.
        line: usize,
        /// What such a log consists of.
        expected: &'static str,
    },
    /// A field that cannot be read, or a wrong number of fields.
    #[error(transparent)]
    Field(#[from] FieldError),
    /// The file ends within a line.
    #[error("line {line}: the file is cut off within its last line ({reason})")]
    CutOff {
        /// Line, from 1.
        line: usize,
        /// What is wrong with it.
        reason: FieldError,
    },
    /// The log has no scan.
    #[error("no scan in {lines} lines; expected {expected}")]
    NoScan {
        /// Number of lines read.
        lines: usize,
        /// What such a log consists of.
        expected: &'static str,
    },
}

/// A log that consists of lines.
pub(super) trait TextLog {
    /// Takes the next line; lines are counted from 1.
    fn take(&mut self, line: usize, text: &str) -> Result<(), FieldError>;

    fn has_scans(&self) -> bool;

    fn left_out(&self) -> &LeftOut;
}

/// Cuts lines from chunks.
#[derive(Clone, Debug)]
pub(super) struct Lines {
    expected: &'static str,
    unfinished: Vec<u8>,
    /// Number of the line read last, from 1.
    number: usize,
}

impl Lines {
    /// For a log that consists of what `expected` says.
    pub(super) fn new(expected: &'static str) -> Self {
        Self {
            expected,
            unfinished: vec![],
            number: 0,
        }
    }

    /// Takes the next bytes, and passes each complete line to the log.
    pub(super) fn push(
        &mut self,
        mut bytes: &[u8],
        log: &mut impl TextLog,
    ) -> Result<(), TextLogError> {
        while let Some(end) = bytes.iter().position(|&b| b == b'\n') {
            let (line, rest) = bytes.split_at(end);
            bytes = rest.get(1..).unwrap_or(&[]);
            let mut whole = std::mem::take(&mut self.unfinished);
            whole.extend_from_slice(line);
            self.line(&whole, log)?;
        }
        self.unfinished.extend_from_slice(bytes);
        if self.unfinished.len() > MAX_LINE {
            let line = self.number + 1;
            check_text(&self.unfinished, line, self.expected)?;
            let expected = self.expected;
            return Err(TextLogError::LineTooLong { line, expected });
        }
        Ok(())
    }

    /// Takes the last line, which may have no line end, and checks that there was a scan. If all
    /// lines were left out, the error says why the first one was.
    pub(super) fn finish(mut self, log: &mut impl TextLog) -> Result<(), TextLogError> {
        let last = std::mem::take(&mut self.unfinished);
        match self.line(&last, log) {
            Err(TextLogError::Field(reason)) => {
                let line = self.number;
                return Err(TextLogError::CutOff { line, reason });
            }
            other => other?,
        }
        if !log.has_scans() {
            if let Some(first) = &log.left_out().lines.first {
                return Err(first.clone().into());
            }
            return Err(TextLogError::NoScan {
                lines: self.number - usize::from(last.is_empty()),
                expected: self.expected,
            });
        }
        Ok(())
    }

    fn line(&mut self, bytes: &[u8], log: &mut impl TextLog) -> Result<(), TextLogError> {
        self.number += 1;
        if is_empty_or_comment(bytes) {
            return Ok(());
        }
        let text = check_text(bytes, self.number, self.expected)?;
        Ok(log.take(self.number, text)?)
    }
}

/// Whether a line has no content.
pub(crate) fn is_empty_or_comment(line: &[u8]) -> bool {
    let mut words = line.iter().filter(|b| !b.is_ascii_whitespace());
    words.next().is_none_or(|b| *b == b'#')
}

fn check_text<'a>(
    bytes: &'a [u8],
    line: usize,
    expected: &'static str,
) -> Result<&'a str, TextLogError> {
    let is_text = |b: &u8| b.is_ascii_graphic() || b.is_ascii_whitespace();
    let text = std::str::from_utf8(bytes);
    match (bytes.iter().position(|b| !is_text(b)), text) {
        (None, Ok(text)) => Ok(text),
        (at, _) => {
            let at = at.unwrap_or(0);
            Err(TextLogError::Binary {
                line,
                column: at + 1,
                byte: bytes.get(at).copied().unwrap_or(0),
                expected,
            })
        }
    }
}
