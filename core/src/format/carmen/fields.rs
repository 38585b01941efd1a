//! One line of a log: text, cut into the fields of its message, counted for the error message.

use super::CarmenError;
use crate::geom::Pose2;

pub(super) fn check_text(bytes: &[u8], line: usize) -> Result<&str, CarmenError> {
    let is_comment = bytes.iter().find(|b| !b.is_ascii_whitespace()) == Some(&b'#');
    let bad = bytes.iter().enumerate().find(|&(_, &b)| {
        (b.is_ascii_control() && !matches!(b, b'\t' | b'\r' | 0x0c | 0x1a))
            || (!b.is_ascii() && !is_comment)
    });
    if let Some((at, &byte)) = bad {
        return Err(CarmenError::Binary {
            line,
            column: at + 1,
            byte,
        });
    }
    // A comment may be in any encoding, and nobody reads it.
    Ok(if is_comment {
        ""
    } else {
        std::str::from_utf8(bytes).unwrap_or("")
    })
}

pub(super) struct Line<'a> {
    pub(super) number: usize,
    pub(super) text: &'a str,
}

impl<'a> Line<'a> {
    pub(super) fn fields(&self, message: &'static str) -> Fields<'a> {
        let mut words = self.text.split_ascii_whitespace();
        words.next();
        Fields {
            line: self.number,
            text: self.text,
            message,
            field: 1,
            words,
        }
    }
}

/// The fields of one message, counted for the error message.
pub(super) struct Fields<'a> {
    line: usize,
    text: &'a str,
    message: &'static str,
    field: usize,
    words: std::str::SplitAsciiWhitespace<'a>,
}

impl Fields<'_> {
    fn next(&mut self) -> Result<&str, CarmenError> {
        self.field += 1;
        self.words.next().ok_or_else(|| CarmenError::Count {
            line: self.line,
            message: self.message,
            announced: "as written".into(),
            expected: self.field,
            found: self.field - 1,
        })
    }

    pub(super) fn expect_total(
        &self,
        expected: usize,
        announced: impl Fn() -> String,
    ) -> Result<(), CarmenError> {
        let found = self.text.split_ascii_whitespace().count();
        if found == expected {
            return Ok(());
        }
        Err(CarmenError::Count {
            line: self.line,
            message: self.message,
            announced: announced(),
            expected,
            found,
        })
    }

    fn bad(&self, found: &str, expected: &'static str) -> CarmenError {
        let shown: String = found.chars().take(24).collect();
        CarmenError::Field {
            line: self.line,
            field: self.field,
            message: self.message,
            found: shown,
            expected,
        }
    }

    pub(super) fn number(&mut self) -> Result<f64, CarmenError> {
        let word = self.next()?.to_owned();
        match word.parse::<f64>() {
            Ok(number) if number.is_finite() => Ok(number),
            _ => Err(self.bad(&word, "a finite number")),
        }
    }

    /// A number of a size that sums and squares of it stay finite.
    pub(super) fn bounded(
        &mut self,
        most: f64,
        expected: &'static str,
    ) -> Result<f64, CarmenError> {
        let word = self.next()?.to_owned();
        match word.parse::<f64>() {
            Ok(number) if number.abs() <= most => Ok(number),
            _ => Err(self.bad(&word, expected)),
        }
    }

    pub(super) fn seconds(&mut self) -> Result<f64, CarmenError> {
        self.bounded(1e12, "a time in seconds, within ±1e12")
    }

    pub(super) fn angle(&mut self) -> Result<f64, CarmenError> {
        self.bounded(1e4, "an angle in radians, within ±10000")
    }

    fn coordinate(&mut self) -> Result<f64, CarmenError> {
        self.bounded(1e9, "a coordinate in metres, within ±1e9")
    }

    pub(super) fn range(&mut self) -> Result<f32, CarmenError> {
        self.field += 1;
        let Some(word) = self.words.next() else {
            self.field -= 1;
            return self.next().map(|_| 0.0);
        };
        match word.parse::<f32>() {
            Ok(range) if range.is_finite() && range >= 0.0 => Ok(range),
            _ => Err(self.bad(word, "a range in metres, finite and at least 0")),
        }
    }

    pub(super) fn count_or_none(&mut self, expected: &'static str) -> Result<usize, CarmenError> {
        let word = self.next()?.to_owned();
        match word.parse::<usize>() {
            Ok(count) if count <= 100_000 => Ok(count),
            _ => Err(self.bad(&word, expected)),
        }
    }

    pub(super) fn count(&mut self, expected: &'static str) -> Result<usize, CarmenError> {
        match self.count_or_none(expected)? {
            0 => Err(self.bad("0", expected)),
            count => Ok(count),
        }
    }

    pub(super) fn pose(&mut self) -> Result<Pose2, CarmenError> {
        let (x, y) = (self.coordinate()?, self.coordinate()?);
        Ok(Pose2::new(x, y, self.angle()?))
    }
}
