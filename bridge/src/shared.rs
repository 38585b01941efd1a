//! What all connections share: they read it, and the hub's queue is their way to the robot.

use std::sync::Arc;
use std::time::Duration;

use slamlab_core::device::hub;
use slamlab_core::wire::message::{About, BridgeHello, CHALLENGE_BYTES, RobotFigures};
use tokio::sync::{OwnedSemaphorePermit, mpsc, oneshot};

use crate::clock::Clock;
use crate::ending::{End, GOING_AWAY};
use crate::hub::outbox::Outbox;
use crate::hub::{FromClient, NewClient};
use crate::metrics::Metrics;
use crate::page::Page;
use crate::safety::ClientId;
use crate::token::Token;

/// What all connections share.
pub(crate) struct Shared {
    pub(crate) page: Option<Page>,
    pub(crate) about: About,
    pub(crate) robot: Option<RobotFigures>,
    pub(crate) token: Option<Token>,
    pub(crate) origins: Vec<String>,
    /// Whether Foxglove may watch.
    pub(crate) foxglove: bool,
    /// Whether rosbridge is spoken.
    pub(crate) rosbridge: bool,
    pub(crate) is_tls: bool,
    pub(crate) limits: Limits,
    pub(crate) hub: mpsc::Sender<FromClient>,
    pub(crate) clock: Clock,
    pub(crate) metrics: Arc<Metrics>,
}

impl Shared {
    /// What the bridge says first, to a client and to a recording.
    pub(crate) fn hello(&self, challenge: [u8; CHALLENGE_BYTES]) -> BridgeHello {
        let (watching, robot) = (self.about.watching, self.robot.clone());
        hub::hello(challenge, watching, robot)
    }
}

/// A client's number, and what waits to be sent to it.
pub(crate) type Joined = (ClientId, Arc<Outbox>);

impl Shared {
    /// Lets a client in that has shown who it is.
    pub(crate) async fn join(&self, name: String, may_drive: bool) -> Result<Joined, End> {
        let outbox = Arc::new(Outbox::default());
        let (answer, id) = oneshot::channel();
        let client = NewClient {
            name,
            may_drive,
            outbox: Arc::clone(&outbox),
        };
        self.tell(FromClient::Joined(client, answer)).await?;
        let id = id.await.map_err(|_| Some(GOING_AWAY))?;
        Ok((id, outbox))
    }

    /// A client's connection has ended.
    pub(crate) async fn leave(&self, id: ClientId) {
        // The hub is gone only when the bridge ends.
        let _ = self.tell(FromClient::Left(id)).await;
    }

    /// Hands something on to the hub.
    pub(crate) async fn tell(&self, what: FromClient) -> Result<(), End> {
        self.hub.send(what).await.map_err(|_| Some(GOING_AWAY))
    }
}

/// A place among the sockets; it is free again when the last holder drops it.
pub(crate) type Place = Arc<OwnedSemaphorePermit>;

/// How much the bridge takes on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Sockets that may be open at the same time. Default 300.
    pub sockets: usize,
    /// A request's header must be there so soon. Default 5 s.
    pub header: Duration,
    /// A connection that is no WebSocket ends after so long. Default 120 s.
    pub request: Duration,
    /// The first message must be there so soon. Default 2 s.
    pub hello: Duration,
    /// A client that says nothing for so long is gone. Default 5 s.
    pub heartbeat: Duration,
    /// A client that takes nothing for so long is gone. Default 30 s.
    pub write: Duration,
    /// Longest message from a client, bytes. Default 64 KiB.
    pub message: usize,
    /// Messages of one client in a second, over longer times; twice as many at once. Default 200.
    pub rate: u32,
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            sockets: 300,
            header: Duration::from_secs(5),
            request: Duration::from_secs(120),
            hello: Duration::from_secs(2),
            heartbeat: Duration::from_secs(5),
            write: Duration::from_secs(30),
            message: 64 * 1024,
            rate: 200,
        }
    }
}
