//! The audit: who came to drive, drove, stopped the robot and was refused, with the time of day.
//!
//! In: what happens. Out: files in a folder, one line of JSON each, cut and kept in a budget as
//! recordings are.
//!
//! 1. Whoever writes it down never waits for the disk: a thread writes, behind a bounded queue.
//! 2. What repeats itself (stops that change nothing, refusals) comes through the budgets of
//!    [`crate::access_log`]; leases, drives and what ended them are all written down.
//! 3. No token stands here, and no proof.
//! 4. Where the disk takes nothing, everybody is told, and another file is tried now and then.

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

/// Lines that wait for the disk.
const MOST_WAITING: usize = 1024;
/// So many files the budget is cut into.
const PIECES: u64 = 8;
const OLDEST_PIECE: Duration = Duration::from_secs(7 * 24 * 3600);

/// How much of it is kept, for a budget of so many MiB.
pub(crate) fn keep(budget_mib: u64) -> Keep {
    let all_bytes = budget_mib.saturating_mul(MEBIBYTE);
    Keep {
        piece_bytes: all_bytes / PIECES,
        piece_age: OLDEST_PIECE,
        all_bytes,
    }
}

/// The audit under way.
#[derive(Debug)]
pub(crate) struct Audit {
    clock: Clock,
    lines: Mutex<Option<SyncSender<String>>>,
    fate: Arc<Fate>,
    thread: Mutex<Option<JoinHandle<()>>>,
}

impl Audit {
    /// Begins a new file in the folder, which was taken for it.
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
        // Every year that a clock can show has four figures.
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

    /// Why nothing more is written; none while all is well.
    pub(crate) fn fault(&self) -> Option<String> {
        let fault = self
            .fate
            .fault
            .lock()
            .unwrap_or_else(PoisonError::into_inner);
        fault.clone()
    }

    /// Waits until all is written.
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
