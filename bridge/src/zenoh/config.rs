//! The configuration: which router, under which name, and with which certificates.
//!
//! In: a [`ZenohConfig`]. Out: the configuration of a session; wrong files are named before
//! anything moves.

use std::fmt;
use std::path::PathBuf;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

use crate::rights::Name;

/// How the bridge is reached through a Zenoh router.
#[derive(Clone, Debug, PartialEq)]
pub struct ZenohConfig {
    /// The router.
    pub router: Endpoint,
    /// The robot's name there: the second part of its keys.
    pub name: Name,
    /// Certificate of the authority that must have signed the router's certificate, PEM; TLS needs
    /// it.
    pub ca: Option<PathBuf>,
    /// Certificate chain and key that the bridge shows to the router, PEM.
    pub identity: Option<(PathBuf, PathBuf)>,
    /// Whether and how tools of ROS 2 see the robot.
    pub ros: Option<RosConfig>,
}

/// How tools of ROS 2 see the robot.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RosConfig {
    /// `ROS_DOMAIN_ID` of those tools.
    pub domain: u8,
    /// Prefix of the names of all topics; default none.
    pub namespace: Option<String>,
    /// The right by which `/cmd_vel` drives; without it nobody can drive that way.
    pub right: Option<Name>,
}

/// Where a router is: `tcp/HOST:PORT` or `tls/HOST:PORT`, as Zenoh writes it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(into = "String", try_from = "String")]
pub struct Endpoint {
    /// Whether it speaks TLS.
    pub is_tls: bool,
    /// Name or address; of IPv6 without brackets.
    pub host: String,
    /// Its port.
    pub port: u16,
}

/// The text is not the address of a router.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "{given:?} is no router's address: {why}; expected tcp/HOST:PORT or tls/HOST:PORT, such as tcp/192.168.1.7:7447"
)]
pub struct EndpointError {
    given: String,
    why: &'static str,
}

impl FromStr for Endpoint {
    type Err = EndpointError;

    fn from_str(text: &str) -> Result<Self, EndpointError> {
        let error = |why| EndpointError {
            given: text.to_owned(),
            why,
        };
        let (transport, place) = (text.split_once('/')).ok_or_else(|| error("it has no `/`"))?;
        let is_tls = match transport {
            "tcp" => false,
            "tls" => true,
            _ => return Err(error("its transport is neither tcp nor tls")),
        };
        let (host, port) = place
            .rsplit_once(':')
            .ok_or_else(|| error("it has no port"))?;
        let port = port.parse().ok().filter(|port| *port > 0);
        let port = port.ok_or_else(|| error("its port is no number from 1 to 65535"))?;
        let bare = host
            .strip_prefix('[')
            .and_then(|host| host.strip_suffix(']'));
        let is_host = |host: &str| {
            let is_inside = |c: char| c.is_ascii_alphanumeric() || ".-_".contains(c);
            !host.is_empty() && host.chars().all(is_inside)
        };
        let host = match bare {
            Some(bare) if bare.parse::<std::net::Ipv6Addr>().is_ok() => bare,
            None if is_host(host) => host,
            _ => return Err(error("its host is neither a name nor an address")),
        };
        Ok(Self {
            is_tls,
            host: host.to_owned(),
            port,
        })
    }
}

impl fmt::Display for Endpoint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (transport, port) = (if self.is_tls { "tls" } else { "tcp" }, self.port);
        match self.host.contains(':') {
            true => write!(f, "{transport}/[{}]:{port}", self.host),
            false => write!(f, "{transport}/{}:{port}", self.host),
        }
    }
}

impl TryFrom<String> for Endpoint {
    type Error = EndpointError;

    fn try_from(text: String) -> Result<Self, EndpointError> {
        text.parse()
    }
}

impl From<Endpoint> for String {
    fn from(endpoint: Endpoint) -> Self {
        endpoint.to_string()
    }
}

/// Why the bridge cannot be reached through a router.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ZenohError {
    /// This program was built without Zenoh.
    #[error(
        "this slamlab-bridge was built without Zenoh: build it with `--features zenoh`, or take [zenoh] out of the settings"
    )]
    NotBuilt,
    /// A file does not hold a certificate or key.
    #[error("zenoh {key} {}: {why}", path.display())]
    File {
        /// Which setting.
        key: &'static str,
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        why: String,
    },
    /// Nobody may drive by that right.
    #[error(
        "ros-right {right}: there is no such right that may drive; make it with `slamlab-bridge token add {right} --role driver`"
    )]
    NoRight {
        /// Its name.
        right: Name,
    },
    /// The system gave no thread.
    #[error("zenoh: no thread: {0}")]
    Thread(#[from] std::io::Error),
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_endpoint_is_written_as_it_was_read() {
        for text in [
            "tcp/192.168.1.7:7447",
            "tls/router.example:443",
            "tcp/[::1]:1",
        ] {
            assert_eq!(text.parse::<Endpoint>().unwrap().to_string(), text);
        }
        assert_eq!("tcp/[::1]:1".parse::<Endpoint>().unwrap().host, "::1");
    }

    #[test]
    fn what_is_no_endpoint_is_told_what_is_wrong_with_it() {
        let check = |text: &str, why: &str| {
            let said = text.parse::<Endpoint>().unwrap_err().to_string();
            assert!(said.contains(why), "{text}: {said}");
        };
        check("", "no `/`");
        check("router:7447", "no `/`");
        check("quic/router:7447", "neither tcp nor tls");
        check("tcp/router", "no port");
        check("tcp/router:0", "no number from 1");
        check("tcp/router:70000", "no number from 1");
        check("tcp/:7447", "neither a name");
        check("tcp/a b:7447", "neither a name");
        check("tcp/a#x=1:7447", "neither a name");
        check("tcp/::1:7447", "neither a name");
        check("tcp/[router]:7447", "neither a name");
    }
}
