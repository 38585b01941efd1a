//! Publishes the hub's messages for everybody at the router.
//!
//! In: an outbox of the hub, as a watcher has. Out: each kind of message under its own key, on its
//! lane; the last of each state in answer to queries; and stops to the hub.

use std::collections::BTreeMap;
use std::io;
use std::sync::{Arc, Mutex, PoisonError};

use ::zenoh::bytes::Encoding;
use ::zenoh::pubsub::{Publisher, Subscriber};
use ::zenoh::qos::{CongestionControl, Priority};
use ::zenoh::query::Queryable;
use ::zenoh::{Session, Wait};
use slamlab_core::wire::message::{Format, FromBridge, Header, ToBridge, Watching, encode};

use super::keys::{self, Keys};
use super::lane::{Put, Readings, Stalled, Urgent, say_failed};
use crate::access_log::Peer;
use crate::clock::Clock;
use crate::hub::FromClient;
use crate::hub::outbox::{Next, Outbox};
use crate::safety::ClientId;
use crate::shared::Shared;

/// Name of the streams among the hub's clients.
const NAME: &str = "zenoh";

/// Key under which the address of the robot's page is found.
pub(super) const PAGE: &str = "page";

/// The last of each state, by its key.
type States = Arc<Mutex<BTreeMap<String, Vec<u8>>>>;

/// The streams at the router; they end when this is dropped.
pub(super) struct Streams {
    outbox: Arc<Outbox>,
    urgent: Urgent,
    readings: Readings,
    writer: Writer,
    /// Answer queries and listen for stops as long as they are kept.
    _ways_in: (Queryable<()>, Option<Subscriber<()>>),
    _client: Joined,
}

/// A client of the hub until it is dropped.
pub(super) struct Joined {
    pub(super) id: ClientId,
    shared: Arc<Shared>,
}

impl Joined {
    pub(super) fn new(id: ClientId, shared: Arc<Shared>) -> Self {
        Self { id, shared }
    }
}

impl Drop for Joined {
    fn drop(&mut self) {
        let (id, shared) = (self.id, Arc::clone(&self.shared));
        // The hub is gone only when the bridge ends.
        if shared.hub.try_send(FromClient::Left(id)).is_err() {
            tokio::spawn(async move { shared.leave(id).await });
        }
    }
}

/// Why there are no streams, or why they ended.
#[derive(Debug, thiserror::Error)]
pub(super) enum StreamsError {
    #[error("{0}")]
    Zenoh(::zenoh::Error),
    #[error("no thread: {0}")]
    Thread(#[from] io::Error),
    #[error("the bridge ends")]
    Ends,
    #[error("it takes nothing any more")]
    Stalled,
}

impl From<::zenoh::Error> for StreamsError {
    fn from(error: ::zenoh::Error) -> Self {
        Self::Zenoh(error)
    }
}

impl From<Stalled> for StreamsError {
    fn from(_: Stalled) -> Self {
        Self::Stalled
    }
}

/// Writes messages as text, and keeps the last of each state.
#[derive(Clone)]
struct Writer {
    session: Session,
    keys: Keys,
    clock: Clock,
    states: States,
    publishers: BTreeMap<&'static str, Arc<Publisher<'static>>>,
    sequence: u32,
}

impl Streams {
    pub(super) async fn start(
        session: &Session,
        keys: &Keys,
        shared: &Arc<Shared>,
        urgent: Urgent,
        page: Option<String>,
        mut also: impl FnMut(&FromBridge) + Send + 'static,
    ) -> Result<Self, StreamsError> {
        let joined = shared.let_in(Peer::Router(None), NAME.to_owned(), None);
        let (id, outbox) = joined.await.map_err(|_| StreamsError::Ends)?;
        let client = Joined::new(id, Arc::clone(shared));
        let states = States::default();
        if let Some(page) = page {
            let page = serde_json::Value::from(page).to_string();
            let mut states = states.lock().unwrap_or_else(PoisonError::into_inner);
            states.insert(keys.stream(PAGE), page.into_bytes());
        }
        let writer = Writer {
            session: session.clone(),
            keys: keys.clone(),
            clock: shared.clock,
            states: Arc::clone(&states),
            publishers: BTreeMap::new(),
            sequence: 0,
        };
        let mut for_readings = writer.clone();
        let readings = Readings::start(move |message| {
            for_readings.put_reading(message);
            also(message);
        })?;
        let answers = session
            .declare_queryable(keys.all_streams())
            .callback(move |query| {
                let states = states
                    .lock()
                    .unwrap_or_else(PoisonError::into_inner)
                    .clone();
                for (key, payload) in states {
                    let is_asked =
                        |key: &str| query.key_expr().intersects(&as_key(key)?).then_some(());
                    if is_asked(&key).is_some() {
                        let reply = query.reply(&key, payload);
                        say_failed(reply.encoding(Encoding::APPLICATION_JSON).wait());
                    }
                }
            })
            .await?;
        // If watching needs a token, a stop needs one too, so the open stop key is not served.
        let stop = match shared.about.watching {
            Watching::Anyone => Some(listen_for_stop(session, keys, shared, id).await?),
            Watching::Token => None,
        };
        Ok(Self {
            outbox,
            urgent,
            readings,
            writer,
            _ways_in: (answers, stop),
            _client: client,
        })
    }

