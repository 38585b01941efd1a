//! The socket of a client that speaks the protocol of another tool: what all such protocols need of it.
//!
//! 1. Each write has its time, each message its place in the rate that the bridge allows.
//! 2. Such protocols know no heartbeat of their own. A ping goes out each [`PING`]; who answers nothing for too long is gone.

use std::time::Duration;

use axum::extract::ws::{CloseFrame, Message, Utf8Bytes, WebSocket};
use futures_util::StreamExt;
use serde::Serialize;
use slamlab_core::wire::message::close;
use tokio::time::{Instant, timeout};

use crate::http::Shared;
use crate::rate::Bucket;

/// Between two pings.
pub(crate) const PING: Duration = Duration::from_secs(1);
/// RFC 6455 §7.4.1: what came cannot be read.
pub(crate) const MALFORMED: u16 = 1007;
const INTERNAL: u16 = 1011;
const TOO_MANY: u16 = 1008;

/// Why a connection ends: with this code, or without a word where the client is gone.
pub(crate) type End = Option<u16>;

/// What a guest sends.
#[derive(Debug)]
pub(crate) enum Heard {
    Text(String),
    Binary,
    /// The answer to a ping, with what was in it.
    Pong(Vec<u8>),
}

pub(crate) struct Guest<'a> {
    socket: WebSocket,
    shared: &'a Shared,
    heard: Instant,
    bucket: Bucket,
}

impl<'a> Guest<'a> {
    pub(crate) fn new(socket: WebSocket, shared: &'a Shared) -> Self {
        Self {
            socket,
            shared,
            heard: Instant::now(),
            bucket: Bucket::new(shared.limits.rate, shared.clock.now()),
        }
    }

    /// The next message.
    pub(crate) async fn next(&mut self) -> Result<Heard, End> {
        loop {
            let message = self.socket.next().await.ok_or(None)?.map_err(|_| None)?;
            self.heard = Instant::now();
            let heard = match message {
                Message::Close(_) => return Err(None),
                Message::Ping(_) => continue,
                Message::Pong(bytes) => Heard::Pong(bytes.to_vec()),
                Message::Text(text) => Heard::Text(text.to_string()),
                Message::Binary(_) => Heard::Binary,
            };
            let is_pong = matches!(heard, Heard::Pong(_));
            if !is_pong && !self.bucket.take(self.shared.clock.now()) {
                return Err(Some(TOO_MANY));
            }
            return Ok(heard);
        }
    }

    /// Asks for a sign of life; an error where the last is too old.
    pub(crate) async fn ping(&mut self, content: &[u8]) -> Result<(), End> {
        if self.heard.elapsed() > self.shared.limits.heartbeat {
            return Err(Some(close::HEARTBEAT));
        }
        self.put(Message::Ping(content.to_vec().into())).await
    }

    pub(crate) async fn say(&mut self, said: &impl Serialize) -> Result<(), End> {
        let text = serde_json::to_string(said).map_err(|error| {
            tracing::error!("a message for another tool could not be written: {error}");
            Some(INTERNAL)
        })?;
        self.put(Message::Text(text.into())).await
    }

    pub(crate) async fn send(&mut self, bytes: Vec<u8>) -> Result<(), End> {
        self.put(Message::Binary(bytes.into())).await
    }

    pub(crate) async fn close(&mut self, code: u16) {
        let reason = Utf8Bytes::from_static("");
        let frame = CloseFrame { code, reason };
        // A client that is gone needs no farewell.
        let _ = self.put(Message::Close(Some(frame))).await;
    }

    async fn put(&mut self, message: Message) -> Result<(), End> {
        let sent = timeout(self.shared.limits.write, self.socket.send(message)).await;
        sent.map_err(|_| None)?.map_err(|_| None)
    }
}
