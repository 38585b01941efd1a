//! From odometry and matches to a pose with covariance, and the map that belongs to it.

mod ekf_slam;
mod line_model;
mod triangle;

pub use ekf_slam::{
    Consistency, EkfConfig, EkfError, EkfSlam, Landmark, LandmarkId, Match, Rejected, Rejection,
    SweepTiming, UpdateReport,
};
pub use triangle::SymmetricMatrix;
