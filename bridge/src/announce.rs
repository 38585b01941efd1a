//! Announces the bridge in the local network by multicast DNS, so that programs find it without
//! knowing its address (RFC 6762, RFC 6763).
//!
//! In: where the bridge listens. Out: `INSTANCE._slamlab._tcp.local` with port, `NAME.local`, and a
//! text record: `version`, `tls` (0 or 1) and `path`. It says goodbye when it is dropped.

use std::net::SocketAddr;
use std::time::Duration;

use mdns_sd::{IfKind, ServiceDaemon, ServiceInfo};

use crate::address;

/// The kind of service, for browsers of the network.
pub const SERVICE: &str = "_slamlab._tcp.local.";
/// Time for the goodbye to be sent.
const FAREWELL: Duration = Duration::from_millis(500);

/// What is announced.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Announcement {
    /// Where the bridge listens.
    pub listening: SocketAddr,
    /// Whether it speaks TLS.
    pub is_tls: bool,
    /// UDP port of multicast DNS; 5353 except in tests.
    pub mdns_port: u16,
}

impl Announcement {
    /// The standard's port.
    pub const MDNS_PORT: u16 = 5353;
}

/// A bridge that is announced, until this is dropped.
pub struct Announced {
    daemon: ServiceDaemon,
    name: String,
}

/// Why nothing is announced: the system gives no multicast socket, or the name is not valid.
#[derive(Debug, thiserror::Error)]
#[error("the bridge is not announced in the local network: {0}")]
pub struct AnnounceError(#[from] mdns_sd::Error);

/// Announces the bridge.
///
/// # Errors    [`AnnounceError`]; the bridge works without being announced.
pub fn announce(what: &Announcement) -> Result<Announced, AnnounceError> {
    let daemon = ServiceDaemon::new_with_port(what.mdns_port)?;
    let ip = what.listening.ip();
    if ip.is_loopback() {
        daemon.disable_interface(IfKind::All)?;
        daemon.enable_interface(IfKind::Addr(ip))?;
    }
    let info = service(what)?;
    let name = info.get_fullname().to_owned();
    daemon.register(info)?;
    Ok(Announced { daemon, name })
}

fn service(what: &Announcement) -> Result<ServiceInfo, mdns_sd::Error> {
    let host = address::host_name().unwrap_or_else(|| "slamlab".into());
    let text = [
        ("version", env!("CARGO_PKG_VERSION")),
        ("tls", if what.is_tls { "1" } else { "0" }),
        ("path", "/"),
    ];
    let (ip, port) = (what.listening.ip(), what.listening.port());
    let (instance, local) = (format!("slamlab on {host}"), format!("{host}.local."));
    if ip.is_unspecified() {
        let info = ServiceInfo::new(SERVICE, &instance, &local, "", port, &text[..])?;
        return Ok(info.enable_addr_auto());
    }
    ServiceInfo::new(SERVICE, &instance, &local, ip, port, &text[..])
}

impl Drop for Announced {
    /// Without a goodbye, others would keep the name for an hour.
    fn drop(&mut self) {
        if let Ok(done) = self.daemon.unregister(&self.name) {
            let _ = done.recv_timeout(FAREWELL);
        }
        if let Ok(done) = self.daemon.shutdown() {
            let _ = done.recv_timeout(FAREWELL);
        }
    }
}