    /// Passes the hub's messages on, until there are no more or the router takes no more.
    pub(super) async fn run(&mut self) -> StreamsError {
        loop {
            let Next::Message(message) = self.outbox.next().await else {
                return StreamsError::Ends;
            };
            let Some(stream) = keys::stream(&message) else {
                continue;
            };
            if !stream.is_urgent {
                self.readings.put(&message);
            } else if let Err(error) = self.put_urgent(stream, &message).await {
                return error;
            }
        }
    }

    async fn put_urgent(
        &mut self,
        stream: keys::Stream,
        message: &FromBridge,
    ) -> Result<(), StreamsError> {
        let Some(payload) = self.writer.write(stream, message) else {
            return Ok(());
        };
        let publisher = self.writer.publisher(stream)?;
        Ok(self.urgent.put(Put { publisher, payload })?)
    }
}

fn as_key(key: &str) -> Option<::zenoh::key_expr::KeyExpr<'_>> {
    ::zenoh::key_expr::KeyExpr::new(key).ok()
}

/// Stops the robot when anything is put at the stop key, whoever puts it.
async fn listen_for_stop(
    session: &Session,
    keys: &Keys,
    shared: &Arc<Shared>,
    id: ClientId,
) -> Result<Subscriber<()>, StreamsError> {
    let (shared, runtime) = (Arc::clone(shared), tokio::runtime::Handle::current());
    let stop = move |_| {
        let now = shared.clock.now();
        let stop = FromClient::Message(id, Header::default(), ToBridge::Stop, now);
        // This runs on a thread of Zenoh, which must not wait; but a stop must not be lost.
        if let Err(full) = shared.hub.try_send(stop) {
            let (stop, shared) = (full.into_inner(), Arc::clone(&shared));
            runtime.spawn(async move { shared.tell(stop).await });
        }
    };
    let listening = session.declare_subscriber(keys.stop()).callback(stop);
    Ok(listening.await?)
}

impl Writer {
    /// The text of a message.
    fn write(&mut self, stream: keys::Stream, message: &FromBridge) -> Option<Vec<u8>> {
        self.sequence = self.sequence.wrapping_add(1);
        let header = Header {
            sequence: self.sequence,
            micros: self.clock.now().as_micros() as u64,
        };
        let written = encode(header, message, Format::Json);
        let payload = written
            .map_err(|error| tracing::error!("zenoh: {error}"))
            .ok()?;
        if stream.is_state {
            let key = self.keys.stream(stream.name);
            let mut states = self.states.lock().unwrap_or_else(PoisonError::into_inner);
            states.insert(key, payload.clone());
        }
        Some(payload)
    }

    fn publisher(&mut self, stream: keys::Stream) -> ::zenoh::Result<Arc<Publisher<'static>>> {
        if let Some(publisher) = self.publishers.get(stream.name) {
            return Ok(Arc::clone(publisher));
        }
        let key = self.keys.stream(stream.name);
        let priority = match stream.is_urgent {
            true => Priority::RealTime,
            false => Priority::Data,
        };
        let publisher = publisher(&self.session, key, priority)?;
        self.publishers.insert(stream.name, Arc::clone(&publisher));
        Ok(publisher)
    }

    fn put_reading(&mut self, message: &FromBridge) {
        let Some(stream) = keys::stream(message) else {
            return;
        };
        let Some(payload) = self.write(stream, message) else {
            return;
        };
        match self.publisher(stream) {
            Ok(publisher) => say_failed(publisher.put(payload).wait()),
            Err(error) => say_failed(Err(error)),
        }
    }
}

/// A publisher of text that blocks on a slow link: what waits for it is bounded elsewhere.
pub(super) fn publisher(
    session: &Session,
    key: String,
    priority: Priority,
) -> ::zenoh::Result<Arc<Publisher<'static>>> {
    let publisher = session
        .declare_publisher(key)
        .congestion_control(CongestionControl::Block)
        .priority(priority)
        .express(priority == Priority::RealTime)
        .encoding(Encoding::APPLICATION_JSON)
        .wait()?;
    Ok(Arc::new(publisher))
}
