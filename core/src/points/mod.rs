//! From a scan to points in the robot frame.

mod cartesian;
mod deskew;

pub use cartesian::{Beam, PointConfig, Points};
pub use deskew::MotionHistory;
