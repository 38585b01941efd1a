//! Opens the listening socket, and turns the system's errors into sentences that say what to do.

use std::io;
use std::net::SocketAddr;

use tokio::net::{TcpListener, TcpSocket};

/// Send buffer of the socket, bytes, inherited by accepted sockets. It is small because data in a
/// slow client's buffer is old by the time it arrives; the bridge keeps the newest itself.
const SEND_BUFFER: u32 = 32 * 1024;
/// Connections that the system holds until the bridge accepts them.
const WAITING: u32 = 1024;

/// Why the bridge cannot listen.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum BindError {
    /// Another program has the port.
    #[error(
        "cannot listen on {address}: port {} is already in use, perhaps by another slamlab; stop that program, or \
         choose another port with --port N (--port 0 takes any free one)", address.port()
    )]
    InUse {
        /// The address that was asked for.
        address: SocketAddr,
    },
    /// The port is reserved for the system.
    #[error(
        "cannot listen on {address}: the system does not allow this user to open port {}; choose one above 1023 with \
         --port N", address.port()
    )]
    Denied {
        /// The address that was asked for.
        address: SocketAddr,
    },
    /// The address is not one of this machine's.
    #[error(
        "cannot listen on {address}: {} is not an address of this machine; use 127.0.0.1 for this machine only, or \
         0.0.0.0 for its whole network", address.ip()
    )]
    NotOurs {
        /// The address that was asked for.
        address: SocketAddr,
    },
    /// Anything else.
    #[error("cannot listen on {address}: {source}")]
    Other {
        /// The address that was asked for.
        address: SocketAddr,
        /// What the system said.
        source: io::Error,
    },
}

/// Opens `address` for listening; port 0 takes any free port, which the listener then reports.
///
/// # Errors
/// [`BindError`] says which address, why not, and what to do.
#[allow(clippy::unused_async)] // it needs a runtime to register with
pub async fn bind(address: SocketAddr) -> Result<TcpListener, BindError> {
    open(address).map_err(|source| match source.kind() {
        io::ErrorKind::AddrInUse => BindError::InUse { address },
        io::ErrorKind::PermissionDenied => BindError::Denied { address },
        io::ErrorKind::AddrNotAvailable => BindError::NotOurs { address },
        _ => BindError::Other { address, source },
    })
}

fn open(address: SocketAddr) -> io::Result<TcpListener> {
    let socket = match address {
        SocketAddr::V4(_) => TcpSocket::new_v4()?,
        SocketAddr::V6(_) => TcpSocket::new_v6()?,
    };
    // As in the standard library: a restarted bridge gets its port back at once. On Windows this
    // option means something else.
    #[cfg(unix)]
    socket.set_reuseaddr(true)?;
    socket.set_send_buffer_size(SEND_BUFFER)?;
    socket.bind(address)?;
    socket.listen(WAITING)
}
