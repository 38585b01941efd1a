//! A recording as a source: a robot's earlier messages, at their original pace.
//!
//! In: an MCAP file made by [`crate::record`], complete, cut off or damaged. Out: the same events,
//! once, then silence.
//!
//! Recorded orders are not played back, and new ones are not taken: the robot of a recording cannot
//! be driven. Pauses are those of the recording, but at most [`LONGEST_PAUSE`].

use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use slamlab_core::wire::message::{DeviceState, FromBridge, RobotFigures};
use slamlab_core::wire::recording::{Recording, RecordingError, RecordingReader, Said};

use super::{Port, Profile, Source, SourceEvent, Waited};

/// Longer pauses are shortened to this.
pub const LONGEST_PAUSE: Duration = Duration::from_secs(60);
/// Bytes of the file per read.
const PIECE: usize = 1 << 18;

/// Why a file cannot be played back.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReplayError {
    /// The system reported an error.
    #[error("cannot read {}: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What it said.
        source: std::io::Error,
    },
    /// Nothing in it can be played.
    #[error("{}: {source}", path.display())]
    Format {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        source: RecordingError,
    },
}

/// A recording that is not playing yet.
#[derive(Debug)]
pub struct ReplaySource {
    path: PathBuf,
    /// Kept in memory encoded: messages are decoded one by one, as they are played.
    recording: Recording,
}

impl ReplaySource {
    /// Reads a recording.
    ///
    /// # Errors    [`ReplayError`]: the file cannot be read, or holds nothing to play.
    pub fn open(path: &Path) -> Result<Self, ReplayError> {
        let recording = read(path)?;
        for damage in recording.damage() {
            tracing::warn!("{}: {damage}", path.display());
        }
        Ok(Self {
            path: path.to_owned(),
            recording,
        })
    }

    /// The events, each with the pause since the one before, where gaps between messages count as
    /// at most [`LONGEST_PAUSE`]. Orders are messages in the other direction, and are skipped.
    pub fn events(&self) -> impl Iterator<Item = (Duration, SourceEvent)> {
        let mut pause = Duration::ZERO;
        let mut before = None;
        self.recording.messages().filter_map(move |message| {
            let recorded = message
                .inspect_err(|damage| tracing::warn!("{}: {damage}", self.path.display()))
                .ok()?;
            let Said::ByBridge(said) = recorded.said else {
                return None;
            };
            pause += self.pause(before.replace(recorded.nanos), recorded.nanos);
            let event = event(said)?;
            Some((std::mem::take(&mut pause), event))
        })
    }

    /// Pause from one message to the next. A damaged time, or a clock that was set meanwhile, must
    /// not make the replay wait for ever.
    fn pause(&self, before: Option<u64>, now: u64) -> Duration {
        let pause = Duration::from_nanos(now.saturating_sub(before.unwrap_or(now)));
        if pause > LONGEST_PAUSE {
            tracing::warn!(
                "{}: a pause of {} s is played as {} s",
                self.path.display(),
                pause.as_secs(),
                LONGEST_PAUSE.as_secs()
            );
        }
        pause.min(LONGEST_PAUSE)
    }
}

/// Reads a recording, piece by piece.
pub(crate) fn read(path: &Path) -> Result<Recording, ReplayError> {
    let io = |source| ReplayError::Io {
        path: path.to_owned(),
        source,
    };
    let format = |source| ReplayError::Format {
        path: path.to_owned(),
        source,
    };
    let mut file = File::open(path).map_err(io)?;
    let mut reader = RecordingReader::default();
    let mut piece = vec![0; PIECE];
    loop {
        let count = file.read(&mut piece).map_err(io)?;
        let Some(bytes) = piece.get(..count).filter(|bytes| !bytes.is_empty()) else {
            return reader.finish().map_err(format);
        };
        reader.push(bytes).map_err(format)?;
    }
}

/// The event from which the message was made; none for messages about the bridge itself.
fn event(said: FromBridge) -> Option<SourceEvent> {
    Some(match said {
        FromBridge::Odometry(body) => SourceEvent::Odometry(body.odometry().ok()?),
        FromBridge::Scan(body) => SourceEvent::Scan(body.scan().ok()?),
        FromBridge::PartialScan(body) => SourceEvent::PartialScan(body.scan().ok()?),
        FromBridge::Rangers(body) => SourceEvent::Rangers(body),
        FromBridge::Bumpers(body) => SourceEvent::Bumpers(body),
        FromBridge::Battery(body) => SourceEvent::Battery(body),
        FromBridge::Currents(body) => SourceEvent::Currents(body),
        FromBridge::Link(body) => SourceEvent::Link(body),
        _ => return None,
    })
}

impl Source for ReplaySource {
    fn profile(&self) -> Profile {
        let robot = self.recording.robot();
        Profile {
            name: format!("replay:{}", self.path.display()),
            robot: robot.as_ref().and_then(RobotFigures::model),
            takes_orders: false,
            scans_on_command: robot.is_some_and(|robot| robot.scans_on_command),
        }
    }

    fn run(self: Box<Self>, port: Port) {
        let device = |state, detail: &str| SourceEvent::Device {
            state,
            model: "recording".into(),
            detail: detail.into(),
        };
        port.send(device(DeviceState::Sending, ""));
        let mut due = Instant::now();
        for (pause, event) in self.events() {
            due += pause;
            loop {
                let left = due.saturating_duration_since(Instant::now());
                match port.wait(left) {
                    Waited::Order(_) => (),
                    Waited::Nothing => break,
                    Waited::Closed => return,
                }
            }
            port.send(event);
        }
        port.send(device(DeviceState::Connected, "The recording has ended."));
        while port.wait(Duration::from_secs(3600)) != Waited::Closed {}
    }
}

#[cfg(test)]
mod tests;
