//! What sits at the other end of a line, without any I/O.

use crate::robot::Stamp;

use crate::device::source::{Order, Profile, SourceEvent};

/// A device at the other end of a line. Time counts on the bridge's clock, the same for all
/// devices; stamps of what a device tells are on that clock too, whatever its own says.
pub trait Device: Send + 'static {
    /// What it is.
    fn profile(&self) -> Profile;

    /// Baud rate of its line.
    fn baud_rate(&self) -> u32;

    /// The line was opened: whatever was known of the device is forgotten, and nothing may move.
    fn opened(&mut self, now: Stamp);

    /// Takes bytes as they come.
    fn receive(&mut self, bytes: &[u8], now: Stamp);

    /// Takes an order.
    fn order(&mut self, order: Order, now: Stamp);

    /// Sees the time, some hundred times a second.
    fn tick(&mut self, now: Stamp);

    /// The bridge ends: what must still be said goes into the wants.
    fn close(&mut self, now: Stamp);

    /// The line broke, or could not be opened; `why` says cause and cure.
    fn broken(&mut self, why: String);

    /// The next thing that it wants done.
    fn next_want(&mut self) -> Option<Want>;
}

/// What a [`Device`] wants done.
#[derive(Clone, Debug, PartialEq)]
pub enum Want {
    /// Write these bytes.
    Write(Vec<u8>),
    /// Set (true) or clear DTR. A line without it (a plain UART) is not affected.
    Dtr(bool),
    /// Report this to the bridge.
    Report(SourceEvent),
    /// All is well: the next time that the line breaks, it is tried again soon.
    Well,
    /// Close the line and start again after a pause.
    Reopen,
    /// Write this in the log.
    Note(Weight, String),
}

/// How much a note of a device matters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Weight {
    /// For somebody who searches for an error.
    Detail,
    /// Good to know.
    Info,
    /// Something does not go as it should.
    Warning,
    /// Something cannot be done.
    Error,
}
