//! The file that the map is kept in: read once at the start, and replaced as a whole.

use std::fs::{self, File, OpenOptions};
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};

use slamlab_core::format::known_file::known_file;
use slamlab_core::format::slamlab::{self, Experiment};

use super::MapError;

/// Maps that were moved aside and may have the same name but for a number.
const MOST_ASIDE: u32 = 10_000;

/// See the module.
#[derive(Clone, Debug)]
pub(super) struct MapFile {
    path: PathBuf,
}

impl MapFile {
    pub(super) fn new(path: PathBuf) -> Self {
        Self { path }
    }

    /// Its name without the folder.
    pub(super) fn name(&self) -> String {
        let name = self.path.file_name().unwrap_or_default();
        name.to_string_lossy().into_owned()
    }

    /// What people call its map.
    pub(super) fn title(&self) -> String {
        let stem = self.path.file_stem().unwrap_or_default();
        stem.to_string_lossy().into_owned()
    }

    /// The map in it; none where there is no such file yet.
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

    /// Whether a map could be written: said at the start, and not after an hour of mapping.
    ///
    /// # Errors    [`MapError::Io`].
    pub(super) fn check_folder(&self) -> Result<(), MapError> {
        let beside = self.beside();
        create(&beside)
            .and_then(|_| fs::remove_file(&beside))
            .map_err(|error| self.io(error))
    }

    /// Replaces the file: at no time half a map has its name.
    ///
    /// # Errors    What the system said; then the map before stands there.
    pub(super) fn write(&self, bytes: &[u8]) -> io::Result<()> {
        let beside = self.beside();
        let written = create(&beside).and_then(|mut file| {
            file.write_all(bytes)?;
            file.sync_all()?;
            fs::rename(&beside, &self.path)
        });
        if written.is_err() {
            // What remains of it may be removed or not; the error counts.
            let _ = fs::remove_file(&beside);
        }
        written.and_then(|()| sync_folder(&self.path))
    }

    /// Gives the file another name, `office.1.slamlab`, that nothing has yet; says which. None
    /// where there is no file.
    pub(super) fn move_aside(&self) -> io::Result<Option<PathBuf>> {
        if !self.path.exists() {
            return Ok(None);
        }
        let stem = self.title();
        for number in 1..=MOST_ASIDE {
            let aside = self.path.with_file_name(format!("{stem}.{number}.slamlab"));
            if !aside.exists() {
                fs::rename(&self.path, &aside)?;
                return sync_folder(&self.path).map(|()| Some(aside));
            }
        }
        Err(io::Error::from(io::ErrorKind::AlreadyExists))
    }

    fn beside(&self) -> PathBuf {
        let name = format!(".{}.new-{}", self.name(), std::process::id());
        self.path.with_file_name(name)
    }

    fn io(&self, source: io::Error) -> MapError {
        let path = self.path.clone();
        MapError::Io { path, source }
    }
}

/// One that was left by a program that ended while it wrote is written over.
fn create(path: &Path) -> io::Result<File> {
    OpenOptions::new()
        .write(true)
        .create(true)
        .truncate(true)
        .open(path)
}

/// A new name survives a power cut only once its folder is on the disk.
#[cfg(unix)]
fn sync_folder(path: &Path) -> io::Result<()> {
    let folder = path
        .parent()
        .filter(|folder| !folder.as_os_str().is_empty());
    File::open(folder.unwrap_or(Path::new(".")))?.sync_all()
}

/// Elsewhere folders cannot be opened as files.
#[cfg(not(unix))]
fn sync_folder(_: &Path) -> io::Result<()> {
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_map_replaces_the_one_before_and_leaves_nothing_beside_it() {
        let folder = tempfile::tempdir().unwrap();
        let file = MapFile::new(folder.path().join("flat.slamlab"));
        file.check_folder().unwrap();
        for text in ["first", "second"] {
            file.write(text.as_bytes()).unwrap();
        }
        let names: Vec<_> = (fs::read_dir(folder.path()).unwrap())
            .map(|entry| entry.unwrap().file_name())
            .collect();
        assert_eq!(names, ["flat.slamlab"]);
        assert_eq!(fs::read(&file.path).unwrap(), b"second");
    }

    #[test]
    fn maps_that_are_moved_aside_never_replace_one_another() {
        let folder = tempfile::tempdir().unwrap();
        let file = MapFile::new(folder.path().join("flat.slamlab"));
        assert_eq!(file.move_aside().unwrap(), None);
        for number in 1..4 {
            file.write(&[number]).unwrap();
            let aside = file.move_aside().unwrap().unwrap();
            assert!(aside.ends_with(format!("flat.{number}.slamlab")));
            assert_eq!(fs::read(aside).unwrap(), [number]);
        }
    }

    #[test]
    fn what_is_no_map_is_called_by_its_name_and_left_alone() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("flat.slamlab");
        let file = MapFile::new(path.clone());
        let good = slamlab::write(&Experiment::default()).unwrap();
        let mut damaged = good.clone();
        let middle = damaged.len() - 6;
        damaged[middle] ^= 1;
        let mut newer = good.clone();
        newer[8] = 200;
        for (bytes, expect) in [
            (&b""[..], "no .slamlab file"),
            (b"hello", "no .slamlab file"),
            (b"%PDF-1.7\n", "a PDF document"),
            (b"P5\n2 2\n255\n1234", "no .slamlab file"),
            (&good[..30], "cut off"),
            (&damaged, "damaged"),
            (&newer, "version 200"),
        ] {
            fs::write(&path, bytes).unwrap();
            let error = file.read().unwrap_err().to_string();
            assert!(error.contains(expect), "{error}");
            assert!(error.contains("flat.slamlab"), "{error}");
            assert!(error.ends_with("left as it is"), "{error}");
            assert_eq!(fs::read(&path).unwrap(), bytes);
        }
        fs::write(&path, good).unwrap();
        assert!(file.read().unwrap().is_some());
    }
}
