//! Devices on serial lines, and the rules that keep a robot safe, without I/O, thread or clock.
//!
//! In: bytes of a line, what somebody who drives asks for, and the time. Out: bytes for the line, and what robot and sensors say.
//!
//! | module | what it holds |
//! |---|---|
//! | [`source`] | what robots and sensors report, and the orders they take |
//! | [`Device`] | what is at the other end of a line: [`Rp6`], [`Rplidar`], [`Ld06`] |
//! | [`safety`] | whether the robot may move, and by whom |
//! | [`hub`] | all rules and state of a bridge, between sources and clients |
//! | [`LocalBridge`] | a hub with its devices and one client: a page that opened the ports itself |
//!
//! The bridge gives each line two threads and each client a queue; a page with Web Serial has the lines and is the only client.
//! Both run the same hub.

pub mod hub;
mod ld06;
mod line;
mod local_bridge;
mod report;
pub mod rp6;
pub mod rplidar;
pub mod safety;
pub mod source;

pub use ld06::Ld06;
pub use line::{Device, Want, Weight};
pub use local_bridge::LocalBridge;
pub use rp6::Rp6;
pub use rplidar::Rplidar;
