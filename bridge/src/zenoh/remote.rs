//! Clients behind the router: the same conversation as over a WebSocket, under two keys.
//!
//! In: messages at `slamlab/NAME/to/CLIENT`, and the liveliness token that a client declares at the
//! same key. Out: messages to the hub as from any client, and the hub's answers at
//! `slamlab/NAME/from/CLIENT`.
//!
//! 1. A client draws a random number of 16 hexadecimal digits, listens at `from/`, and declares its
//!    token at `to/`: this opens the connection. The bridge says hello with a challenge; the client
//!    answers as everywhere, with a proof or as a watcher.
//! 2. A client that has shown a right to drive signs each later message: the attachment is
//!    [`MessageKey::sign`] of the payload. Messages that others write at its key are ignored: they
//!    do not count against its rate, and do not end the connection. Replayed messages are ignored,
//!    because sequence numbers must rise. An attacker that writes there before the client has said
//!    hello can keep it from coming in, but can do no more.
//! 3. The connection ends when the token disappears (the client, its network or its router is
//!    gone), when the client is silent for longer than a WebSocket may be, or with a code:
//!    `{"close":4009,"reason":"…"}` is the last message to it. Then its robot stops as for any lost
//!    driver.
//! 4. The end of a token may overtake messages sent before it: a client that stops a robot this way
//!    must stay until it is told that the robot is disarmed, or put its stop at
//!    `slamlab/NAME/stop`.
//! 5. A client is sent its own messages and the states; it takes readings from the streams.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use ::zenoh::Session;
use ::zenoh::pubsub::{Publisher, Subscriber};
use ::zenoh::qos::Priority;
use ::zenoh::sample::{Sample, SampleKind};
use serde_json::json;
use slamlab_core::wire::message::{
    CHALLENGE_BYTES, Format, FromBridge, Header, MessageKey, ToBridge, close, decode, encode,
};
use tokio::sync::mpsc;
use tokio::time::{Instant, sleep_until, timeout};

use super::keys::{self, Keys};
use super::lane::{Put, Urgent};
use super::streams::{self, Joined, StreamsError};
use crate::access_log::Peer;
use crate::connection::admit;
use crate::ending::{self, End, INTERNAL, MALFORMED, TOO_LARGE, TOO_MANY, TOO_SLOW};
use crate::hub::FromClient;
use crate::hub::outbox::{Next, Outbox};
use crate::rate::Bucket;
use crate::shared::Shared;

/// Most clients at the same time: a router serves a fleet's users, not the public.
const MOST: usize = 64;
/// Most of these that may not drive: the other places are kept for those that may.
const MOST_WATCHERS: usize = 48;
/// Most waiting messages of one client; and most events of all clients (tokens and messages) that
/// wait to be sorted. More are dropped, so that nobody can block the router's link.
const MOST_WAITING: (usize, usize) = (64, 1024);

/// An event from the router.
enum Came {
    Here(u64),
    Gone(u64),
    Said(u64, Said),
}

/// A message, and its signature.
struct Said {
    payload: Vec<u8>,
    signature: Vec<u8>,
}

/// All clients; their connections end when this is dropped.
pub(super) struct Remote {
    came: mpsc::Receiver<Came>,
    clients: BTreeMap<u64, mpsc::Sender<Said>>,
    session: Session,
    keys: Keys,
    shared: Arc<Shared>,
    urgent: Urgent,
    watchers: Arc<AtomicUsize>,
    _listening: (Subscriber<()>, Subscriber<()>),
}

