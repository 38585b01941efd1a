//! Devices on serial lines, and the rules that keep a robot safe, without I/O, thread or clock.
//!
//! In: bytes of a line, what somebody who drives asks for, and the time. Out: bytes for the line, and what robot and sensors say.
//!
//! | module | what it holds |
//! |---|---|
//! | [`source`] | what robots and sensors report, and the orders they take |
//! | [`Device`] | what is at the other end of a line: [`Rp6`], [`Rplidar`], [`Ld06`] |
//! | [`safety`] | whether the robot may move, and by whom |
//! | [`robot_side`] | what its readings mean for driving |
//! | [`news`] | what clients are told of all that |
//! | [`Near`] | all of it for one who drives in the same program: a page that opened the port itself |
//!
//! The bridge gives each line two threads and joins many clients; a page with Web Serial has the lines and is the only client.
//! Both run this code.

mod ld06;
mod line;
mod near;
pub mod news;
mod report;
pub mod robot_side;
pub mod rp6;
pub mod rplidar;
pub mod safety;
pub mod source;

pub use ld06::Ld06;
pub use line::{Device, Want, Weight};
pub use near::Near;
pub use rp6::Rp6;
pub use rplidar::Rplidar;
