//! Which page is served: the one inside the program, or a folder.

use std::path::PathBuf;

use crate::embedded;

/// The folder that a program without a page serves, relative to the repository's root.
const WORKSHOP: &str = "www/dist";

/// There is no page.
#[derive(Debug, thiserror::Error)]
#[error(
    "there is no page in {place}: index.html is missing; build it with `cargo xtask build`, or name its folder with --page DIR; \
     `cargo xtask package` makes a program with the page in it"
)]
pub struct PageError {
    /// Where it was searched.
    place: String,
}

/// Where the page comes from.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Page {
    /// Read from a folder at each request: a rebuilt page needs a reload, not a restart.
    Folder(PathBuf),
    /// Built into the program (`cargo xtask package`).
    Embedded,
}

impl Page {
    /// The given folder; else the page inside the program; else `www/dist`.
    #[must_use]
    pub fn choose(folder: Option<PathBuf>) -> Self {
        match folder {
            Some(folder) => Self::Folder(folder),
            None if embedded::is_there() => Self::Embedded,
            None => Self::Folder(WORKSHOP.into()),
        }
    }

    /// Checks that there is a page.
    ///
    /// # Errors    [`PageError`] if there is no `index.html`.
    pub fn check(&self) -> Result<(), PageError> {
        match self {
            Self::Embedded if embedded::is_there() => Ok(()),
            Self::Folder(folder) if folder.join("index.html").is_file() => Ok(()),
            Self::Embedded => Err(PageError {
                place: "this program".into(),
            }),
            Self::Folder(folder) => Err(PageError {
                place: folder.display().to_string(),
            }),
        }
    }
}