impl Remote {
    pub(super) async fn start(
        session: &Session,
        keys: &Keys,
        shared: &Arc<Shared>,
        urgent: Urgent,
    ) -> Result<Self, StreamsError> {
        let (sender, came) = mpsc::channel(MOST_WAITING.1);
        let (messages, own) = (sender.clone(), keys.clone());
        let said = session
            .declare_subscriber(keys.to("*"))
            .callback(move |sample: Sample| {
                if let Some(number) = own.client(sample.key_expr().as_str()) {
                    let said = Said {
                        payload: sample.payload().to_bytes().into_owned(),
                        signature: sample
                            .attachment()
                            .map_or(vec![], |bytes| bytes.to_bytes().into_owned()),
                    };
                    // If the queue is full, somebody floods the router: drop the message.
                    let _ = messages.try_send(Came::Said(number, said));
                }
            })
            .await?;
        let own = keys.clone();
        let alive = session
            .liveliness()
            .declare_subscriber(keys.to("*"))
            .history(true)
            .callback(move |sample| {
                if let Some(number) = own.client(sample.key_expr().as_str()) {
                    let came = match sample.kind() {
                        SampleKind::Put => Came::Here(number),
                        SampleKind::Delete => Came::Gone(number),
                    };
                    // A missed event does no harm: the client ends by its silence.
                    let _ = sender.try_send(came);
                }
            })
            .await?;
        Ok(Self {
            came,
            clients: BTreeMap::new(),
            session: session.clone(),
            keys: keys.clone(),
            shared: Arc::clone(shared),
            urgent,
            watchers: Arc::default(),
            _listening: (said, alive),
        })
    }

    /// Serves clients as long as it is polled.
    pub(super) async fn run(&mut self) {
        while let Some(came) = self.came.recv().await {
            self.clients.retain(|_, client| !client.is_closed());
            match came {
                Came::Here(number) => self.begin(number),
                // This ends the client's task.
                Came::Gone(number) => _ = self.clients.remove(&number),
                Came::Said(number, said) => {
                    if let Some(client) = self.clients.get(&number) {
                        let _ = client.try_send(said);
                    }
                }
            }
        }
    }

    /// Begins a conversation, unless there is one for this number: a token that is reported once
    /// more, whoever declared it, changes nothing.
    fn begin(&mut self, number: u64) {
        if self.clients.contains_key(&number) {
            return;
        }
        if self.clients.len() >= MOST {
            self.shared.ended(Peer::Router(Some(number)), close::FULL);
            return;
        }
        let key = self.keys.from(number);
        let publisher = match streams::publisher(&self.session, key, Priority::RealTime) {
            Ok(publisher) => publisher,
            Err(error) => return tracing::debug!("zenoh: {error}"),
        };
        let (sender, inbox) = mpsc::channel(MOST_WAITING.0);
        self.clients.insert(number, sender);
        let client = Client {
            peer: Peer::Router(Some(number)),
            shared: Arc::clone(&self.shared),
            inbox,
            publisher,
            urgent: self.urgent.clone(),
            watchers: Arc::clone(&self.watchers),
            sent: 0,
            heard: 0,
        };
        tokio::spawn(client.run());
    }
}

/// One conversation.
struct Client {
    peer: Peer,
    shared: Arc<Shared>,
    inbox: mpsc::Receiver<Said>,
    publisher: Arc<Publisher<'static>>,
    urgent: Urgent,
    /// Number of clients that may not drive.
    watchers: Arc<AtomicUsize>,
    sent: u32,
    heard: u32,
}

/// The state of a client that was let in.
struct Entered {
    joined: Joined,
    outbox: Arc<Outbox>,
    key: Option<MessageKey>,
    _watches: Option<Watches>,
}

/// The place of a client that may not drive.
struct Watches(Arc<AtomicUsize>);

impl Watches {
    fn take(all: &Arc<AtomicUsize>) -> Result<Self, End> {
        let place = Self(Arc::clone(all));
        match all.fetch_add(1, Ordering::Relaxed) < MOST_WATCHERS {
            true => Ok(place),
            false => Err(Some(close::FULL)),
        }
    }
}

impl Drop for Watches {
    fn drop(&mut self) {
        self.0.fetch_sub(1, Ordering::Relaxed);
    }
}

impl Client {
    async fn run(mut self) {
        let ended = match self.enter().await {
            Ok(entered) => self.live(&entered).await,
            Err(end) => end,
        };
        let Some(code) = ended else { return };
        self.shared.ended(self.peer, code);
        let farewell = json!({ "close": code, "reason": ending::reason(code) });
        let _ = self.put(farewell.to_string().into_bytes());
    }

