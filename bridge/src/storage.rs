//! Copies finished pieces of the recording to object storage: S3 and compatible stores, Azure,
//! Google Cloud, or another folder.
//!
//! ```text
//!   folder of the recording ── finished pieces ──> uploader (a task) ── parts ──> bucket
//!                                └─ ledger beside each: what is there already
//! ```
//!
//! 1. A piece is finished once the next one is being written. The uploader takes the oldest piece
//!    that is not stored yet, part by part; after each part it updates the ledger beside the piece,
//!    on the disk (`ledger`). So a network failure, or the end of the program, costs only the
//!    current part. The piece's name in the store ends in its hash, because other robots may use
//!    the same store.
//! 2. Once all parts are stored, the object is read back and compared by SHA-256 (`upload`). Only
//!    then does the piece count as stored.
//! 3. A fault is reported once to all clients, with what and where, and retried after growing
//!    pauses. Recording and robot never wait for it.
//! 4. Pieces in the folder and in the store are listed and served over HTTP (`serve`), with limits
//!    on requests to the store (`listing`, `fetches`).
//!
//! The recording's budget has priority: a piece deleted before it was stored is lost, which is
//! reported. Only compiled with the feature `storage`, because the code for HTTP and its signatures
//! is as large as the rest of the bridge.

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

/// The object storage for finished recordings.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StorageConfig {
    /// `s3://bucket/folder`, `az://container/folder`, `gs://bucket/folder`, `file:///folder`.
    pub url: String,
    /// Options of the store, by their names in `object_store`: `aws_endpoint`. Keys and secrets are
    /// better in the environment (`AWS_SECRET_ACCESS_KEY`), where settings do not show them.
    pub options: BTreeMap<String, String>,
    /// Size of a part, MiB: a broken link loses at most this. Default 8.
    pub part_mib: u64,
    /// Whether each object is read back and compared. Default true.
    pub verify: bool,
}

/// Least and greatest size of a part, MiB: S3 takes no less than 5, and no more than 10 000 parts.
pub const PART_MIB: (u64, u64) = (5, 512);

impl StorageConfig {
    /// This store, with the defaults.
    #[must_use]
    pub fn new(url: String) -> Self {
        Self {
            url,
            options: BTreeMap::new(),
            part_mib: 8,
            verify: true,
        }
    }

    /// Checks the settings; nothing is asked of a store, and nothing written.
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

/// The secret in a URL, if it has one. In Azure's URLs the name before the `@` is a container's.
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
    /// The program was built without object storage.
    #[error(
        "storage url {url:?}: this program was built without object storage; build it with `--features storage`, or leave the setting out"
    )]
    NotBuilt {
        /// What was asked for.
        url: String,
    },
    /// There is nothing to store: recordings go into no folder.
    #[error(
        "storage url {url:?}: recordings go into no folder; set `record` to one (a path that ends in /)"
    )]
    NoFolder {
        /// What was asked for.
        url: String,
    },
    /// The URL names no store.
    #[error("storage url {url:?}: {why}; expected s3://, az://, gs:// or file:/// and a name")]
    Url {
        /// What was asked for.
        url: String,
        /// What is wrong with it.
        why: String,
    },
    /// The URL holds a secret, which watchers would see; so this error does not repeat it.
    #[error(
        "storage url holds {what}, and whoever watches would see it: keys and secrets belong into the environment \
         (AWS_SECRET_ACCESS_KEY), or into [storage.options]"
    )]
    Secret {
        /// The kind of secret.
        what: &'static str,
    },
    /// Store and recordings are in the same folder, so the budget would delete stored recordings.
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
    /// The store does not have this option.
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
