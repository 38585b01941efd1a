//! One client's connection: authenticates, then passes messages both ways until one side ends.
//!
//! In: a WebSocket. Out: the client's messages, to the hub; the hub's messages, to the client.
//!
//! 1. The bridge says hello with a challenge; the client must answer in time, with a proof or as a
//!    watcher.
//! 2. Reading and writing run concurrently: a client that does not read can still send, and one
//!    that is silent still receives.
//! 3. The first of these ends it: malformed, too large or too many messages; silence; a close from
//!    either side. However it ends, the hub learns of it, and stops the robot if this client drove
//!    it.

use axum::extract::ws::{Message, Utf8Bytes, WebSocket};
use slamlab_core::wire::message::{
    CHALLENGE_BYTES, ClientHello, Format, FromBridge, Header, MessageError, SCHEMA, ToBridge,
    Watching, close, decode, encode,
};
use tokio::time::timeout;

use crate::ending::{End, FAREWELL, INTERNAL, MALFORMED, UNSUPPORTED};
use crate::hub::FromClient;
use crate::hub::outbox::{Next, Outbox};
use crate::rights::Granted;
use crate::safety::ClientId;
use crate::shared::{Joined, Shared, Visitor};
use crate::socket;

/// Longest part of a client's name that others see, bytes.
const LONGEST_NAME: usize = 64;

/// Serves a client to its end.
pub(crate) async fn run(socket: WebSocket, shared: &Shared, visitor: &Visitor, format: Format) {
    let (reading, writing) = socket::halves(socket, shared);
    let mut writer = Writer {
        socket: writing,
        format,
        sequence: 0,
    };
    let mut reader = Reader {
        socket: reading,
        format,
        sequence: 0,
    };
    match enter(&mut writer, &mut reader, visitor).await {
        Ok((id, outbox)) => {
            let ended = serve(id, &mut writer, &mut reader, &outbox).await;
            shared.leave(id).await;
            if let Some(code) = ended {
                shared.shown_out(visitor, code);
            }
        }
        Err(Some(code)) => {
            shared.shown_out(visitor, code);
            writer.socket.close(code).await;
        }
        Err(None) => (),
    }
}

/// Exchanges the first messages; returns the client's number and its outbox.
async fn enter(
    writer: &mut Writer<'_>,
    reader: &mut Reader<'_>,
    visitor: &Visitor,
) -> Result<Joined, End> {
    let shared = writer.socket.shared;
    let mut challenge = [0; CHALLENGE_BYTES];
    if let Err(error) = getrandom::fill(&mut challenge) {
        tracing::error!("no random numbers: {error}");
        return Err(Some(INTERNAL));
    }
    let hello = FromBridge::Hello(shared.hello(challenge));
    writer.send(&hello).await?;
    let first = timeout(shared.limits.hello, reader.next()).await;
    let (_, ToBridge::Hello(hello)) = first.map_err(|_| Some(close::ACCESS))?? else {
        return Err(Some(close::ACCESS));
    };
    let granted = admit(shared, &challenge, &hello)?;
    if granted.as_ref().is_some_and(Granted::may_drive) {
        reader.socket.trust();
    }
    let mut name = hello.name;
    name.truncate(name.floor_char_boundary(LONGEST_NAME));
    shared.join(visitor, name, granted).await
}

/// The right that the client shows, if any; an error if it may not even watch.
pub(crate) fn admit(
    shared: &Shared,
    challenge: &[u8; CHALLENGE_BYTES],
    hello: &ClientHello,
) -> Result<Option<Granted>, End> {
    if hello.schema != SCHEMA {
        return Err(Some(close::OTHER_SCHEMA));
    }
    match &hello.proof {
        Some(proof) => match shared.proved(challenge, proof) {
            Some(granted) => Ok(Some(granted)),
            None => Err(Some(close::ACCESS)),
        },
        None if shared.about.watching == Watching::Anyone => Ok(None),
        None => Err(Some(close::ACCESS)),
    }
}

