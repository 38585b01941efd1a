//! The client against our own server, over a network that loses the datagrams that the test
//! chooses.

use std::f64::consts::TAU;

use super::*;
use crate::device::lidar::Lidar;
use crate::device::source::SourceEvent;
use crate::device::{Device, Want};
use crate::geom::Pose2;
use crate::wire::pilch::DEFAULT_PATH;
use crate::wire::pilch::server::{Server, ServerEvent};

/// A server with a lidar in a round room of 2 m, at 5 turns a second and 400 readings a turn, and
/// its client.
struct Network {
    server: Option<Server<&'static str>>,
    client: Lidar<UdpLidar>,
    is_open: bool,
    is_measuring: bool,
    is_blocked: bool,
    tenth: u64,
    /// The states that the client reported, with their sentences, and the number of scans.
    states: Vec<(DeviceState, String)>,
    scans: usize,
}

impl Network {
    fn new(path: &str) -> Self {
        let mut client = Lidar::new("udp:test", UdpLidar::new(path), Pose2::identity());
        client.opened(Stamp(0));
        Self {
            server: Some(Server::new(vec![DEFAULT_PATH.into()])),
            client,
            is_open: false,
            is_measuring: false,
            is_blocked: false,
            tenth: 0,
            states: vec![],
            scans: 0,
        }
    }

    fn run(&mut self, seconds: f64) {
        for _ in 0..(10.0 * seconds).round() as u64 {
            self.tenth += 1;
            self.step(Stamp::from_seconds(0.1 * self.tenth as f64));
        }
    }

    fn step(&mut self, now: Stamp) {
        self.client.tick(now);
        while let Some(want) = self.client.next_want() {
            match want {
                Want::Write(datagram) => {
                    if let Some(server) = &mut self.server {
                        server.receive("client", &datagram, now);
                    }
                }
                Want::Report(SourceEvent::Device { state, detail, .. }) => {
                    self.states.push((state, detail));
                }
                Want::Report(SourceEvent::Scan(scan)) => {
                    scan.validate().unwrap();
                    assert_eq!(scan.len(), 400);
                    self.scans += 1;
                }
                _ => (),
            }
        }
        let Some(server) = &mut self.server else {
            return;
        };
        // Half a turn in a tenth of a second.
        let half = |k: u64| {
            let part = if self.is_blocked {
                0.2
            } else {
                (200 * (self.tenth % 2) + k) as f64 / 400.0
            };
            Node::new(TAU * (part + 0.001), 2.0, 15)
        };
        if self.is_measuring {
            server.publish((0..200).map(half));
        }
        server.tick(now);
        while let Some(event) = server.next_event() {
            match event {
                ServerEvent::Send { datagram, .. } => self.client.receive(&datagram, now),
                ServerEvent::Connect { .. } => {
                    self.is_open = true;
                    server.set_state(DeviceState::Connected);
                }
                ServerEvent::Start => self.is_measuring = self.is_open,
                ServerEvent::Stop => self.is_measuring = false,
            }
        }
    }

    fn last(&self) -> Option<(DeviceState, &str)> {
        let (state, detail) = self.states.last()?;
        Some((*state, detail))
    }

    fn assert_fault(&self, fault: &UdpFault) {
        let expected = fault.to_string();
        assert_eq!(self.last(), Some((DeviceState::Fault, &*expected)));
    }
}

const PATH: &str = "/dev/ttyUSB0";
const WELL: Option<(DeviceState, &str)> = Some((DeviceState::Sending, ""));

#[test]
fn a_lidar_behind_a_server_gives_its_turns_as_long_as_the_heart_beats() {
    let mut network = Network::new(PATH);
    network.run(20.0);
    assert_eq!(network.last(), WELL);
    assert!((90..=100).contains(&network.scans), "{}", network.scans);
    network.client.close(Stamp::from_seconds(20.0));
    network.run(0.1);
    assert!(!network.is_measuring);
}

#[test]
fn nobody_is_named_and_found_when_it_comes() {
    let mut network = Network::new(PATH);
    let server = network.server.take();
    network.run(7.5);
    network.assert_fault(&UdpFault::NoAnswer);
    network.server = server;
    network.run(3.0);
    assert_eq!(network.last(), WELL);
}

#[test]
fn a_network_that_goes_for_a_while_is_mended_when_it_comes_back() {
    // Shorter than the server's time-out, and longer.
    for seconds in [3.0, 12.0] {
        let mut network = Network::new(PATH);
        network.run(3.0);
        let server = network.server.take();
        network.run(seconds);
        let silence = UdpFault::Silent.to_string();
        let waiting = (DeviceState::Waiting, silence);
        assert!(network.states.contains(&waiting), "{:?}", network.states);
        network.server = server;
        network.run(8.0);
        assert_eq!(network.last(), WELL);
    }
}

#[test]
fn a_server_that_starts_anew_is_greeted_anew() {
    let mut network = Network::new(PATH);
    network.run(3.0);
    network.server = Some(Server::new(vec![DEFAULT_PATH.into()]));
    network.is_measuring = false;
    network.run(8.0);
    assert_eq!(network.last(), WELL);
}

#[test]
fn faults_of_server_and_lidar_have_their_names() {
    let mut refused = Network::new("/etc/passwd");
    refused.run(20.0);
    let path = "/etc/passwd".into();
    refused.assert_fault(&UdpFault::LidarFault { path });

    let mut blocked = Network::new(PATH);
    blocked.is_blocked = true;
    blocked.run(5.0);
    blocked.assert_fault(&UdpFault::DoesNotTurn);
    blocked.is_blocked = false;
    blocked.run(1.0);
    assert_eq!(blocked.last(), WELL);

    let mut other = Network::new(PATH);
    other.client.receive(b"\xFF\x012:GPIO", Stamp(0));
    other.server = None;
    other.run(0.1);
    let devices = "GPIO".into();
    other.assert_fault(&UdpFault::NoLidar { devices });
}
