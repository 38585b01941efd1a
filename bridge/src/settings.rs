//! The settings of `serve`: on the command line, and in a file, `bridge.toml`. Both have the same
//! settings.
//!
//! In: the text of the file, and what the command line says. Out: complete [`Settings`].
//!
//! 1. [`Settings::read`] reads a file; an unknown key or an invalid value is named with its line.
//! 2. [`Settings::over`] puts one above another: the command line wins, key by key.
//! 3. [`Settings::complete`] fills in the defaults. `slamlab-bridge config` prints the result.
//!
//! `bridge/deploy/bridge.toml` is the file that the package installs: it has every key, with its
//! meaning.

mod map;
mod recording;
mod storage;
mod zenoh;

use std::io;
use std::net::{IpAddr, Ipv4Addr, SocketAddr};
use std::path::{Path, PathBuf};
use std::str::FromStr;

use clap::Args;
use serde::{Deserialize, Serialize};
use slamlab_core::geom::Pose2;
use slamlab_core::slam::UnknownMethod;

use crate::host;
use crate::source::{self, Source, SourceError, SourceName};
use crate::storage::StorageError;
pub use map::{Failsafe, MapSettings};
pub use storage::StorageSettings;
pub use zenoh::ZenohSettings;

/// The default address: this machine only.
pub const LOCAL: SocketAddr = SocketAddr::new(IpAddr::V4(Ipv4Addr::LOCALHOST), 8080);

/// What a file or a command line says; nothing where it says nothing.
#[derive(Clone, Debug, Default, PartialEq, Args, Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct Settings {
    /// Address to listen on; 0.0.0.0 opens the page to the whole network [default: 127.0.0.1:8080]
    #[arg(long, value_name = "IP:PORT")]
    pub listen: Option<SocketAddr>,
    /// Port to listen on, in place of the one in `listen`; 0 takes any free one
    #[arg(long)]
    pub port: Option<u16>,
    /// Folder of the built page [default: the page inside the program, else www/dist]
    #[arg(long, value_name = "DIR")]
    pub page: Option<PathBuf>,
    /// Show the page in the default browser
    #[arg(long, num_args = 0..=1, require_equals = true, default_missing_value = "true", value_name = "BOOL")]
    pub open: Option<bool>,
    #[allow(missing_docs, reason = "its help names the kinds that there are")]
    #[arg(long, value_name = "KIND:WHICH", help = source_help())]
    pub source: Option<Vec<SourceSettings>>,
    /// Record to this new MCAP file, or to one named by the time of day in this folder
    #[arg(long, value_name = "FILE or DIR/")]
    pub record: Option<PathBuf>,
    /// A file in that folder ends at so many MiB, and another begins [default: 512]
    #[arg(long, value_name = "MIB")]
    pub record_piece_mib: Option<u64>,
    /// Or when it is so old, minutes [default: 60]
    #[arg(long, value_name = "MINUTES")]
    pub record_piece_minutes: Option<u64>,
    /// Delete the oldest recordings in that folder when all have more MiB [default: 8192]
    #[arg(long, value_name = "MIB")]
    pub record_budget_mib: Option<u64>,
    /// Write down who drove, stopped the robot and was refused, into files in this folder
    #[arg(long, value_name = "DIR")]
    pub audit: Option<PathBuf>,
    /// Delete the oldest of these files when all have more MiB [default: 64]
    #[arg(long, value_name = "MIB")]
    pub audit_budget_mib: Option<u64>,
    /// Let nobody watch without a token
    #[arg(long, num_args = 0..=1, require_equals = true, default_missing_value = "true", value_name = "BOOL")]
    pub private: Option<bool>,
    /// Origin of another page that may connect, as a browser writes it; may stand more than once
    #[arg(long, value_name = "ORIGIN")]
    pub allow_origin: Option<Vec<String>>,
    /// Name that the bridge answers to beside its own, of a reverse proxy or in a VPN; may stand
    /// more than once
    #[arg(long, value_name = "NAME")]
    pub allow_host: Option<Vec<String>>,
    /// Let Foxglove and Lichtblick watch, at ws://HOST:PORT/foxglove; their web pages need an
    /// --allow-origin too
    #[arg(long, num_args = 0..=1, require_equals = true, default_missing_value = "true", value_name = "BOOL")]
    pub foxglove: Option<bool>,
    /// Speak rosbridge, at ws://HOST:PORT/rosbridge
    #[arg(long, num_args = 0..=1, require_equals = true, default_missing_value = "true", value_name = "BOOL")]
    pub rosbridge: Option<bool>,
    /// Announce the bridge in the local network [default: unless it listens on this machine only]
    #[arg(long, num_args = 0..=1, require_equals = true, default_missing_value = "true", value_name = "BOOL")]
    pub mdns: Option<bool>,
    /// File of the owner's token [default: slamlab/token in the user's configuration]; all other
    /// rights stand in rights.toml beside it
    #[arg(long, value_name = "FILE")]
    pub token_file: Option<PathBuf>,
    /// Speak TLS; with a certificate of its own, beside the token, where none is named
    #[arg(long, num_args = 0..=1, require_equals = true, default_missing_value = "true", value_name = "BOOL")]
    pub tls: Option<bool>,
    /// Certificate chain to speak TLS with, PEM
    #[arg(long, value_name = "FILE")]
    pub tls_cert: Option<PathBuf>,
    /// Its private key, PEM
    #[arg(long, value_name = "FILE")]
    pub tls_key: Option<PathBuf>,
    /// Where finished recordings are kept, too; only in the file.
    #[arg(skip)]
    pub storage: Option<StorageSettings>,
    /// Whether and how the bridge maps; the command line has flags of its own for it.
    #[arg(skip)]
    pub map: Option<MapSettings>,
    /// Whether and how the robot is reached through a Zenoh router.
    #[command(flatten)]
    pub zenoh: Option<ZenohSettings>,
}

