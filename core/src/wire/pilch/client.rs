//! The client's end: greets, keeps the heart beating, orders the lidar, takes its readings.
//!
//! In: the server's datagrams, orders, the time. Out: datagrams to send, and what the server said.

use std::collections::VecDeque;

use super::{DatagramError, Device, HEARTBEAT, HELLO, PATIENCE, Reply, Request};
use crate::robot::Stamp;
use crate::wire::message::DeviceState;
use crate::wire::rplidar::node::Node;

/// What the client heard.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Event {
    /// Send this datagram to the server.
    Send(Vec<u8>),
    /// The server took us.
    Connected(Vec<Device>),
    /// The lidar's state.
    State(DeviceState),
    /// Readings.
    Readings(Vec<Node>),
    /// The server did not answer for [`PATIENCE`] seconds: it is down, has another client, or a wall is in between.
    /// Greeting goes on.
    NoAnswer,
}

/// The client's end.
#[derive(Clone, Debug)]
pub struct Client {
    is_connected: bool,
    next_beat: Stamp,
    /// Since when no answer to a greeting came.
    waiting_since: Stamp,
    events: VecDeque<Event>,
}

impl Client {
    /// A client that greets at once.
    #[must_use]
    pub fn new(now: Stamp) -> Self {
        let mut client = Self {
            is_connected: false,
            next_beat: now,
            waiting_since: now,
            events: VecDeque::new(),
        };
        client.tick(now);
        client
    }

    /// Takes a datagram of the server's.
    ///
    /// # Errors    [`DatagramError`]: it is dropped.
    pub fn receive(&mut self, datagram: &[u8]) -> Result<(), DatagramError> {
        let event = match Reply::decode(datagram)? {
            Reply::Devices(devices) => {
                self.is_connected = true;
                Event::Connected(devices)
            }
            Reply::State(state) => Event::State(state),
            Reply::Readings(nodes) => Event::Readings(nodes),
        };
        self.events.push_back(event);
        Ok(())
    }

    /// Orders the lidar.
    pub fn send(&mut self, request: &Request) {
        self.events.push_back(Event::Send(request.encode()));
    }

    /// Lets the client see the time: greets or beats each second.
    pub fn tick(&mut self, now: Stamp) {
        if !self.is_connected && now.since(self.waiting_since) > PATIENCE {
            self.waiting_since = now;
            self.events.push_back(Event::NoAnswer);
        }
        if now < self.next_beat {
            return;
        }
        self.next_beat = now.plus(HEARTBEAT);
        self.send(&if self.is_connected {
            Request::Heartbeat
        } else {
            Request::Hello(HELLO.into())
        });
    }

    /// The next thing to do or to know.
    pub fn next_event(&mut self) -> Option<Event> {
        self.events.pop_front()
    }
}
