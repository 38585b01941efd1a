//! What goes over a wire: frames of robots and sensors, and the messages between bridge and page.
//!
//! Codecs without I/O: bytes in, typed values out, and back. A decoder takes bytes as they arrive,
//! in pieces of any size, resynchronises after noise, and counts what it threw away. Page, bridge,
//! firmware tests and simulated devices share the codecs, which are thus the only definition of
//! each byte.
//!
//! It takes the map type from [`crate::format`], because the map on the wire is the one that is
//! saved; the history of motion from [`crate::points`]; and the geofence from [`crate::geom`].
//!
//! Units change here and nowhere else: millimetres, degrees, ticks and counts outside; metres and
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
