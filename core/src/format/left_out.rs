//! What a reader left out of a log that is otherwise good, to be reported to a person.
//!
//! 1. A range that is NaN, infinite or negative is a beam that measured nothing. It says neither
//!    that something is there nor that the way is free: the scan has NaN in its place.
//! 2. A line whose pose or time is NaN, infinite or absurdly large is left out as a whole.
//! 3. A word that is not a number, or a wrong number of fields, still ends the reading: such a file
//!    is not what it claims to be.

use super::FieldError;

/// What a reader left out.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct LeftOut {
    /// Invalid ranges.
    pub ranges: Tally,
    /// Lines without a valid pose or time.
    pub lines: Tally,
}

/// How often something was wrong, and the first instance.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Tally {
    /// How often.
    pub count: usize,
    /// The first instance, with its line.
    pub first: Option<FieldError>,
}

impl LeftOut {
    /// One sentence for each kind that occurred.
    #[must_use]
    pub fn sentences(&self) -> Vec<String> {
        let ranges = self.ranges.sentence(
            "1 range is no measurement and was left out",
            "ranges are no measurements and were left out",
        );
        let lines = self.lines.sentence(
            "1 line cannot be used and was left out",
            "lines cannot be used and were left out",
        );
        ranges.into_iter().chain(lines).collect()
    }
}

impl Tally {
    /// Counts one more; `error` is called only for the first.
    pub(super) fn add(&mut self, error: impl FnOnce() -> FieldError) {
        self.count += 1;
        self.first.get_or_insert_with(error);
    }

    /// Adds those of a later part of the file.
    pub(super) fn append(&mut self, others: Self) {
        self.count += others.count;
        self.first = self.first.take().or(others.first);
    }

    fn sentence(&self, one: &str, many: &str) -> Option<String> {
        let first = self.first.as_ref()?;
        Some(match self.count {
            1 => format!("{one}: {first}"),
            count => format!("{count} {many}. The first: {first}"),
        })
    }
}

/// Whether a word is a number that cannot be a range: NaN, infinite or negative.
pub(super) fn is_no_range(word: &str) -> bool {
    let number = word.parse::<f64>();
    number.is_ok_and(|range| !range.is_finite() || range < 0.0)
}

/// Whether a word is NaN or infinite.
pub(super) fn is_not_finite(word: &str) -> bool {
    word.parse::<f64>().is_ok_and(|number| !number.is_finite())
}
