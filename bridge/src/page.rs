//! Which page is served: the one inside the program, or a folder.

use std::path::PathBuf;

use crate::embedded;
use crate::serve::RunError;

/// Where a program without a page in it looks for one: the repository's root is where one works on the page.
const WORKSHOP: &str = "www/dist";

/// Where the page comes from.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Page {
    /// It is read from a folder at each request: a rebuilt page needs a reload and not a restart.
    Folder(PathBuf),
    /// It was put into the program when that was built (`cargo xtask package`).
    Embedded,
}

impl Page {
    /// The folder that somebody named; else the page inside the program; else `www/dist`.
    #[must_use]
    pub fn choose(folder: Option<PathBuf>) -> Self {
        match folder {
            Some(folder) => Self::Folder(folder),
            None if embedded::is_there() => Self::Embedded,
            None => Self::Folder(WORKSHOP.into()),
        }
    }

    /// Whether there is a page.
    ///
    /// # Errors
    /// [`RunError::NoPage`] where there is no `index.html`.
    pub fn check(&self) -> Result<(), RunError> {
        match self {
            Self::Embedded if embedded::is_there() => Ok(()),
            Self::Folder(folder) if folder.join("index.html").is_file() => Ok(()),
            Self::Embedded => Err(RunError::NoPage {
                place: "this program".into(),
            }),
            Self::Folder(folder) => Err(RunError::NoPage {
                place: folder.display().to_string(),
            }),
        }
    }
}
