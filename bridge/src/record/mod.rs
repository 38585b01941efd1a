//! Recording to MCAP: everything that clients could see, and every order to the robot.
//!
//! In: messages and orders, as they happen. Out: a file that survives the end of the program at any
//! time.
//!
//! 1. The hub never waits for the disk: a thread writes, behind a bounded queue. Messages that find
//!    no room are counted as lost.
//! 2. The thread takes the waiting messages, up to a limit, and passes them to the system in one
//!    write (`journal`). Only then do they count as acknowledged. They survive the end of the
//!    program by any signal; once a second they are forced to the disk, and then survive a power
//!    cut.
//! 3. A write that fails (the disk is full) is undone: the file ends after the last acknowledged
//!    message. All clients are told why, and the robot drives on.
//! 4. A recording into a folder is split into pieces, each complete for its reader and all within a
//!    budget (`pieces`). After a full disk, a new piece begins once there is room.
//! 5. At a regular end the summary is added, which lets readers seek. A file without it can still
//!    be read from its start.
//!
//! Chunks are not used, because an unfinished chunk is lost if the program dies; [`export()`] uses
//! them, afterwards. Channel `slamlab` holds every message as it crossed the wire
//! ([`slamlab_core::wire::message`]), from the bridge's hello on, which names the robot;
//! [`slamlab_core::wire::recording`] reads it, and [`crate::source::replay`] plays it back.
//! `/scan`, `/points`, `/odom`, `/tf` and `/cmd_vel` hold the same for other tools, as ROS 2
//! messages (`ros`); [`export()`] adds `/map` and `/pose`.
//!
//! Source: the MCAP format specification, mcap.dev/spec; OMG CDR for the ROS 2 messages.

pub(crate) mod cdr;
mod export;
mod journal;
pub(crate) mod pieces;
mod place;
pub(crate) mod ros;
mod thread;
mod writer;

use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::{SyncSender, sync_channel};
use std::thread::JoinHandle;
use std::time::Duration;

use slamlab_core::wire::message::{DriveBody, FromBridge, Header, RecordingBody, ToBridge};
use slamlab_core::wire::recording::{Recorded, Said};

use crate::clock::Clock;
use crate::source::Order;
pub use export::{ExportError, Exported, MAP_EVERY, export};
use pieces::Files;
pub use pieces::{Keep, MEBIBYTE};
pub(crate) use place::is_folder;
use thread::Progress;
pub(crate) use thread::is_full;

/// Most messages that may wait for the disk: ten seconds of a robot with a lidar.
const MOST_WAITING: usize = 4096;

/// Why a recording cannot begin.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RecordError {
    /// The file exists already: a recording is never overwritten.
    #[error("{} is already there: choose another name, or move it away", path.display())]
    Exists {
        /// The file.
        path: PathBuf,
    },
    /// Another bridge writes there; the two would delete and upload each other's files.
    #[error("folder {}: another bridge writes there; end that one, or name another folder", folder.display())]
    Taken {
        /// The folder.
        folder: PathBuf,
    },
    /// The system reported an error.
    #[error("cannot write {}: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What it said.
        source: io::Error,
    },
}

/// A running recording, as the hub holds it.
#[derive(Debug)]
pub struct Recorder {
    clock: Clock,
    entries: Option<SyncSender<Recorded>>,
    progress: Arc<Progress>,
    thread: Option<JoinHandle<()>>,
}

impl Recorder {
    /// Checks that a recording could begin there; nothing is written.
    ///
    /// # Errors    [`RecordError::Exists`].
    pub fn check(path: &Path) -> Result<(), RecordError> {
        place::check(path)
    }

    /// Begins a recording in a new file: `path` or, if that is a folder, a file in it named by the
    /// time of day, followed by others according to `keep`.
    ///
    /// # Errors    [`RecordError`]: the file exists already, or cannot be written, or another
    /// bridge records into the folder.
    pub fn start(path: &Path, keep: Keep, clock: Clock) -> Result<Self, RecordError> {
        Self::start_in(Files::recordings(path, keep, clock)?)
    }

