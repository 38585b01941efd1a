//! Records which parts of a piece are already in the store, in a file beside it:
//! `NAME.mcap.upload`.
//!
//! It is rewritten as a whole after each part. A ledger that cannot be read, or belongs to another
//! store or another piece of that name, is ignored: the upload begins again.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use crate::record::name_in_store;
use crate::replaced_file::{Readers, replace};

/// Suffix to the name of the piece.
const SUFFIX: &str = ".upload";

/// See the module.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields, rename_all = "kebab-case")]
pub(super) struct Ledger {
    /// The store and the folder in it.
    pub(super) to: String,
    /// Size of the piece.
    pub(super) bytes: u64,
    /// Size of a part.
    pub(super) part_bytes: u64,
    /// SHA-256 of the piece, taken before any of it was sent. Earlier versions of this program did
    /// not store it.
    pub(super) sum: Option<String>,
    /// The store's id of the upload.
    pub(super) upload: Option<String>,
    /// The store's answer to each part that it has.
    pub(super) parts: Vec<String>,
    /// How often in a row the store refused to go on with the upload.
    pub(super) refusals: u32,
    /// SHA-256 of the piece, once all of it is stored and compared.
    pub(super) stored: Option<String>,
}

impl Ledger {
    /// The ledger of this piece, or a new one.
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

    /// Reads the ledger of a piece.
    pub(super) fn read(piece: &Path) -> Option<Self> {
        let text = fs::read_to_string(path(piece)).ok()?;
        serde_json::from_str(&text).ok()
    }

    /// Forgets all parts: nothing of the piece is in the store.
    pub(super) fn begin_anew(&mut self) {
        (self.sum, self.upload, self.stored) = (None, None, None);
        self.parts.clear();
        self.refusals = 0;
    }

    /// The name of this piece in the store. Its hash tells it apart from another robot's piece of
    /// the same second: only equal bytes get equal names, so nobody's piece is ever overwritten by
    /// another, whoever sends first.
    pub(super) fn name_in_store(&self, piece: &str) -> String {
        match &self.sum {
            Some(sum) => name_in_store(piece, sum),
            None => piece.to_owned(),
        }
    }

    /// Writes it beside the piece.
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

/// The piece to which a ledger belongs.
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