/// Passes messages both ways; returns why the bridge ended the connection, if it did.
async fn serve(
    id: ClientId,
    writer: &mut Writer<'_>,
    reader: &mut Reader<'_>,
    outbox: &Outbox,
) -> End {
    let mut writing = std::pin::pin!(writer.run(outbox));
    let code = tokio::select! {
        end = &mut writing => return end,
        end = reader.run(id) => end?,
    };
    outbox.close(code);
    // A client that does not even read the reason is dropped.
    let _ = timeout(FAREWELL, writing).await;
    Some(code)
}

struct Writer<'a> {
    socket: socket::Writer<'a>,
    format: Format,
    sequence: u32,
}

impl Writer<'_> {
    /// Sends the hub's messages until there are no more or the client stops reading.
    async fn run(&mut self, outbox: &Outbox) -> End {
        loop {
            match outbox.next().await {
                Next::Close(code) => {
                    self.socket.close(code).await;
                    return Some(code);
                }
                Next::Message(message) => {
                    if let Err(end) = self.send(&message).await {
                        return end;
                    }
                }
            }
        }
    }

    async fn send(&mut self, message: &FromBridge) -> Result<(), End> {
        self.sequence = self.sequence.wrapping_add(1);
        let header = Header {
            sequence: self.sequence,
            micros: self.socket.shared.clock.now().as_micros() as u64,
        };
        let bytes = encode(header, message, self.format).map_err(|error| {
            tracing::error!("a message could not be written: {error}");
            Some(INTERNAL)
        })?;
        let message = match self.format {
            Format::Binary => Message::Binary(bytes.into()),
            // JSON is always UTF-8.
            Format::Json => Message::Text(Utf8Bytes::try_from(bytes).unwrap_or_default()),
        };
        self.socket.send(message).await
    }
}

struct Reader<'a> {
    socket: socket::Reader<'a>,
    format: Format,
    sequence: u32,
}

impl Reader<'_> {
    /// Passes the client's messages on, until there is a reason to end.
    async fn run(&mut self, id: ClientId) -> End {
        let shared = self.socket.shared;
        loop {
            let (header, message) = match timeout(shared.limits.heartbeat, self.next()).await {
                Err(_) => return Some(close::HEARTBEAT),
                Ok(Err(end)) => return end,
                Ok(Ok(said)) => said,
            };
            let now = shared.clock.now();
            match message {
                ToBridge::Hello(_) => return Some(MALFORMED),
                ToBridge::Heartbeat => continue,
                _ => (),
            }
            let says = FromClient::Message(id, header, message, now);
            if let Err(end) = shared.tell(says).await {
                return end;
            }
        }
    }

    /// The next message. WebSocket pings are answered by the layer below, and count as messages.
    async fn next(&mut self) -> Result<(Header, ToBridge), End> {
        loop {
            let message = self.socket.next().await?;
            let bytes = match (&message, self.format) {
                (Message::Binary(bytes), Format::Binary) => bytes.as_ref(),
                (Message::Text(text), Format::Json) => text.as_bytes(),
                (Message::Ping(_) | Message::Pong(_), _) => continue,
                (Message::Close(_), _) => return Err(None),
                _ => return Err(Some(UNSUPPORTED)),
            };
            let metrics = &self.socket.shared.metrics;
            metrics.received.add(1);
            let (header, message) = decode::<ToBridge>(bytes, self.format).map_err(|error| {
                metrics.malformed.add(1);
                tracing::debug!("a client's message: {error}");
                match error {
                    MessageError::Protocol { .. } => Some(close::OTHER_SCHEMA),
                    _ => Some(MALFORMED),
                }
            })?;
            if header.sequence <= self.sequence {
                return Err(Some(MALFORMED));
            }
            self.sequence = header.sequence;
            return Ok((header, message));
        }
    }
}
