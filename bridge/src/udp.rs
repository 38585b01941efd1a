//! Serves a lidar by the UDP protocol of Pilch's server, so that his application, another bridge
//! (`--source udp:HOST`) or any script can use it.
//!
//! In: datagrams. Out: datagrams. The rules (one client, its heartbeat, paths from a list, rates)
//! are in [`slamlab_core::wire::pilch::server`]; this module has the socket and the lidar.
//!
//! 1. Answers go to the client's address, but to the port fixed by the paper: the client listens at
//!    another port than it sends from.
//! 2. An order to connect opens the lidar at its path; it is started, watched and reopened as in
//!    `serve`.
//! 3. Readings come from whole scans: the hits, in the order in which they were measured. In a scan
//!    without qualities, readings get the quality of an express scan.
//!
//! The protocol has neither encryption nor authentication: it is off unless asked for.

mod line;

use std::io;
use std::net::{IpAddr, SocketAddr, UdpSocket};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use slamlab_core::device::Kind;
use slamlab_core::geom::Pose2;
use slamlab_core::robot::{Scan, Stamp};
use slamlab_core::wire::message::DeviceState;
use slamlab_core::wire::pilch::server::{Server, ServerEvent};
use slamlab_core::wire::rplidar::express;
use slamlab_core::wire::rplidar::node::Node;
use tokio::sync::mpsc;

use crate::serial::DeviceSource;
use crate::source::{self, Running};

pub use line::{UdpAddress, UdpAddressError};

/// The lidar of this protocol, by its name in the table of devices.
const LIDAR: &str = "rplidar";
/// How long one read waits for a datagram.
const TURN: Duration = Duration::from_millis(10);
/// Most events of the lidar that may wait.
const MOST_WAITING: usize = 64;

/// Serves the lidars at these paths to a client that listens at `client_port`, until `stop` is set.
/// Then, and whenever the client is gone, the lidar is stopped.
///
/// # Errors    If the socket does not work any more.
fn serve(
    socket: &UdpSocket,
    paths: Vec<String>,
    client_port: u16,
    stop: &AtomicBool,
) -> io::Result<()> {
    socket.set_read_timeout(Some(TURN))?;
    let (sender, events) = mpsc::channel(MOST_WAITING);
    let mut desk = Desk {
        socket,
        client_port,
        server: Server::new(paths),
        lidar: None,
        is_measuring: false,
        sender,
        events,
    };
    let began = Instant::now();
    let now = || Stamp(began.elapsed().as_micros() as u64);
    let mut datagram = [0; 2048];
    while !stop.load(Ordering::Relaxed) {
        match socket.recv_from(&mut datagram) {
            Ok((length, from)) => {
                let bytes = datagram.get(..length).unwrap_or_default();
                desk.server.receive(from.ip(), bytes, now());
            }
            // This may also be the result of an earlier answer: the client's port was closed.
            Err(error) if is_pause(&error) => (),
            Err(error) => return Err(error),
        }
        desk.hear_lidar();
        desk.server.tick(now());
        desk.obey();
    }
    Ok(())
}

/// Serves the lidars at these paths of this machine to a client that listens at `client_port`, on a
/// thread of its own.
///
/// # Errors    If the system has no thread left.
pub fn start(socket: UdpSocket, paths: Vec<String>, client_port: u16) -> io::Result<UdpServer> {
    let stop = Arc::new(AtomicBool::new(false));
    let for_thread = Arc::clone(&stop);
    let thread = std::thread::Builder::new()
        .name("udp".into())
        .spawn(move || {
            if let Err(error) = serve(&socket, paths, client_port, &for_thread) {
                tracing::error!("the UDP server ended: {error}");
            }
        })?;
    Ok(UdpServer {
        stop,
        thread: Some(thread),
    })
}

/// A running server; dropping it stops it and its lidar.
#[derive(Debug)]
pub struct UdpServer {
    stop: Arc<AtomicBool>,
    thread: Option<std::thread::JoinHandle<()>>,
}

