//! What goes over a wire: frames of robots and sensors, and the messages between bridge and page.
//!
//! Codecs without I/O: bytes in, typed values out, and back. A decoder takes bytes as they come, in
//! pieces of any size, finds the start of a frame again after noise, and counts what it threw away.
//! Page, bridge, firmware tests and simulated devices share them, so that there is one truth about
//! each byte.
//!
//! Of [`crate::format`] it takes what a map is, so that the wire tells the map that is saved, and
//! no other; of [`crate::points`] how motion is remembered, of [`crate::control`] what a geofence
//! is.
//!
//! Units change here and only here: millimetres, degrees, ticks and counts outside; metres and
//! radians inside.

mod carried_pose;
pub mod client;
mod clock;
mod inbox;
pub mod ld06;
pub mod message;
pub mod pilch;
pub mod recording;
pub mod rp6;
pub mod rplidar;
pub mod timeline;

pub use carried_pose::CarriedPose;
pub use clock::ClockMap;
pub use inbox::Tally;