/// The help of `--source`.
#[must_use]
pub fn source_help() -> String {
    let forms = source::forms();
    format!("Robot or sensor: {forms}; may stand more than once; hides those of the file")
}

/// A robot or a sensor, and where it sits.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(
    deny_unknown_fields,
    rename_all = "kebab-case",
    expecting = "[[source]] on a line of its own for each, and below it name = \"KIND:WHICH\""
)]
pub struct SourceSettings {
    /// As on the command line: `rplidar:/dev/rplidar`.
    pub name: SourceName,
    /// Where a lidar sits on the robot. Default: in its middle, looking ahead.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mount: Option<Mount>,
}

/// Where a sensor sits: the origin between the driven wheels, x ahead, y to the left.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct Mount {
    /// Ahead of the middle, m.
    #[serde(default)]
    pub x: f64,
    /// Left of the middle, m.
    #[serde(default)]
    pub y: f64,
    /// Direction of the sensor's zero, degrees: 0 ahead, 90 to the left.
    #[serde(default)]
    pub yaw_degrees: f64,
}

/// Farthest that a sensor can sit from the middle of a robot that this bridge drives, m.
const FARTHEST: f64 = 2.0;

/// Why the settings cannot be used.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SettingsError {
    /// The file cannot be read.
    #[error("settings {}: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// The file does not hold settings.
    #[error("settings {}, {}", path.display(), said.trim_end())]
    Text {
        /// The file.
        path: PathBuf,
        /// Line, column, and what is wrong there.
        said: String,
    },
    /// Only one of certificate and key is given.
    #[error("tls-cert and tls-key belong together; {missing} is missing")]
    HalfTls {
        /// Which.
        missing: &'static str,
    },
    /// A number for recordings is out of range.
    #[error("{key} is {value}; expected 1 to {}", recording::MOST)]
    Recording {
        /// Which.
        key: &'static str,
        /// The given value.
        value: u64,
    },
    /// The budget has no room for two pieces, a finished one and the one being written.
    #[error(
        "record-budget-mib is {budget} and record-piece-mib {piece}; expected room for two pieces at least"
    )]
    Budget {
        /// MiB of all.
        budget: u64,
        /// MiB of a piece.
        piece: u64,
    },
    /// No browser writes this as an origin.
    #[error(
        "allow-origin {given:?}: {why}; expected an origin as a browser writes it, such as https://lab.example or \
         http://192.168.1.7:3000"
    )]
    Origin {
        /// The given value.
        given: String,
        /// What is wrong.
        why: &'static str,
    },
    /// No browser asks for such a host.
    #[error(
        "allow-host {given:?}: {why}; expected a name such as robot.example.com, as it stands in the page's address"
    )]
    Host {
        /// The given value.
        given: String,
        /// What is wrong.
        why: &'static str,
    },
    /// The path of a file or folder is empty.
    #[error("{key} is empty; expected a path, or leave it out")]
    EmptyPath {
        /// Which.
        key: &'static str,
    },
    /// A setting has no effect, so it must be a mistake.
    #[error("{key} does nothing: {why}")]
    Idle {
        /// Which.
        key: &'static str,
        /// Why.
        why: &'static str,
    },
    /// There is no such method.
    #[error("map method: {0}")]
    MapMethod(#[from] UnknownMethod),
    /// A time is out of range.
    #[error("map save-seconds is {value}; expected 1 to {most}")]
    MapSave {
        /// The given value.
        value: u64,
        /// Greatest valid value.
        most: u64,
    },
    /// The robot may go home, but no right is named for it.
    #[error(
        "a robot that goes home drives by a right that was given for it: name it as failsafe-right, and make it with \
         `slamlab-bridge token add NAME --role driver`"
    )]
    NoFailsafeRight,
    /// A setting for the Zenoh router is missing or invalid.
    #[error("zenoh {key} {why}")]
    Zenoh {
        /// Which.
        key: &'static str,
        /// What is wrong with it.
        why: &'static str,
    },
    /// Watching needs a token, but everybody at the router could watch.
    #[error(
        "private lets nobody watch without a token, and a router shows the robot to whoever it lets in: name a router at \
         tls/, with a certificate (zenoh cert and key), that asks for those of all others"
    )]
    ZenohPrivate,
    /// The battery voltage is out of range.
    #[error("low-volts is {value}; expected {least} to {most}")]
    LowVolts {
        /// The given value.
        value: f32,
        /// Least valid value.
        least: f32,
        /// Greatest.
        most: f32,
    },
    /// The part's size is out of range: stores refuse it, or too much is lost when the link breaks.
    #[error("storage part-mib is {value}; expected {least} to {most}")]
    StoragePart {
        /// The given value.
        value: u64,
        /// Least valid value.
        least: u64,
        /// Greatest.
        most: u64,
    },
    /// The store cannot be used.
    #[error(transparent)]
    Storage(#[from] StorageError),
    /// The mount is at a place where no sensor can be.
    #[error(
        "mount of {name}: {key} is {value}; expected a number of at most {most} to either side"
    )]
    Mount {
        /// The source.
        name: String,
        /// Which number.
        key: &'static str,
        /// The given value.
        value: f64,
        /// Greatest valid value.
        most: f64,
    },
}

