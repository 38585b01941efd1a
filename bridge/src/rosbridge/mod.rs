//! A subset of rosbridge v2, for scripts that use roslibjs or roslibpy.
//!
//! In: JSON from such a client. Out: `/scan`, `/odom` and `/tf` to subscribers, and `/map` and
//! `/pose` if the bridge maps; `/cmd_vel` to the robot, from a client that has shown a driver's
//! token, holds the lease and has armed the robot.
//!
//! 1. It is served on the bridge's own port, at [`PATH`], behind the same checks; it is off by
//!    default.
//! 2. rosbridge has no place for a token, so services are used: `/slamlab/challenge` gives a
//!    challenge, `/slamlab/enter` takes the proof made from it
//!    ([`slamlab_core::wire::message::proof`]), `/slamlab/take` takes the lease, `/slamlab/arm`
//!    arms. Then `/cmd_vel` drives, at 10 Hz or faster, by the same rules as for every client
//!    ([`crate::safety`]). Anyone may call `/slamlab/stop` and `/slamlab/emergency_stop`; if
//!    watching needs the token, the proof must come first, and in time. `/rosapi` lists what there
//!    is (`rosapi`).
//! 3. There is no `/map` if the bridge does not map: clients can build their own, and `export`
//!    makes one from a recording.
//! 4. A driving message must give an upper bound of its age, which rosbridge's messages do not. So
//!    a driver is pinged ten times a second with the bridge's time. A WebSocket keeps its messages
//!    in order, so whatever follows a pong was sent after the client saw that ping.
//!
//! Source: rosbridge v2 protocol specification (github.com/RobotWebTools/rosbridge_suite,
//! ROSBRIDGE_PROTOCOL.md).

mod message;
mod request;
mod rosapi;
mod services;
mod subscriptions;

use std::sync::Arc;
use std::time::Duration;

use axum::extract::ws::WebSocket;
use serde_json::Value;
use slamlab_core::robot::Command;
use slamlab_core::wire::message::{
    DriveBody, FromBridge, Header, RefusalReason, ToBridge, Watching, close,
};

use crate::adapter::{Adapter, Incoming, PING};
use crate::ending::{End, GOING_AWAY};
use crate::hub::outbox::{Next, Outbox};
use crate::hub::{Answer, FromClient};
use crate::rights::Granted;
use crate::safety::ClientId;
use crate::shared::{Shared, Visitor};
use message::{Reply, Topics};
use request::{Asked, Request, velocity};
use services::Services;
use subscriptions::Subscriptions;
use tokio::sync::oneshot;

/// Path of the endpoint.
pub(crate) const PATH: &str = "/rosbridge";
const VELOCITY: &str = "/cmd_vel";
/// Interval between pings of a client that may drive.
const DRIVER_PING: Duration = Duration::from_millis(100);
/// How old a driving message may be.
const TTL_MILLIS: u16 = 400;
/// Interval between answers that give the same reason for ignoring a command.
const SAY_AGAIN: Duration = Duration::from_secs(1);

/// Serves a client to its end.
pub(crate) async fn run(socket: WebSocket, shared: &Shared, visitor: &Visitor) {
    let (adapter, writer) = Adapter::new(socket, shared);
    let mut peer = Peer {
        adapter,
        shared,
        visitor,
        client: None,
        outbox: Arc::new(Outbox::default()),
        topics: Topics::default(),
        subscriptions: Subscriptions::default(),
        services: Services::default(),
        seen: 0,
        sequence: 0,
        left_out: None,
    };
    writer.beside(visitor, peer.live()).await;
    peer.leave().await;
}

struct Peer<'a> {
    adapter: Adapter<'a>,
    shared: &'a Shared,
    visitor: &'a Visitor,
    /// Its number at the hub, and whether it may drive.
    client: Option<(ClientId, bool)>,
    outbox: Arc<Outbox>,
    topics: Topics,
    subscriptions: Subscriptions,
    services: Services,
    /// Newest bridge time that the client has certainly seen, µs.
    seen: u64,
    sequence: u32,
    /// Why a command was last ignored, and when that was reported.
    left_out: Option<(RefusalReason, Duration)>,
}

