//! Files that only their owner may read: the token, and the key of the certificate.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use crate::replaced_file::{Readers, replace};

/// Why such a file cannot be used.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SecretFileError {
    /// The system reported an error.
    #[error("{}: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What it said.
        source: io::Error,
    },
    /// Others can read it.
    #[error("{} can be read by others (mode {mode:03o}); `chmod 600` it", path.display())]
    Open {
        /// The file.
        path: PathBuf,
        /// Its permissions.
        mode: u32,
    },
}

impl SecretFileError {
    pub(crate) fn of(path: &Path, source: io::Error) -> Self {
        let path = path.to_owned();
        Self::Io { path, source }
    }

    /// Whether there is no such file.
    pub(crate) fn is_not_found(&self) -> bool {
        matches!(self, Self::Io { source, .. } if source.kind() == io::ErrorKind::NotFound)
    }
}

/// Reads a file, which nobody else may be able to read.
pub(crate) fn read(path: &Path) -> Result<String, SecretFileError> {
    let text = fs::read_to_string(path).and_then(|text| Ok((text, mode_for_others(path)?)));
    match text.map_err(|source| SecretFileError::of(path, source))? {
        (text, None) => Ok(text),
        (_, Some(mode)) => Err(SecretFileError::Open {
            path: path.to_owned(),
            mode,
        }),
    }
}

/// Replaces it, and creates its folder if needed.
pub(crate) fn write(path: &Path, text: &str) -> Result<(), SecretFileError> {
    let made = path.parent().map_or(Ok(()), fs::create_dir_all);
    made.and_then(|()| replace(path, format!("{text}\n").as_bytes(), Readers::Owner))
        .map_err(|source| SecretFileError::of(path, source))
}

/// The file's permissions, if they give access to anybody but its owner.
#[cfg(unix)]
fn mode_for_others(path: &Path) -> io::Result<Option<u32>> {
    use std::os::unix::fs::PermissionsExt;
    let mode = fs::metadata(path)?.permissions().mode() & 0o777;
    Ok((mode & 0o077 != 0).then_some(mode))
}

/// On other systems the rules of a user's folder keep its files private.
#[cfg(not(unix))]
fn mode_for_others(path: &Path) -> io::Result<Option<u32>> {
    fs::metadata(path).map(|_| None)
}