/// Whether and with which certificate TLS is used.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Tls {
    /// Not at all.
    Off,
    /// With a certificate of the bridge's own, made if there is none.
    Own,
    /// With a certificate that somebody else made.
    Files {
        /// Certificate chain, PEM.
        cert: PathBuf,
        /// Private key, PEM.
        key: PathBuf,
    },
}

impl Settings {
    /// Reads a file.
    ///
    /// # Errors    [`SettingsError`]: the file cannot be read, or has an invalid line, which the
    /// error names.
    pub fn read(path: &Path) -> Result<Self, SettingsError> {
        let text = std::fs::read_to_string(path).map_err(|source| SettingsError::Io {
            path: path.to_owned(),
            source,
        })?;
        toml::from_str(&text).map_err(|error| SettingsError::Text {
            path: path.to_owned(),
            said: error.to_string(),
        })
    }

    /// These settings, completed by those of `below`. `listen` also hides a `port` below it.
    #[must_use]
    pub fn over(self, below: Self) -> Self {
        let port_below = below.port.filter(|_| self.listen.is_none());
        // Naming a certificate switches TLS on.
        let names_tls = self.tls_cert.is_some() || self.tls_key.is_some();
        let tls_below = below.tls.filter(|_| !names_tls);
        Self {
            listen: self.listen.or(below.listen),
            port: self.port.or(port_below),
            page: self.page.or(below.page),
            open: self.open.or(below.open),
            source: self.source.or(below.source),
            record: self.record.or(below.record),
            record_piece_mib: self.record_piece_mib.or(below.record_piece_mib),
            record_piece_minutes: self.record_piece_minutes.or(below.record_piece_minutes),
            record_budget_mib: self.record_budget_mib.or(below.record_budget_mib),
            audit: self.audit.or(below.audit),
            audit_budget_mib: self.audit_budget_mib.or(below.audit_budget_mib),
            private: self.private.or(below.private),
            allow_origin: self.allow_origin.or(below.allow_origin),
            allow_host: self.allow_host.or(below.allow_host),
            foxglove: self.foxglove.or(below.foxglove),
            rosbridge: self.rosbridge.or(below.rosbridge),
            mdns: self.mdns.or(below.mdns),
            token_file: self.token_file.or(below.token_file),
            tls: self.tls.or(tls_below),
            tls_cert: self.tls_cert.or(below.tls_cert),
            tls_key: self.tls_key.or(below.tls_key),
            storage: self.storage.or(below.storage),
            map: match (self.map, below.map) {
                (Some(above), Some(below)) => Some(above.over(below)),
                (above, below) => above.or(below),
            },
            zenoh: match (self.zenoh, below.zenoh) {
                (Some(above), Some(below)) => Some(above.over(below)),
                (above, below) => above.or(below),
            },
        }
    }

