//! How connections end: the close codes, and a sentence for a person who reads the browser's log.

use std::time::Duration;

use axum::extract::ws::{CloseFrame, Message, Utf8Bytes};
use slamlab_core::wire::message::close;
use tungstenite::error::ProtocolError;

/// Why a connection ends: the close code to send, or none if the client is gone.
pub(crate) type End = Option<u16>;

/// How long a client has to read why its connection ends.
pub(crate) const FAREWELL: Duration = Duration::from_secs(1);

/// RFC 6455 §7.4.1.
pub(crate) const GOING_AWAY: u16 = 1001;
pub(crate) const NO_FRAME: u16 = 1002;
pub(crate) const UNSUPPORTED: u16 = 1003;
pub(crate) const MALFORMED: u16 = 1007;
pub(crate) const TOO_MANY: u16 = 1008;
pub(crate) const TOO_LARGE: u16 = 1009;
pub(crate) const INTERNAL: u16 = 1011;
pub(crate) const TOO_SLOW: u16 = 1013;

/// The last message of a connection.
pub(crate) fn farewell(code: u16) -> Message {
    Message::Close(Some(CloseFrame {
        code,
        reason: Utf8Bytes::from_static(reason(code)),
    }))
}

/// The end that follows from an error of the WebSocket layer.
pub(crate) fn of_error(error: axum::Error) -> End {
    match error.into_inner().downcast_ref::<tungstenite::Error>() {
        Some(tungstenite::Error::Capacity(_)) => Some(TOO_LARGE),
        Some(tungstenite::Error::Utf8(_)) => Some(MALFORMED),
        // A client that disconnects without a close frame has done nothing wrong.
        Some(tungstenite::Error::Protocol(ProtocolError::ResetWithoutClosingHandshake)) => None,
        Some(tungstenite::Error::Protocol(_)) => Some(NO_FRAME),
        _ => None,
    }
}

pub(crate) fn reason(code: u16) -> &'static str {
    match code {
        GOING_AWAY => "the bridge ends",
        NO_FRAME => "this is not a WebSocket frame",
        UNSUPPORTED => "binary messages, or text behind ?fmt=json",
        MALFORMED => "a message could not be read, or its sequence did not rise",
        TOO_MANY => "too many messages",
        TOO_LARGE => "the message is too large",
        INTERNAL => "the bridge failed at something; its log says at what",
        TOO_SLOW => "it did not take answers and notices that must not be dropped",
        close::ACCESS => "no proof of a token in time, or a wrong one",
        close::NO_RIGHT => {
            "this right is not good for that: driving needs the token of a driver or an owner"
        }
        close::HEARTBEAT => "no heartbeat",
        close::REVOKED => "the right was taken away, or changed",
        close::TAKEN_OVER => "another client took over",
        close::FULL => "as many watch as may; who has the token gets in",
        close::OTHER_SCHEMA => {
            "the bridge speaks another schema: reload the page from the bridge, or update what is older"
        }
        _ => "",
    }
}
