//! Files that only their owner may read: the token, and the key of the certificate.

use std::fs::{self, OpenOptions};
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};

/// Why such a file cannot be used.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SecretFileError {
    /// The system said no.
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

/// Reads a file that nobody else can read.
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

/// Writes a new file beside it, then renames it: at no time half a secret, or a readable one, has
/// the name.
pub(crate) fn write(path: &Path, text: &str) -> Result<(), SecretFileError> {
    let beside = path.with_extension(format!("new-{}", std::process::id()));
    let mut options = OpenOptions::new();
    options.write(true).create_new(true);
    #[cfg(unix)]
    std::os::unix::fs::OpenOptionsExt::mode(&mut options, 0o600);
    let made = path.parent().map_or(Ok(()), fs::create_dir_all);
    made.and_then(|()| options.open(&beside))
        .and_then(|mut file| {
            let written = hand_over(&file, path)
                .and_then(|()| writeln!(file, "{text}"))
                .and_then(|()| file.sync_all());
            written
                .and_then(|()| fs::rename(&beside, path))
                .inspect_err(|_| {
                    // What remains of it may be removed or not; the error counts.
                    let _ = fs::remove_file(&beside);
                })
        })
        .map_err(|source| SecretFileError::of(path, source))
}

/// What root writes into the folder of a service is the service's: it could not read it otherwise.
#[cfg(unix)]
pub(crate) fn hand_over(file: &fs::File, path: &Path) -> io::Result<()> {
    use std::os::unix::fs::MetadataExt;
    let Some(folder) = path
        .parent()
        .filter(|folder| !folder.as_os_str().is_empty())
    else {
        return Ok(());
    };
    let (own, folder) = (file.metadata()?, fs::metadata(folder)?);
    match own.uid() == 0 && folder.uid() != 0 {
        true => std::os::unix::fs::fchown(file, Some(folder.uid()), Some(folder.gid())),
        false => Ok(()),
    }
}

#[cfg(not(unix))]
pub(crate) fn hand_over(_: &fs::File, _: &Path) -> io::Result<()> {
    Ok(())
}

/// The file's permissions, if they let anybody but its owner in.
#[cfg(unix)]
fn mode_for_others(path: &Path) -> io::Result<Option<u32>> {
    use std::os::unix::fs::PermissionsExt;
    let mode = fs::metadata(path)?.permissions().mode() & 0o777;
    Ok((mode & 0o077 != 0).then_some(mode))
}

/// Elsewhere files in a user's folder are private by the folder's own rules.
#[cfg(not(unix))]
fn mode_for_others(path: &Path) -> io::Result<Option<u32>> {
    fs::metadata(path).map(|_| None)
}
