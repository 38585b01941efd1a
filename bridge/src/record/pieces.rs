//! The pieces of a recording: a folder gets one file after the other, within a budget of bytes; if
//! a file was named, it is the only piece.
//!
//! Pieces are named by the time of day and sort by it: the oldest is deleted first. Only files
//! named as pieces are ever deleted, and never the newest.

use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};
use std::time::Duration;

use super::RecordError;
use super::journal::Storage;
use super::place::{self, AUDITS, Naming, RECORDINGS};
use crate::clock::Clock;

/// How long pieces are, and how many bytes of them are kept. For folders only.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Keep {
    /// Size at which a piece ends, bytes. Default 512 MiB.
    pub piece_bytes: u64,
    /// Age at which a piece ends. Default 1 h.
    pub piece_age: Duration,
    /// The oldest pieces are deleted if all in the folder exceed this, bytes. Default 8 GiB.
    pub all_bytes: u64,
}

/// 1 MiB.
pub const MEBIBYTE: u64 = 1 << 20;

impl Default for Keep {
    fn default() -> Self {
        Self {
            piece_bytes: 512 * MEBIBYTE,
            piece_age: Duration::from_secs(60 * 60),
            all_bytes: 8 * 1024 * MEBIBYTE,
        }
    }
}

/// Where the next piece comes from.
pub(crate) trait Pieces {
    /// The file that is written to.
    type File: Storage;
    /// A new piece and its path; none if the first is the only one.
    fn next(&mut self) -> Result<Option<(Self::File, PathBuf)>, RecordError>;
    /// Removes a piece that could not even begin: it is empty.
    fn discard(&mut self, path: &Path);
    /// Deletes pieces beyond the budget, but never the current one.
    fn make_room(&mut self, current: &Path);
}

/// Pieces in a folder, or one file.
#[derive(Debug)]
pub(crate) struct Files {
    pub(crate) path: PathBuf,
    naming: Naming,
    is_folder: bool,
    pub(crate) keep: Keep,
    pub(crate) clock: Clock,
    /// While it is open, no other bridge writes into the folder.
    _lock: Option<File>,
}

impl Files {
    /// The files of a recording.
    ///
    /// # Errors    [`RecordError::Taken`], [`RecordError::Io`].
    pub(crate) fn recordings(path: &Path, keep: Keep, clock: Clock) -> Result<Self, RecordError> {
        let is_folder = place::is_folder(path);
        Self::new(path, RECORDINGS, is_folder, keep, clock)
    }

    /// The files of an audit, which is always a folder.
    ///
    /// # Errors    [`RecordError::Taken`], [`RecordError::Io`].
    pub(crate) fn audits(path: &Path, keep: Keep, clock: Clock) -> Result<Self, RecordError> {
        Self::new(path, AUDITS, true, keep, clock)
    }

    fn new(
        path: &Path,
        naming: Naming,
        is_folder: bool,
        keep: Keep,
        clock: Clock,
    ) -> Result<Self, RecordError> {
        let lock = is_folder.then(|| naming.lock(path)).transpose()?;
        Ok(Self {
            path: path.to_owned(),
            naming,
            is_folder,
            keep,
            clock,
            _lock: lock,
        })
    }
}

impl Pieces for Files {
    type File = File;

    fn next(&mut self) -> Result<Option<(File, PathBuf)>, RecordError> {
        if !self.is_folder {
            return Ok(None);
        }
        let now = self.clock.time_of_day(self.clock.now());
        self.naming.create(&self.path, now).map(Some)
    }

    fn discard(&mut self, path: &Path) {
        if let Err(error) = fs::remove_file(path) {
            tracing::warn!("{}: {error}", path.display());
        }
    }

    fn make_room(&mut self, current: &Path) {
        if !self.is_folder {
            return;
        }
        match oldest_beyond(self.naming, &self.path, current, self.keep.all_bytes) {
            Ok(too_many) => {
                for piece in too_many {
                    match fs::remove_file(&piece) {
                        Ok(()) => tracing::info!("deleted {}: the budget is full", piece.display()),
                        Err(error) => tracing::warn!("{}: {error}", piece.display()),
                    }
                }
            }
            Err(error) => tracing::warn!("{}: {error}", self.path.display()),
        }
    }
}

