//! `bridge.toml`: all that `serve` can be told, in a file.
//!
//! In: the text of the file, and what the command line says. Out: [`Settings`], and [`Effective`] ones with every default
//! filled in.
//!
//! 1. [`Settings::read`] reads a file; a key that is unknown, or a value that cannot be, is named with its line.
//! 2. [`Settings::over`] lays one above another: what the command line says wins, key by key.
//! 3. [`Settings::effective`] fills in what nobody said. `slamlab-bridge config` prints that.
//!
//! `bridge/deploy/bridge.toml` is the file that the package installs: every key stands in it, with its meaning.

use std::io;
use std::net::{IpAddr, Ipv4Addr, SocketAddr};
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use slamlab_core::geom::Pose2;

use crate::source::{Source, SourceError, SourceName};

/// Where the bridge listens unless it is told otherwise: on this machine only.
pub const LOCAL: SocketAddr = SocketAddr::new(IpAddr::V4(Ipv4Addr::LOCALHOST), 8080);

/// What a file or a command line says; nothing where it says nothing.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct Settings {
    /// Address to listen on. Default 127.0.0.1:8080; 0.0.0.0 opens the page to the whole network.
    pub listen: Option<SocketAddr>,
    /// Port in place of the one in `listen`.
    pub port: Option<u16>,
    /// Folder of the built page. Default: the page inside the program, else `www/dist`.
    pub page: Option<PathBuf>,
    /// Show the page in the default browser. Default no.
    pub open: Option<bool>,
    /// Let nobody watch without the token. Default no.
    pub private: Option<bool>,
    /// Let Foxglove watch, where anyone may. Default no.
    pub foxglove: Option<bool>,
    /// Speak rosbridge. Default no.
    pub rosbridge: Option<bool>,
    /// Origins of other pages that may connect. Default none.
    pub allow_origin: Option<Vec<String>>,
    /// File of the token. Default `slamlab/token` in the user's configuration.
    pub token_file: Option<PathBuf>,
    /// New file to record to, or folder that takes a new one at each start. Default: nothing is recorded.
    pub record: Option<PathBuf>,
    /// Speak TLS; without `tls-cert` with a certificate of its own, beside the token. Default no.
    pub tls: Option<bool>,
    /// Certificate chain to speak TLS with, PEM.
    pub tls_cert: Option<PathBuf>,
    /// Its private key, PEM.
    pub tls_key: Option<PathBuf>,
    /// Announce the bridge in the local network. Default: unless it listens on this machine only.
    pub mdns: Option<bool>,
    /// Robots and sensors. Default none.
    pub source: Option<Vec<SourceSettings>>,
}

/// A robot or a sensor, and where it sits.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
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

/// Farther from the middle no sensor sits on a robot that this bridge drives, m.
const FARTHEST: f64 = 2.0;

/// Why there are no settings.
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
    /// It does not hold settings.
    #[error("settings {}, {}", path.display(), said.trim_end())]
    Text {
        /// The file.
        path: PathBuf,
        /// Line, column, and what is wrong there.
        said: String,
    },
    /// One half of what TLS needs.
    #[error("tls-cert and tls-key belong together; {missing} is missing")]
    HalfTls {
        /// Which.
        missing: &'static str,
    },
    /// A place where no sensor is.
    #[error(
        "mount of {name}: {key} is {value}; expected a number of at most {most} to either side"
    )]
    Mount {
        /// The source.
        name: String,
        /// Which figure.
        key: &'static str,
        /// What stands there.
        value: f64,
        /// Greatest that may stand there.
        most: f64,
    },
}

/// Settings with nothing left open.
#[derive(Clone, Debug, PartialEq)]
pub struct Effective {
    /// Address to listen on.
    pub listen: SocketAddr,
    /// Folder of the page, where one was named.
    pub page: Option<PathBuf>,
    /// Show the page in the default browser.
    pub open: bool,
    /// Let nobody watch without the token.
    pub private: bool,
    /// Let Foxglove watch, where anyone may.
    pub foxglove: bool,
    /// Speak rosbridge.
    pub rosbridge: bool,
    /// Origins of other pages that may connect.
    pub allow_origin: Vec<String>,
    /// File of the token, where one was named.
    pub token_file: Option<PathBuf>,
    /// New file to record to, or folder that takes a new one at each start.
    pub record: Option<PathBuf>,
    /// How TLS is spoken.
    pub tls: Tls,
    /// Whether the bridge is announced in the local network.
    pub mdns: bool,
    /// Robots and sensors.
    pub source: Vec<SourceSettings>,
}

