//! A lidar behind the UDP protocol of Pilch's server ([`crate::wire::pilch`]): its line carries
//! datagrams.
//!
//! ```text
//! greeting -list of devices-> asking -readings-> measuring
//!     ^  ^                     |  ^                 | silence 1 s
//!     |  +--- nothing 5 s -----+  +-----------------+
//!     +--- no list 7 s: fault, and again
//! ```
//!
//! 1. Each second something is sent to the server: a greeting until it answers; then a heartbeat
//!    and, while no readings arrive, all requests again, because datagrams may be lost.
//! 2. The server answers no other client while it has one. It drops a client only after 5 s of
//!    silence: one that left without a word, or that has restarted and greets again. So a greeting
//!    gets 7 s.
//! 3. A server that reports a fault of its lidar does not say which: see its own log.
//!
//! Instants: readings carry none. The last one of a datagram counts as taken when the datagram
//! arrived, each one before it a sample time of an RPLIDAR A1 earlier. If server and network hold
//! readings back (some 30 ms with our own server), the scan is dated later than it was taken.

use crate::device::lidar::revolution::Figures;
use crate::device::lidar::{LidarProtocol, Output};
use crate::device::line::Weight;
use crate::device::rplidar::{RATE_OF_A1, Rplidar};
use crate::robot::Stamp;
use crate::wire::Tally;
use crate::wire::message::DeviceState;
use crate::wire::pilch::{HEARTBEAT, HELLO, LIDAR, PATIENCE, Reply, Request};
use crate::wire::rplidar::node::Node;

/// Time for an answer to a greeting, s: the server may have to drop another client first.
const FOR_GREETING: f64 = PATIENCE + 2.0 * HEARTBEAT;
/// Time for the first readings, s: the server has to start its lidar up.
const FOR_READINGS: f64 = 15.0;
/// Readings per datagram: as many as fit into one Ethernet packet.
const SAMPLES: u32 = 250;
/// Interval between two datagrams of readings, ms: the shortest that our own server allows.
const INTERVAL_MILLIS: u32 = 20;

/// Why there are no scans.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum UdpFault {
    /// No datagram arrived.
    #[error(
        "no lidar server answers: start `slamlab-bridge udp` there, check address and firewall, and that no other client has it"
    )]
    NoAnswer,
    /// The server has only other devices.
    #[error("the server has no lidar; it has {devices}")]
    NoLidar {
        /// Names of its devices.
        devices: String,
    },
    /// The server reports a fault, without a reason.
    #[error(
        "the server does not open its lidar at {path}: the path is not in its list, or the lidar does not work; its log says which"
    )]
    LidarFault {
        /// Path of the port at the server.
        path: String,
    },
    /// The server answers, but sends no readings.
    #[error("the server answers, but sends no readings of its lidar: look at the cable there")]
    NoReadings,
    /// Readings stopped coming.
    #[error("the server fell silent while measuring: network or server is gone")]
    Silent,
    /// Readings arrive, but no whole turn.
    #[error("the server sends readings but no whole turn: the lidar's head is blocked there")]
    DoesNotTurn,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Stage {
    Greeting,
    Asking,
    Measuring,
}

/// What is specific to a lidar behind UDP.
#[derive(Debug)]
pub struct UdpLidar {
    /// Path of the lidar's port at the server.
    path: String,
    stage: Stage,
    since: Stamp,
    next_beat: Stamp,
    /// When the server last said anything.
    answered: Stamp,
    tally: Tally,
}

impl UdpLidar {
    /// The lidar at this port of the server.
    #[must_use]
    pub fn new(path: impl Into<String>) -> Self {
        Self {
            path: path.into(),
            stage: Stage::Greeting,
            since: Stamp(0),
            next_beat: Stamp(0),
            answered: Stamp(0),
            tally: Tally::default(),
        }
    }

    fn enter(&mut self, stage: Stage, now: Stamp) {
        (self.stage, self.since) = (stage, now);
    }

