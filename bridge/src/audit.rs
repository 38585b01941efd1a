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

mod story;

use std::fs::File;
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use serde::Serialize;
use slamlab_core::wire::message::{DisarmReason, Right, Role};
use time::OffsetDateTime;
use time::format_description::well_known::Rfc3339;

use crate::access_log::Peer;
use crate::clock::Clock;
use crate::record::pieces::{Files, Keep, Pieces};
use crate::record::{MEBIBYTE, RecordError};
pub(crate) use story::Story;

/// Lines that wait for the disk.
const MOST_WAITING: usize = 1024;
/// Between two tries, where the disk takes nothing.
const TRY_AGAIN: Duration = Duration::from_secs(5);
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

/// Somebody who is connected.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub(crate) struct Who {
    /// Of the connection.
    client: u32,
    /// Name of the right; none for the first token, and for who has none.
    #[serde(skip_serializing_if = "String::is_empty")]
    name: String,
    role: Role,
    /// What it calls itself.
    calls_itself: String,
    #[serde(serialize_with = "as_text")]
    from: Peer,
}

impl Who {
    pub(crate) fn new(client: u32, right: &Right, calls_itself: &str, from: Peer) -> Self {
        Self {
            client,
            name: right.name.clone(),
            role: right.role,
            calls_itself: calls_itself.to_owned(),
            from,
        }
    }
}

/// What happened.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "what", rename_all = "kebab-case")]
pub(crate) enum What {
    /// The bridge begins to serve.
    Begins { version: &'static str },
    /// Somebody got the right to drive.
    Lease { who: Who },
    /// It has it no longer.
    LeaseEnds { who: Who },
    /// The robot moves on its commands, from now on.
    Drives { who: Who },
    /// And no longer: why, and who stopped it, where somebody did.
    Stops {
        who: Option<Who>,
        cause: DisarmReason,
        #[serde(skip_serializing_if = "Option::is_none")]
        by: Option<Who>,
        after_seconds: f64,
    },
    /// The motors are cut off.
    EmergencyStop {
        cause: DisarmReason,
        #[serde(skip_serializing_if = "Option::is_none")]
        by: Option<Who>,
    },
    /// And may run again.
    EmergencyReset {
        #[serde(skip_serializing_if = "Option::is_none")]
        by: Option<Who>,
    },
    /// Somebody pressed a stop that changed nothing.
    StopAgain { by: Who },
    /// A connection that the bridge ended, or did not let in.
    Refused {
        #[serde(serialize_with = "as_text")]
        from: Peer,
        code: u16,
        why: &'static str,
    },
    /// A right was taken away while it was used.
    Revoked { who: Who },
    /// The bridge ends.
    Ends,
}

fn as_text<S: serde::Serializer>(peer: &Peer, to: S) -> Result<S::Ok, S::Error> {
    to.collect_str(peer)
}

/// A line.
#[derive(Serialize)]
struct Line<'a> {
    /// UTC.
    at: String,
    #[serde(flatten)]
    what: &'a What,
}

/// The audit under way.
#[derive(Debug)]
pub(crate) struct Audit {
    clock: Clock,
    lines: Mutex<Option<SyncSender<String>>>,
    fault: Arc<Mutex<Option<String>>>,
    lost: Arc<AtomicU64>,
    thread: Mutex<Option<JoinHandle<()>>>,
}

impl Audit {
    /// Begins a new file in the folder.
    ///
    /// # Errors    [`RecordError`]: it cannot be written.
    pub(crate) fn start(folder: &Path, keep: Keep, clock: Clock) -> Result<Self, RecordError> {
        let mut pieces = Files::audits(folder, keep, clock);
        let first = pieces.next()?;
        let (lines, waiting) = sync_channel(MOST_WAITING);
        let (fault, lost) = (Arc::default(), Arc::default());
        let mut writer = Writer {
            pieces,
            keep,
            file: first,
            length: 0,
            begun: Instant::now(),
            next_try: Instant::now(),
            fault: Arc::clone(&fault),
            lost: Arc::clone(&lost),
        };
        let thread = std::thread::Builder::new()
            .name("audit".into())
            .spawn(move || writer.run(&waiting))
            .map_err(|source| RecordError::Io {
                path: folder.to_owned(),
                source,
            })?;
        let audit = Self {
            clock,
            lines: Mutex::new(Some(lines)),
            fault,
            lost,
            thread: Mutex::new(Some(thread)),
        };
        let version = env!("CARGO_PKG_VERSION");
        audit.note(clock.now(), What::Begins { version });
        Ok(audit)
    }

