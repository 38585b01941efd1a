//! Opens the listening socket, and turns the system's refusals into sentences that say what to do.

use std::io;
use std::net::SocketAddr;

use tokio::net::TcpListener;

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

/// Opens `address` for listening; port 0 takes any free port, which the listener then names.
///
/// # Errors
/// [`BindError`] says which address, why not, and what to do.
pub async fn bind(address: SocketAddr) -> Result<TcpListener, BindError> {
    TcpListener::bind(address)
        .await
        .map_err(|source| match source.kind() {
            io::ErrorKind::AddrInUse => BindError::InUse { address },
            io::ErrorKind::PermissionDenied => BindError::Denied { address },
            io::ErrorKind::AddrNotAvailable => BindError::NotOurs { address },
            _ => BindError::Other { address, source },
        })
}
