//! Exports a recording with the results of SLAM, for tools that show ROS 2 messages.
//!
//! In: a recording. Out: another one, in chunks, with the same messages plus `/map`, `/pose` and
//! the transform from `map` to `odom`.
//!
//! Not every bridge maps, and one that does may skip scans to keep up. So this is done afterwards,
//! by the same replay as in `evaluate` and the page. The file holds a map every [`MAP_EVERY`] s, as
//! it was known then.

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

/// Interval between maps, s of the recording.
pub const MAP_EVERY: f64 = 5.0;

/// Why a recording cannot be exported.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ExportError {
    /// The recording cannot be read.
    #[error(transparent)]
    Read(#[from] replay::ReplayError),
    /// The new file cannot be created.
    #[error(transparent)]
    Create(#[from] RecordError),
    /// Writing the new file failed.
    #[error("cannot write {}: {source}", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        source: McapError,
    },
    /// A setting is out of range.
    #[error(transparent)]
    Replay(#[from] ReplayError),
}

/// What was written.
#[derive(Clone, Debug, PartialEq)]
pub struct Exported {
    /// Readable messages of the recording.
    pub messages: usize,
    /// Poses, one for each scan that could be used.
    pub poses: usize,
    /// Maps.
    pub maps: usize,
    /// Notes for the user: damage of the recording, scans that were left out.
    pub notes: Vec<String>,
}

/// Maps the recording `from`, and writes it with the map to the new file `to`.
///
/// # Errors    [`ExportError`]; a new file that could not be finished is left unfinished.
pub fn export(from: &Path, to: &Path, method: Method) -> Result<Exported, ExportError> {
    let recording = replay::read(from)?;
    // Begin before the file is created: an unsuitable method leaves no file behind.
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
    /// Time of the last message taken.
    time: Duration,
    map_due: Duration,
    done: Exported,
}

impl Export {
    fn begin(recording: Recording, method: Method) -> Result<Self, ReplayError> {
        // The replay has its own copy: the messages are small compared with the map.
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

    /// The messages up to the next scan, and the results of that scan; `None` at the end.
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
            // The replay has already reported what cannot be read.
            if let Some(Ok(recorded)) = self.recording.message(self.next) {
                self.time = Duration::from_nanos(recorded.nanos);
                entries.push(recorded);
            }
            self.next += 1;
        }
        self.done.messages += entries.len();
        entries
    }

    /// The results: a pose with each scan; a map when one is due, and at the end.
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
