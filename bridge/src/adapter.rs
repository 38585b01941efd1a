//! The socket of a client that speaks another tool's protocol: what all such protocols have in
//! common.
//!
//! In: a WebSocket. Out: the client's messages ([`Adapter::next`]), and a queue for messages to it.
//!
//! 1. Reading and writing run concurrently ([`Writer::beside`]), so a client that reads nothing can
//!    still send a stop. Each write has a timeout.
//! 2. Answers are queued; a client that lets the queue grow full is disconnected. Readings of the
//!    robot are taken only when the queue is empty ([`Adapter::when_idle`]), so a slow client gets
//!    fewer readings, but fresh ones.
//! 3. Every message from a client, including pings, counts against the allowed rate.
//! 4. These protocols have no heartbeat. A ping is sent every [`PING`]; a client that stays silent
//!    too long is disconnected.

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

/// Interval between pings.
pub(crate) const PING: Duration = Duration::from_secs(1);
/// Most messages that may wait to be written: one hub message can become two for each subscription.
const MOST_WAITING: usize = 160;

/// What a client sends.
#[derive(Debug)]
pub(crate) enum Incoming {
    Text(String),
    Binary,
    /// The answer to a ping, with the ping's content.
    Pong(Vec<u8>),
}

/// The reading half, and the queue of the writing half.
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

    /// The client has shown a driver's token.
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

    /// The hub's next message, taken once the queue is empty.
    pub(crate) fn when_idle<'o>(&self, outbox: &'o Outbox) -> impl Future<Output = Next> + use<'o> {
        let queue = self.queue.clone();
        async move {
            // An error means that the writer has ended, which ends the connection.
            let _ = queue.reserve_many(MOST_WAITING).await;
            outbox.next().await
        }
    }

    /// Pings the client; an error if it has been silent too long.
    pub(crate) fn ping(&self, content: &[u8]) -> Result<(), End> {
        if self.heard.elapsed() > self.socket.shared.limits.heartbeat {
            return Err(Some(close::HEARTBEAT));
        }
        // If messages still wait, the client is pinged the next time.
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
    /// Writes the queue while `live` runs, then the rest of it and the reason for the end.
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

    /// Runs until nothing more can come, or the client stops reading.
    async fn run(&mut self) {
        while let Some(message) = self.waiting.recv().await {
            if self.socket.send(message).await.is_err() {
                return;
            }
        }
    }
}
