//! Our protocol to the RP6, over its serial line: 38400 baud, 8 data bits, no parity, 1 stop bit.
//!
//! In: bytes in pieces of any size, or messages. Out: messages with counts of what was thrown away,
//! or bytes. The firmware in `bridge/firmware` uses exactly the same bytes.
//!
//! 1. A message is `kind, sequence, payload`. Numbers are little-endian, signed ones in two's
//!    complement.
//! 2. A CRC-16 over all of it is appended, low byte first.
//! 3. COBS (Cheshire & Baker 1999) removes the zero bytes, at the cost of one byte.
//! 4. A zero byte before and one after mark the frame. After noise, decoding restarts at the next
//!    zero.
//!
//! ```text
//! 00 | COBS( kind | sequence | payload … | CRC low | CRC high ) | 00
//! ```
//!
//! A frame to the robot has at most [`LONGEST_TO_ROBOT`] bytes: small receive buffers hold it
//! completely.
//!
//! | to the robot | kind | payload | what it asks for |
//! |---|---|---|---|
//! | [`Command::Greet`] | 01 | nonce u8 | say hello with this nonce; stand, forget sequences |
//! | [`Command::Velocity`] | 02 | forward i16 mm/s, turn i16 mrad/s | drive so until commanded otherwise |
//! | [`Command::Forward`] | 03 | way i32 µm | drive this way straight |
//! | [`Command::Turn`] | 04 | angle i32 µrad | turn on the spot, counter-clockwise |
//! | [`Command::Stop`] | 05 | | motors off at once |
//! | [`Command::EStop`] | 06 | | motors off at once, and latched |
//! | [`Command::Reset`] | 07 | | unlatch; this moves nothing |
//! | [`Command::Servo`] | 08 | angle i16 mrad | point the servo, abort a sweep |
//! | [`Command::Sweep`] | 09 | from, to, step: i16 mrad each | one sweep of the servo, with rangers |
//! | [`Command::SetRate`] | 0A | period u16 ms | telemetry once in this period, 10 to 500 ms |
//! | [`Command::Alive`] | 0B | | continue the motion under way |
//!
//! | from the robot | kind | payload |
//! |---|---|---|
//! | [`Report::Hello`] | 81 | protocol u8, firmware major u8, minor u8, nonce u8, reset cause u8, capabilities u8, length mm u16, width mm u16, track width mm u16, way of a count nm u32, highest speed mm/s u16, rangers n u8, n x mounting angle mrad i16 |
//! | [`Report::Ack`] | 82 | of sequence u8, result u8 (0 done, 1 repeated, 2 stale, 3 bad value, 4 latched, 5 unknown kind) |
//! | [`Report::Telemetry`] | 83 | time ms u32, counts left and right i32, speeds counts/s i16, i16, currents ADC u16, u16, battery ADC u16, state u8, fault u8 |
//! | [`Report::Ranger`] | 84 | time ms u32, servo angle mrad i16, index u8, ADC u16, sweep u8 |
//!
//! State: bit 0 left bumper, 1 right bumper, 2 moving, 3 sweeping, 4 emergency stop latched, 5
//! stopped by silence. Fault: 0 none, 1 left encoder silent, 2 right encoder silent, 3 current too
//! high, 4 battery low. Any command that is accepted feeds the robot's watchdog, which stops the
//! motors after 400 ms; [`Command::Alive`] does nothing else.
//!
//! Commands carry a sequence that increases by one. The robot acknowledges each, does not carry out
//! a repeated one again, and refuses an older one. [`Link`] obeys this.
//!
//! # Example
//! `Stop` with sequence 7: `05 07`, CRC `BF FA` (CRC-16/MCRF4XX: reflected polynomial 8408, start
//! FFFF, as avr-libc's `_crc_ccitt_update`), so `00 05 05 07 BF FA 00` on the line; the tests hold
//! the golden bytes of all messages.

mod bytes;
mod convert;
#[cfg(test)]
pub(crate) mod fixture;
mod frame;
mod link;
mod message;
mod ranger_scan;
mod report;
#[cfg(test)]
mod tests;

pub use convert::{BATTERY_ADC, CommandError, Odometer};
pub use frame::{Decoder, Frame, LONGEST_TO_ROBOT, encode};
pub use link::{Down, Link, LinkError, LinkEvent, Phase};
pub use message::{Command, Message};
pub use ranger_scan::RangerScans;
pub use report::{
    CommandResult, Fault, Hello, PROTOCOL, Ranger, Report, ResetCause, State, Telemetry,
};
