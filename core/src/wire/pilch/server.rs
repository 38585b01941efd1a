//! The server's end: one client, one lidar, and which requests are allowed.
//!
//! In: datagrams with their sender's address, the lidar's state and readings, the time. Out:
//! [`ServerEvent`]s.
//!
//! 1. The first `HELLO` makes its sender the client. Nobody else is heard until it has sent no
//!    heartbeat for [`PATIENCE`] seconds; then the lidar is stopped.
//! 2. Of the client, `MOST_PER_SECOND` datagrams a second are heard; while there is no client, as
//!    many of all senders together. What strangers send does not count against the client.
//! 3. A path that is not in the list is refused, and state 4 says so.
//! 4. Readings are kept in order, the newest [`MOST_READINGS`]. At the interval that the client
//!    asked for, as many are sent as it asked for.
//!
//! An address is anything that the caller can compare. For a UDP socket it is the IP address,
//! because the paper's client listens on another port than it sends from.

use std::collections::VecDeque;

use super::{Device, LIDAR, MOST_READINGS, PATIENCE, Reply, Request};
use crate::robot::Stamp;
use crate::wire::message::DeviceState;
use crate::wire::rplidar::node::Node;

/// Name of the lidar in the list of devices.
const NAME: &str = "LIDAR";
/// Datagrams that are heard in a second; a lower number stops a flood earlier.
const MOST_PER_SECOND: u32 = 100;
/// Shortest interval of readings, ms; shorter ones are raised to it.
const SHORTEST_INTERVAL: u32 = 20;

/// What the server wants done.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ServerEvent<A> {
    /// Send this datagram.
    Send {
        /// Address of the receiver.
        to: A,
        /// Its bytes.
        datagram: Vec<u8>,
    },
    /// Connect the lidar at this path, which is in the list.
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
}

/// The server's end.
#[derive(Clone, Debug)]
pub struct Server<A> {
    /// Paths that a client may open.
    paths: Vec<String>,
    client: Option<Client<A>>,
    state: DeviceState,
    readings: VecDeque<Node>,
    events: VecDeque<ServerEvent<A>>,
    /// The current second, and the datagrams heard in it.
    second: u64,
    heard: u32,
}

#[derive(Clone, Debug)]
struct Client<A> {
    address: A,
    last_heard: Stamp,
    sending: Option<Sending>,
}

#[derive(Clone, Copy, Debug)]
struct Sending {
    samples: usize,
    interval: f64,
    next: Stamp,
}

impl<A: Clone + PartialEq> Server<A> {
    /// A server without a client, on which these paths may be opened.
    #[must_use]
    pub fn new(paths: Vec<String>) -> Self {
        Self {
            paths,
            client: None,
            state: DeviceState::Waiting,
            readings: VecDeque::new(),
            events: VecDeque::new(),
            second: 0,
            heard: 0,
        }
    }

    /// Takes a datagram.
    pub fn receive(&mut self, from: A, datagram: &[u8], now: Stamp) {
        self.tick(now);
        let is_stranger = self.client().is_some_and(|client| *client != from);
        if is_stranger || !self.is_within_rate(now) {
            return;
        }
        let Ok(request) = Request::decode(datagram) else {
            return;
        };
        match &mut self.client {
            None if matches!(request, Request::Hello(_)) => self.greet(from, now),
            Some(client) => {
                // In the paper, only a heartbeat proves that a client is alive; a flood of orders
                // does not keep it alive.
                if request == Request::Heartbeat {
                    client.last_heard = now;
                }
                self.obey(request, now);
            }
            None => (),
        }
    }

    /// Called with the current time: drops a silent client, sends what is due.
    pub fn tick(&mut self, now: Stamp) {
        let Some(client) = &mut self.client else {
            return;
        };
        if now.since(client.last_heard) > PATIENCE {
            self.client = None;
            self.readings.clear();
            self.events.push_back(ServerEvent::Stop);
            return;
        }
        let Some(sending) = &mut client.sending else {
            return;
        };
        if now < sending.next || self.readings.is_empty() {
            return;
        }
        sending.next = now.plus(sending.interval);
        let count = sending.samples.min(self.readings.len());
        let nodes = self.readings.drain(..count).collect();
        self.reply(&Reply::Readings(nodes));
    }

    /// The lidar's state changed: the client is told.
    pub fn set_state(&mut self, state: DeviceState) {
        self.state = match state {
            DeviceState::Measuring if self.is_sending() => DeviceState::Sending,
            other => other,
        };
        self.reply(&Reply::State(self.state));
    }

    /// Takes readings of the lidar. They are kept while the client wants readings; the oldest are
    /// dropped.
    pub fn publish(&mut self, nodes: impl IntoIterator<Item = Node>) {
        if self.is_sending() {
            self.readings.extend(nodes);
            let too_many = self.readings.len().saturating_sub(MOST_READINGS);
            self.readings.drain(..too_many);
        }
    }

    /// The next thing to do.
    pub fn next_event(&mut self) -> Option<ServerEvent<A>> {
        self.events.pop_front()
    }

    /// Who is the client.
    pub fn client(&self) -> Option<&A> {
        self.client.as_ref().map(|client| &client.address)
    }

    fn is_sending(&self) -> bool {
        let client = self.client.as_ref();
        client.is_some_and(|client| client.sending.is_some())
    }

    fn is_within_rate(&mut self, now: Stamp) -> bool {
        let second = now.0 / 1_000_000;
        if self.second != second {
            (self.second, self.heard) = (second, 0);
        }
        self.heard = self.heard.saturating_add(1);
        self.heard <= MOST_PER_SECOND
    }

    fn greet(&mut self, from: A, now: Stamp) {
        self.client = Some(Client {
            address: from,
            last_heard: now,
            sending: None,
        });
        let name = NAME.to_owned();
        self.reply(&Reply::Devices(vec![Device { id: LIDAR, name }]));
    }

    fn obey(&mut self, request: Request, now: Stamp) {
        match request {
            Request::Hello(_) | Request::Heartbeat => (),
            Request::Connect { baud, path } if self.paths.contains(&path) => {
                self.events.push_back(ServerEvent::Connect { baud, path });
            }
            Request::Connect { .. } => self.reply(&Reply::State(DeviceState::Fault)),
            Request::Start => self.events.push_back(ServerEvent::Start),
            Request::Stop => {
                self.set_sending(None);
                self.readings.clear();
                self.events.push_back(ServerEvent::Stop);
            }
            Request::Send { samples, interval } => {
                let interval = interval.max(SHORTEST_INTERVAL);
                let sending = Sending {
                    samples: (samples as usize).min(MOST_READINGS),
                    interval: f64::from(interval) * 1e-3,
                    next: now,
                };
                self.set_sending((samples > 0).then_some(sending));
                self.set_state(match self.state {
                    DeviceState::Sending => DeviceState::Measuring,
                    other => other,
                });
            }
        }
    }

    fn set_sending(&mut self, sending: Option<Sending>) {
        if let Some(client) = &mut self.client {
            client.sending = sending;
        }
    }

    fn reply(&mut self, reply: &Reply) {
        if let Some(client) = &self.client {
            self.events.push_back(ServerEvent::Send {
                to: client.address.clone(),
                datagram: reply.encode(),
            });
        }
    }
}