impl Drop for UdpServer {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take()
            && thread.join().is_err()
        {
            tracing::error!("the UDP server panicked");
        }
    }
}

/// The server's rules, its socket and the lidar.
struct Desk<'a> {
    socket: &'a UdpSocket,
    client_port: u16,
    server: Server<IpAddr>,
    /// The lidar at a path.
    lidar: Option<(String, Running)>,
    is_measuring: bool,
    sender: mpsc::Sender<(u8, source::SourceEvent)>,
    events: mpsc::Receiver<(u8, source::SourceEvent)>,
}

impl Desk<'_> {
    fn hear_lidar(&mut self) {
        while let Ok((_, event)) = self.events.try_recv() {
            match event {
                source::SourceEvent::Scan(scan) if self.is_measuring => {
                    self.server.publish(nodes(&scan))
                }
                source::SourceEvent::Device { state, .. } if self.lidar.is_some() => {
                    self.server.set_state(match state {
                        DeviceState::Sending if self.is_measuring => DeviceState::Measuring,
                        DeviceState::Sending => DeviceState::Connected,
                        other => other,
                    })
                }
                _ => (),
            }
        }
    }

    fn obey(&mut self) {
        while let Some(event) = self.server.next_event() {
            match event {
                ServerEvent::Send { to, datagram } => {
                    // A lost datagram is not sent again: the protocol allows for losses.
                    if let Err(error) = self
                        .socket
                        .send_to(&datagram, SocketAddr::new(to, self.client_port))
                    {
                        tracing::debug!("a datagram was not sent: {error}");
                    }
                }
                ServerEvent::Connect { baud, path } => self.connect(baud, path),
                ServerEvent::Start => self.measure(true),
                ServerEvent::Stop => {
                    self.measure(false);
                    if self.server.client().is_none() {
                        self.lidar = None;
                    }
                }
            }
        }
    }

    fn connect(&mut self, baud: u32, path: String) {
        let Some(kind) = Kind::named(LIDAR) else {
            return self.server.set_state(DeviceState::Fault);
        };
        if baud != kind.baud_rate {
            let (title, rate) = (kind.title, kind.baud_rate);
            tracing::warn!("the UDP client asks for {baud} baud; an {title} has {rate}");
        }
        if self.lidar.as_ref().is_some_and(|(open, _)| *open == path) {
            return self.server.set_state(DeviceState::Connected);
        }
        let lidar = (kind.open)(format!("{LIDAR}:{path}"), Pose2::identity());
        let source = Box::new(DeviceSource::at_port(lidar, &path));
        match source::start(0, source, self.sender.clone()) {
            Ok(running) => self.lidar = Some((path, running)),
            Err(error) => {
                tracing::error!("the lidar has no thread: {error}");
                self.server.set_state(DeviceState::Fault);
            }
        }
    }

    fn measure(&mut self, is_measuring: bool) {
        self.is_measuring = is_measuring;
        if self.lidar.is_some() {
            self.server.set_state(if is_measuring {
                DeviceState::Measuring
            } else {
                DeviceState::Connected
            });
        }
    }
}

/// The hits, as the sensor would send them; the first one begins a sweep.
fn nodes(scan: &Scan) -> impl Iterator<Item = Node> {
    let beams = scan.bearings.iter().zip(&scan.ranges).enumerate();
    let hits = beams.filter(|(_, (_, range))| range.is_finite());
    hits.enumerate()
        .map(|(place, (beam, (bearing, range)))| Node {
            starts: place == 0,
            ..Node::new(
                -bearing,
                f64::from(*range),
                scan.quality(beam).unwrap_or(express::QUALITY),
            )
        })
}

fn is_pause(error: &io::Error) -> bool {
    matches!(
        error.kind(),
        io::ErrorKind::WouldBlock
            | io::ErrorKind::TimedOut
            | io::ErrorKind::Interrupted
            | io::ErrorKind::ConnectionRefused
            | io::ErrorKind::ConnectionReset
    )
}
