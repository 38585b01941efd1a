//! The audit's thread: writes lines, begins another file where one is long or old enough, and tries
//! again where the disk takes nothing.

use std::fs::File;
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::Receiver;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use crate::record::RecordError;
use crate::record::pieces::{Files, Keep, Pieces};

/// Lines that are written at once.
const MOST_AT_ONCE: usize = 64;
/// Between two tries, where the disk takes nothing.
const TRY_AGAIN: Duration = Duration::from_secs(5);

/// The thread's end.
pub(super) struct Writer {
    pieces: Files,
    keep: Keep,
    /// None while the disk takes nothing.
    file: Option<(File, PathBuf)>,
    length: u64,
    begun: Instant,
    next_try: Instant,
    fate: Arc<Fate>,
}

/// What became of the lines.
#[derive(Debug, Default)]
pub(super) struct Fate {
    /// Why nothing more is written; none while all is well.
    pub(super) fault: Mutex<Option<String>>,
    pub(super) lost: AtomicU64,
}

impl Writer {
    /// With a first file.
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
            // Each line may be the last before the power goes.
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

    /// The hub tells everybody, and logs it.
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
