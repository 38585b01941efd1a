//! The map's file: read once at the start, then always replaced as a whole.

use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};

use slamlab_core::format::known_file::known_file;
use slamlab_core::format::slamlab::{self, Experiment};
use slamlab_core::wire::message::ZoneBody;

use super::{MapError, fence_file};
use crate::locked_file;
use crate::replaced_file::{Readers, check, replace, sync_folder};

/// Most maps moved aside under the same name with a number.
const MOST_ASIDE: u32 = 10_000;

/// Locks a map's file for one bridge, until the returned file is closed. The map itself is replaced
/// again and again, so the lock is on a separate file beside it that stays.
///
/// # Errors    [`MapError::Taken`], [`MapError::Io`].
pub(super) fn lock(path: &Path) -> Result<File, MapError> {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let beside = path.with_file_name(format!(".{name}.lock"));
    let io = |source| MapError::Io {
        path: beside.clone(),
        source,
    };
    let taken = || MapError::Taken {
        path: path.to_owned(),
    };
    locked_file::lock(&beside).map_err(io)?.ok_or_else(taken)
}

/// See the module.
#[derive(Clone, Debug)]
pub(super) struct MapFile {
    path: PathBuf,
}

impl MapFile {
    pub(super) fn new(path: PathBuf) -> Self {
        Self { path }
    }

    /// The file's name without the folder.
    pub(super) fn name(&self) -> String {
        let name = self.path.file_name().unwrap_or_default();
        name.to_string_lossy().into_owned()
    }

    /// The file's path.
    pub(super) fn path(&self) -> &Path {
        &self.path
    }

    /// Where its geofence is kept.
    pub(super) fn fence(&self) -> PathBuf {
        fence_file::beside(&self.path)
    }

    /// The map's title: the file's name without its extension.
    pub(super) fn title(&self) -> String {
        let stem = self.path.file_stem().unwrap_or_default();
        stem.to_string_lossy().into_owned()
    }

    /// The map in it; none if there is no file yet.
    ///
    /// # Errors    [`MapError::Io`], [`MapError::File`], [`MapError::Foreign`].
    pub(super) fn read(&self) -> Result<Option<Experiment>, MapError> {
        let bytes = match fs::read(&self.path) {
            Ok(bytes) => bytes,
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
            Err(error) => return Err(self.io(error)),
        };
        let path = || self.path.clone();
        if !slamlab::begins(&bytes)
            && let Some(found) = known_file(&bytes)
        {
            let (path, found) = (path(), found.to_string());
            return Err(MapError::Foreign { path, found });
        }
        let read = slamlab::read(&bytes);
        read.map(Some).map_err(|source| MapError::File {
            path: path(),
            source,
        })
    }

    /// Checks that a map could be written.
    ///
    /// # Errors    [`MapError::Io`].
    pub(super) fn check_folder(&self) -> Result<(), MapError> {
        check(&self.path).map_err(|error| self.io(error))
    }

    /// Replaces the file.
    ///
    /// # Errors    What the system said; then the previous map is still there.
    pub(super) fn write(&self, bytes: &[u8]) -> io::Result<()> {
        replace(&self.path, bytes, Readers::Anyone)
    }

    /// The geofence of its map.
    ///
    /// # Errors    [`MapError::Fence`].
    pub(super) fn read_fence(&self) -> Result<Vec<ZoneBody>, MapError> {
        fence_file::read(&self.path)
    }

    /// Keeps the geofence of its map.
    ///
    /// # Errors    What the system said; then the previous fence is kept.
    pub(super) fn write_fence(&self, zones: &[ZoneBody]) -> io::Result<()> {
        fence_file::write(&self.path, zones)
    }

    /// Renames the file to the first free name like `office.1.slamlab`, and returns it; none if
    /// there is no file. Its geofence goes with it: it means nothing in another map.
    pub(super) fn move_aside(&self) -> io::Result<Option<PathBuf>> {
        let fence = fence_file::beside(&self.path);
        if !self.path.exists() {
            return fence_file::write(&self.path, &[]).map(|()| None);
        }
        let stem = self.title();
        for number in 1..=MOST_ASIDE {
            let aside = self.path.with_file_name(format!("{stem}.{number}.slamlab"));
            if !aside.exists() {
                fs::rename(&self.path, &aside)?;
                match fs::rename(&fence, fence_file::beside(&aside)) {
                    Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(error),
                    _ => (),
                }
                return sync_folder(&self.path).map(|()| Some(aside));
            }
        }
        Err(io::Error::from(io::ErrorKind::AlreadyExists))
    }

    fn io(&self, source: io::Error) -> MapError {
        let path = self.path.clone();
        MapError::Io { path, source }
    }
}
