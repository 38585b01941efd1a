//! The UDP protocol of Pilch's lidar server, both ends: port 5000 at the server, 20000 at the
//! client.
//!
//! In and out: datagrams. Every number is little-endian, as in the sensor's protocol: the paper
//! does not say.
//!
//! | datagram | from | |
//! |---|---|---|
//! | `FF 00` text | client | asks to be the client; the text is "HELLO" |
//! | `FF 01` `id:name##id:name…` | server | accepted; these are the devices |
//! | `FF 02` | client | heartbeat, each second; 5 s without, and the server drops the client |
//! | `01 00` baud u32, n u8, path of n bytes | client | connect the lidar at this path |
//! | `01 01` | client | start measuring |
//! | `01 02` | client | stop measuring |
//! | `01 03` samples u32, interval u32 (ms) | client | send this many readings, this often |
//! | `01 03` n u32, n × (quality u8, angle u16, distance u16) | server | readings, scaled as RPLIDAR's nodes |
//! | `01 04` state u8 | server | [`DeviceState`] |
//!
//! A reading: quality in bits 7..2, angle in bits 15..1 in 1/64° clockwise, distance in 1/4 mm. The
//! source's figure 3.14 adds length and checksum before sending: those of UDP itself.
//!
//! Source: Pilch 2016 §3.6 and figs. 3.14 to 3.21. Added here: only listed paths are opened, only
//! the client's own address is heard, and a rate limit. The protocol has no authentication, so use
//! it only on a trusted network.

use super::message::DeviceState;
use super::rplidar::node::Node;

pub mod server;

/// Port of the server.
pub const SERVER_PORT: u16 = 5000;
/// Port of the client.
pub const CLIENT_PORT: u16 = 20_000;
/// Path of the lidar at the paper's server.
pub const DEFAULT_PATH: &str = "/dev/ttyUSB0";
/// The text of a first datagram.
pub const HELLO: &str = "HELLO";
/// Seconds between two heartbeats.
pub const HEARTBEAT: f64 = 1.0;
/// Seconds without a heartbeat after which a client is dropped.
pub const PATIENCE: f64 = 5.0;
/// Most readings of a datagram: as many as UDP can carry.
pub const MOST_READINGS: usize = (65_507 - 6) / Node::LEN;

const SERVER: u8 = 0xFF;
/// Address of the lidar, in datagrams and in the list of devices.
pub const LIDAR: u8 = 0x01;

/// Messages of a client.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Request {
    /// Asks to be the client.
    Hello(String),
    /// The client is still there.
    Heartbeat,
    /// Connect the lidar.
    Connect {
        /// Baud rate.
        baud: u32,
        /// Path of the port.
        path: String,
    },
    /// Start measuring.
    Start,
    /// Stop measuring.
    Stop,
    /// Send readings.
    Send {
        /// Readings per datagram.
        samples: u32,
        /// Interval of datagrams, ms.
        interval: u32,
    },
}

/// Messages of the server.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Reply {
    /// You are the client; these are the devices.
    Devices(Vec<Device>),
    /// The lidar's state.
    State(DeviceState),
    /// Readings.
    Readings(Vec<Node>),
}

/// A device of the server.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Device {
    /// Its address in datagrams.
    pub id: u8,
    /// Its name, without ':' and '#'.
    pub name: String,
}

/// Why a datagram cannot be read.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum DatagramError {
    /// Neither of the two addresses, or a command that is unknown at its address.
    #[error("datagram begins with {head:02X?}, expected one of FF 00 to FF 02 or 01 00 to 01 04")]
    Unknown {
        /// Its first two bytes, or fewer.
        head: Vec<u8>,
    },
    /// Too short or too long for its command.
    #[error("datagram {command:02X?} has {found} bytes, expected {expected}")]
    Length {
        /// Address and command.
        command: [u8; 2],
        /// Bytes found.
        found: usize,
        /// Bytes expected.
        expected: usize,
    },
    /// A text that is not UTF-8, or a device that is not "id:name".
    #[error("datagram {command:02X?}: text {text:?} is not {expected}")]
    Text {
        /// Address and command.
        command: [u8; 2],
        /// The text.
        text: String,
        /// What is expected.
        expected: &'static str,
    },
    /// An unknown state.
    #[error("lidar state {0} is not one of 0 to 4")]
    State(u8),
}

impl Request {
    /// The datagram. A path of more than 255 bytes is cut off: the wire has no room for it.
    #[must_use]
    pub fn encode(&self) -> Vec<u8> {
        match self {
            Self::Hello(text) => [&[SERVER, 0], text.as_bytes()].concat(),
            Self::Heartbeat => vec![SERVER, 2],
            Self::Connect { baud, path } => {
                let path = &path.as_bytes()[..path.len().min(255)];
                [
                    &[LIDAR, 0],
                    &baud.to_le_bytes()[..],
                    &[path.len() as u8],
                    path,
                ]
                .concat()
            }
            Self::Start => vec![LIDAR, 1],
            Self::Stop => vec![LIDAR, 2],
            Self::Send { samples, interval } => [
                &[LIDAR, 3],
                &samples.to_le_bytes()[..],
                &interval.to_le_bytes(),
            ]
            .concat(),
        }
    }