    /// Writes down what happened at `now`.
    pub(crate) fn note(&self, now: Duration, what: What) {
        let at = OffsetDateTime::UNIX_EPOCH + self.clock.time_of_day(now);
        // Every year that a clock can show has four figures.
        let at = at.format(&Rfc3339).unwrap_or_default();
        let Ok(line) = serde_json::to_string(&Line { at, what: &what }) else {
            return;
        };
        let lines = self.lines.lock().unwrap_or_else(PoisonError::into_inner);
        let is_taken = (lines.as_ref()).is_some_and(|lines| lines.try_send(line).is_ok());
        if !is_taken {
            self.lost.fetch_add(1, Ordering::Relaxed);
        }
    }

    /// Why nothing more is written; none while all is well.
    pub(crate) fn fault(&self) -> Option<String> {
        let fault = self.fault.lock().unwrap_or_else(PoisonError::into_inner);
        fault.clone()
    }

    /// Waits until all is written.
    pub(crate) fn finish(&self) {
        self.note(self.clock.now(), What::Ends);
        let lines = &mut *self.lines.lock().unwrap_or_else(PoisonError::into_inner);
        drop(lines.take());
        let thread = &mut *self.thread.lock().unwrap_or_else(PoisonError::into_inner);
        if thread.take().is_some_and(|thread| thread.join().is_err()) {
            tracing::error!("the audit's thread panicked");
        }
        let lost = self.lost.load(Ordering::Relaxed);
        if lost > 0 {
            tracing::warn!("{lost} lines of the audit were lost");
        }
    }
}

/// The thread's end.
struct Writer {
    pieces: Files,
    keep: Keep,
    /// None while the disk takes nothing.
    file: Option<(File, PathBuf)>,
    length: u64,
    begun: Instant,
    next_try: Instant,
    fault: Arc<Mutex<Option<String>>>,
    lost: Arc<AtomicU64>,
}

impl Writer {
    fn run(&mut self, waiting: &Receiver<String>) {
        while let Ok(mut line) = waiting.recv() {
            line.push('\n');
            self.turn_over();
            let Some((file, path)) = &mut self.file else {
                self.lost.fetch_add(1, Ordering::Relaxed);
                continue;
            };
            // Few lines are written, and each may be the last before the power goes.
            match file
                .write_all(line.as_bytes())
                .and_then(|()| file.sync_data())
            {
                Ok(()) => {
                    self.length += line.len() as u64;
                    self.say(None);
                }
                Err(error) => {
                    let why = words(&error, path);
                    self.lost.fetch_add(1, Ordering::Relaxed);
                    self.file = None;
                    self.next_try = Instant::now() + TRY_AGAIN;
                    self.say(Some(why));
                }
            }
        }
    }

    /// Begins another file where this one is long or old enough, or there is none.
    fn turn_over(&mut self) {
        let is_due = match &self.file {
            Some(_) => {
                self.length >= self.keep.piece_bytes || self.begun.elapsed() >= self.keep.piece_age
            }
            None => Instant::now() >= self.next_try,
        };
        if !is_due {
            return;
        }
        match self.pieces.next() {
            Ok(Some((file, path))) => {
                self.pieces.make_room(&path);
                self.file = Some((file, path));
                (self.length, self.begun) = (0, Instant::now());
            }
            Ok(None) => (),
            Err(error) => {
                self.next_try = Instant::now() + TRY_AGAIN;
                // Better too long a file than none.
                self.begun = Instant::now();
                self.say(Some(error.to_string()));
            }
        }
    }

    fn say(&self, why: Option<String>) {
        let mut fault = self.fault.lock().unwrap_or_else(PoisonError::into_inner);
        if *fault != why {
            if let Some(why) = &why {
                tracing::error!("audit: {why}");
            }
            *fault = why;
        }
    }
}

fn words(error: &io::Error, path: &Path) -> String {
    let path = path.display();
    match crate::record::is_full(error) {
        true => format!("the disk is full: nothing more is written to {path}; make room"),
        false => format!("nothing more is written to {path}: {error}"),
    }
}

#[cfg(test)]
mod tests;
