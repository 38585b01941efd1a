//! Simulated devices at the other end of pseudo-terminals: the bridge cannot tell them from real
//! ones.
//!
//! In: what the bridge writes. Out: byte for byte what the device would send, from a world of
//! `core::sim`; and on demand the faults of real devices: flipped bits, silence, a pulled cable,
//! half a frame, a wrong baud rate.
//!
//! A device itself ([`Rplidar`], [`Ld06`], [`Rp6`]) has no I/O and no clock; [`Socket`] gives it
//! both.

mod aboard;
mod ld06;
mod rp6;
mod rplidar;
mod socket;
mod spoil;
mod view;

pub use aboard::{Aboard, Carrier};
pub use ld06::Ld06;
pub use rp6::Rp6;
pub use rplidar::Rplidar;
pub use socket::Socket;
pub use spoil::{Faults, Line};
pub use view::View;

/// A device on a serial line, without I/O.
pub trait Device: Send + 'static {
    /// Its baud rate; at any other both sides see noise.
    fn baud_rate(&self) -> u32;

    /// It is powered on: all commands are forgotten.
    fn power_on(&mut self);

    /// Lets time pass while its cable is out, s. Default: without a cable it has no power.
    fn unplugged(&mut self, _seconds: f64) {}

    /// Its cable is pulled out.
    fn pulled(&mut self) {}

    /// Takes bytes that were written to it.
    fn receive(&mut self, bytes: &[u8]);

    /// Lets time pass, s; returns the bytes that it sends meanwhile.
    fn advance(&mut self, seconds: f64) -> Vec<u8>;
}
