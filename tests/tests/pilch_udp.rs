//! The UDP server of Pilch's protocol as seen by a plain script: bytes written by hand from the
//! published layout, with no code shared with the server. And the bridge's own client
//! (`--source udp:HOST`) with that server.
#![cfg(unix)]
#![allow(missing_docs)] // a test binary has no public interface
#![allow(clippy::unwrap_used)] // helpers of tests, which clippy does not count as tests

use std::net::{SocketAddr, UdpSocket};
use std::time::{Duration, Instant};

use slamlab_bridge::source::{self, Running, SourceEvent, SourceName};
use slamlab_bridge::udp::{UdpAddress, UdpServer, start};
use slamlab_core::sim::worlds;
use slamlab_core::wire::message::DeviceState;
use slamlab_tests::calm::on_a_calm_machine;
use slamlab_tests::devices::{Rplidar, Socket, View};
use tokio::sync::mpsc;

struct Client {
    socket: UdpSocket,
    server: SocketAddr,
}

impl Client {
    fn send(&self, bytes: &[u8]) {
        self.socket.send_to(bytes, self.server).unwrap();
    }

    /// The first datagram that begins with these bytes.
    fn wait(&self, head: &[u8]) -> Vec<u8> {
        let until = Instant::now() + Duration::from_secs(10);
        let (mut buffer, mut others) = ([0; 65_536], vec![]);
        while Instant::now() < until {
            // Heartbeats, as sent by the source's client, only more often.
            self.send(&[0xFF, 2]);
            if let Ok((length, from)) = self.socket.recv_from(&mut buffer) {
                assert_eq!(from, self.server);
                let datagram = buffer[..length].to_vec();
                if datagram.starts_with(head) {
                    return datagram;
                }
                others.push(datagram[..length.min(8)].to_vec());
            }
        }
        panic!("no {head:02X?}, only {others:02X?}");
    }
}

fn server(path: &str) -> (UdpServer, Client) {
    let ours = UdpSocket::bind("127.0.0.1:0").unwrap();
    let server = ours.local_addr().unwrap();
    let socket = UdpSocket::bind("127.0.0.1:0").unwrap();
    socket
        .set_read_timeout(Some(Duration::from_millis(100)))
        .unwrap();
    let client_port = socket.local_addr().unwrap().port();
    let running = start(ours, vec![path.into()], client_port).unwrap();
    (running, Client { socket, server })
}

fn connect(path: &str) -> Vec<u8> {
    // 115200 = 0x0001C200.
    [
        &[1, 0, 0x00, 0xC2, 0x01, 0x00, path.len() as u8],
        path.as_bytes(),
    ]
    .concat()
}

#[test]
fn a_script_after_the_published_layout_gets_the_world() {
    on_a_calm_machine(|| {
        let view = View::from_start(&worlds::builtin("arena").unwrap());
        let lidar = Socket::plugged(Rplidar::new(view.clone())).unwrap();
        let (_server, client) = server(&lidar.path());
        client.send(b"\xFF\x00HELLO");
        assert_eq!(client.wait(&[0xFF, 1]), b"\xFF\x011:LIDAR");
        client.send(&connect("/etc/passwd"));
        assert_eq!(
            client.wait(&[1, 4]),
            [1, 4, 4],
            "a path that is not in the list"
        );
        client.send(&connect(&lidar.path()));
        client.wait(&[1, 4, 1]);
        client.send(&[1, 1]);
        client.wait(&[1, 4, 2]);
        // 100 readings every 50 ms.
        client.send(&[1, 3, 100, 0, 0, 0, 50, 0, 0, 0]);
        client.wait(&[1, 4, 3]);
        for _ in 0..5 {
            let data = client.wait(&[1, 3]);
            let count = u32::from_le_bytes(data[2..6].try_into().unwrap()) as usize;
            assert!((1..=100).contains(&count));
            assert_eq!(data.len(), 6 + 5 * count);
            for reading in data[6..].chunks(5) {
                let angle = f64::from(u16::from_le_bytes([reading[1], reading[2]]) >> 1) / 64.0;
                let millimetres = f64::from(u16::from_le_bytes([reading[3], reading[4]])) / 4.0;
                assert!(reading[0] >> 2 > 0);
                let truth = 1e3 * view.range(-angle.to_radians()).unwrap();
                assert!(
                    (millimetres - truth).abs() < 0.2,
                    "{millimetres} at {angle}°, the world gives {truth}"
                );
            }
        }
        client.send(&[1, 2]);
        client.wait(&[1, 4, 1]);
    });
}