/// How TLS is spoken.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Tls {
    /// Not at all.
    Off,
    /// With a certificate of the bridge's own, made where there is none.
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
    /// # Errors    [`SettingsError`]: it cannot be read, or what stands in which line of it is no setting.
    pub fn read(path: &Path) -> Result<Self, SettingsError> {
        let text = std::fs::read_to_string(path).map_err(|source| SettingsError::Io {
            path: path.to_owned(),
            source,
        })?;
        let settings: Self = toml::from_str(&text).map_err(|error| SettingsError::Text {
            path: path.to_owned(),
            said: error.to_string(),
        })?;
        Ok(settings)
    }

    /// These settings, and those of `below` where these say nothing. `listen` also hides a `port` below it.
    #[must_use]
    pub fn over(self, below: Self) -> Self {
        let port_below = if self.listen.is_some() {
            None
        } else {
            below.port
        };
        // A certificate is named to be used.
        let tls_below = if self.tls_cert.is_some() || self.tls_key.is_some() {
            None
        } else {
            below.tls
        };
        Self {
            listen: self.listen.or(below.listen),
            port: self.port.or(port_below),
            page: self.page.or(below.page),
            open: self.open.or(below.open),
            private: self.private.or(below.private),
            foxglove: self.foxglove.or(below.foxglove),
            rosbridge: self.rosbridge.or(below.rosbridge),
            allow_origin: self.allow_origin.or(below.allow_origin),
            token_file: self.token_file.or(below.token_file),
            record: self.record.or(below.record),
            tls: self.tls.or(tls_below),
            tls_cert: self.tls_cert.or(below.tls_cert),
            tls_key: self.tls_key.or(below.tls_key),
            mdns: self.mdns.or(below.mdns),
            source: self.source.or(below.source),
        }
    }

    /// Fills in what nobody said.
    ///
    /// # Errors    [`SettingsError`]: settings that do not go together.
    pub fn effective(self) -> Result<Effective, SettingsError> {
        let mut listen = self.listen.unwrap_or(LOCAL);
        if let Some(port) = self.port {
            listen.set_port(port);
        }
        let source = self.source.unwrap_or_default();
        for source in &source {
            source.check()?;
        }
        Ok(Effective {
            listen,
            page: self.page,
            open: self.open.unwrap_or(false),
            private: self.private.unwrap_or(false),
            foxglove: self.foxglove.unwrap_or(false),
            rosbridge: self.rosbridge.unwrap_or(false),
            allow_origin: self.allow_origin.unwrap_or_default(),
            token_file: self.token_file,
            record: self.record,
            tls: tls(self.tls, self.tls_cert, self.tls_key)?,
            mdns: self.mdns.unwrap_or(!listen.ip().is_loopback()),
            source,
        })
    }
}

/// `tls = false` switches off what the files would switch on.
fn tls(
    is_on: Option<bool>,
    cert: Option<PathBuf>,
    key: Option<PathBuf>,
) -> Result<Tls, SettingsError> {
    match (is_on, cert, key) {
        (Some(false), ..) | (None, None, None) => Ok(Tls::Off),
        (Some(true), None, None) => Ok(Tls::Own),
        (_, Some(cert), Some(key)) => Ok(Tls::Files { cert, key }),
        (_, Some(_), None) => Err(SettingsError::HalfTls { missing: "tls-key" }),
        (_, None, Some(_)) => Err(SettingsError::HalfTls {
            missing: "tls-cert",
        }),
    }
}

impl Effective {
    /// As a file would say it, every key that has a value.
    ///
    /// # Errors    Where a path is no Unicode.
    pub fn to_toml(&self) -> Result<String, toml::ser::Error> {
        let (tls, tls_cert, tls_key) = match &self.tls {
            Tls::Off => (false, None, None),
            Tls::Own => (true, None, None),
            Tls::Files { cert, key } => (true, Some(cert.clone()), Some(key.clone())),
        };
        toml::to_string(&Settings {
            listen: Some(self.listen),
            port: None,
            page: self.page.clone(),
            open: Some(self.open),
            private: Some(self.private),
            foxglove: Some(self.foxglove),
            rosbridge: Some(self.rosbridge),
            allow_origin: Some(self.allow_origin.clone()),
            token_file: self.token_file.clone(),
            record: self.record.clone(),
            tls: Some(tls),
            tls_cert,
            tls_key,
            mdns: Some(self.mdns),
            source: Some(self.source.clone()),
        })
    }
}

impl SourceSettings {
    /// A source in the middle of the robot, as the command line names it.
    #[must_use]
    pub fn of(name: SourceName) -> Self {
        Self { name, mount: None }
    }

    /// Opens it.
    ///
    /// # Errors    [`SourceError`]: what is not there, or cannot be read, or cannot be mounted.
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
            // Not a number is no more than anything.
            if value.is_nan() || value.abs() > most {
                let name = self.name.to_string();
                return Err(SettingsError::Mount {
                    name,
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
