//! What of a piece is in the store already, kept beside it: `NAME.mcap.upload`.
//!
//! It is written after each part, and as a whole. One that cannot be read, or is of another store
//! or another piece of that name, counts for nothing: the upload begins again.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use crate::record::name_in_store;
use crate::replaced_file::{Readers, replace};

/// Behind the name of the piece.
const SUFFIX: &str = ".upload";

/// See the module.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields, rename_all = "kebab-case")]
pub(super) struct Ledger {
    /// The store and the folder in it.
    pub(super) to: String,
    /// Of the piece.
    pub(super) bytes: u64,
    /// Of a part.
    pub(super) part_bytes: u64,
    /// SHA-256 of the piece, from before any of it was sent. Programs before this one took none.
    pub(super) sum: Option<String>,
    /// By which the store knows the upload.
    pub(super) upload: Option<String>,
    /// What the store answered to each part that it has.
    pub(super) parts: Vec<String>,
    /// SHA-256 of the piece, once all of it is stored and compared.
    pub(super) stored: Option<String>,
}

impl Ledger {
    /// That of this piece, or a new one.
    pub(super) fn of(piece: &Path, to: &str, bytes: u64, part_bytes: u64) -> Self {
        let kept = Self::read(piece).filter(|kept| {
            let is_same = kept.to == to && kept.bytes == bytes;
            is_same && (kept.stored.is_some() || kept.part_bytes == part_bytes)
        });
        kept.unwrap_or_else(|| Self {
            to: to.to_owned(),
            bytes,
            part_bytes,
            ..Self::default()
        })
    }

    /// What is kept of a piece.
    pub(super) fn read(piece: &Path) -> Option<Self> {
        let text = fs::read_to_string(path(piece)).ok()?;
        serde_json::from_str(&text).ok()
    }

    /// Nothing of it is there.
    pub(super) fn begin_anew(&mut self) {
        (self.sum, self.upload, self.stored) = (None, None, None);
        self.parts.clear();
    }

    /// What the piece of this name is called in the store. Of another robot's that began in the
    /// same second it is told by what is in it: the same bytes alone have the same name, so that
    /// nothing of another's is ever written over, whoever sends first.
    pub(super) fn name_in_store(&self, piece: &str) -> String {
        match &self.sum {
            Some(sum) => name_in_store(piece, sum),
            None => piece.to_owned(),
        }
    }

    /// Keeps it beside the piece.
    ///
    /// # Errors    What the system said.
    pub(super) fn write(&self, piece: &Path) -> io::Result<()> {
        let text = serde_json::to_string(self)?;
        replace(&path(piece), text.as_bytes(), Readers::Anyone)
    }
}

fn path(piece: &Path) -> PathBuf {
    let mut name = piece.as_os_str().to_owned();
    name.push(SUFFIX);
    name.into()
}

/// The piece that a ledger is of.
pub(super) fn piece_of(ledger: &Path) -> Option<PathBuf> {
    let name = ledger.file_name()?.to_str()?.strip_suffix(SUFFIX)?;
    Some(ledger.with_file_name(name))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ledger_of_another_store_piece_or_part_counts_for_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let piece = folder.path().join("slamlab-2026-01-01T00-00-00Z.mcap");
        let new = Ledger::of(&piece, "s3://a", 100, 10);
        assert_eq!((new.parts.len(), &new.stored), (0, &None));
        let begun = Ledger {
            upload: Some("7".into()),
            parts: vec!["x".into()],
            ..new
        };
        begun.write(&piece).unwrap();
        assert_eq!(Ledger::of(&piece, "s3://a", 100, 10), begun);
        for (to, bytes, part) in [
            ("s3://b", 100, 10),
            ("s3://a", 101, 10),
            ("s3://a", 100, 11),
        ] {
            assert!(Ledger::of(&piece, to, bytes, part).parts.is_empty());
        }
        fs::write(path(&piece), "{").unwrap();
        assert!(Ledger::of(&piece, "s3://a", 100, 10).parts.is_empty());
        assert_eq!(piece_of(&path(&piece)), Some(piece));
    }
}