    /// Like [`Self::start`], for a folder that is already locked.
    pub(crate) fn start_in(pieces: Files) -> Result<Self, RecordError> {
        let (keep, clock) = (pieces.keep, pieces.clock);
        let (file, path) = place::create(&pieces.path, clock.time_of_day(clock.now()))?;
        let (entries, waiting) = sync_channel(MOST_WAITING);
        let progress = Arc::new(Progress::default());
        let name = path.file_name().unwrap_or_default();
        progress.lock().file = name.to_string_lossy().into();
        let first = (file, path.clone());
        let shared = Arc::clone(&progress);
        let thread = std::thread::Builder::new()
            .name("record".into())
            .spawn(move || {
                thread::run(first, pieces, keep, &waiting, &shared);
            })
            .map_err(|source| RecordError::Io {
                path: path.clone(),
                source,
            })?;
        tracing::info!(file = %path.display(), "recording");
        Ok(Self {
            clock,
            entries: Some(entries),
            progress,
            thread: Some(thread),
        })
    }

    /// Records a message to the clients.
    pub fn message(&self, message: &FromBridge, now: Duration) {
        // The recording's own progress is of no use in the recording.
        if !matches!(message, FromBridge::Recording(_) | FromBridge::Heartbeat(_)) {
            self.put(Said::ByBridge(message.clone()), now);
        }
    }

    /// Records an order to the robot, as the message that would cause it.
    pub fn order(&self, order: &Order, now: Duration) {
        let message = match order {
            Order::Command(command) => ToBridge::Drive(DriveBody {
                epoch: 0,
                seen: now.as_micros() as u64,
                ttl_millis: 0,
                motion: *command,
            }),
            Order::EmergencyStop => ToBridge::EmergencyStop,
            Order::ResetEmergencyStop => ToBridge::ResetEmergencyStop { epoch: 0 },
        };
        self.put(Said::ToRobot(message), now);
    }

    fn put(&self, said: Said, at: Duration) {
        let entry = Recorded {
            nanos: self.clock.time_of_day(at).as_nanos() as u64,
            header: Header {
                sequence: 0, // The writer counts.
                micros: at.as_micros() as u64,
            },
            said,
        };
        let taken = self
            .entries
            .as_ref()
            .is_some_and(|to| to.try_send(entry).is_ok());
        if !taken {
            self.progress.lock().lost += 1;
        }
    }

    /// The state of the recording.
    #[must_use]
    pub fn status(&self) -> RecordingBody {
        self.progress.lock().clone()
    }

    /// The piece being written, for the uploader, which stores the others.
    #[cfg(feature = "storage")]
    pub(crate) fn current(&self) -> Current {
        Current(Arc::clone(&self.progress))
    }

    /// Writes the waiting messages and the summary, and closes the file.
    pub fn finish(mut self) -> RecordingBody {
        self.end();
        self.status()
    }

    fn end(&mut self) {
        self.entries = None;
        if let Some(thread) = self.thread.take()
            && thread.join().is_err()
        {
            tracing::error!("the recorder panicked");
        }
    }
}

/// The piece that is being written.
#[cfg(feature = "storage")]
#[derive(Debug)]
pub(crate) struct Current(Arc<Progress>);

#[cfg(feature = "storage")]
impl Current {
    /// Its name, without the folder.
    pub(crate) fn name(&self) -> String {
        self.0.lock().file.clone()
    }
}

/// Whether a file in a folder of recordings has the name of a piece.
#[cfg(feature = "storage")]
pub(crate) fn is_piece(name: &str) -> bool {
    place::RECORDINGS.is_piece(name)
}

/// The name of a piece in a store, which may hold pieces of other robots; unchanged if it is not a
/// piece's name.
#[cfg(feature = "storage")]
pub(crate) fn name_in_store(piece: &str, sha_256: &str) -> String {
    let name = place::RECORDINGS.among_others(piece, sha_256);
    name.unwrap_or_else(|| piece.to_owned())
}

/// Whether a file in a store has the name of a piece.
#[cfg(feature = "storage")]
pub(crate) fn is_piece_in_store(name: &str) -> bool {
    place::RECORDINGS.is_piece_among_others(name)
}

impl Drop for Recorder {
    fn drop(&mut self) {
        self.end();
    }
}

#[cfg(test)]
mod tests;
