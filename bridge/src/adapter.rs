//! The socket of a client that speaks the protocol of another tool: what all such protocols need of
//! it.
//!
//! In: a WebSocket. Out: the client's messages ([`Adapter::next`]), and a queue for those to it.
//!
//! 1. Reading and writing run side by side ([`Writer::beside`]): a client that reads nothing may
//!    still send a stop. Each write has its time.
//! 2. Answers are queued; a client that lets the queue grow full is disconnected. Readings of the
//!    robot are taken only when the queue is empty ([`Adapter::when_idle`]), so that a slow client
//!    gets fewer and newer ones.
//! 3. Each message of a client, pings too, counts against the rate that the bridge allows.
//! 4. Such protocols know no heartbeat of their own. A ping goes out each [`PING`]; a client that
//!    is silent for too long is gone.

use std::time::Duration;

use axum::extract::ws::{Message, WebSocket};
use serde::Serialize;
use slamlab_core::wire::message::close;
use tokio::sync::mpsc;
use tokio::time::{Instant, timeout};

use crate::ending::{End, FAREWELL, INTERNAL, TOO_SLOW};
use crate::hub::outbox::{Next, Outbox};
use crate::shared::{Shared, Visitor};
use crate::socket;

/// Between two pings.
pub(crate) const PING: Duration = Duration::from_secs(1);
/// Messages that wait to be written: one of the hub can make two for each subscription.
const MOST_WAITING: usize = 160;

/// What a client sends.
#[derive(Debug)]
pub(crate) enum Incoming {
    Text(String),
    Binary,
    /// The answer to a ping, with what was in it.
    Pong(Vec<u8>),
}

/// The reading half, and the queue of the other.
pub(crate) struct Adapter<'a> {
    socket: socket::Reader<'a>,
    queue: mpsc::Sender<Message>,
    heard: Instant,
}

impl<'a> Adapter<'a> {
    /// Both halves of a socket.
    pub(crate) fn new(socket: WebSocket, shared: &'a Shared) -> (Self, Writer<'a>) {
        let (reading, writing) = socket::halves(socket, shared);
        let (queue, waiting) = mpsc::channel(MOST_WAITING);
        let adapter = Self {
            socket: reading,
            queue,
            heard: Instant::now(),
        };
        let writer = Writer {
            socket: writing,
            waiting,
        };
        (adapter, writer)
    }

    /// The client has shown the token.
    pub(crate) fn trust(&mut self) {
        self.socket.trust();
    }

    /// The next message.
    pub(crate) async fn next(&mut self) -> Result<Incoming, End> {
        loop {
            let message = self.socket.next().await?;
            self.heard = Instant::now();
            let incoming = match message {
                Message::Close(_) => return Err(None),
                Message::Ping(_) => continue,
                Message::Pong(bytes) => return Ok(Incoming::Pong(bytes.to_vec())),
                Message::Text(text) => Incoming::Text(text.to_string()),
                Message::Binary(_) => Incoming::Binary,
            };
            self.socket.shared.metrics.received.add(1);
            return Ok(incoming);
        }
    }

    /// What the hub has next, as soon as the queue is empty.
    pub(crate) fn when_idle<'o>(&self, outbox: &'o Outbox) -> impl Future<Output = Next> + use<'o> {
        let queue = self.queue.clone();
        async move {
            // An error means that nothing is written any more: the connection ends by that.
            let _ = queue.reserve_many(MOST_WAITING).await;
            outbox.next().await
        }
    }

    /// Asks for a sign of life; an error where the last is too old.
    pub(crate) fn ping(&self, content: &[u8]) -> Result<(), End> {
        if self.heard.elapsed() > self.socket.shared.limits.heartbeat {
            return Err(Some(close::HEARTBEAT));
        }
        // A client that takes nothing now is asked the next time.
        if self.queue.capacity() == MOST_WAITING {
            self.put(Message::Ping(content.to_vec().into()))?;
        }
        Ok(())
    }

    pub(crate) fn send(&self, message: &impl Serialize) -> Result<(), End> {
        let text = serde_json::to_string(message).map_err(|error| {
            tracing::error!("a message for another tool could not be written: {error}");
            Some(INTERNAL)
        })?;
        self.put(Message::Text(text.into()))
    }

    pub(crate) fn send_bytes(&self, bytes: Vec<u8>) -> Result<(), End> {
        self.put(Message::Binary(bytes.into()))
    }

    fn put(&self, message: Message) -> Result<(), End> {
        self.queue.try_send(message).map_err(|_| Some(TOO_SLOW))
    }
}

/// The half that writes.
pub(crate) struct Writer<'a> {
    socket: socket::Writer<'a>,
    waiting: mpsc::Receiver<Message>,
}

impl Writer<'_> {
    /// Writes the queue while `live` goes on, then what is left of it and why it ends.
    pub(crate) async fn beside(
        mut self,
        visitor: &Visitor,
        live: impl Future<Output = Result<(), End>>,
    ) {
        let ended = tokio::select! {
            () = self.run() => return,
            ended = live => ended,
        };
        let Err(Some(code)) = ended else { return };
        self.socket.shared.shown_out(visitor, code);
        self.waiting.close();
        let rest = async {
            self.run().await;
            self.socket.close(code).await;
        };
        // A client that is gone needs no farewell.
        let _ = timeout(FAREWELL, rest).await;
    }

    /// Until nothing more can come, or the client takes nothing.
    async fn run(&mut self) {
        while let Some(message) = self.waiting.recv().await {
            if self.socket.send(message).await.is_err() {
                return;
            }
        }
    }
}
