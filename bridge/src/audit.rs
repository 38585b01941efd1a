//! The audit: who had the lease, drove, stopped the robot and was refused, with the time of day.
//!
//! In: what happens. Out: files in a folder, one line of JSON per entry, split into pieces and kept
//! within a budget like recordings.
//!
//! 1. Callers never wait for the disk: a thread writes, behind a bounded queue.
//! 2. Entries that can repeat (stops that change nothing, refusals) are limited by the budgets of
//!    [`crate::access_log`]; leases, drives and what ended them are all written.
//! 3. It never holds a token or a proof.
//! 4. If the disk accepts no writes, all clients are told, and a new file is tried now and then.

mod entry;
mod story;
mod writer;

use std::sync::atomic::Ordering;
use std::sync::mpsc::{SyncSender, sync_channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;

use time::OffsetDateTime;
use time::format_description::well_known::Rfc3339;

use crate::clock::Clock;
use crate::record::pieces::{Files, Keep};
use crate::record::{MEBIBYTE, RecordError};
use entry::Line;
pub(crate) use entry::{What, Who};
pub(crate) use story::Story;
use writer::{Fate, Writer};

/// Most lines that may wait for the disk.
const MOST_WAITING: usize = 1024;
/// Number of files that share the budget.
const PIECES: u64 = 8;
const OLDEST_PIECE: Duration = Duration::from_secs(7 * 24 * 3600);

/// How long files become and how much is kept, for a budget in MiB.
pub(crate) fn keep(budget_mib: u64) -> Keep {
    let all_bytes = budget_mib.saturating_mul(MEBIBYTE);
    Keep {
        piece_bytes: all_bytes / PIECES,
        piece_age: OLDEST_PIECE,
        all_bytes,
    }
}

/// The running audit.
#[derive(Debug)]
pub(crate) struct Audit {
    clock: Clock,
    lines: Mutex<Option<SyncSender<String>>>,
    fate: Arc<Fate>,
    thread: Mutex<Option<JoinHandle<()>>>,
}

impl Audit {
    /// Begins a new file in the folder, which must already be locked for it.
    ///
    /// # Errors    [`RecordError`]: it cannot be written.
    pub(crate) fn start(pieces: Files) -> Result<Self, RecordError> {
        let (folder, keep, clock) = (pieces.path.clone(), pieces.keep, pieces.clock);
        let (lines, waiting) = sync_channel(MOST_WAITING);
        let fate = Arc::default();
        let mut writer = Writer::start(pieces, keep, &fate)?;
        let thread = std::thread::Builder::new()
            .name("audit".into())
            .spawn(move || writer.run(&waiting))
            .map_err(|source| RecordError::Io {
                path: folder,
                source,
            })?;
        let audit = Self {
            clock,
            lines: Mutex::new(Some(lines)),
            fate,
            thread: Mutex::new(Some(thread)),
        };
        let version = env!("CARGO_PKG_VERSION");
        audit.note(clock.now(), &What::Begins { version });
        Ok(audit)
    }

    /// Writes down what happened at `now`.
    pub(crate) fn note(&self, now: Duration, what: &What) {
        let at = OffsetDateTime::UNIX_EPOCH + self.clock.time_of_day(now);
        // Formatting cannot fail: every year that a clock can show has four digits.
        let at = at.format(&Rfc3339).unwrap_or_default();
        let Ok(line) = serde_json::to_string(&Line { at, what }) else {
            return;
        };
        let lines = self.lines.lock().unwrap_or_else(PoisonError::into_inner);
        let is_taken = (lines.as_ref()).is_some_and(|lines| lines.try_send(line).is_ok());
        if !is_taken {
            self.fate.lost.fetch_add(1, Ordering::Relaxed);
        }
    }

    /// Why nothing is being written; none while all is well.
    pub(crate) fn fault(&self) -> Option<String> {
        let fault = self
            .fate
            .fault
            .lock()
            .unwrap_or_else(PoisonError::into_inner);
        fault.clone()
    }

    /// Waits until everything is written.
    pub(crate) fn finish(&self) {
        self.note(self.clock.now(), &What::Ends);
        let lines = &mut *self.lines.lock().unwrap_or_else(PoisonError::into_inner);
        drop(lines.take());
        let thread = &mut *self.thread.lock().unwrap_or_else(PoisonError::into_inner);
        if thread.take().is_some_and(|thread| thread.join().is_err()) {
            tracing::error!("the audit's thread panicked");
        }
        let lost = self.fate.lost.load(Ordering::Relaxed);
        if lost > 0 {
            tracing::warn!("{lost} lines of the audit were lost");
        }
    }
}

#[cfg(test)]
mod tests;
