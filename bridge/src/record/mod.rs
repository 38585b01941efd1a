//! Recording to MCAP: whatever the clients could see, and every order to the robot.
//!
//! In: messages and orders, as they happen. Out: a file that survives the end of the program at any
//! time.
//!
//! 1. The hub never waits for the disk: a thread writes, behind a bounded queue. What finds no room
//!    is counted as lost.
//! 2. The thread takes what waits, up to a bounded number of messages, and gives it to the system
//!    in one write (`journal`). Then, and not before, these messages count as acknowledged. They
//!    survive the end of the program, by whatever signal; each second they are forced to the disk,
//!    and survive the end of the power.
//! 3. A write that fails (the disk is full) is undone: the file ends behind the last acknowledged
//!    message. Everybody learns why, and the robot drives on.
//! 4. A folder takes one piece after the other, each with all that its reader must know, and keeps
//!    a budget of them (`pieces`). Where the disk was full, another piece begins once it is not.
//! 5. At a regular end the summary is added, which lets readers jump. A file without it reads just
//!    as well from its start.
//!
//! Chunks are not used, for a chunk under way is lost with the program; [`export()`] uses them,
//! afterwards. Channel `slamlab` holds every message as it crossed the wire
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

/// Messages that wait for the disk: ten seconds of a robot with a lidar.
const MOST_WAITING: usize = 4096;

/// Why a recording cannot begin.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RecordError {
    /// A recording is never written over.
    #[error("{} is already there: choose another name, or move it away", path.display())]
    Exists {
        /// The file.
        path: PathBuf,
    },
    /// Two that write there would delete and store each other's files.
    #[error("folder {}: another bridge writes there; end that one, or name another folder", folder.display())]
    Taken {
        /// The folder.
        folder: PathBuf,
    },
    /// The system said no.
    #[error("cannot write {}: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What it said.
        source: io::Error,
    },
}

/// A recording under way, as the hub holds it.
#[derive(Debug)]
pub struct Recorder {
    clock: Clock,
    entries: Option<SyncSender<Recorded>>,
    progress: Arc<Progress>,
    thread: Option<JoinHandle<()>>,
}

impl Recorder {
    /// Whether a recording could begin there; nothing is written.
    ///
    /// # Errors    [`RecordError::Exists`].
    pub fn check(path: &Path) -> Result<(), RecordError> {
        place::check(path)
    }

    /// Begins a recording in a new file: `path`, or, where that is a folder, one named by the time
    /// of day in there, and further ones as `keep` says.
    ///
    /// # Errors    [`RecordError`]: the file is there already, or cannot be written, or another
    /// bridge records into the folder.
    pub fn start(path: &Path, keep: Keep, clock: Clock) -> Result<Self, RecordError> {
        Self::start_in(Files::recordings(path, keep, clock)?)
    }

    /// As [`Self::start`], where the folder was taken already.
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
        // How the recording goes is of no use in the recording.
        if !matches!(message, FromBridge::Recording(_) | FromBridge::Heartbeat(_)) {
            self.put(Said::ByBridge(message.clone()), now);
        }
    }

    /// Records an order to the robot, as the message that would have caused it.
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

    /// How it goes.
    #[must_use]
    pub fn status(&self) -> RecordingBody {
        self.progress.lock().clone()
    }

    /// Which piece is being written, for whoever stores those that are not.
    #[cfg(feature = "storage")]
    pub(crate) fn current(&self) -> Current {
        Current(Arc::clone(&self.progress))
    }

    /// Writes what waits and the summary, and closes the file.
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

/// Whether a file in a folder of recordings is called as one.
#[cfg(feature = "storage")]
pub(crate) fn is_piece(name: &str) -> bool {
    place::RECORDINGS.is_piece(name)
}

/// What a piece is called in a store, which may have those of other robots; itself where it is not
/// called as a piece.
#[cfg(feature = "storage")]
pub(crate) fn name_in_store(piece: &str, sha_256: &str) -> String {
    let name = place::RECORDINGS.among_others(piece, sha_256);
    name.unwrap_or_else(|| piece.to_owned())
}

/// Whether a file in a store is called as a recording.
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
