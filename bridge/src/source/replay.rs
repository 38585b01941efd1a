//! A recording as a source: what a robot said once, at the pace at which it said it.
//!
//! In: an MCAP file made by [`crate::record`], whole, cut off or damaged. Out: the same events, once, then silence.
//!
//! Orders are not played back, and none are taken: a recording cannot be driven.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use slamlab_core::robot::Stamp;
use slamlab_core::wire::message::{DeviceState, FromBridge};
use slamlab_core::wire::recording::{Recording, RecordingError, Said};

use super::{Event, Link, Port, Profile, Source, Waited};

/// Why a file cannot be played back.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReplayError {
    /// The system said no.
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

/// A recording that does not play yet.
#[derive(Debug)]
pub struct ReplaySource {
    name: String,
    /// When since the start of the recording, and what.
    events: Vec<(Duration, Event)>,
}

impl ReplaySource {
    /// Reads a recording.
    ///
    /// # Errors    [`ReplayError`]: the file cannot be read, or holds nothing that could be played.
    pub fn open(path: &Path) -> Result<Self, ReplayError> {
        let bytes = std::fs::read(path).map_err(|source| ReplayError::Io {
            path: path.to_owned(),
            source,
        })?;
        let recording = Recording::parse(&bytes).map_err(|source| ReplayError::Format {
            path: path.to_owned(),
            source,
        })?;
        for damage in recording.damage() {
            tracing::warn!("{}: {damage}", path.display());
        }
        let events = read(&recording, path);
        Ok(Self {
            name: format!("replay:{}", path.display()),
            events,
        })
    }

    /// What it holds, and when since its start.
    #[must_use]
    pub fn events(&self) -> &[(Duration, Event)] {
        &self.events
    }
}

/// Orders are messages of the other direction, and are passed over here.
fn read(recording: &Recording, path: &Path) -> Vec<(Duration, Event)> {
    let mut events = Vec::new();
    let mut start = None;
    for message in recording.messages() {
        let recorded = match message {
            Ok(recorded) => recorded,
            Err(damage) => {
                tracing::warn!("{}: {damage}", path.display());
                continue;
            }
        };
        let Said::ByBridge(said) = recorded.said else {
            continue;
        };
        let at = Duration::from_nanos(recorded.nanos);
        let start = *start.get_or_insert(at);
        events.extend(event(said).map(|event| (at.saturating_sub(start), event)));
    }
    events
}

/// The event that the message was made of; none for news of the bridge itself.
fn event(said: FromBridge) -> Option<Event> {
    Some(match said {
        FromBridge::Odometry(body) => Event::Odometry(body.odometry().ok()?),
        FromBridge::Scan(body) => Event::Scan(body.scan().ok()?),
        FromBridge::Rangers(body) => Event::Rangers {
            stamp: Stamp(body.stamp),
            readings: body.readings,
        },
        FromBridge::Bumpers(body) => Event::Bumpers {
            stamp: Stamp(body.stamp),
            left: body.left,
            right: body.right,
        },
        FromBridge::Battery(body) => Event::Battery {
            stamp: Stamp(body.stamp),
            volts: body.volts,
        },
        FromBridge::Currents(body) => Event::Currents {
            stamp: Stamp(body.stamp),
            left: body.left,
            right: body.right,
        },
        FromBridge::Link(body) => Event::Link(Link {
            state: body.state,
            round_trip: body
                .round_trip
                .and_then(|s| Duration::try_from_secs_f32(s).ok()),
            damaged: body.damaged,
            skipped: body.skipped,
        }),
        _ => return None,
    })
}

impl Source for ReplaySource {
    fn profile(&self) -> Profile {
        Profile {
            name: self.name.clone(),
            robot: None,
            scans_on_command: false,
        }
    }

    fn run(self: Box<Self>, port: Port) {
        let device = |state, detail: &str| Event::Device {
            state,
            model: "recording".into(),
            detail: detail.into(),
        };
        port.send(device(DeviceState::Sending, ""));
        let start = Instant::now();
        for (at, event) in self.events {
            loop {
                let left = (start + at).saturating_duration_since(Instant::now());
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