#[test]
fn a_second_client_is_not_heard_and_the_lidar_stops_when_the_server_ends() {
    on_a_calm_machine(|| {
        use slamlab_core::wire::rplidar::request::Request;
        let lidar = Socket::plugged(Rplidar::new(View::from_start(
            &worlds::builtin("arena").unwrap(),
        )))
        .unwrap();
        let (server, client) = server(&lidar.path());
        client.send(b"\xFF\x00HELLO");
        client.wait(&[0xFF, 1]);
        client.send(&connect(&lidar.path()));
        client.wait(&[1, 4, 1]);
        let other = UdpSocket::bind("127.0.0.2:0").unwrap();
        for order in [&b"\xFF\x00HELLO"[..], &[1, 2]] {
            other.send_to(order, client.server).unwrap();
        }
        other
            .set_read_timeout(Some(Duration::from_millis(300)))
            .unwrap();
        assert!(other.recv_from(&mut [0; 64]).is_err());
        drop(server);
        assert_eq!(
            lidar.with(|lidar| lidar.asked.last().copied()),
            Some(Request::Stop)
        );
    });
}

/// A port that was free a moment ago.
fn free_port() -> u16 {
    let socket = UdpSocket::bind("0.0.0.0:0").unwrap();
    socket.local_addr().unwrap().port()
}

fn serve(path: &str, port: u16, client_port: u16) -> UdpServer {
    let socket = UdpSocket::bind(("127.0.0.1", port)).unwrap();
    start(socket, vec![path.into()], client_port).unwrap()
}

/// The bridge's own client at work.
struct Ear {
    _running: Running,
    events: mpsc::Receiver<(u8, SourceEvent)>,
}

impl Ear {
    fn new(path: &str, port: u16, client_port: u16) -> Self {
        let address = UdpAddress::parse(&format!("127.0.0.1:{port}{path}")).unwrap();
        let name = SourceName::Udp(UdpAddress {
            client_port,
            ..address
        });
        let (sender, events) = mpsc::channel(source::MOST_WAITING);
        let running = source::start(0, name.open(None).unwrap(), sender).unwrap();
        Self {
            _running: running,
            events,
        }
    }

    /// The first event that is wanted.
    fn wait<T>(&mut self, mut wanted: impl FnMut(&SourceEvent) -> Option<T>) -> T {
        let until = Instant::now() + Duration::from_secs(60);
        let mut others = vec![];
        while Instant::now() < until {
            match self.events.try_recv() {
                Ok((_, event)) => match wanted(&event) {
                    Some(found) => return found,
                    None => others.push(format!("{event:?}").chars().take(100).collect::<String>()),
                },
                Err(_) => std::thread::sleep(Duration::from_millis(2)),
            }
        }
        panic!("only: {others:#?}")
    }

    fn state(&mut self, wanted: DeviceState, words: &str) {
        self.wait(|event| match event {
            SourceEvent::Device { state, detail, .. } => {
                (*state == wanted && detail.contains(words)).then_some(())
            }
            _ => None,
        });
    }
}

#[test]
fn a_lidar_behind_our_server_is_a_source_like_any_other() {
    on_a_calm_machine(|| {
        let view = View::from_start(&worlds::builtin("arena").unwrap());
        let lidar = Socket::plugged(Rplidar::new(view.clone())).unwrap();
        let (port, client_port) = (free_port(), free_port());
        // The server starts later than its client, stops, and comes back.
        let mut ear = Ear::new(&lidar.path(), port, client_port);
        ear.state(DeviceState::Fault, "no lidar server answers");
        for _ in 0..2 {
            let server = serve(&lidar.path(), port, client_port);
            ear.state(DeviceState::Sending, "");
            let scan = ear.wait(|event| match event {
                SourceEvent::Scan(scan) => Some(scan.clone()),
                _ => None,
            });
            scan.validate().unwrap();
            let mut hits = 0;
            for (&bearing, &range) in scan.bearings.iter().zip(&scan.ranges) {
                if range.is_finite() {
                    hits += 1;
                    let truth = view.range(bearing).unwrap();
                    let error = (f64::from(range) - truth).abs();
                    assert!(error < 0.2e-3, "{range}, the world gives {truth}");
                }
            }
            assert!(hits > 300, "{hits} hits");
            drop(server);
            ear.state(DeviceState::Waiting, "fell silent");
        }
    });
}

#[test]
fn a_path_that_the_server_does_not_open_is_named() {
    on_a_calm_machine(|| {
        let (port, client_port) = (free_port(), free_port());
        let _server = serve("/dev/ttyUSB0", port, client_port);
        let mut ear = Ear::new("/dev/null", port, client_port);
        ear.state(DeviceState::Fault, "/dev/null: the path is not in its list");
    });
}
