//! Devices on serial ports, and behind UDP: opened, watched, closed and opened again.
//!
//! In: the path of a port, or the address of a lidar server, and the [`Device`] at its other end.
//! Out: a [`Source`](crate::source::Source).
//!
//! 1. [`Line`] reads and writes on two threads of its own, because serial ports block; the queues
//!    between are bounded.
//! 2. [`DeviceSource`] passes bytes, time and orders to the device, which does no I/O itself, and
//!    carries out what it wants.
//! 3. Any error of the port, or a read that returns 0 bytes (a pulled cable), closes it. It is
//!    tried again after 0.25 s, then 0.5, 1, 2, 2 … s, so a device that is plugged in later, or
//!    again, is found. Orders given meanwhile are dropped, and the driver must arm again: nothing
//!    moves by itself when a cable is put back.
//!
//! Why not an asynchronous port: `tokio-serial` 5.5 returns `Ok(0)` for ever after a hang-up.

mod line;
mod open;
mod source;

pub(crate) use line::Channel;
pub use line::{Line, LineError, Received};
pub use open::{OpenError, PortSettings};
use slamlab_core::device::Weight;
pub use slamlab_core::device::{Device, Want};
pub use source::DeviceSource;

/// Writes a device's note to the log.
pub(crate) fn note(device: &str, weight: Weight, text: &str) {
    match weight {
        Weight::Detail => tracing::debug!("{device}: {text}"),
        Weight::Info => tracing::info!("{device}: {text}"),
        Weight::Warning => tracing::warn!("{device}: {text}"),
        Weight::Error => tracing::error!("{device}: {text}"),
    }
}
