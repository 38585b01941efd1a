//! What was not tested, and why: one list for Rust, the page and these commands.
//!
//! Code that leaves a test out appends a line, `WHAT` tab `WHY`, to the file that the variable
//! `SLAMLAB_SKIPPED` names. [`crate::tools`] sets that variable for every cargo and npm that it
//! starts.

use std::fs::{self, OpenOptions};
use std::io::Write;
use std::path::PathBuf;

use anyhow::{Context, Result};

use crate::tools;

/// One or several tests that did not run.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Skip {
    /// Their name.
    pub what: String,
    /// The reason, one sentence.
    pub why: String,
}

impl Skip {
    /// Whether it is acceptable in CI: only tests that need recorded data, on a machine without it.
    #[must_use]
    pub fn is_fine_in_ci(&self) -> bool {
        self.why.starts_with("recorded data") && !tools::data_folder().is_dir()
    }
}

/// The file in which skips are gathered.
#[must_use]
pub fn file() -> PathBuf {
    tools::target_dir().join("skipped.tsv")
}

/// Starts with an empty list.
///
/// # Errors
/// If it cannot be written.
pub fn begin() -> Result<()> {
    let file = file();
    fs::create_dir_all(tools::target_dir())?;
    fs::write(&file, "").with_context(|| format!("cannot write {}", file.display()))
}

/// Records that something is left out, and why.
///
/// # Errors
/// If it cannot be recorded.
pub fn note(what: &str, why: &str) -> Result<()> {
    eprintln!("skipped: {what}: {why}");
    let file = file();
    let line = format!("{what}\t{why}\n");
    OpenOptions::new()
        .create(true)
        .append(true)
        .open(&file)
        .and_then(|mut list| list.write_all(line.as_bytes()))
        .with_context(|| format!("cannot write {}", file.display()))
}

/// All that were recorded since [`begin`], without repetitions.
///
/// # Errors
/// If the list cannot be read.
pub fn all() -> Result<Vec<Skip>> {
    let file = file();
    let text = fs::read_to_string(&file);
    let text = text.with_context(|| format!("cannot read {}", file.display()))?;
    Ok(parse(&text))
}

fn parse(text: &str) -> Vec<Skip> {
    let mut skips: Vec<Skip> = vec![];
    for line in text.lines() {
        let (what, why) = line.split_once('\t').unwrap_or((line, "without a reason"));
        let [what, why] = [what, why].map(str::to_owned);
        let skip = Skip { what, why };
        if !skips.contains(&skip) {
            skips.push(skip);
        }
    }
    skips
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_test_that_was_skipped_is_named_once_with_its_reason() {
        let skips = parse("a\tno lidar\nb\tno robot\na\tno lidar\nc\n");
        let read: Vec<_> = skips
            .iter()
            .map(|s| (s.what.as_str(), s.why.as_str()))
            .collect();
        let expected = [
            ("a", "no lidar"),
            ("b", "no robot"),
            ("c", "without a reason"),
        ];
        assert_eq!(read, expected);
    }
}
