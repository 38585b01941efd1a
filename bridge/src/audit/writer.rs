//! The audit's thread: writes lines, begins a new file when the current one is long or old enough,
//! and tries again when the disk accepts no writes.

use std::fs::File;
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::Receiver;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use crate::record::RecordError;
use crate::record::pieces::{Files, Keep, Pieces};

/// Most lines per write.
const MOST_AT_ONCE: usize = 64;
/// Interval between tries while the disk accepts no writes.
const TRY_AGAIN: Duration = Duration::from_secs(5);

/// The thread's end of the queue.
pub(super) struct Writer {
    pieces: Files,
    keep: Keep,
    /// None while the disk accepts no writes.
    file: Option<(File, PathBuf)>,
    length: u64,
    begun: Instant,
    next_try: Instant,
    fate: Arc<Fate>,
}

/// What became of the lines.
#[derive(Debug, Default)]
pub(super) struct Fate {
    /// Why nothing is being written; none while all is well.
    pub(super) fault: Mutex<Option<String>>,
    pub(super) lost: AtomicU64,
}

impl Writer {
    /// Starts the thread with a first file.
    pub(super) fn start(
        mut pieces: Files,
        keep: Keep,
        fate: &Arc<Fate>,
    ) -> Result<Self, RecordError> {
        let now = Instant::now();
        Ok(Self {
            file: pieces.next()?,
            pieces,
            keep,
            length: 0,
            begun: now,
            next_try: now,
            fate: Arc::clone(fate),
        })
    }

    pub(super) fn run(&mut self, waiting: &Receiver<String>) {
        while let Ok(mut lines) = waiting.recv() {
            lines.push('\n');
            let mut count = 1;
            for line in waiting.try_iter().take(MOST_AT_ONCE) {
                lines.extend([line.as_str(), "\n"]);
                count += 1;
            }
            self.turn_over();
            let Some((file, path)) = &mut self.file else {
                self.fate.lost.fetch_add(count, Ordering::Relaxed);
                continue;
            };
            // Force each line to the disk: it may be the last one before a power cut.
            match file
                .write_all(lines.as_bytes())
                .and_then(|()| file.sync_data())
            {
                Ok(()) => {
                    self.length += lines.len() as u64;
                    self.say(None);
                }
                Err(error) => {
                    let why = words(&error, path);
                    self.fate.lost.fetch_add(count, Ordering::Relaxed);
                    self.file = None;
                    self.next_try = Instant::now() + TRY_AGAIN;
                    self.say(Some(why));
                }
            }
        }
    }

    /// Begins a new file if this one is long or old enough, or there is none.
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
                // A file that is too long is better than none.
                self.begun = Instant::now();
                self.say(Some(error.to_string()));
            }
        }
    }

    /// Sets the fault, which the hub logs and tells all clients.
    fn say(&self, why: Option<String>) {
        let fault = &self.fate.fault;
        *fault.lock().unwrap_or_else(PoisonError::into_inner) = why;
    }
}

fn words(error: &io::Error, path: &Path) -> String {
    let path = path.display();
    match crate::record::is_full(error) {
        true => format!("the disk is full: nothing more is written to {path}; make room"),
        false => format!("nothing more is written to {path}: {error}"),
    }
}