    async fn enter(&mut self) -> Result<Entered, End> {
        let mut challenge = [0; CHALLENGE_BYTES];
        getrandom::fill(&mut challenge).map_err(|_| Some(INTERNAL))?;
        let shared = Arc::clone(&self.shared);
        self.send(&FromBridge::Hello(shared.hello(challenge)))?;
        let first = timeout(shared.limits.hello, self.inbox.recv()).await;
        let said = first.map_err(|_| Some(close::ACCESS))?.ok_or(None)?;
        let (header, ToBridge::Hello(hello)) = self.read(&said)? else {
            return Err(Some(close::ACCESS));
        };
        self.heard = header.sequence;
        let granted = admit(&shared, &challenge, &hello)?;
        let drives = granted.as_ref().filter(|granted| granted.may_drive());
        let key = (drives.zip(hello.proof))
            .map(|(granted, proof)| granted.message_key(&challenge, &proof));
        let watches = key.is_none().then(|| Watches::take(&self.watchers));
        let watches = watches.transpose()?;
        let (id, outbox) = shared.let_in(self.peer, hello.name, granted).await?;
        let joined = Joined::new(id, shared);
        Ok(Entered {
            joined,
            outbox,
            key,
            _watches: watches,
        })
    }

    async fn live(&mut self, entered: &Entered) -> End {
        let shared = Arc::clone(&self.shared);
        let limits = shared.limits;
        let rate = match entered.key {
            Some(_) => limits.rate,
            None => limits.watcher_rate,
        };
        let mut bucket = Bucket::new(rate, shared.clock.now());
        let mut silent = Instant::now() + limits.heartbeat;
        loop {
            tokio::select! {
                next = entered.outbox.next() => match next {
                    Next::Close(code) => return Some(code),
                    Next::Message(message) => {
                        if keys::is_personal(&message) && let Err(end) = self.send(&message) {
                            return end;
                        }
                    }
                },
                said = self.inbox.recv() => {
                    let said = said?;
                    if !is_signed(entered.key.as_ref(), &said) {
                        shared.metrics.malformed.add(1);
                        continue;
                    }
                    // Replayed messages are ignored, too, although they are signed.
                    let (header, message) = match self.read(&said) {
                        Ok((header, _)) if header.sequence <= self.heard => continue,
                        Ok(read) => read,
                        Err(end) => return end,
                    };
                    if !bucket.take(shared.clock.now()) {
                        return Some(TOO_MANY);
                    }
                    self.heard = header.sequence;
                    silent = Instant::now() + limits.heartbeat;
                    if let Err(end) = self.hand_on(entered, header, message).await {
                        return end;
                    }
                }
                () = sleep_until(silent) => return Some(close::HEARTBEAT),
            }
        }
    }

    async fn hand_on(
        &self,
        entered: &Entered,
        header: Header,
        message: ToBridge,
    ) -> Result<(), End> {
        match message {
            ToBridge::Hello(_) => Err(Some(MALFORMED)),
            ToBridge::Heartbeat => Ok(()),
            message => {
                let now = self.shared.clock.now();
                let says = FromClient::Message(entered.joined.id, header, message, now);
                self.shared.tell(says).await
            }
        }
    }

    fn read(&self, said: &Said) -> Result<(Header, ToBridge), End> {
        if said.payload.len() > self.shared.limits.message {
            return Err(Some(TOO_LARGE));
        }
        self.shared.metrics.received.add(1);
        let read = decode::<ToBridge>(&said.payload, Format::Json);
        let (header, message) = read.map_err(|error| {
            self.shared.metrics.malformed.add(1);
            tracing::debug!("a remote client's message: {error}");
            Some(MALFORMED)
        })?;
        Ok((header, message))
    }

    fn send(&mut self, message: &FromBridge) -> Result<(), End> {
        self.sent = self.sent.wrapping_add(1);
        let header = Header {
            sequence: self.sent,
            micros: self.shared.clock.now().as_micros() as u64,
        };
        let payload = encode(header, message, Format::Json).map_err(|error| {
            tracing::error!("a message could not be written: {error}");
            Some(INTERNAL)
        })?;
        self.put(payload)
    }

    fn put(&self, payload: Vec<u8>) -> Result<(), End> {
        let publisher = Arc::clone(&self.publisher);
        let put = Put { publisher, payload };
        self.urgent.put(put).map_err(|_| Some(TOO_SLOW))
    }
}

/// Whether a message is signed if it must be. A client without a key may only do what everybody
/// may, so it need not sign.
fn is_signed(key: Option<&MessageKey>, said: &Said) -> bool {
    key.is_none_or(|key| key.has_signed(&said.payload, &said.signature))
}
