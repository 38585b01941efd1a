//! A recording written again with what SLAM makes of it, for tools that show ROS 2 messages.
//!
//! In: a recording. Out: another in chunks, with the same messages, and beside them `/map`, `/pose`
//! and the transform from `map` to `odom`.
//!
//! Not every bridge maps, and one that does may leave scans out to keep up. So this is done
//! afterwards, by the replay that `evaluate` and the page run. A map stands in the file every
//! [`MAP_EVERY`] s, as it was known then.

use std::path::{Path, PathBuf};
use std::time::Duration;

use mcap::McapError;
use slamlab_core::replay::{Log, Replay, ReplayError};
use slamlab_core::slam::Method;
use slamlab_core::wire::recording::{Recorded, Recording};

use super::ros::{self, Topic};
use super::writer::Writer;
use super::{RecordError, place};
use crate::source::replay;

/// Between two maps, s of the recording.
pub const MAP_EVERY: f64 = 5.0;

/// Why a recording cannot be exported.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ExportError {
    /// The recording cannot be read.
    #[error(transparent)]
    Read(#[from] replay::ReplayError),
    /// The new file cannot begin.
    #[error(transparent)]
    Create(#[from] RecordError),
    /// The new file cannot go on.
    #[error("cannot write {}: {source}", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        source: McapError,
    },
    /// A setting out of range.
    #[error(transparent)]
    Replay(#[from] ReplayError),
}

/// What was written.
#[derive(Clone, Debug, PartialEq)]
pub struct Exported {
    /// Messages of the recording that could be read.
    pub messages: usize,
    /// Poses, one for each scan that could be used.
    pub poses: usize,
    /// Maps.
    pub maps: usize,
    /// What a person should read: damage of the recording, scans that were left out.
    pub notes: Vec<String>,
}

/// Maps the recording `from`, and writes it with the map to the new file `to`.
///
/// # Errors    [`ExportError`]; a new file that could not be finished stays as far as it came.
pub fn export(from: &Path, to: &Path, method: Method) -> Result<Exported, ExportError> {
    let recording = replay::read(from)?;
    // A method that cannot do it leaves no file behind.
    let mut export = Export::begin(recording, method)?;
    let file = place::create_file(to.to_owned())?.0;
    let write = |source| ExportError::Write {
        path: to.to_owned(),
        source,
    };
    let mut writer = Writer::new(file, Topic::ALL, true).map_err(write)?;
    while let Some((entries, made, time)) = export.step() {
        writer.write(&entries).map_err(write)?;
        writer.made(&made, time).map_err(write)?;
    }
    writer.finish().map_err(write)?;
    Ok(export.done)
}

struct Export {
    recording: Recording,
    replay: Replay,
    is_over: bool,
    next: usize,
    /// Of the message taken last.
    time: Duration,
    map_due: Duration,
    done: Exported,
}

impl Export {
    fn begin(recording: Recording, method: Method) -> Result<Self, ReplayError> {
        // The replay has its own: the messages are few bytes beside the map.
        let log = Log::from(recording.clone());
        let settings = log.settings();
        Ok(Self {
            recording,
            replay: Replay::new(log, method, &settings)?,
            is_over: false,
            next: 0,
            time: Duration::ZERO,
            map_due: Duration::ZERO,
            done: Exported {
                messages: 0,
                poses: 0,
                maps: 0,
                notes: vec![],
            },
        })
    }

    /// Messages up to the next scan, and what is made of it; `None` at the end.
    fn step(&mut self) -> Option<(Vec<Recorded>, ros::Messages, Duration)> {
        if self.is_over {
            return None;
        }
        let stepped = self.replay.step();
        self.is_over = matches!(stepped, Ok(false));
        self.done.notes.append(&mut self.replay.take_notes());
        let end = if self.is_over {
            self.recording.len()
        } else {
            self.replay.messages_done()
        };
        let entries = self.entries(end);
        let made = match stepped {
            Err(error) => {
                self.done
                    .notes
                    .push(format!("A scan was left out: {error}"));
                vec![]
            }
            Ok(more) => self.made(more),
        };
        Some((entries, made, self.time))
    }

    fn entries(&mut self, end: usize) -> Vec<Recorded> {
        let mut entries = vec![];
        while self.next < end {
            // The replay has reported what cannot be read.
            if let Some(Ok(recorded)) = self.recording.message(self.next) {
                self.time = Duration::from_nanos(recorded.nanos);
                entries.push(recorded);
            }
            self.next += 1;
        }
        self.done.messages += entries.len();
        entries
    }

    /// A pose with each scan; a map where one is due, and at the end.
    fn made(&mut self, is_scan: bool) -> ros::Messages {
        let slam = self.replay.session().slam();
        let mut made = vec![];
        if is_scan {
            let odom = self.replay.odom_from_robot();
            made = ros::localised(&slam.estimate(), &odom, self.time);
            self.done.poses += 1;
        }
        if self.time >= self.map_due || !is_scan {
            let map = ros::map(slam.grid(), self.time);
            self.done.maps += map.len();
            made.extend(map);
            self.map_due = self.time + Duration::from_secs_f64(MAP_EVERY);
        }
        made
    }
}