    /// Reads a client's datagram.
    ///
    /// # Errors    [`DatagramError`]
    pub fn decode(datagram: &[u8]) -> Result<Self, DatagramError> {
        match datagram {
            [SERVER, 0, text @ ..] => Ok(Self::Hello(self::text([SERVER, 0], text)?)),
            [SERVER, 2] => Ok(Self::Heartbeat),
            [LIDAR, 0, a, b, c, d, length, path @ ..] => {
                let expected = 7 + usize::from(*length);
                check_length(datagram, expected)?;
                Ok(Self::Connect {
                    baud: u32::from_le_bytes([*a, *b, *c, *d]),
                    path: text([LIDAR, 0], path)?,
                })
            }
            [LIDAR, 0, ..] => Err(length_error(datagram, 7)),
            [LIDAR, 1] => Ok(Self::Start),
            [LIDAR, 2] => Ok(Self::Stop),
            &[LIDAR, 3, a, b, c, d, e, f, g, h] => Ok(Self::Send {
                samples: u32::from_le_bytes([a, b, c, d]),
                interval: u32::from_le_bytes([e, f, g, h]),
            }),
            [LIDAR, 3, ..] => Err(length_error(datagram, 10)),
            [SERVER, 2, ..] | [LIDAR, 1 | 2, ..] => Err(length_error(datagram, 2)),
            _ => Err(unknown(datagram)),
        }
    }
}

impl Reply {
    /// The datagram. Readings beyond [`MOST_READINGS`] are left out: UDP has no room for them.
    #[must_use]
    pub fn encode(&self) -> Vec<u8> {
        match self {
            Self::Devices(devices) => {
                let pairs: Vec<String> = devices
                    .iter()
                    .map(|device| format!("{}:{}", device.id, device.name))
                    .collect();
                [&[SERVER, 1], pairs.join("##").as_bytes()].concat()
            }
            Self::State(state) => vec![LIDAR, 4, *state as u8],
            Self::Readings(nodes) => {
                let count = nodes.len().min(MOST_READINGS);
                let mut bytes = vec![LIDAR, 3];
                bytes.extend((count as u32).to_le_bytes());
                bytes.extend(nodes.iter().take(count).flat_map(Node::encode));
                bytes
            }
        }
    }

    /// Reads a server's datagram. Check bits of readings are ignored: UDP has a checksum of its
    /// own, and the paper's server may not set them.
    ///
    /// # Errors    [`DatagramError`]
    pub fn decode(datagram: &[u8]) -> Result<Self, DatagramError> {
        match datagram {
            [SERVER, 1, list @ ..] => devices(list).map(Self::Devices),
            [LIDAR, 3, a, b, c, d, readings @ ..] => {
                let count = u32::from_le_bytes([*a, *b, *c, *d]) as usize;
                check_length(datagram, count.saturating_mul(Node::LEN).saturating_add(6))?;
                let (nodes, _) = readings.as_chunks();
                let nodes = nodes.iter().copied().map(Node::unchecked).collect();
                Ok(Self::Readings(nodes))
            }
            [LIDAR, 3, ..] => Err(length_error(datagram, 6)),
            // The messages of the bridge number the states as the paper does.
            [LIDAR, 4, state] => DeviceState::ALL
                .get(usize::from(*state))
                .copied()
                .map(Self::State)
                .ok_or(DatagramError::State(*state)),
            [LIDAR, 4, ..] => Err(length_error(datagram, 3)),
            _ => Err(unknown(datagram)),
        }
    }
}

fn devices(list: &[u8]) -> Result<Vec<Device>, DatagramError> {
    let list = text([SERVER, 1], list)?;
    let pairs = list.split("##").filter(|pair| !pair.is_empty());
    pairs
        .map(|pair| {
            let device = pair.split_once(':').and_then(|(id, name)| {
                let (id, name) = (id.trim().parse().ok()?, name.to_owned());
                Some(Device { id, name })
            });
            device.ok_or_else(|| DatagramError::Text {
                command: [SERVER, 1],
                text: pair.to_owned(),
                expected: "id:name with an id of 0 to 255",
            })
        })
        .collect()
}

fn text(command: [u8; 2], bytes: &[u8]) -> Result<String, DatagramError> {
    String::from_utf8(bytes.to_vec()).map_err(|_| DatagramError::Text {
        command,
        text: String::from_utf8_lossy(bytes).into_owned(),
        expected: "UTF-8",
    })
}

fn check_length(datagram: &[u8], expected: usize) -> Result<(), DatagramError> {
    if datagram.len() == expected {
        Ok(())
    } else {
        Err(length_error(datagram, expected))
    }
}

fn length_error(datagram: &[u8], expected: usize) -> DatagramError {
    match datagram {
        &[address, command, ..] => DatagramError::Length {
            command: [address, command],
            found: datagram.len(),
            expected,
        },
        _ => unknown(datagram),
    }
}

fn unknown(datagram: &[u8]) -> DatagramError {
    DatagramError::Unknown {
        head: datagram.iter().take(2).copied().collect(),
    }
}

#[cfg(test)]
mod tests;