/// The oldest pieces that must go, so that the rest has at most `most` bytes.
fn oldest_beyond(
    naming: Naming,
    folder: &Path,
    current: &Path,
    most: u64,
) -> io::Result<Vec<PathBuf>> {
    let mut pieces = vec![];
    for entry in fs::read_dir(folder)? {
        let entry = entry?;
        let name = entry.file_name();
        if name.to_str().is_some_and(|name| naming.is_piece(name)) && entry.file_type()?.is_file() {
            pieces.push((
                naming.age_of(&entry.path()),
                entry.path(),
                entry.metadata()?.len(),
            ));
        }
    }
    pieces.sort();
    let mut all: u64 = pieces.iter().map(|(_, _, bytes)| bytes).sum();
    let mut too_many = vec![];
    for (_, path, bytes) in pieces {
        if all <= most {
            break;
        }
        if path != current {
            all -= bytes;
            too_many.push(path);
        }
    }
    Ok(too_many)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_oldest_pieces_go_and_nothing_else() {
        let folder = tempfile::TempDir::new().unwrap();
        let path = |name: &str| folder.path().join(name);
        // Within one second, number 10 is younger than number 2.
        for name in [
            "slamlab-2026-01-01T00-00-00Z.mcap",
            "slamlab-2026-01-01T00-00-00Z-2.mcap",
            "slamlab-2026-01-01T00-00-00Z-10.mcap",
            "slamlab-2026-01-02T00-00-00Z.mcap",
            "slamlab-2026-01-03T00-00-00Z.mcap",
        ] {
            fs::write(path(name), [0; 100]).unwrap();
        }
        for precious in [
            "flat.mcap",
            "slamlab-flat.mcap",
            "notes",
            "slamlab-2026-01-01T00-00-00Z.txt",
        ] {
            fs::write(path(precious), [0; 1000]).unwrap();
        }
        let current = path("slamlab-2026-01-03T00-00-00Z.mcap");
        let keep = |all_bytes| Keep {
            all_bytes,
            ..Keep::default()
        };
        let left = |all_bytes| {
            let mut files =
                Files::recordings(folder.path(), keep(all_bytes), Clock::start()).unwrap();
            files.make_room(&current);
            let mut names: Vec<_> = fs::read_dir(folder.path())
                .unwrap()
                .map(|entry| entry.unwrap().file_name().into_string().unwrap())
                .filter(|name| RECORDINGS.is_piece(name))
                .collect();
            names.sort();
            names
        };
        assert_eq!(left(500).len(), 5);
        assert_eq!(
            left(350),
            [
                "slamlab-2026-01-01T00-00-00Z-10.mcap",
                "slamlab-2026-01-02T00-00-00Z.mcap",
                "slamlab-2026-01-03T00-00-00Z.mcap"
            ]
        );
        assert_eq!(left(0), ["slamlab-2026-01-03T00-00-00Z.mcap"]);
        for precious in ["flat.mcap", "slamlab-flat.mcap", "notes"] {
            assert!(path(precious).exists(), "{precious}");
        }
    }

    #[test]
    fn a_file_that_was_named_is_the_only_one() {
        let folder = tempfile::TempDir::new().unwrap();
        let path = folder.path().join("flat.mcap");
        let mut files = Files::recordings(&path, Keep::default(), Clock::start()).unwrap();
        assert!(files.next().unwrap().is_none());
        let mut files = Files::recordings(folder.path(), Keep::default(), Clock::start()).unwrap();
        assert!(files.next().unwrap().is_some());
    }

    #[test]
    fn a_folder_is_one_bridges_alone_and_its_audits_are_another_matter() {
        let root = tempfile::TempDir::new().unwrap();
        let folder = root.path().join("drives/");
        let recordings = || Files::recordings(&folder, Keep::default(), Clock::start());
        let audits = || Files::audits(&folder, Keep::default(), Clock::start());
        let (first, _audit) = (recordings().unwrap(), audits().unwrap());
        for refused in [recordings(), audits()] {
            let error = refused.unwrap_err().to_string();
            let expected = format!("folder {}: another bridge writes there", folder.display());
            assert!(error.contains(&expected), "{error}");
        }
        drop(first);
        assert!(recordings().is_ok());
    }
}
