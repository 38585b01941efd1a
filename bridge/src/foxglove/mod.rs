//! A read-only endpoint for Foxglove and other tools that speak its WebSocket protocol (Lichtblick,
//! the Foxglove SDK).
//!
//! In: what every watcher gets. Out: `/scan`, `/points`, `/odom` and `/tf` as ROS 2 messages, and
//! `/map` and `/pose` if the bridge maps, to the clients that subscribed.
//!
//! 1. It is served on the bridge's own port, at [`PATH`], behind the same checks: host, origin,
//!    number and size. It is off by default. If watching needs the token, the endpoint refuses
//!    everybody, because this protocol has no place for a proof.
//! 2. To the hub its client is an ordinary watcher, which can never drive: newest readings first,
//!    odometry joined.
//! 3. Any request beyond watching is answered by a status message and has no effect.
//!
//! Source: Foxglove WebSocket protocol v1 (github.com/foxglove/ws-protocol, docs/spec.md);
//! `foxglove.sdk.v1` is the name under which newer clients ask for the same.

mod message;

use std::collections::BTreeMap;

use axum::extract::ws::WebSocket;
use slamlab_core::wire::message::FromBridge;

use crate::adapter::{Adapter, Incoming, PING};
use crate::ending::{End, MALFORMED};
use crate::hub::outbox::{Next, Outbox};
use crate::record::ros::{self, Odom, Topic};
use crate::shared::{Shared, Visitor};
use message::{Reply, Request};

/// Path of the endpoint.
pub(crate) const PATH: &str = "/foxglove";
/// The subprotocols offered, the preferred one first.
pub(crate) const PROTOCOLS: [&str; 2] = ["foxglove.sdk.v1", "foxglove.websocket.v1"];

/// The topics; those that only a mapping bridge has come last.
const TOPICS: [Topic; 6] = [
    Topic::Scan,
    Topic::Points,
    Topic::Odometry,
    Topic::Transforms,
    Topic::Pose,
    Topic::Map,
];
/// The number of topics without a map.
const WITHOUT_MAP: usize = 4;
/// Most subscriptions of one client.
const MOST_SUBSCRIPTIONS: usize = 64;

/// Serves a client to its end.
pub(crate) async fn run(socket: WebSocket, shared: &Shared, visitor: &Visitor) {
    let (adapter, writer) = Adapter::new(socket, shared);
    let (id, outbox) = match shared.join(visitor, "foxglove".to_owned(), None).await {
        Ok(joined) => joined,
        Err(end) => return writer.beside(visitor, async { Err(end) }).await,
    };
    let mut viewer = Viewer {
        adapter,
        shared,
        subscriptions: BTreeMap::new(),
        odom: Odom::default(),
    };
    writer.beside(visitor, viewer.live(&outbox)).await;
    shared.leave(id).await;
}

struct Viewer<'a> {
    adapter: Adapter<'a>,
    shared: &'a Shared,
    /// By the client's own subscription numbers.
    subscriptions: BTreeMap<u32, Topic>,
    odom: Odom,
}

impl Viewer<'_> {
    async fn live(&mut self, outbox: &Outbox) -> Result<(), End> {
        self.adapter.send(&Reply::server_info())?;
        self.adapter.send(&Reply::advertise(self.topics()))?;
        let mut ping = tokio::time::interval(PING);
        loop {
            let next = self.adapter.when_idle(outbox);
            tokio::select! {
                incoming = self.adapter.next() => self.receive(incoming?)?,
                next = next => match next {
                    Next::Close(code) => return Err(Some(code)),
                    Next::Message(message) => self.forward(&message)?,
                },
                _ = ping.tick() => self.adapter.ping(&[])?,
            }
        }
    }

    fn receive(&mut self, incoming: Incoming) -> Result<(), End> {
        let text = match incoming {
            Incoming::Text(text) => text,
            Incoming::Pong(_) => return Ok(()),
            // Clients send published data and service calls in binary.
            Incoming::Binary => return self.refuse("a binary message"),
        };
        match serde_json::from_str(&text).map_err(|_| Some(MALFORMED))? {
            Request::Subscribe { subscriptions } => {
                for asked in subscriptions {
                    self.subscribe(asked.id, asked.channel_id)?;
                }
            }
            Request::Unsubscribe { subscription_ids } => {
                for id in subscription_ids {
                    self.subscriptions.remove(&id);
                }
            }
            Request::Other => return self.refuse("this operation"),
        }
        Ok(())
    }

    fn subscribe(&mut self, id: u32, channel: u32) -> Result<(), End> {
        match self.topics().get(channel as usize) {
            Some(&topic) if self.subscriptions.len() < MOST_SUBSCRIPTIONS => {
                self.subscriptions.insert(id, topic);
                self.send_map(topic)
            }
            Some(_) => self.refuse("one more subscription"),
            None => self.refuse("a channel that was never advertised"),
        }
    }

    fn topics(&self) -> &'static [Topic] {
        match self.shared.mapping {
            Some(_) => &TOPICS,
            None => TOPICS.split_at(WITHOUT_MAP).0,
        }
    }

    /// Sends the map at once to a new subscriber, which may have missed the last change.
    fn send_map(&mut self, topic: Topic) -> Result<(), End> {
        let mapping = self.shared.mapping.as_ref();
        match mapping.and_then(|mapping| mapping.shown().borrow().map.clone()) {
            Some(map) if topic == Topic::Map => self.forward(&map),
            _ => Ok(()),
        }
    }

    fn refuse(&mut self, what: &str) -> Result<(), End> {
        let text = format!(
            "{what} is not for this endpoint: it shows what the robot says, and takes nothing"
        );
        self.adapter.send(&Reply::error(&text))
    }

    /// Sends what a message holds for the subscribed topics.
    fn forward(&mut self, message: &FromBridge) -> Result<(), End> {
        let now = self.shared.clock.time_of_day(self.shared.clock.now());
        for (topic, payload) in ros::messages_of(&mut self.odom, message, now) {
            let wanted = self.subscriptions.iter().filter(|(_, of)| **of == topic);
            let wanted: Vec<u32> = wanted.map(|(id, _)| *id).collect();
            for id in wanted {
                let bytes = message::data(id, now, &payload);
                self.adapter.send_bytes(bytes)?;
            }
        }
        Ok(())
    }
}
