//! The local bridge: robot and sensors at serial ports that the page itself has opened.

use std::time::Duration;

use slamlab_core::device::{Device, KINDS, Kind, LocalBridge, Want};
use slamlab_core::geom::Pose2;
use wasm_bindgen::prelude::{JsError, wasm_bindgen};

use crate::border::messages;

/// There is no device of this kind.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("there is no device `{0}`; expected one of {names}", names = KINDS.map(|kind| kind.name).join(", "))]
pub struct DeviceKindError(String);

/// Devices at ports of the page. Times are µs of the page's clock; the messages are those of a
/// bridge.
#[wasm_bindgen]
pub struct WebLocalBridge {
    bridge: LocalBridge,
}

/// What the device at a line requests.
#[wasm_bindgen(getter_with_clone)]
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LineWant {
    /// `write`, `dtr`, `well` or `reopen`.
    pub what: String,
    /// Bytes to write.
    pub bytes: Vec<u8>,
    /// Whether DTR is to be set.
    pub on: bool,
}

#[wasm_bindgen]
impl WebLocalBridge {
    /// Devices by the numbers of their lines; each is given by the name of its kind.
    ///
    /// # Errors    [`DeviceKindError`].
    #[wasm_bindgen(constructor)]
    #[allow(
        clippy::needless_pass_by_value,
        reason = "lists of text cross the border by value only"
    )]
    pub fn new(kinds: Vec<String>) -> Result<Self, JsError> {
        let devices: Result<Vec<_>, _> = kinds.iter().map(|kind| device(kind)).collect();
        Ok(Self {
            bridge: LocalBridge::new(devices?),
        })
    }

    /// Baud rate of a line; 0 if there is no such line.
    #[must_use]
    pub fn baud_rate(&self, line: u32) -> u32 {
        self.bridge.baud_rate(line as usize).unwrap_or(0)
    }

    /// Says hello to the page when it begins or restarts.
    pub fn begin(&mut self, now: f64) {
        self.bridge.begin(micros(now));
    }

    /// A line was opened.
    pub fn opened(&mut self, now: f64, line: u32) {
        self.bridge.opened(micros(now), line as usize);
    }

    /// Bytes that arrived on a line at time `came`.
    pub fn received(&mut self, now: f64, came: f64, line: u32, bytes: &[u8]) {
        self.bridge
            .received(micros(now), micros(came), line as usize, bytes);
    }

    /// A line broke, or could not be opened; `why` gives cause and cure.
    pub fn broken(&mut self, now: f64, line: u32, why: &str) {
        self.bridge.broken(micros(now), line as usize, why);
    }

    /// The lines are about to be closed.
    pub fn close(&mut self, now: f64) {
        self.bridge.close(micros(now));
    }

    /// To be called some hundred times a second.
    pub fn tick(&mut self, now: f64) {
        self.bridge.tick(micros(now));
    }

    /// The next request of the device at a line.
    #[must_use]
    pub fn next_want(&mut self, line: u32) -> Option<LineWant> {
        let (what, bytes, on) = match self.bridge.next_want(line as usize)? {
            Want::Write(bytes) => ("write", bytes, false),
            Want::Dtr(on) => ("dtr", vec![], on),
            Want::Reopen => ("reopen", vec![], false),
            // Reports and notes have become messages.
            Want::Well | Want::Report(_) | Want::Note(..) => ("well", vec![], false),
        };
        Some(LineWant {
            what: what.to_owned(),
            bytes,
            on,
        })
    }

    /// Takes a message of the page.
    ///
    /// # Errors    A sentence on bytes that are not a message.
    pub fn message(&mut self, now: f64, bytes: &[u8]) -> Result<(), JsError> {
        Ok(self.bridge.message(micros(now), bytes)?)
    }

    /// The person stops the robot; with `cut_off` its motors are cut off until that is reset.
    pub fn stop(&mut self, now: f64, cut_off: bool) {
        self.bridge.stop(micros(now), cut_off);
    }

    /// The messages for the page.
    #[must_use]
    pub fn outgoing(&mut self) -> Vec<js_sys::Uint8Array> {
        messages(&self.bridge.take_outgoing())
    }
}

fn device(name: &str) -> Result<Box<dyn Device>, DeviceKindError> {
    let kind = Kind::named(name).ok_or_else(|| DeviceKindError(name.to_owned()))?;
    Ok((kind.open)(format!("{name}:cable"), Pose2::identity()))
}

fn micros(now: f64) -> Duration {
    Duration::from_micros(now as u64)
}
