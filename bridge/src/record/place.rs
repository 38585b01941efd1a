//! Where a recording goes: the named file, or a new file in the named folder.
//!
//! A service starts again and again with the same settings, and a recording is never overwritten:
//! so a folder takes the recording of each start, named by the time of day in UTC.

use std::fs::{File, OpenOptions, create_dir_all};
use std::io;
use std::path::{MAIN_SEPARATOR, Path, PathBuf};
use std::time::Duration;

use super::RecordError;
use crate::locked_file;

/// How files in a folder are named: `FIRST-TIME.EXTENSION`, with a number after the time if several
/// begin in the same second.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Naming {
    first: &'static str,
    lock: &'static str,
    extension: &'static str,
}

/// Recordings.
pub(super) const RECORDINGS: Naming = Naming {
    first: "slamlab-",
    lock: ".slamlab-recordings.lock",
    extension: ".mcap",
};

/// Audits.
pub(super) const AUDITS: Naming = Naming {
    first: "slamlab-audit-",
    lock: ".slamlab-audits.lock",
    extension: ".jsonl",
};

/// Most recordings of the same second, told apart by a number: a computer without a battery-backed
/// clock starts at the same time of day each time.
const MOST_OF_A_SECOND: u32 = 10_000;

/// Digits of the SHA-256 in a name, enough to tell recordings of the same second apart.
#[cfg(feature = "storage")]
const DIGITS: usize = 16;

/// Opens the new file of a recording that starts at `time_of_day`, since 1970, and returns its path
/// too.
///
/// If the path ends in a separator, or is a folder, the new file is made in it; a missing folder is
/// created.
pub(super) fn create(path: &Path, time_of_day: Duration) -> Result<(File, PathBuf), RecordError> {
    if !is_folder(path) {
        return create_file(path.to_owned());
    }
    RECORDINGS.create(path, time_of_day)
}

/// Checks that a recording could begin there.
///
/// # Errors    [`RecordError::Exists`].
pub(super) fn check(path: &Path) -> Result<(), RecordError> {
    match !is_folder(path) && path.exists() {
        true => Err(RecordError::Exists {
            path: path.to_owned(),
        }),
        false => Ok(()),
    }
}

impl Naming {
    /// Locks a folder for one writer, until the returned file is closed; creates the folder if it
    /// is missing. The lock is needed because a writer deletes the oldest files, and knows of no
    /// current file but its own.
    ///
    /// # Errors    [`RecordError::Taken`], [`RecordError::Io`].
    pub(super) fn lock(self, folder: &Path) -> Result<File, RecordError> {
        make(folder)?;
        let path = folder.join(self.lock);
        let taken = || RecordError::Taken {
            folder: folder.to_owned(),
        };
        let locked = locked_file::lock(&path);
        let locked = locked.map_err(|source| RecordError::Io { path, source })?;
        locked.ok_or_else(taken)
    }

    /// Opens a new file in a folder, and returns its path too; creates the folder if it is missing.
    pub(super) fn create(
        self,
        folder: &Path,
        time_of_day: Duration,
    ) -> Result<(File, PathBuf), RecordError> {
        make(folder)?;
        let stem = self.stem(time_of_day);
        // Always a number above the existing ones: files are deleted by age, and the oldest may be
        // deleted within the same second.
        let first = self.highest(folder, &stem) + 1;
        let mut taken = create_file(folder.join(self.name(&stem, first)));
        for number in first + 1..=MOST_OF_A_SECOND {
            if !matches!(taken, Err(RecordError::Exists { .. })) {
                break;
            }
            taken = create_file(folder.join(self.name(&stem, number)));
        }
        taken
    }
}

fn make(folder: &Path) -> Result<(), RecordError> {
    create_dir_all(folder).map_err(|source| RecordError::Io {
        path: folder.to_owned(),
        source,
    })
}

/// Whether the path is a folder, in which each recording gets its own file.
pub(crate) fn is_folder(path: &Path) -> bool {
    path.is_dir() || path.to_string_lossy().ends_with(['/', MAIN_SEPARATOR])
}

impl Naming {
    /// `slamlab-2026-11-21T09-05-07Z`: sorting by name sorts by time, and every file system accepts
    /// it.
    fn stem(self, time_of_day: Duration) -> String {
        let t = time::OffsetDateTime::UNIX_EPOCH + time_of_day;
        let (year, month, day) = t.to_calendar_date();
        let (hour, minute, second) = t.to_hms();
        format!(
            "{}{year}-{:02}-{day:02}T{hour:02}-{minute:02}-{second:02}Z",
            self.first,
            u8::from(month)
        )
    }

    fn name(self, stem: &str, number: u32) -> String {
        match number {
            1 => format!("{stem}{}", self.extension),
            _ => format!("{stem}-{number}{}", self.extension),
        }
    }

    /// Highest number of the files of this second; 0 if there are none, or the folder cannot be
    /// read.
    fn highest(self, folder: &Path, stem: &str) -> u32 {
        let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
        let number = |entry: std::fs::DirEntry| {
            let name = entry.file_name();
            let name = name.to_str().filter(|name| name.starts_with(stem))?;
            self.parts(name).map(|(_, number)| number)
        };
        entries.filter_map(number).max().unwrap_or(0)
    }

    /// Whether a file has the name of a piece.
    pub(super) fn is_piece(self, name: &str) -> bool {
        self.parts(name).is_some()
    }