    fn answer(&mut self, reply: Reply, output: &mut Output, now: Stamp) {
        self.answered = now;
        match reply {
            Reply::Devices(devices) => {
                let Some(lidar) = devices.iter().find(|device| device.id == LIDAR) else {
                    let names: Vec<_> = devices.into_iter().map(|device| device.name).collect();
                    let devices = names.join(", ");
                    return output.fail(&UdpFault::NoLidar { devices });
                };
                output.report.model = format!("{} by UDP", lidar.name);
                if self.stage == Stage::Greeting {
                    output.report.detail = String::new();
                    output.enter(DeviceState::Connected);
                    self.enter(Stage::Asking, now);
                    self.ask(output);
                }
            }
            Reply::State(DeviceState::Fault) => {
                let path = self.path.clone();
                output.fail(&UdpFault::LidarFault { path });
            }
            Reply::State(_) => (),
            Reply::Readings(nodes) => self.measured(&nodes, output, now),
        }
    }

    /// While this client is still greeting, the readings may be those of a client before it.
    fn measured(&mut self, nodes: &[Node], output: &mut Output, now: Stamp) {
        if nodes.is_empty() || self.stage == Stage::Greeting {
            return;
        }
        if self.stage == Stage::Asking {
            output.watch(now);
            self.enter(Stage::Measuring, now);
        }
        output.heard(now);
        let interval = f64::from(RATE_OF_A1.standard_micros) * 1e-6;
        let reading = |node: &Node| (node.radians(), node.metres(), Some(node.quality));
        output.take(nodes.iter().map(reading), interval, now.seconds(), now);
    }

    fn ask(&self, output: &mut Output) {
        let requests = [
            Request::Connect {
                baud: Self::BAUD_RATE,
                path: self.path.clone(),
            },
            Request::Start,
            Request::Send {
                samples: SAMPLES,
                interval: INTERVAL_MILLIS,
            },
        ];
        for request in requests {
            output.report.write(request.encode());
        }
    }

    fn beat(&mut self, output: &mut Output, now: Stamp) {
        if now < self.next_beat {
            return;
        }
        self.next_beat = now.plus(HEARTBEAT);
        if self.stage == Stage::Greeting {
            return output.report.write(Request::Hello(HELLO.into()).encode());
        }
        output.report.write(Request::Heartbeat.encode());
        if self.stage == Stage::Asking {
            self.ask(output);
        }
    }

    fn watch(&mut self, output: &mut Output, now: Stamp) {
        let lasts = now.since(self.since);
        match self.stage {
            Stage::Greeting if lasts > FOR_GREETING => {
                output.fail(&UdpFault::NoAnswer);
                self.since = now;
            }
            Stage::Asking if now.since(self.answered) > PATIENCE => {
                self.enter(Stage::Greeting, now);
            }
            Stage::Asking if lasts > FOR_READINGS => {
                if output.state() != DeviceState::Fault {
                    output.fail(&UdpFault::NoReadings);
                }
                self.since = now;
            }
            Stage::Measuring if output.is_silent(now) => {
                let why = UdpFault::Silent;
                output
                    .report
                    .note(Weight::Warning, format!("{why}; it is asked again"));
                output.report.detail = why.to_string();
                output.enter(DeviceState::Waiting);
                self.enter(Stage::Asking, now);
            }
            Stage::Measuring if output.does_not_turn(now) => {
                output.fail(&UdpFault::DoesNotTurn);
                output.watch(now);
            }
            _ => (),
        }
    }
}

impl LidarProtocol for UdpLidar {
    /// That of the lidar's port at the server.
    const BAUD_RATE: u32 = Rplidar::BAUD_RATE;

    /// The server has an RPLIDAR A1.
    const FIGURES: Figures = Rplidar::FIGURES;

    fn opened(&mut self, _: &mut Output, now: Stamp) {
        *self = Self::new(std::mem::take(&mut self.path));
        self.enter(Stage::Greeting, now);
        self.next_beat = now;
    }

    /// Takes a datagram.
    fn receive(&mut self, datagram: &[u8], output: &mut Output, now: Stamp) {
        self.tally.bytes += datagram.len() as u64;
        match Reply::decode(datagram) {
            Ok(reply) => {
                self.tally.frames += 1;
                self.answer(reply, output, now);
            }
            Err(_) => {
                self.tally.rejected += 1;
                self.tally.discarded += datagram.len() as u64;
            }
        }
    }

    fn tick(&mut self, output: &mut Output, now: Stamp) {
        self.watch(output, now);
        self.beat(output, now);
    }

    /// If these datagrams are lost, the server's own time-out replaces them.
    fn close(&mut self, output: &mut Output, _: Stamp) {
        output.report.write(Request::Stop.encode());
    }

    fn tally(&self) -> Tally {
        self.tally
    }
}

#[cfg(test)]
mod tests;
