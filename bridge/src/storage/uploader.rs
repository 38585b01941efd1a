//! The task that stores one finished piece after the other, and reports what prevents it.

use std::collections::BTreeMap;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use slamlab_core::wire::message::Severity;
use tokio::sync::mpsc;

use super::bucket::Bucket;
use super::fetches::Fetches;
use super::ledger::{Ledger, piece_of};
use super::listing::Listing;
use super::upload::{Fault, upload};
use super::{StorageConfig, StorageError};
use crate::hub::FromClient;
use crate::record::{Current, MEBIBYTE, is_folder, is_piece};

/// Interval between checks for a finished piece.
const LOOK: Duration = Duration::from_secs(5);
/// Pause after a fault: the first, and the longest.
const WAIT: (Duration, Duration) = (Duration::from_secs(1), Duration::from_secs(300));

/// The state of the uploads, for HTTP.
#[derive(Debug)]
pub(crate) struct Uploads {
    pub(super) bucket: Bucket,
    pub(super) folder: PathBuf,
    current: Current,
    fault: Mutex<Option<String>>,
    /// The last list of the store.
    pub(super) listing: Listing,
    pub(super) fetches: Fetches,
}

impl Uploads {
    /// Why nothing can be stored at present.
    pub(super) fn fault(&self) -> Option<String> {
        self.lock().clone()
    }

    fn lock(&self) -> MutexGuard<'_, Option<String>> {
        self.fault.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The pieces in the folder by their names, with their bytes; the one being written is last.
    pub(super) fn pieces(&self) -> io::Result<BTreeMap<String, u64>> {
        let mut pieces = BTreeMap::new();
        for entry in fs::read_dir(&self.folder)? {
            let entry = entry?;
            if let Some(name) = entry.file_name().to_str().filter(|name| is_piece(name)) {
                // A piece may have been deleted meanwhile to make room.
                if let Ok(known) = entry.metadata() {
                    pieces.insert(name.to_owned(), known.len());
                }
            }
        }
        Ok(pieces)
    }

    /// Whether a piece is being written.
    pub(super) fn is_current(&self, name: &str) -> bool {
        self.current.name() == name
    }
}

/// A store and the folder of its pieces: everything that can be wrong with them has been checked.
pub(crate) struct Ready {
    config: StorageConfig,
    bucket: Bucket,
    folder: PathBuf,
}

/// Checks settings and folder; nothing is asked of the store, and nothing written.
///
/// # Errors    [`StorageError`].
pub(crate) fn ready(config: &StorageConfig, record: Option<&Path>) -> Result<Ready, StorageError> {
    config.check(record)?;
    let folder = record.filter(|path| is_folder(path));
    let folder = folder.ok_or_else(|| StorageError::NoFolder {
        url: config.url.clone(),
    })?;
    Ok(Ready {
        bucket: Bucket::open(config)?,
        config: config.clone(),
        folder: folder.to_owned(),
    })
}

impl Ready {
    /// Begins to store the pieces in the recording's folder, and those to come.
    pub(crate) fn start(
        self,
        current: Current,
        hub: mpsc::Sender<FromClient>,
    ) -> (Arc<Uploads>, impl Future<Output = ()> + use<>) {
        let uploads = Arc::new(Uploads {
            bucket: self.bucket,
            folder: self.folder,
            current,
            fault: Mutex::default(),
            listing: Listing::default(),
            fetches: Fetches::default(),
        });
        let uploader = Uploader {
            uploads: Arc::clone(&uploads),
            part_bytes: self.config.part_mib * MEBIBYTE,
            verify: self.config.verify,
            hub,
        };
        (uploads, uploader.run())
    }
}

struct Uploader {
    uploads: Arc<Uploads>,
    part_bytes: u64,
    verify: bool,
    hub: mpsc::Sender<FromClient>,
}

impl Uploader {
    async fn run(self) {
        let mut wait = WAIT.0;
        loop {
            match self.next().await {
                Ok(true) => wait = WAIT.0,
                Ok(false) => tokio::time::sleep(LOOK).await,
                Err(why) => {
                    self.say_fault(why).await;
                    tokio::time::sleep(wait).await;
                    wait = (2 * wait).min(WAIT.1);
                }
            }
        }
    }

    /// Stores the oldest piece that is not stored yet; true if there was one.
    async fn next(&self) -> Result<bool, String> {
        let uploads = &*self.uploads;
        let pieces = uploads.pieces();
        let pieces = pieces
            .map_err(|error| format!("{} cannot be read: {error}", uploads.folder.display()))?;
        self.clear_away();
        let mut unreadable = None;
        for (name, bytes) in pieces {
            let piece = uploads.folder.join(&name);
            if uploads.is_current(&name) {
                continue;
            }
            let mut ledger = Ledger::of(&piece, &uploads.bucket.url, bytes, self.part_bytes);
            if ledger.stored.is_some() {
                continue;
            }
            let stored = upload(&piece, &name, &uploads.bucket, &mut ledger, self.verify).await;
            let why = match stored {
                Ok(sum) => {
                    tracing::info!(
                        "{name} is stored in {} as {} (SHA-256 {sum})",
                        uploads.bucket.url,
                        ledger.name_in_store(&name)
                    );
                    if unreadable.is_none() {
                        self.say_well().await;
                    }
                    return Ok(true);
                }
                Err(_) if !piece.exists() => {
                    tracing::warn!("{name} was deleted before it was stored: the budget is full");
                    return Ok(true);
                }
                Err(Fault::Disk(error)) => {
                    // The other pieces need not wait for this one.
                    let why = format!("{name} is not stored: {error}");
                    unreadable = unreadable.or(Some(why));
                    continue;
                }
                Err(fault) => format!("{name} is not stored in {} yet: {fault}", uploads.bucket),
            };
            return Err(why);
        }
        unreadable.map_or(Ok(false), Err)
    }

    /// Removes ledgers of pieces that are gone.
    fn clear_away(&self) {
        let entries = fs::read_dir(&self.uploads.folder).into_iter().flatten();
        for ledger in entries.flatten().map(|entry| entry.path()) {
            let piece = piece_of(&ledger).filter(|piece| is_named_as_piece(piece));
            if piece.is_some_and(|piece| !piece.exists()) {
                // If this fails, it is tried again the next time.
                let _ = fs::remove_file(&ledger);
            }
        }
    }

    async fn say_fault(&self, why: String) {
        let before = self.uploads.lock().replace(why.clone());
        // Everybody is told only once until it works again: the link may be down for a day. Another
        // reason is logged.
        if let Some(before) = before {
            match before == why {
                true => tracing::debug!("{why}"),
                false => tracing::warn!("{why}"),
            }
            return;
        }
        let text = format!("{why}. It is tried again; the recording goes on.");
        self.say(Severity::Warning, text).await;
    }

    async fn say_well(&self) {
        if self.uploads.lock().take().is_some() {
            let text = format!(
                "Recordings are stored in {} again.",
                self.uploads.bucket.url
            );
            self.say(Severity::Info, text).await;
        }
    }

    async fn say(&self, severity: Severity, text: String) {
        // A hub that has ended cannot tell anybody.
        let _ = self.hub.send(FromClient::Notice(severity, text)).await;
    }
}

fn is_named_as_piece(path: &Path) -> bool {
    let name = path.file_name().and_then(|name| name.to_str());
    name.is_some_and(is_piece)
}
