//! From a scan to points in the robot frame.

mod cartesian;
mod deskew;
mod oriented;

pub use cartesian::{Beam, PointConfig, Points};
pub use deskew::MotionHistory;
pub use oriented::{OrientedConfig, OrientedPoint, oriented_points};
