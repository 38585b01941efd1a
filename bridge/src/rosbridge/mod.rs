//! A subset of rosbridge v2, for scripts that know roslibjs or roslibpy.
//!
//! In: JSON of such a client. Out: `/scan`, `/odom` and `/tf` to those who subscribed; `/cmd_vel`
//! to the robot, from whoever has the token, the lease, and armed.
//!
//! 1. It stands on the bridge's own port, at [`PATH`], behind the same gates; it is off by default.
//! 2. rosbridge has no place for a token. Services stand in: `/slamlab/challenge` gives a
//!    challenge, `/slamlab/enter` takes the proof made of it
//!    ([`slamlab_core::wire::message::proof`]), `/slamlab/take` the lease, `/slamlab/arm` arms.
//!    Anyone may call `/slamlab/stop`, but where watching needs the token: there the proof must
//!    come in time. Then `/cmd_vel` drives, at 10 Hz or faster: the rules are those of every client
//!    ([`crate::safety`]).
//! 3. There is no `/map`: whoever watches draws its own, and the bridge none, for it must keep up
//!    with its robot on the smallest computer. `export` draws it from a recording.
//! 4. A driving message must show how old it is at most, and rosbridge's do not say. So a driver is
//!    pinged ten times a second with the bridge's time; WebSocket answers in order, so what follows
//!    on an answer was sent after its ping was seen.
//!
//! Source: rosbridge v2 protocol specification (github.com/RobotWebTools/rosbridge_suite,
//! ROSBRIDGE_PROTOCOL.md).

mod message;
mod services;

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Duration;

use axum::extract::ws::WebSocket;
use slamlab_core::robot::Command;
use slamlab_core::wire::message::{DriveBody, FromBridge, Header, ToBridge, Watching, close};

use crate::adapter::{Adapter, Incoming, PING};
use crate::ending::{End, MALFORMED};
use crate::hub::FromClient;
use crate::hub::outbox::{Next, Outbox};
use crate::safety::ClientId;
use crate::shared::Shared;
use message::{Reply, Request, Topics, Twist};
use services::Services;

/// Path of the endpoint.
pub(crate) const PATH: &str = "/rosbridge";
const VELOCITY: &str = "/cmd_vel";
/// Between two pings of a client that may drive.
const DRIVER_PING: Duration = Duration::from_millis(100);
/// How old a driving message may be.
const TTL_MILLIS: u16 = 400;
/// Subscriptions of one client.
const MOST_SUBSCRIPTIONS: usize = 64;

/// Serves a client to its end.
pub(crate) async fn run(socket: WebSocket, shared: &Shared) {
    let (adapter, writer) = Adapter::new(socket, shared);
    let mut peer = Peer {
        adapter,
        shared,
        client: None,
        outbox: Arc::new(Outbox::default()),
        topics: Topics::default(),
        subscriptions: BTreeMap::new(),
        services: Services::default(),
        seen: 0,
        sequence: 0,
    };
    writer.beside(peer.live()).await;
    peer.leave().await;
}

/// What a client wants of a topic.
struct Subscription {
    /// At least so long between two messages.
    throttle: Duration,
    sent: Option<Duration>,
}

struct Peer<'a> {
    adapter: Adapter<'a>,
    shared: &'a Shared,
    /// Its number at the hub, and whether it may drive.
    client: Option<(ClientId, bool)>,
    outbox: Arc<Outbox>,
    topics: Topics,
    subscriptions: BTreeMap<String, Subscription>,
    services: Services,
    /// Newest bridge time that it has surely seen, µs.
    seen: u64,
    sequence: u32,
}

