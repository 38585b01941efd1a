//! Finished pieces of the recording, kept in object storage too: S3 and what speaks like it, Azure,
//! Google Cloud, or another folder.
//!
//! ```text
//!   folder of the recording ── finished pieces ──> uploader (a task) ── parts ──> bucket
//!                                └─ ledger beside each: what is there already
//! ```
//!
//! 1. A piece is finished when another one is written. The uploader takes the oldest that is not
//!    stored yet, part after part; after each the ledger beside the piece says so, on the disk
//!    (`ledger`). A cut network, or the end of the program, costs the part under way. Its name
//!    there ends in what tells it from those of other robots, which may have the same store.
//! 2. When all parts are there the object is read back and compared by SHA-256 (`upload`). Then,
//!    and not before, the piece counts as stored.
//! 3. What goes wrong is said once to everybody, with what and where, and tried again after a
//!    while that grows. Recording and robot never wait for it.
//! 4. Pieces here and there are listed and handed out over HTTP (`serve`), and the store is asked
//!    no more of that than it should be (`listing`, `fetches`).
//!
//! The recording's budget is what counts: a piece that goes before it was stored is gone, which is
//! said. Only compiled with the feature `storage`: what speaks HTTP and its signatures is as large
//! as the rest of the bridge.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

#[cfg(feature = "storage")]
mod bucket;
#[cfg(feature = "storage")]
mod fetches;
#[cfg(feature = "storage")]
mod ledger;
#[cfg(feature = "storage")]
mod listing;
#[cfg(feature = "storage")]
mod serve;
#[cfg(feature = "storage")]
mod upload;
#[cfg(feature = "storage")]
mod uploader;

#[cfg(feature = "storage")]
pub(crate) use serve::routes;
#[cfg(feature = "storage")]
pub(crate) use uploader::{Ready, Uploads, ready};

/// Where finished recordings are kept too.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StorageConfig {
    /// `s3://bucket/folder`, `az://container/folder`, `gs://bucket/folder`, `file:///folder`.
    pub url: String,
    /// Of the store, by the names that `object_store` has for them: `aws_endpoint`. Keys and
    /// secrets are better in the environment (`AWS_SECRET_ACCESS_KEY`), where settings do not show
    /// them.
    pub options: BTreeMap<String, String>,
    /// MiB of a part: what is lost when the link breaks. Default 8.
    pub part_mib: u64,
    /// Whether each object is read back and compared. Default true.
    pub verify: bool,
}

/// Least and greatest MiB of a part: S3 takes no less than 5, and no more than 10 000 parts.
pub const PART_MIB: (u64, u64) = (5, 512);

impl StorageConfig {
    /// With the defaults.
    #[must_use]
    pub fn new(url: String) -> Self {
        Self {
            url,
            options: BTreeMap::new(),
            part_mib: 8,
            verify: true,
        }
    }

    /// Looks at what it says; nothing is asked of a store, and nothing written.
    ///
    /// # Errors    [`StorageError`].
    pub(crate) fn check(&self, record: Option<&Path>) -> Result<(), StorageError> {
        let url = || self.url.clone();
        if let Some(what) = secret_in(&self.url) {
            return Err(StorageError::Secret { what });
        }
        if self.url.is_empty() {
            let (url, why) = (url(), "it is empty".to_owned());
            return Err(StorageError::Url { url, why });
        }
        #[cfg(feature = "storage")]
        if bucket::Bucket::open(self)?.meets(record) {
            let (url, record) = (url(), record.unwrap_or(Path::new("")).to_owned());
            return Err(StorageError::SameFolder { url, record });
        }
        #[cfg(not(feature = "storage"))]
        let _ = record;
        Ok(())
    }
}

/// What of a URL nobody should see. The name before the `@` of Azure's is that of a container.
fn secret_in(url: &str) -> Option<&'static str> {
    let (scheme, rest) = url.split_once(':')?;
    if rest.contains('?') {
        return Some("a query (what stands behind the ?)");
    }
    let host = rest.trim_start_matches('/').split('/').next()?;
    let (user, _) = host.rsplit_once('@').filter(|_| scheme != "file")?;
    let is_container = ["az", "azure", "adl", "abfs", "abfss"].contains(&scheme);
    (!is_container || user.contains(':')).then_some("a user or a password")
}

/// Why recordings cannot be stored at all.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum StorageError {
    /// The program cannot.
    #[error(
        "storage url {url:?}: this program was built without object storage; build it with `--features storage`, or leave the setting out"
    )]
    NotBuilt {
        /// What was asked for.
        url: String,
    },
    /// There is nothing to store.
    #[error(
        "storage url {url:?}: recordings go into no folder; set `record` to one (a path that ends in /)"
    )]
    NoFolder {
        /// What was asked for.
        url: String,
    },
    /// It names no store.
    #[error("storage url {url:?}: {why}; expected s3://, az://, gs:// or file:/// and a name")]
    Url {
        /// What was asked for.
        url: String,
        /// What is wrong with it.
        why: String,
    },
    /// Whoever watches would see it; so it is not said here either.
    #[error(
        "storage url holds {what}, and whoever watches would see it: keys and secrets belong into the environment \
         (AWS_SECRET_ACCESS_KEY), or into [storage.options]"
    )]
    Secret {
        /// What.
        what: &'static str,
    },
    /// The budget would delete what is stored.
    #[error(
        "storage url {url:?}: recordings are made in {}, one in the other, and the budget there would delete what is stored, \
         or store it again; name a folder elsewhere", record.display()
    )]
    SameFolder {
        /// What was asked for.
        url: String,
        /// The folder of the recording.
        record: PathBuf,
    },
    /// An option that the store does not have.
    #[error("storage {url:?}: options {key}: {why}")]
    Option {
        /// What was asked for.
        url: String,
        /// Its name.
        key: String,
        /// What is wrong with it.
        why: String,
    },
    /// The options do not go together.
    #[error("storage url {url:?}: {why}")]
    Store {
        /// What was asked for.
        url: String,
        /// What is wrong with them.
        why: String,
    },
}
