//! The bridge is found by browsing the network, and says goodbye. The test uses loopback and a port
//! of its own: nothing leaves the machine.
#![allow(missing_docs)] // a test binary has no public interface
#![allow(clippy::unwrap_used)] // helpers of tests, which clippy does not count as tests
#![cfg(target_os = "linux")] // elsewhere loopback may have no multicast

use std::net::{IpAddr, Ipv4Addr, UdpSocket};
use std::time::{Duration, Instant};

use mdns_sd::{IfKind, Receiver, ServiceDaemon, ServiceEvent};
use slamlab_bridge::announce::{Announcement, SERVICE, announce};

const PATIENCE: Duration = Duration::from_secs(60);

/// Waits for an event from which `wanted` returns something.
fn wait<T>(events: &Receiver<ServiceEvent>, wanted: impl Fn(ServiceEvent) -> Option<T>) -> T {
    let until = Instant::now() + PATIENCE;
    loop {
        let event = events.recv_deadline(until).unwrap();
        if let Some(found) = wanted(event) {
            return found;
        }
    }
}

#[test]
fn whoever_browses_finds_the_bridge_and_learns_that_it_ends() {
    let here = IpAddr::V4(Ipv4Addr::LOCALHOST);
    let mdns_port = UdpSocket::bind((here, 0))
        .unwrap()
        .local_addr()
        .unwrap()
        .port();
    let browser = ServiceDaemon::new_with_port(mdns_port).unwrap();
    browser.disable_interface(IfKind::All).unwrap();
    browser.enable_interface(IfKind::Addr(here)).unwrap();
    let events = browser.browse(SERVICE).unwrap();
    let announced = announce(&Announcement {
        listening: (here, 8443).into(),
        is_tls: true,
        mdns_port,
    });
    let announced = announced.unwrap();
    let found = wait(&events, |event| match event {
        ServiceEvent::ServiceResolved(found) => Some(found),
        _ => None,
    });
    assert_eq!(found.get_port(), 8443);
    assert!(
        found.get_addresses_v4().contains(&Ipv4Addr::LOCALHOST),
        "{found:?}"
    );
    assert_eq!(found.get_property_val_str("tls"), Some("1"));
    assert_eq!(
        found.get_property_val_str("version"),
        Some(env!("CARGO_PKG_VERSION"))
    );
    assert!(found.get_hostname().ends_with(".local."), "{found:?}");
    let name = found.get_fullname().to_owned();
    drop(announced);
    wait(&events, |event| match event {
        ServiceEvent::ServiceRemoved(_, gone) if gone == name => Some(()),
        _ => None,
    });
    browser.shutdown().unwrap();
}
