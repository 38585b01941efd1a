//! Angles, poses, lines, segments, outlines and covariances: the vocabulary of every other module.

mod angle;
mod chi2;
mod covariance;
mod footprint;
mod gaussian;
pub mod geofence;
mod length;
mod line;
mod pose2;
mod ring;
mod segment;

pub use angle::{sin_cos, unit_vector, wrap};
pub use chi2::chi2_quantile;
pub use covariance::{CHI2_2DOF_99, PoseEstimate, pose_cov, symmetrize};
pub use footprint::Footprint;
pub use gaussian::gaussian_pair;
pub use length::Length;
pub use line::Line;
pub use pose2::Pose2;
pub use ring::{bounds, ring_holds, sides_of};
pub use segment::Segment;
