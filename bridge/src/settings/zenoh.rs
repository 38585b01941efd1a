//! The settings of a Zenoh router, and of ROS 2 behind it.

use std::path::PathBuf;

use clap::Args;
use serde::{Deserialize, Serialize};

use super::{Settings, SettingsError};
use crate::rights::Name;
use crate::zenoh::{Endpoint, RosConfig, ZenohConfig};

/// Highest `ROS_DOMAIN_ID`: higher ones have no ports in DDS, and the tools refuse them.
const LAST_DOMAIN: u16 = 232;

/// `[zenoh]`: where it stands, the robot is reached through a router, too.
#[derive(Clone, Debug, Default, PartialEq, Args, Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub struct ZenohSettings {
    /// Reach the robot through this Zenoh router, too; needs a program that was built with it
    #[arg(
        id = "zenoh",
        long = "zenoh",
        value_name = "tcp/HOST:PORT or tls/HOST:PORT"
    )]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub router: Option<Endpoint>,
    /// What the robot is called there [default: the name of this machine]
    #[arg(id = "zenoh-name", long = "zenoh-name", value_name = "NAME")]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub name: Option<Name>,
    /// Certificate of the authority that signed the router's, PEM; tls/ needs it
    #[arg(id = "zenoh-ca", long = "zenoh-ca", value_name = "FILE")]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ca: Option<PathBuf>,
    /// Certificate that the bridge shows to the router, PEM
    #[arg(id = "zenoh-cert", long = "zenoh-cert", value_name = "FILE")]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cert: Option<PathBuf>,
    /// Its private key, PEM
    #[arg(id = "zenoh-key", long = "zenoh-key", value_name = "FILE")]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub key: Option<PathBuf>,
    /// Be a node of ROS 2 in this domain, for tools that speak rmw_zenoh
    #[arg(long, value_name = "NUMBER")]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ros_domain: Option<u16>,
    /// Before the names of its topics and services
    #[arg(long, value_name = "NAME")]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ros_namespace: Option<String>,
    /// The driver's right by which /cmd_vel drives, made for that with `token add`
    #[arg(long, value_name = "NAME")]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ros_right: Option<Name>,
}

impl ZenohSettings {
    /// These settings, completed by those of `below`.
    #[must_use]
    pub fn over(self, below: Self) -> Self {
        Self {
            router: self.router.or(below.router),
            name: self.name.or(below.name),
            ca: self.ca.or(below.ca),
            cert: self.cert.or(below.cert),
            key: self.key.or(below.key),
            ros_domain: self.ros_domain.or(below.ros_domain),
            ros_namespace: self.ros_namespace.or(below.ros_namespace),
            ros_right: self.ros_right.or(below.ros_right),
        }
    }

    pub(super) fn complete(self, is_private: bool) -> Result<Self, SettingsError> {
        let config = self.config()?;
        if is_private && config.identity.is_none() {
            return Err(SettingsError::ZenohPrivate);
        }
        Ok(Self {
            name: Some(config.name),
            ..self
        })
    }

    /// How the bridge is reached through a router.
    ///
    /// # Errors    [`SettingsError`]: settings that are missing, or contradict each other.
    pub fn config(&self) -> Result<ZenohConfig, SettingsError> {
        let missing = |key, why| SettingsError::Zenoh { key, why };
        let router = self.router.clone();
        let router = router.ok_or(missing("router", "is missing: which router?"))?;
        if !router.is_tls && (self.ca.is_some() || self.cert.is_some() || self.key.is_some()) {
            let why = "is tcp/, which shows and checks no certificate: expected tls/HOST:PORT";
            return Err(missing("router", why));
        }
        if router.is_tls && self.ca.is_none() {
            let why = "is missing: by what is a router of tls/ known?";
            return Err(missing("ca", why));
        }
        let identity = match (self.cert.clone(), self.key.clone()) {
            (None, None) => None,
            (Some(cert), Some(key)) => Some((cert, key)),
            (Some(_), None) => return Err(missing("key", "is missing: it belongs to cert")),
            (None, Some(_)) => return Err(missing("cert", "is missing: it belongs to key")),
        };
        Ok(ZenohConfig {
            router,
            name: self.robot_name()?,
            ca: self.ca.clone(),
            identity,
            ros: self.ros()?,
        })
    }

    fn robot_name(&self) -> Result<Name, SettingsError> {
        let machine = || {
            let name = gethostname::gethostname().to_string_lossy().into_owned();
            name.split('.').next().and_then(|first| first.parse().ok())
        };
        let why = "is missing, and this machine's name cannot be one: expected letters, digits, `.`, `-` and `_`";
        let name = self.name.clone().or_else(machine);
        name.ok_or(SettingsError::Zenoh { key: "name", why })
    }

    fn ros(&self) -> Result<Option<RosConfig>, SettingsError> {
        let wrong = |key, why| Err(SettingsError::Zenoh { key, why });
        let Some(domain) = self.ros_domain else {
            return match (&self.ros_namespace, &self.ros_right) {
                (None, None) => Ok(None),
                _ => wrong("ros-domain", "is missing: in which domain of ROS 2?"),
            };
        };
        if domain > LAST_DOMAIN {
            return wrong("ros-domain", "is too high: expected 0 to 232");
        }
        if (self.ros_namespace.as_deref()).is_some_and(|name| !is_namespace(name)) {
            let why = "is none: expected words of ASCII letters, digits and `_`, `/` between them, none of which begins with a digit";
            return wrong("ros-namespace", why);
        }
        Ok(Some(RosConfig {
            domain: domain as u8,
            namespace: self.ros_namespace.clone(),
            right: self.ros_right.clone(),
        }))
    }
}

/// # Source    ROS 2 design, "Topic and Service name mapping to DDS".
fn is_namespace(text: &str) -> bool {
    let is_inside = |c: char| c.is_ascii_alphanumeric() || c == '_';
    text.split('/').all(|word| {
        let begins = word
            .chars()
            .next()
            .is_some_and(|first| !first.is_ascii_digit());
        begins && word.chars().all(is_inside) && !word.contains("__")
    })
}

impl Settings {
    /// Whether and how the bridge is reached through a router.
    ///
    /// # Errors    [`SettingsError`].
    pub fn zenoh(&self) -> Result<Option<ZenohConfig>, SettingsError> {
        self.zenoh.as_ref().map(ZenohSettings::config).transpose()
    }
}