impl Peer<'_> {
    async fn live(&mut self) -> Result<(), End> {
        let mut why_not = close::ACCESS;
        if self.shared.about.watching == Watching::Anyone {
            match self.join(None).await {
                // A client that has a token may still show it.
                Err(Some(close::FULL)) => why_not = close::FULL,
                joined => joined?,
            }
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
                () = &mut too_late, if self.client.is_none() => return Err(Some(why_not)),
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

    /// Joins the hub as a client; joins again, with its right, once that is shown.
    async fn join(&mut self, granted: Option<Granted>) -> Result<(), End> {
        self.leave().await;
        let name = "rosbridge".to_owned();
        let may_drive = granted.as_ref().is_some_and(Granted::may_drive);
        let (id, outbox) = self.shared.join(self.visitor, name, granted).await?;
        if may_drive {
            self.adapter.trust();
        }
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
            Incoming::Text(text) => match Request::read(&text) {
                Ok(request) => self.handle(request).await,
                Err(said) => self.refuse(said.id, &said.why),
            },
            Incoming::Pong(bytes) => {
                let sent = bytes.try_into().map(u64::from_le_bytes).unwrap_or(0);
                let now = self.shared.clock.now().as_micros() as u64;
                // A time in the future answers no ping of ours.
                if sent <= now {
                    self.seen = self.seen.max(sent);
                }
                Ok(())
            }
            Incoming::Binary => self.refuse(None, "binary messages are not taken"),
        }
    }

    async fn handle(&mut self, Request { id, asked }: Request) -> Result<(), End> {
        match asked {
            Asked::Subscribe { topic, throttle } => self.subscribe(id, topic, throttle),
            Asked::Unsubscribe { topic } => {
                self.subscriptions.remove(&topic, id.as_ref());
                Ok(())
            }
            Asked::Publish { topic, msg } if topic == VELOCITY => match velocity(&msg) {
                Ok(motion) => self.drive(id, motion).await,
                Err(why) => self.refuse(id, &why),
            },
            Asked::Advertise { topic } if topic == VELOCITY => Ok(()),
            Asked::Publish { topic, .. } | Asked::Advertise { topic } => {
                let why = format!("{topic} is not taken here; {VELOCITY} is");
                self.refuse(id, &why)
            }
            Asked::CallService { service, args } => self.serve(id, service, &args).await,
            Asked::Nothing => Ok(()),
        }
    }

    fn subscribe(
        &mut self,
        id: Option<Value>,
        topic: String,
        throttle: Duration,
    ) -> Result<(), End> {
        let maps = self.shared.mapping.is_some();
        if !Topics::names(maps).contains(&topic.as_str()) {
            return self.refuse(id, &message::no_topic(&topic, maps));
        }
        let is_map = topic == "/map";
        if let Err(why) = self.subscriptions.add(topic, id.as_ref(), throttle) {
            return self.refuse(id, &why);
        }
        // The map is sent when it changes, and at once to a new subscriber, which may have missed
        // the last change.
        let mapping = self.shared.mapping.as_ref();
        let map = mapping.and_then(|mapping| mapping.shown().borrow().map.clone());
        match map.filter(|_| is_map) {
            Some(map) => self.forward(&map),
            None => Ok(()),
        }
    }

    async fn drive(&mut self, id: Option<Value>, motion: Command) -> Result<(), End> {
        let message = ToBridge::Drive(DriveBody {
            epoch: self.services.epoch,
            seen: self.seen,
            ttl_millis: TTL_MILLIS,
            motion,
        });
        let reason = match self.ask(message).await? {
            Some(Answer::Refused(reason)) => reason,
            Some(Answer::Done | Answer::Granted(_)) => return Ok(()),
            None => RefusalReason::NoRight,
        };
        let now = self.shared.clock.now();
        let was_said =
            |(said, at): (RefusalReason, Duration)| said == reason && now < at + SAY_AGAIN;
        if self.left_out.is_some_and(was_said) {
            return Ok(());
        }
        self.left_out = Some((reason, now));
        self.refuse(id, &format!("{VELOCITY} was left out: {reason}"))
    }

    /// Sends a message to the hub, as any client would, and waits for the answer; none if it is not
    /// a client yet.
    async fn ask(&mut self, message: ToBridge) -> Result<Option<Answer>, End> {
        let Some((id, _)) = self.client else {
            return Ok(None);
        };
        self.sequence += 1;
        let header = Header {
            sequence: self.sequence,
            micros: 0,
        };
        let (answer, answered) = oneshot::channel();
        let now = self.shared.clock.now();
        let says = FromClient::Asked(id, header, message, now, answer);
        self.shared.tell(says).await?;
        // The hub is gone only when the bridge ends.
        answered.await.map(Some).map_err(|_| Some(GOING_AWAY))
    }

    /// Sends what a message holds for the subscribed topics.
    fn forward(&mut self, message: &FromBridge) -> Result<(), End> {
        let now = self.shared.clock.now();
        for (topic, msg) in self
            .topics
            .messages(message, self.shared.clock.time_of_day(now))
        {
            if self.subscriptions.is_due(topic, now) {
                self.adapter.send(&Reply::Publish { topic, msg })?;
            }
        }
        Ok(())
    }

    fn refuse(&mut self, id: Option<Value>, why: &str) -> Result<(), End> {
        self.adapter.send(&Reply::Status {
            id,
            level: "error",
            msg: why,
        })
    }
}