impl Peer<'_> {
    async fn live(&mut self) -> Result<(), End> {
        if self.shared.about.watching == Watching::Anyone {
            self.join(false).await?;
        }
        let too_late = tokio::time::sleep(self.shared.limits.hello);
        tokio::pin!(too_late);
        let mut ping = tokio::time::interval(DRIVER_PING);
        let mut pinged = Duration::ZERO;
        loop {
            let outbox = Arc::clone(&self.outbox);
            let next = self.adapter.when_idle(&outbox);
            tokio::select! {
                incoming = self.adapter.next() => self.receive(incoming?).await?,
                next = next => match next {
                    Next::Close(code) => return Err(Some(code)),
                    Next::Message(message) => self.forward(&message)?,
                },
                () = &mut too_late, if self.client.is_none() => return Err(Some(close::ACCESS)),
                _ = ping.tick() => {
                    let now = self.shared.clock.now();
                    let may_drive = self.client.is_some_and(|(_, may_drive)| may_drive);
                    if may_drive || now >= pinged + PING {
                        pinged = now;
                        self.adapter.ping(&(now.as_micros() as u64).to_le_bytes())?;
                    }
                }
            }
        }
    }

    /// Becomes a client of the hub; again, with the right to drive, once that is shown.
    async fn join(&mut self, may_drive: bool) -> Result<(), End> {
        self.leave().await;
        let (id, outbox) = self.shared.join("rosbridge".to_owned(), may_drive).await?;
        self.outbox = outbox;
        self.client = Some((id, may_drive));
        Ok(())
    }

    async fn leave(&mut self) {
        if let Some((id, _)) = self.client.take() {
            self.shared.leave(id).await;
        }
    }

    async fn receive(&mut self, incoming: Incoming) -> Result<(), End> {
        match incoming {
            Incoming::Text(text) => {
                let asked = serde_json::from_str(&text).map_err(|_| Some(MALFORMED))?;
                self.handle(asked).await
            }
            Incoming::Pong(bytes) => {
                let sent = bytes.try_into().map(u64::from_le_bytes).unwrap_or(0);
                let now = self.shared.clock.now().as_micros() as u64;
                // Nobody has seen what is still to come: that answers no ping of ours.
                if sent <= now {
                    self.seen = self.seen.max(sent);
                }
                Ok(())
            }
            Incoming::Binary => self.refuse("binary messages are not taken"),
        }
    }

    async fn handle(&mut self, asked: Request) -> Result<(), End> {
        match asked {
            Request::Subscribe {
                topic,
                throttle_rate,
            } => self.subscribe(topic, throttle_rate),
            Request::Unsubscribe { topic } => {
                self.subscriptions.remove(&topic);
                Ok(())
            }
            Request::Publish { topic, msg } if topic == VELOCITY => {
                let twist: Twist = serde_json::from_value(msg).map_err(|_| Some(MALFORMED))?;
                self.drive(&twist).await
            }
            Request::Advertise { topic } if topic == VELOCITY => Ok(()),
            Request::Publish { topic, .. } | Request::Advertise { topic } => {
                let why = format!("{topic} is not taken here; {VELOCITY} is");
                self.refuse(&why)
            }
            Request::CallService { id, service, args } => self.serve(id, service, &args).await,
            Request::Unadvertise => Ok(()),
            Request::Other => self.refuse("this operation is not known here"),
        }
    }

    fn subscribe(&mut self, topic: String, throttle_millis: u64) -> Result<(), End> {
        if !Topics::NAMES.contains(&topic.as_str()) {
            return self.refuse(&message::no_topic(&topic));
        }
        if self.subscriptions.len() < MOST_SUBSCRIPTIONS {
            let throttle = Duration::from_millis(throttle_millis);
            let subscription = Subscription {
                throttle,
                sent: None,
            };
            self.subscriptions.insert(topic, subscription);
        }
        Ok(())
    }

    async fn drive(&mut self, twist: &Twist) -> Result<(), End> {
        let motion = Command::Velocity {
            forward: twist.linear.x,
            turn: twist.angular.z,
        };
        self.ask(ToBridge::Drive(DriveBody {
            epoch: self.services.epoch,
            seen: self.seen,
            ttl_millis: TTL_MILLIS,
            motion,
        }))
        .await
    }

    /// Asks the hub for something, as any client would.
    async fn ask(&mut self, message: ToBridge) -> Result<(), End> {
        let Some((id, _)) = self.client else {
            return Err(Some(close::ACCESS));
        };
        self.sequence += 1;
        let header = Header {
            sequence: self.sequence,
            micros: 0,
        };
        let now = self.shared.clock.now();
        let says = FromClient::Message(id, header, message, now);
        self.shared.tell(says).await
    }

    /// Sends what was subscribed of a message, and answers what waits for it.
    fn forward(&mut self, message: &FromBridge) -> Result<(), End> {
        if let Some(answer) = self
            .services
            .answer_to(message, self.client.map(|(id, _)| id))
        {
            self.adapter.send(&answer)?;
        } else if let FromBridge::Refused(reason) = message {
            let why = format!("{VELOCITY} was left out: {reason}");
            self.refuse(&why)?;
        }
        let now = self.shared.clock.now();
        for (topic, msg) in self
            .topics
            .messages(message, self.shared.clock.time_of_day(now))
        {
            let Some(subscription) = self.subscriptions.get_mut(topic) else {
                continue;
            };
            if subscription
                .sent
                .is_none_or(|at| now >= at + subscription.throttle)
            {
                subscription.sent = Some(now);
                self.adapter.send(&Reply::Publish { topic, msg })?;
            }
        }
        Ok(())
    }

    fn refuse(&mut self, why: &str) -> Result<(), End> {
        self.adapter.send(&Reply::Status {
            level: "error",
            msg: why,
        })
    }
}
