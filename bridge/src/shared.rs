//! What all connections share: read-only state, and the hub's queue, which is their way to the
//! robot.

#[cfg(feature = "zenoh")]
use std::net::SocketAddr;
use std::sync::Arc;
use std::time::Duration;

use slamlab_core::device::hub;
use slamlab_core::wire::message::{
    About, BridgeHello, CHALLENGE_BYTES, PROOF_BYTES, RobotFigures, close,
};
use tokio::sync::{mpsc, oneshot, watch};

use crate::access_log::{AccessLog, Kind, Peer};
use crate::audit::{Audit, What};
use crate::clock::Clock;
use crate::ending::{self, End, GOING_AWAY};
use crate::hub::outbox::Outbox;
use crate::hub::{FromClient, NewClient};
use crate::mapping::Mapping;
use crate::metrics::Metrics;
use crate::page::Page;
use crate::places::Place;
use crate::rights::{Granted, Rights};
use crate::safety::ClientId;

/// What all connections share.
pub(crate) struct Shared {
    pub(crate) page: Option<Page>,
    pub(crate) about: About,
    pub(crate) robot: Option<RobotFigures>,
    /// The present rights.
    pub(crate) rights: watch::Receiver<Arc<Rights>>,
    pub(crate) origins: Vec<String>,
    /// Names that the bridge answers to in addition to its own.
    pub(crate) hosts: Arc<[String]>,
    /// Whether Foxglove may watch.
    pub(crate) foxglove: bool,
    /// Whether the rosbridge endpoint is on.
    pub(crate) rosbridge: bool,
    pub(crate) is_tls: bool,
    pub(crate) limits: Limits,
    pub(crate) hub: mpsc::Sender<FromClient>,
    pub(crate) clock: Clock,
    pub(crate) metrics: Arc<Metrics>,
    pub(crate) log: Arc<AccessLog>,
    pub(crate) audit: Option<Arc<Audit>>,
    /// None if the bridge does not map.
    pub(crate) mapping: Option<Arc<Mapping>>,
    /// None if the bridge uses no router.
    #[cfg(feature = "zenoh")]
    pub(crate) fleet: Option<Arc<crate::zenoh::Fleet>>,
    /// Where the bridge listens; none if the system does not tell.
    #[cfg(feature = "zenoh")]
    pub(crate) listening: Option<SocketAddr>,
    /// None if recordings are not stored elsewhere.
    #[cfg(feature = "storage")]
    pub(crate) uploads: Option<Arc<crate::storage::Uploads>>,
}

/// A connection: its place, and its address.
#[derive(Clone, Debug)]
pub(crate) struct Visitor {
    pub(crate) place: Arc<Place>,
    pub(crate) peer: Peer,
}

impl Shared {
    /// What the bridge says first, to a client and to a recording.
    pub(crate) fn hello(&self, challenge: [u8; CHALLENGE_BYTES]) -> BridgeHello {
        let (watching, robot) = (self.about.watching, self.robot.clone());
        hub::hello(challenge, watching, robot)
    }
}

/// A client's number and outbox.
pub(crate) type Joined = (ClientId, Arc<Outbox>);

impl Shared {
    /// The right that a proof shows.
    pub(crate) fn proved(
        &self,
        challenge: &[u8; CHALLENGE_BYTES],
        shown: &[u8; PROOF_BYTES],
    ) -> Option<Granted> {
        let rights = Arc::clone(&self.rights.borrow());
        rights.proved(challenge, shown)
    }

    /// Lets a client in, with the right that it has shown or else as a watcher; [`close::FULL`] if
    /// no place is left for it.
    pub(crate) async fn join(
        &self,
        visitor: &Visitor,
        name: String,
        granted: Option<Granted>,
    ) -> Result<Joined, End> {
        let may_drive = granted.as_ref().is_some_and(Granted::may_drive);
        let is_room = match may_drive {
            true => visitor.place.trust(),
            false => visitor.place.watch(),
        };
        if !is_room {
            self.metrics.turned_away.add(1);
            return Err(Some(close::FULL));
        }
        self.let_in(visitor.peer, name, granted).await
    }

    /// The same without a place: for ways in that have their own limits.
    pub(crate) async fn let_in(
        &self,
        peer: Peer,
        name: String,
        granted: Option<Granted>,
    ) -> Result<Joined, End> {
        let outbox = Arc::new(Outbox::default());
        let (answer, id) = oneshot::channel();
        let client = NewClient {
            name,
            granted,
            peer,
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

    /// Sends something to the hub.
    pub(crate) async fn tell(&self, what: FromClient) -> Result<(), End> {
        self.hub.send(what).await.map_err(|_| Some(GOING_AWAY))
    }

    /// Logs that the bridge ended a connection, and counts clients without access.
    pub(crate) fn shown_out(&self, visitor: &Visitor, code: u16) {
        self.ended(visitor.peer, code);
    }

    /// The same for a connection without a place of its own.
    pub(crate) fn ended(&self, peer: Peer, code: u16) {
        let kind = kind_of(code);
        self.metrics.shown_out.add(1);
        if code == close::ACCESS {
            self.metrics.intruders.add(1);
        }
        if let Some(kind) = kind {
            let why = ending::reason(code);
            let now = self.clock.now();
            let what = format_args!("{peer} was shown out ({code}): {why}");
            let is_admitted = self.log.note(now, kind, what);
            if is_admitted && let Some(audit) = &self.audit {
                audit.note(
                    now,
                    &What::Refused {
                        from: peer,
                        code,
                        why,
                    },
                );
            }
        }
    }
}

/// How the end of a connection is logged; none if it is nothing out of the ordinary.
fn kind_of(code: u16) -> Option<Kind> {
    match code {
        GOING_AWAY => None,
        close::ACCESS => Some(Kind::Proof),
        close::FULL => Some(Kind::Full),
        _ => Some(Kind::ShownOut),
    }
}

/// The bridge's limits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Sockets that may be open at the same time. Default 300.
    pub sockets: usize,
    /// Of these, from one address; of IPv6, from one network of 64 bits. Default 100.
    pub per_address: usize,
    /// Clients that may only watch. Default 200: the other places are kept for those that may
    /// drive.
    pub watchers: usize,
    /// Of these, from one address. Default 80.
    pub watchers_per_address: usize,
    /// Time within which a request's header must arrive. Default 5 s.
    pub header: Duration,
    /// Time after which a connection that is no WebSocket ends. Default 120 s.
    pub request: Duration,
    /// Time within which the first message must arrive. Default 2 s.
    pub hello: Duration,
    /// Time after which a silent client counts as gone. Default 5 s.
    pub heartbeat: Duration,
    /// Time after which a client that reads nothing counts as gone. Default 30 s.
    pub write: Duration,
    /// Longest message from a client, bytes. Default 64 KiB.
    pub message: usize,
    /// Messages per second of one client that may drive, on average; a burst may be twice as large.
    /// Default 200.
    pub rate: u32,
    /// The same for everybody else. Default 20.
    pub watcher_rate: u32,
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            sockets: 300,
            per_address: 100,
            watchers: 200,
            watchers_per_address: 80,
            header: Duration::from_secs(5),
            request: Duration::from_secs(120),
            hello: Duration::from_secs(2),
            heartbeat: Duration::from_secs(5),
            write: Duration::from_secs(30),
            message: 64 * 1024,
            rate: 200,
            watcher_rate: 20,
        }
    }
}
