//! From a scan to points in the robot frame.

mod cartesian;

pub use cartesian::{Beam, PointConfig, Points};
