//! The two halves of a client's WebSocket, with the limits that hold for every client, whatever its
//! protocol.

use std::time::Duration;

use axum::extract::ws::{Message, WebSocket};
use futures_util::stream::{SplitSink, SplitStream};
use futures_util::{SinkExt, StreamExt};
use tokio::time::{Instant, timeout, timeout_at};

use crate::ending::{End, FAREWELL, TOO_MANY, farewell, of_error};
use crate::rate::Bucket;
use crate::shared::Shared;

/// Time from the message that was too much to the end of the connection.
const PENALTY: Duration = Duration::from_secs(1);

/// The half that reads: each message counts against the allowed rate, which is small until the
/// client has shown a driver's token.
pub(crate) struct Reader<'a> {
    stream: SplitStream<WebSocket>,
    pub(crate) shared: &'a Shared,
    bucket: Bucket,
    /// Set once the client sent too much: when its connection ends.
    muted_until: Option<Instant>,
}

/// The half that writes: each message has a timeout.
pub(crate) struct Writer<'a> {
    sink: SplitSink<WebSocket, Message>,
    pub(crate) shared: &'a Shared,
}

/// Both halves of a socket.
pub(crate) fn halves(socket: WebSocket, shared: &Shared) -> (Reader<'_>, Writer<'_>) {
    let (sink, stream) = socket.split();
    let bucket = Bucket::new(shared.limits.watcher_rate, shared.clock.now());
    let reader = Reader {
        stream,
        shared,
        bucket,
        muted_until: None,
    };
    (reader, Writer { sink, shared })
}

impl Reader<'_> {
    /// The client has shown a driver's token.
    pub(crate) fn trust(&mut self) {
        self.bucket = Bucket::new(self.shared.limits.rate, self.shared.clock.now());
    }

    /// The next message of any kind; an error if the client is gone or sends too much. A client
    /// that sends too much is ignored from then on, and disconnected a while later, so that it
    /// cannot come back at once.
    pub(crate) async fn next(&mut self) -> Result<Message, End> {
        if let Some(until) = self.muted_until {
            return Err(self.pass_over(until).await);
        }
        let message = self.stream.next().await.ok_or(None)?.map_err(of_error)?;
        if self.bucket.take(self.shared.clock.now()) {
            return Ok(message);
        }
        let until = Instant::now() + PENALTY;
        self.muted_until = Some(until);
        Err(self.pass_over(until).await)
    }

    /// Reads and ignores what still comes: unread data at the end would keep the client from
    /// reading the reason.
    async fn pass_over(&mut self, until: Instant) -> End {
        let end = timeout_at(until, async {
            while let Some(Ok(_)) = self.stream.next().await {}
        });
        match end.await {
            Ok(()) => None,
            Err(_) => Some(TOO_MANY),
        }
    }
}

impl Writer<'_> {
    /// Writes a message; an error if the client is gone or does not read.
    pub(crate) async fn send(&mut self, message: Message) -> Result<(), End> {
        let bytes = match &message {
            Message::Text(text) => text.len(),
            Message::Binary(bytes) => bytes.len(),
            _ => 0,
        };
        let sent = timeout(self.shared.limits.write, self.sink.send(message)).await;
        sent.map_err(|_| None)?.map_err(|_| None)?;
        if bytes > 0 {
            self.shared.metrics.sent.add(1);
            self.shared.metrics.sent_bytes.add(bytes as u64);
        }
        Ok(())
    }

    /// Says why the connection ends; failure does not matter if the client is gone.
    pub(crate) async fn close(&mut self, code: u16) {
        let _ = timeout(FAREWELL, self.send(farewell(code))).await;
    }
}
