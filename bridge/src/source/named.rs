//! Sources by their names on the command line.

use std::path::Path;
use std::str::FromStr;

use super::Source;
use super::replay::{ReplayError, ReplaySource};
use super::sim::{SimSource, SimSourceError};

/// Why a source cannot be had.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SourceError {
    /// There is no such kind.
    #[error("there is no source `{0}`; expected sim:WORLD or replay:FILE")]
    Unknown(String),
    /// The simulated robot.
    #[error(transparent)]
    Sim(#[from] SimSourceError),
    /// The recording.
    #[error(transparent)]
    Replay(#[from] ReplayError),
}

/// A source that was named and not opened yet.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum SourceName {
    /// `sim:WORLD`.
    Sim(String),
    /// `replay:FILE`.
    Replay(String),
}

impl FromStr for SourceName {
    type Err = SourceError;

    fn from_str(name: &str) -> Result<Self, SourceError> {
        match name.split_once(':') {
            Some(("sim", world)) => Ok(Self::Sim(world.to_owned())),
            Some(("replay", file)) => Ok(Self::Replay(file.to_owned())),
            _ => Err(SourceError::Unknown(name.to_owned())),
        }
    }
}

impl SourceName {
    /// Opens it.
    ///
    /// # Errors    [`SourceError`]: what is not there, or cannot be read.
    pub fn open(&self) -> Result<Box<dyn Source>, SourceError> {
        Ok(match self {
            Self::Sim(world) => Box::new(SimSource::new(world)?),
            Self::Replay(file) => Box::new(ReplaySource::open(Path::new(file))?),
        })
    }
}
