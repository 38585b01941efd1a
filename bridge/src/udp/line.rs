//! The client's end of the UDP protocol as a line: each datagram from the server is a piece.

use std::fmt;
use std::io;
use std::net::{IpAddr, Ipv4Addr, Ipv6Addr, SocketAddr, ToSocketAddrs, UdpSocket};
use std::time::{Duration, Instant};

use slamlab_core::wire::pilch;

use super::is_pause;
use crate::serial::{Channel, LineError, Received};

/// The longest datagram.
const LONGEST: usize = 65_507;

/// Where a lidar is served: `HOST[:PORT][/PATH]`, as in `--source udp:192.168.1.5/dev/ttyUSB0`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct UdpAddress {
    /// Name or address of the server; of IPv6 in square brackets.
    pub host: String,
    /// Its port. Default 5000.
    pub port: u16,
    /// Path of the lidar's port at the server. Default `/dev/ttyUSB0`.
    pub path: String,
    /// Port on this machine to which the server sends. The protocol fixes 20000.
    pub client_port: u16,
}

/// Why an address is not valid, or cannot be opened.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum UdpAddressError {
    /// The text does not have the form of an address.
    #[error("`{0}` is no address of a lidar server; expected HOST[:PORT][/PATH]")]
    Form(String),
    /// The host is not found.
    #[error("{host} is not found ({detail}): check the name, or write its address in figures")]
    Host {
        /// As it was typed.
        host: String,
        /// What the system says.
        detail: String,
    },
    /// Another program already listens there.
    #[error(
        "UDP port {port} does not open ({detail}): mostly another program listens for the same lidar; end it"
    )]
    Port {
        /// Port on this machine.
        port: u16,
        /// What the system says.
        detail: String,
    },
}

impl UdpAddress {
    /// Reads an address.
    ///
    /// # Errors    [`UdpAddressError::Form`]
    pub fn parse(text: &str) -> Result<Self, UdpAddressError> {
        let form = || UdpAddressError::Form(text.to_owned());
        let (server, path) = match text.find('/') {
            Some(at) => text.split_at(at),
            None => (text, pilch::DEFAULT_PATH),
        };
        // The colons of an IPv6 address are inside brackets.
        let after_host = server.find(']').map_or(0, |at| at + 1);
        let (host, port) = match server[after_host..].find(':') {
            Some(at) => {
                let (host, port) = server.split_at(after_host + at);
                (host, port[1..].parse().map_err(|_| form())?)
            }
            None => (server, pilch::SERVER_PORT),
        };
        if host.is_empty() || path == "/" {
            return Err(form());
        }
        Ok(Self {
            host: host.to_owned(),
            port,
            path: path.to_owned(),
            client_port: pilch::CLIENT_PORT,
        })
    }

    /// Opens a socket that listens for the server.
    pub(crate) fn open(&self) -> Result<UdpLine, UdpAddressError> {
        let found = (format!("{}:{}", self.host, self.port)).to_socket_addrs();
        let host = |detail: String| UdpAddressError::Host {
            host: self.host.clone(),
            detail,
        };
        let mut found = found.map_err(|error| host(error.to_string()))?;
        let server = found.next().ok_or_else(|| host("no address".into()))?;
        let any = match server {
            SocketAddr::V4(_) => IpAddr::from(Ipv4Addr::UNSPECIFIED),
            SocketAddr::V6(_) => IpAddr::from(Ipv6Addr::UNSPECIFIED),
        };
        let socket = UdpSocket::bind((any, self.client_port));
        let socket = socket.map_err(|error: io::Error| UdpAddressError::Port {
            port: self.client_port,
            detail: error.to_string(),
        })?;
        Ok(UdpLine { socket, server })
    }
}

impl fmt::Display for UdpAddress {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}{}", self.host, self.port, self.path)
    }
}

/// A socket that receives from one server.
#[derive(Debug)]
pub(crate) struct UdpLine {
    socket: UdpSocket,
    server: SocketAddr,
}

impl Channel for UdpLine {
    /// Ignores datagrams from anybody but the server. An error of the socket does not break the
    /// line: only the server's silence shows that it is gone.
    fn receive(&mut self, timeout: Duration) -> Received {
        let mut datagram = vec![0; LONGEST];
        let heard = self
            .socket
            .set_read_timeout(Some(timeout))
            .and_then(|()| self.socket.recv_from(&mut datagram));
        match heard {
            Ok((length, from)) if from.ip() == self.server.ip() => {
                datagram.truncate(length);
                Received::Bytes(datagram, Instant::now())
            }
            Ok(_) => Received::Nothing,
            Err(error) => {
                if !is_pause(&error) {
                    tracing::debug!("UDP: {error}");
                    std::thread::sleep(timeout);
                }
                Received::Nothing
            }
        }
    }

    fn send(&mut self, datagram: Vec<u8>) -> Result<(), LineError> {
        // A lost datagram does no harm: what matters is sent again by the protocol.
        if let Err(error) = self.socket.send_to(&datagram, self.server) {
            tracing::debug!("a datagram was not sent: {error}");
        }
        Ok(())
    }

    fn set_dtr(&mut self, _: bool) {}
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(text: &str, host: &str, port: u16, path: &str) {
        let address = UdpAddress::parse(text).unwrap();
        let parts = (&*address.host, address.port, &*address.path);
        assert_eq!(parts, (host, port, path));
        assert_eq!(UdpAddress::parse(&address.to_string()).unwrap(), address);
    }

    #[test]
    fn addresses_have_a_host_and_may_have_port_and_path() {
        check("lidar.local", "lidar.local", 5000, "/dev/ttyUSB0");
        check("10.0.0.2:6000", "10.0.0.2", 6000, "/dev/ttyUSB0");
        check("10.0.0.2/dev/serial0", "10.0.0.2", 5000, "/dev/serial0");
        check("[::1]:6000/dev/a:b", "[::1]", 6000, "/dev/a:b");
        check("[::1]", "[::1]", 5000, "/dev/ttyUSB0");
        for wrong in ["", ":5000", "host:", "host:70000", "/dev/ttyUSB0", "host/"] {
            let error = UdpAddress::parse(wrong).unwrap_err().to_string();
            assert!(error.contains("HOST[:PORT][/PATH]"), "{error}");
        }
    }

    #[test]
    fn a_port_that_is_taken_and_a_host_that_nobody_knows_are_named() {
        let other = UdpSocket::bind("0.0.0.0:0").unwrap();
        let address = UdpAddress {
            client_port: other.local_addr().unwrap().port(),
            ..UdpAddress::parse("127.0.0.1").unwrap()
        };
        let error = address.open().unwrap_err().to_string();
        assert!(error.contains("another program listens"), "{error}");
        let address = UdpAddress::parse("no-such-host.invalid").unwrap();
        let error = address.open().unwrap_err().to_string();
        assert!(error.contains("is not found"), "{error}");
    }
}