    /// Fills in each default; files and folders without a default stay unset.
    ///
    /// # Errors    [`SettingsError`]: settings that contradict each other.
    pub fn complete(self) -> Result<Self, SettingsError> {
        let listen = self.address();
        self.source
            .iter()
            .flatten()
            .try_for_each(SourceSettings::check)?;
        self.allow_origin.iter().flatten().try_for_each(|given| {
            host::check_origin(given).map_err(|why| SettingsError::Origin {
                given: given.clone(),
                why,
            })
        })?;
        self.allow_host.iter().flatten().try_for_each(|given| {
            host::check_host(given).map_err(|why| SettingsError::Host {
                given: given.clone(),
                why,
            })
        })?;
        self.check_paths()?;
        if self.private == Some(true) && self.foxglove == Some(true) {
            let why = "private lets nobody watch without a token, and Foxglove has none";
            return Err(SettingsError::Idle {
                key: "foxglove",
                why,
            });
        }
        self.check_recording()?;
        self.storage()?;
        let map = self.map.clone().map(MapSettings::complete).transpose()?;
        let is_private = self.private == Some(true);
        let zenoh = self.zenoh.clone();
        let zenoh = zenoh.map(|zenoh| zenoh.complete(is_private)).transpose()?;
        let tls = self.tls()?;
        let (tls_cert, tls_key) = match &tls {
            Tls::Files { cert, key } => (Some(cert.clone()), Some(key.clone())),
            Tls::Off | Tls::Own => (None, None),
        };
        let defaults = Self {
            open: Some(false),
            source: Some(vec![]),
            private: Some(false),
            allow_origin: Some(vec![]),
            allow_host: Some(vec![]),
            foxglove: Some(false),
            rosbridge: Some(false),
            mdns: Some(!listen.ip().is_loopback()),
            ..recording::defaults(self.record.as_deref(), self.audit.as_deref())
        };
        Ok(Self {
            listen: Some(listen),
            port: None,
            tls: Some(tls != Tls::Off),
            tls_cert,
            tls_key,
            map,
            zenoh,
            ..self.over(defaults)
        })
    }