    /// The key that sorts pieces by age: the second in which they began, and their number in it.
    pub(super) fn age_of(self, path: &Path) -> Option<(String, u32)> {
        let (stem, number) = self.parts(path.file_name()?.to_str()?)?;
        Some((stem.to_owned(), number))
    }

    /// The file's name in a place shared with other writers: its SHA-256 tells it apart from their
    /// files, which may be of the same second. None if it does not have the name of a piece.
    #[cfg(feature = "storage")]
    pub(super) fn among_others(self, name: &str, sha_256: &str) -> Option<String> {
        self.parts(name)?;
        let stem = name.strip_suffix(self.extension)?;
        Some(format!(
            "{stem}-{}{}",
            sha_256.get(..DIGITS)?,
            self.extension
        ))
    }

    /// Whether a file has the name of a piece, in a shared place or in a folder.
    #[cfg(feature = "storage")]
    pub(super) fn is_piece_among_others(self, name: &str) -> bool {
        let parts = name.strip_suffix(self.extension).and_then(|stem| {
            let (stem, digits) = stem.rsplit_once('-')?;
            let is_sum = digits.len() == DIGITS && digits.bytes().all(|b| b.is_ascii_hexdigit());
            is_sum.then(|| format!("{stem}{}", self.extension))
        });
        self.is_piece(parts.as_deref().unwrap_or(name))
    }

    fn parts(self, name: &str) -> Option<(&str, u32)> {
        let rest = (name.strip_prefix(self.first)?).strip_suffix(self.extension)?;
        let (stem, number) = rest.split_once('Z')?;
        let is_time = stem.len() == "2026-11-21T09-05-07".len()
            && stem
                .bytes()
                .all(|b| b.is_ascii_digit() || b == b'-' || b == b'T');
        let number = match number {
            "" => 1,
            number => number.strip_prefix('-')?.parse().ok()?,
        };
        is_time.then_some((stem, number))
    }
}

/// Opens a new file.
pub(super) fn create_file(path: PathBuf) -> Result<(File, PathBuf), RecordError> {
    match OpenOptions::new().write(true).create_new(true).open(&path) {
        Ok(file) => Ok((file, path)),
        Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {
            Err(RecordError::Exists { path })
        }
        Err(source) => Err(RecordError::Io { path, source }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let mut names: Vec<String> = std::fs::read_dir(folder)
            .unwrap()
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    }

    #[test]
    fn a_folder_takes_every_start() {
        let root = tempfile::TempDir::new().unwrap();
        let folder = root.path().join("drives/");
        // 2004-02-29 12:34:56 UTC, by `date -u -d @1078058096`.
        let leap_day = Duration::new(1_078_058_096, 900_000_000);
        for _ in 0..3 {
            create(&folder, leap_day).unwrap();
        }
        create(&folder, Duration::ZERO).unwrap();
        assert_eq!(
            names(&folder),
            [
                "slamlab-1970-01-01T00-00-00Z.mcap",
                "slamlab-2004-02-29T12-34-56Z-2.mcap",
                "slamlab-2004-02-29T12-34-56Z-3.mcap",
                "slamlab-2004-02-29T12-34-56Z.mcap",
            ]
        );
    }

    #[test]
    fn a_number_that_is_free_again_is_not_given_to_a_newer_file() {
        let root = tempfile::TempDir::new().unwrap();
        let path = || create(root.path(), Duration::ZERO).unwrap().1;
        let (first, second, third) = (path(), path(), path());
        std::fs::remove_file(first).unwrap();
        std::fs::remove_file(second).unwrap();
        let fourth = path();
        assert!(RECORDINGS.age_of(&fourth) > RECORDINGS.age_of(&third));
    }

    #[cfg(feature = "storage")]
    #[test]
    fn recordings_of_one_second_have_names_of_their_own_among_others() {
        let (one, other) = ("0123456789abcdef01", "f123456789abcdef01");
        for name in [
            "slamlab-2026-01-01T00-00-00Z.mcap",
            "slamlab-2026-01-01T00-00-00Z-2.mcap",
        ] {
            let called = |sum| RECORDINGS.among_others(name, sum).unwrap();
            assert_ne!(called(one), called(other));
            for called in [&called(one), &called(other), name] {
                assert!(RECORDINGS.is_piece_among_others(called), "{called}");
            }
            // In a folder only files that were named there are ever deleted.
            assert!(!RECORDINGS.is_piece(&called(other)));
        }
        assert_eq!(
            RECORDINGS.among_others("slamlab-2026-01-01T00-00-00Z-2.mcap", one),
            Some("slamlab-2026-01-01T00-00-00Z-2-0123456789abcdef.mcap".into())
        );
        assert_eq!(RECORDINGS.among_others("flat.mcap", one), None);
        for other in [
            "flat-0123456789abcdef.mcap",
            "slamlab-2026-01-01T00-00-00Z-0123456789abcdeg.mcap",
            "slamlab-2026-01-01T00-00-00Z-é123456789abcde.mcap",
            "-0123456789abcdef.mcap",
        ] {
            assert!(!RECORDINGS.is_piece_among_others(other), "{other}");
        }
    }

    #[test]
    fn a_file_is_where_a_folder_was_meant() {
        let root = tempfile::TempDir::new().unwrap();
        std::fs::write(root.path().join("drives"), "precious").unwrap();
        let meant = root.path().join("drives/");
        let error = create(&meant, Duration::ZERO).unwrap_err();
        assert!(error.to_string().contains("drives"), "{error}");
        assert_eq!(
            std::fs::read(root.path().join("drives")).unwrap(),
            b"precious"
        );
    }
}
