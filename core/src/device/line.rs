//! What is at the other end of a line, without any I/O.

use crate::robot::Stamp;

use crate::device::source::{Order, Profile, SourceEvent};

/// A device at the other end of a line. Time is the bridge's clock, the same for all devices. The
/// stamps of what a device reports are on that clock too, whatever the device's own clock says.
pub trait Device: Send + 'static {
    /// What it is.
    fn profile(&self) -> Profile;

    /// Baud rate of its line.
    fn baud_rate(&self) -> u32;

    /// The line was opened: all that was known of the device is forgotten, and nothing may move.
    fn opened(&mut self, now: Stamp);

    /// Takes bytes as they arrive.
    fn receive(&mut self, bytes: &[u8], now: Stamp);

    /// Takes an order.
    fn order(&mut self, order: Order, now: Stamp);

    /// Called with the current time, some hundred times a second.
    fn tick(&mut self, now: Stamp);

    /// The bridge shuts down: bytes that must still be sent go into the wants.
    fn close(&mut self, now: Stamp);

    /// The line broke, or could not be opened; `why` names cause and cure.
    fn broken(&mut self, why: String);

    /// The next thing that the device wants done.
    fn next_want(&mut self) -> Option<Want>;
}

/// What a [`Device`] wants done.
#[derive(Clone, Debug, PartialEq)]
pub enum Want {
    /// Write these bytes.
    Write(Vec<u8>),
    /// Set (true) or clear DTR. No effect on a line without it (a plain UART).
    Dtr(bool),
    /// Report this to the bridge.
    Report(SourceEvent),
    /// All is well: the next time the line breaks, it is soon reopened.
    Well,
    /// Close the line and start again after a pause.
    Reopen,
    /// Write this in the log.
    Note(Weight, String),
}

/// How much a note of a device matters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Weight {
    /// For somebody looking for an error.
    Detail,
    /// Good to know.
    Info,
    /// Something does not go as it should.
    Warning,
    /// Something cannot be done.
    Error,
}
