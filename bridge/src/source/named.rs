//! Sources by their names on the command line.

use std::fmt;
use std::path::Path;
use std::str::FromStr;

use slamlab_core::geom::Pose2;
use slamlab_core::wire::revolution::RevolutionConfig;
use slamlab_core::wire::rplidar::driver::{DriverConfig, ScanMode};

use super::Source;
use super::replay::{ReplayError, ReplaySource};
use super::sim::{SimSource, SimSourceError};
use crate::serial::{Ld06, Rp6, Rplidar, SerialSource};

/// Why a source cannot be had.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SourceError {
    /// There is no such kind.
    #[error(
        "there is no source `{0}`; expected sim:WORLD[,SENSOR], replay:FILE, rp6:PORT, rplidar:PORT, rplidar-express:PORT or ld06:PORT"
    )]
    Unknown(String),
    /// It knows itself where its sensor sits.
    #[error(
        "{0} takes no mount: only a lidar at a serial port does, for nothing else tells where it sits"
    )]
    Mount(String),
    /// The simulated robot.
    #[error(transparent)]
    Sim(#[from] SimSourceError),
    /// The recording.
    #[error(transparent)]
    Replay(#[from] ReplayError),
}

/// A source that was named and not opened yet.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(try_from = "String", into = "String")]
pub enum SourceName {
    /// `sim:WORLD` or `sim:WORLD,SENSOR`.
    Sim(String),
    /// `replay:FILE`.
    Replay(String),
    /// `rp6:PORT`.
    Rp6(String),
    /// `rplidar:PORT`, or `rplidar-express:PORT` for capsules.
    Rplidar(String, ScanMode),
    /// `ld06:PORT`; an LD19 too.
    Ld06(String),
}

impl FromStr for SourceName {
    type Err = SourceError;

    fn from_str(name: &str) -> Result<Self, SourceError> {
        match name.split_once(':') {
            Some(("sim", world)) => Ok(Self::Sim(world.to_owned())),
            Some(("replay", file)) => Ok(Self::Replay(file.to_owned())),
            Some(("rp6", port)) if !port.is_empty() => Ok(Self::Rp6(port.to_owned())),
            Some(("rplidar", port)) if !port.is_empty() => {
                Ok(Self::Rplidar(port.to_owned(), ScanMode::Standard))
            }
            Some(("rplidar-express", port)) if !port.is_empty() => {
                Ok(Self::Rplidar(port.to_owned(), ScanMode::Express))
            }
            Some(("ld06", port)) if !port.is_empty() => Ok(Self::Ld06(port.to_owned())),
            _ => Err(SourceError::Unknown(name.to_owned())),
        }
    }
}

impl fmt::Display for SourceName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (kind, which) = match self {
            Self::Sim(world) => ("sim", world),
            Self::Replay(file) => ("replay", file),
            Self::Rp6(port) => ("rp6", port),
            Self::Rplidar(port, ScanMode::Standard) => ("rplidar", port),
            Self::Rplidar(port, ScanMode::Express) => ("rplidar-express", port),
            Self::Ld06(port) => ("ld06", port),
        };
        write!(f, "{kind}:{which}")
    }
}

impl TryFrom<String> for SourceName {
    type Error = SourceError;

    fn try_from(name: String) -> Result<Self, SourceError> {
        name.parse()
    }
}

impl From<SourceName> for String {
    fn from(name: SourceName) -> Self {
        name.to_string()
    }
}

impl SourceName {
    /// Opens it. A serial port need not be there yet: its source waits for it. A lidar sits at `mount` on the robot, or in
    /// its middle, looking ahead.
    ///
    /// # Errors    [`SourceError`]: what is not there, or cannot be read, or is no lidar and has a `mount`.
    pub fn open(&self, mount: Option<Pose2>) -> Result<Box<dyn Source>, SourceError> {
        let is_lidar = matches!(self, Self::Rplidar(..) | Self::Ld06(_));
        if mount.is_some() && !is_lidar {
            return Err(SourceError::Mount(self.to_string()));
        }
        let robot_from_sensor = mount.unwrap_or_else(Pose2::identity);
        Ok(match self {
            Self::Sim(world) => Box::new(SimSource::new(world)?),
            Self::Replay(file) => Box::new(ReplaySource::open(Path::new(file))?),
            Self::Rp6(port) => Box::new(SerialSource::new(Rp6::new(self.to_string()), port)),
            Self::Rplidar(port, mode) => {
                let config = DriverConfig {
                    mode: *mode,
                    revolution: RevolutionConfig {
                        robot_from_sensor,
                        ..RevolutionConfig::rplidar()
                    },
                    ..DriverConfig::default()
                };
                let lidar = Rplidar::new(self.to_string(), config);
                Box::new(SerialSource::new(lidar, port))
            }
            Self::Ld06(port) => {
                let config = RevolutionConfig {
                    robot_from_sensor,
                    ..RevolutionConfig::ld06()
                };
                let lidar = Ld06::new(self.to_string(), config);
                Box::new(SerialSource::new(lidar, port))
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_kind_has_its_name_and_others_are_refused() {
        let port = || "/dev/serial0".to_owned();
        for (name, expected) in [
            ("sim:arena", SourceName::Sim("arena".into())),
            ("rp6:/dev/serial0", SourceName::Rp6(port())),
            (
                "rplidar:/dev/serial0",
                SourceName::Rplidar(port(), ScanMode::Standard),
            ),
            (
                "rplidar-express:/dev/serial0",
                SourceName::Rplidar(port(), ScanMode::Express),
            ),
            ("ld06:/dev/serial0", SourceName::Ld06(port())),
        ] {
            assert_eq!(name.parse::<SourceName>().unwrap(), expected);
            assert_eq!(expected.to_string(), name);
        }
        for wrong in ["rp6", "rp6:", "lidar:/dev/serial0", ""] {
            let error = wrong.parse::<SourceName>().unwrap_err().to_string();
            assert!(error.contains("expected sim:WORLD"), "{error}");
        }
    }
}
