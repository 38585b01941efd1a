//! Sources by their names on the command line.

use std::fmt;
use std::path::Path;
use std::str::FromStr;

use slamlab_core::device::udp::UdpLidar;
use slamlab_core::device::{KINDS, Kind, Lidar, Role};
use slamlab_core::geom::Pose2;

use super::Source;
use super::replay::{ReplayError, ReplaySource};
use super::sim::{SimSource, SimSourceError};
use crate::serial::DeviceSource;
use crate::udp::{UdpAddress, UdpAddressError};

/// The forms that `--source` accepts, as a person types them.
#[must_use]
pub fn forms() -> String {
    let kinds = KINDS.map(|kind| format!("{}:PORT", kind.name));
    format!(
        "sim:WORLD[,SENSOR], replay:FILE, {}, udp:HOST[:PORT][/PATH]",
        kinds.join(", ")
    )
}

/// Why a source cannot be opened.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SourceError {
    /// There is no such kind.
    #[error("there is no source `{0}`; expected one of {forms}", forms = forms())]
    Unknown(String),
    /// The source takes no mount: it already knows where its sensor sits.
    #[error("{0} takes no mount: only a lidar does, for nothing else tells where it sits")]
    Mount(String),
    /// Something is wrong with the simulated robot.
    #[error(transparent)]
    Sim(#[from] SimSourceError),
    /// Something is wrong with the recording.
    #[error(transparent)]
    Replay(#[from] ReplayError),
    /// Something is wrong with the address of a lidar server.
    #[error(transparent)]
    Udp(#[from] UdpAddressError),
}

/// A source that is named but not opened yet.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(try_from = "String", into = "String")]
pub enum SourceName {
    /// `sim:WORLD` or `sim:WORLD,SENSOR`.
    Sim(String),
    /// `replay:FILE`.
    Replay(String),
    /// A device at a serial port: `rp6:PORT`.
    Serial(&'static Kind, String),
    /// A lidar behind a server of Pilch's protocol: `udp:HOST[:PORT][/PATH]`.
    Udp(UdpAddress),
}

impl FromStr for SourceName {
    type Err = SourceError;

    fn from_str(name: &str) -> Result<Self, SourceError> {
        let unknown = || SourceError::Unknown(name.to_owned());
        let (kind, which) = name.split_once(':').ok_or_else(unknown)?;
        match kind {
            "sim" => Ok(Self::Sim(which.to_owned())),
            "replay" => Ok(Self::Replay(which.to_owned())),
            "udp" => Ok(Self::Udp(UdpAddress::parse(which)?)),
            _ => Kind::named(kind)
                .filter(|_| !which.is_empty())
                .map(|kind| Self::Serial(kind, which.to_owned()))
                .ok_or_else(unknown),
        }
    }
}

impl fmt::Display for SourceName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Sim(world) => write!(f, "sim:{world}"),
            Self::Replay(file) => write!(f, "replay:{file}"),
            Self::Serial(kind, port) => write!(f, "{}:{port}", kind.name),
            Self::Udp(address) => write!(f, "udp:{address}"),
        }
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
    /// Opens it. A serial port need not exist yet: its source waits for it. A lidar sits at `mount`
    /// on the robot; without it, in the robot's middle, looking ahead.
    ///
    /// # Errors    [`SourceError`]: the source does not exist, cannot be read, or has a `mount` but
    /// is no lidar.
    pub fn open(&self, mount: Option<Pose2>) -> Result<Box<dyn Source>, SourceError> {
        let takes_mount = match self {
            Self::Serial(kind, _) => kind.role == Role::Lidar,
            Self::Udp(_) => true,
            Self::Sim(_) | Self::Replay(_) => false,
        };
        if mount.is_some() && !takes_mount {
            return Err(SourceError::Mount(self.to_string()));
        }
        let mount = mount.unwrap_or_else(Pose2::identity);
        Ok(match self {
            Self::Sim(world) => Box::new(SimSource::new(world)?),
            Self::Replay(file) => Box::new(ReplaySource::open(Path::new(file))?),
            Self::Serial(kind, port) => {
                let device = (kind.open)(self.to_string(), mount);
                Box::new(DeviceSource::at_port(device, port))
            }
            Self::Udp(address) => {
                let protocol = UdpLidar::new(&address.path);
                let lidar = Lidar::new(self.to_string(), protocol, mount);
                Box::new(DeviceSource::by_udp(Box::new(lidar), address.clone()))
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_kind_has_its_name_and_others_are_refused() {
        let sim: SourceName = "sim:arena".parse().unwrap();
        assert_eq!(sim, SourceName::Sim("arena".into()));
        for kind in &KINDS {
            let name = format!("{}:/dev/serial0", kind.name);
            let expected = SourceName::Serial(kind, "/dev/serial0".into());
            assert_eq!(name.parse::<SourceName>().unwrap(), expected);
            assert_eq!(expected.to_string(), name);
        }
        let udp: SourceName = "udp:pi.local/dev/rplidar".parse().unwrap();
        assert_eq!(udp.to_string(), "udp:pi.local:5000/dev/rplidar");
        assert_eq!(udp.to_string().parse::<SourceName>().unwrap(), udp);
        for wrong in ["rp6", "rp6:", "lidar:/dev/serial0", ""] {
            let error = wrong.parse::<SourceName>().unwrap_err().to_string();
            assert!(error.contains("expected one of sim:WORLD"), "{error}");
        }
    }
}
