//! Files that are replaced as a whole: the name never refers to half a file, and a successful write
//! survives a power cut.

use std::fs::{self, File, OpenOptions};
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};

/// Who may read a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Readers {
    /// Permissions by the system's defaults.
    Anyone,
    /// Only its owner.
    Owner,
}

/// Writes a new file beside `path`, then gives it that name.
///
/// # Errors    What the system said; then the previous file is still there.
pub(crate) fn replace(path: &Path, bytes: &[u8], readers: Readers) -> io::Result<()> {
    let new = beside(path);
    let written = create(path, readers).and_then(|mut file| {
        file.write_all(bytes)?;
        file.sync_all()?;
        fs::rename(&new, path)
    });
    if written.is_err() {
        // Clean up if possible; only the first error counts.
        let _ = fs::remove_file(&new);
    }
    written.and_then(|()| sync_folder(path))
}

/// Checks that [`replace`] could write, so that an error shows at the start and not after an hour
/// of work.
///
/// # Errors    What the system said.
pub(crate) fn check(path: &Path) -> io::Result<()> {
    create(path, Readers::Anyone).and_then(|_| fs::remove_file(beside(path)))
}

fn create(path: &Path, readers: Readers) -> io::Result<File> {
    let new = beside(path);
    // Remove a file left by a program with the same process number that ended while it wrote: its
    // permissions may be different.
    match fs::remove_file(&new) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(error),
        _ => (),
    }
    let mut options = OpenOptions::new();
    options.write(true).create_new(true);
    #[cfg(unix)]
    if readers == Readers::Owner {
        std::os::unix::fs::OpenOptionsExt::mode(&mut options, 0o600);
    }
    #[cfg(not(unix))]
    let _ = readers;
    let file = options.open(&new)?;
    hand_over(&file, path)?;
    Ok(file)
}

fn beside(path: &Path) -> PathBuf {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    path.with_file_name(format!(".{name}.new-{}", std::process::id()))
}

/// Forces the folder to the disk: only then does a new name survive a power cut.
#[cfg(unix)]
pub(crate) fn sync_folder(path: &Path) -> io::Result<()> {
    let folder = folder_of(path).unwrap_or(Path::new("."));
    File::open(folder)?.sync_all()
}

/// On other systems folders cannot be opened as files.
#[cfg(not(unix))]
pub(crate) fn sync_folder(_: &Path) -> io::Result<()> {
    Ok(())
}

/// Gives a file that root writes into a service's folder to the service, which could not read it
/// otherwise.
#[cfg(unix)]
pub(crate) fn hand_over(file: &File, path: &Path) -> io::Result<()> {
    use std::os::unix::fs::MetadataExt;
    let Some(folder) = folder_of(path) else {
        return Ok(());
    };
    let (own, folder) = (file.metadata()?, fs::metadata(folder)?);
    match own.uid() == 0 && folder.uid() != 0 {
        true => std::os::unix::fs::fchown(file, Some(folder.uid()), Some(folder.gid())),
        false => Ok(()),
    }
}

#[cfg(not(unix))]
pub(crate) fn hand_over(_: &File, _: &Path) -> io::Result<()> {
    Ok(())
}

#[cfg(unix)]
fn folder_of(path: &Path) -> Option<&Path> {
    let folder = path.parent();
    folder.filter(|folder| !folder.as_os_str().is_empty())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_replaced_and_nothing_is_left_beside_it() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("office.slamlab");
        check(&path).unwrap();
        assert!(!path.exists());
        fs::write(beside(&path), "half a m").unwrap();
        for text in ["one", "another"] {
            replace(&path, text.as_bytes(), Readers::Anyone).unwrap();
            assert_eq!(fs::read_to_string(&path).unwrap(), text);
            assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
        }
    }

    #[test]
    fn what_cannot_be_written_leaves_what_stands_there() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("office.slamlab");
        // A folder of that name is in the way of the file.
        fs::create_dir(&path).unwrap();
        fs::write(path.join("kept"), "as it was").unwrap();
        assert!(replace(&path, b"map", Readers::Anyone).is_err());
        assert_eq!(fs::read_to_string(path.join("kept")).unwrap(), "as it was");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
        let nowhere = folder.path().join("none").join("office.slamlab");
        assert!(check(&nowhere).is_err());
    }

    #[cfg(unix)]
    #[test]
    fn a_secret_is_read_by_its_owner_only_whatever_lay_beside_it() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("token");
        fs::write(beside(&path), "").unwrap();
        fs::set_permissions(beside(&path), fs::Permissions::from_mode(0o644)).unwrap();
        replace(&path, b"secret", Readers::Owner).unwrap();
        let mode = fs::metadata(&path).unwrap().permissions().mode() & 0o777;
        assert_eq!(mode, 0o600);
    }

    /// Names the file for a process of this same program, which writes it until it is killed.
    const WRITER: &str = "SLAMLAB_TEST_WRITES";

    /// SIGKILL at forty moments of a save: the file is one of the two versions, and complete.
    #[test]
    fn a_writer_that_is_killed_in_the_midst_leaves_the_file_before() {
        let contents = [b"a", b"b"].map(|letter| letter.repeat(3 << 20));
        if let Some(path) = std::env::var_os(WRITER) {
            for content in contents.iter().cycle() {
                replace(Path::new(&path), content, Readers::Anyone).unwrap();
            }
        }
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("office.slamlab");
        replace(&path, &contents[0], Readers::Anyone).unwrap();
        let mut cut_off = 0;
        for moment in 0..40 {
            let name =
                "replaced_file::tests::a_writer_that_is_killed_in_the_midst_leaves_the_file_before";
            let mut writer = std::process::Command::new(std::env::current_exe().unwrap())
                .args([name, "--exact", "--nocapture"])
                .env(WRITER, &path)
                .stdout(std::process::Stdio::null())
                .stderr(std::process::Stdio::null())
                .spawn()
                .unwrap();
            std::thread::sleep(std::time::Duration::from_millis(20 + 3 * moment));
            assert!(writer.try_wait().unwrap().is_none(), "it ended by itself");
            writer.kill().unwrap();
            writer.wait().unwrap();
            let found = fs::read(&path).unwrap();
            assert!(contents.contains(&found), "{} bytes", found.len());
            // The unfinished file has another name.
            cut_off += u32::from(fs::read_dir(folder.path()).unwrap().count() > 1);
            for beside in fs::read_dir(folder.path()).unwrap() {
                let beside = beside.unwrap().path();
                if beside != path {
                    fs::remove_file(beside).unwrap();
                }
            }
        }
        assert!(cut_off > 0, "it was never in the midst of it");
    }
}