    /// An empty path would mean the folder in which the bridge happened to be started.
    fn check_paths(&self) -> Result<(), SettingsError> {
        let map = self.map.as_ref().and_then(|map| map.file.as_ref());
        let zenoh = self.zenoh.as_ref();
        let all = [
            ("page", self.page.as_ref()),
            ("record", self.record.as_ref()),
            ("audit", self.audit.as_ref()),
            ("token-file", self.token_file.as_ref()),
            ("tls-cert", self.tls_cert.as_ref()),
            ("tls-key", self.tls_key.as_ref()),
            ("map file", map),
            ("zenoh ca", zenoh.and_then(|zenoh| zenoh.ca.as_ref())),
            ("zenoh cert", zenoh.and_then(|zenoh| zenoh.cert.as_ref())),
            ("zenoh key", zenoh.and_then(|zenoh| zenoh.key.as_ref())),
        ];
        let is_empty =
            |path: Option<&PathBuf>| path.is_some_and(|path| path.as_os_str().is_empty());
        match all.into_iter().find(|(_, path)| is_empty(*path)) {
            Some((key, _)) => Err(SettingsError::EmptyPath { key }),
            None => Ok(()),
        }
    }

    /// Where to listen.
    #[must_use]
    pub fn address(&self) -> SocketAddr {
        let mut listen = self.listen.unwrap_or(LOCAL);
        listen.set_port(self.port.unwrap_or(listen.port()));
        listen
    }

    /// Whether and with which certificate TLS is used; `tls = false` wins over certificate files.
    ///
    /// # Errors    [`SettingsError::HalfTls`].
    pub fn tls(&self) -> Result<Tls, SettingsError> {
        match (self.tls, &self.tls_cert, &self.tls_key) {
            (Some(false), ..) | (None, None, None) => Ok(Tls::Off),
            (Some(true), None, None) => Ok(Tls::Own),
            (_, Some(cert), Some(key)) => Ok(Tls::Files {
                cert: cert.clone(),
                key: key.clone(),
            }),
            (_, Some(_), None) => Err(SettingsError::HalfTls { missing: "tls-key" }),
            (_, None, Some(_)) => Err(SettingsError::HalfTls {
                missing: "tls-cert",
            }),
        }
    }
}

/// A source in the middle of the robot, as the command line names it.
impl FromStr for SourceSettings {
    type Err = SourceError;

    fn from_str(name: &str) -> Result<Self, SourceError> {
        let name = name.parse()?;
        Ok(Self { name, mount: None })
    }
}

impl SourceSettings {
    /// Opens it.
    ///
    /// # Errors    [`SourceError`]: the source does not exist, cannot be read, or cannot be
    /// mounted.
    pub fn open(&self) -> Result<Box<dyn Source>, SourceError> {
        self.name.open(self.mount.map(Mount::pose))
    }

    fn check(&self) -> Result<(), SettingsError> {
        let Some(Mount { x, y, yaw_degrees }) = self.mount else {
            return Ok(());
        };
        let figures = [
            ("x", x, FARTHEST),
            ("y", y, FARTHEST),
            ("yaw-degrees", yaw_degrees, 360.0),
        ];
        for (key, value, most) in figures {
            // NaN compares false with everything.
            if value.is_nan() || value.abs() > most {
                return Err(SettingsError::Mount {
                    name: self.name.to_string(),
                    key,
                    value,
                    most,
                });
            }
        }
        Ok(())
    }
}

impl Mount {
    /// Place of the sensor on the robot.
    #[must_use]
    pub fn pose(self) -> Pose2 {
        Pose2::new(self.x, self.y, self.yaw_degrees.to_radians())
    }
}

#[cfg(test)]
mod tests;
