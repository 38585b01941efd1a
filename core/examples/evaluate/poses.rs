//! Poses from a file beside a log: its odometry, or the truth that its run is compared with.

use std::path::Path;

use anyhow::{Context, Result};
use serde_json::{Value, json};
use slamlab_core::format::poses::read_poses;
use slamlab_core::replay::{Log, PoseTrack, PosedLog, Replay};

use crate::Arguments;

/// What poses are.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum PosesAs {
    Odometry,
    Truth,
}

/// Poses of a file, and what they are.
pub(crate) struct Poses {
    track: PoseTrack,
    are: PosesAs,
    name: String,
}

impl Poses {
    pub(crate) fn read(arguments: &Arguments) -> Result<Option<Self>> {
        let given = arguments.poses.as_deref().zip(arguments.poses_as);
        given.map(|(path, are)| Self::of(path, are)).transpose()
    }

    fn of(path: &Path, are: PosesAs) -> Result<Self> {
        let name = format!("poses {}", path.display());
        let bytes = std::fs::read(path).with_context(|| name.clone())?;
        let file = read_poses(&bytes).with_context(|| name.clone())?;
        if file.repeated > 0 {
            let count = file.repeated;
            eprintln!("{name}: {count} poses were left out, for another one has the same time");
        }
        let track = file.into();
        Ok(Self { track, are, name })
    }

    /// The log with these poses as its odometry, if that is what they are.
    pub(crate) fn drive(&self, log: Log) -> Result<Log> {
        match self.are {
            PosesAs::Truth => Ok(log),
            PosesAs::Odometry => {
                let figures = log.settings().log;
                let posed = PosedLog::new(log, self.track.clone(), &figures);
                Ok(posed.with_context(|| self.name.clone())?.into())
            }
        }
    }

    /// Compares the run with these poses, if they are the truth.
    pub(crate) fn hold(&self, replay: &mut Replay) -> Result<()> {
        if self.are == PosesAs::Truth {
            let note = replay.set_truth(self.track.clone());
            if let Some(note) = note.with_context(|| self.name.clone())? {
                eprintln!("{}: {note}", self.name);
            }
        }
        Ok(())
    }
}

/// Errors of a run against the truth; null without one.
pub(crate) fn figures(replay: &Replay) -> Value {
    let Some(errors) = replay.truth_errors() else {
        return Value::Null;
    };
    let squares: f64 = errors.poses.iter().map(|e| e.heading * e.heading).sum();
    let count = errors.poses.len();
    json!({
        "count": count,
        "left_out": errors.left_out,
        "ate_rmse_m": errors.rmse,
        "ate_max_m": errors.max,
        "heading_rmse_deg": (squares / count as f64).sqrt().to_degrees(),
    })
}
