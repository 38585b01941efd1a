//! From a scan to points in the robot frame, and to runs of points that may lie on one surface.

mod blind_zone;
mod cartesian;
mod deskew;
#[cfg(test)]
#[path = "tests/fixture.rs"]
pub(crate) mod fixture;
mod oriented;
mod range_sigma;
mod saved;
mod scatter;
mod sectors;
mod segmentation;
mod spacing;
mod things;
mod thinned;
mod walkers;

pub use blind_zone::{BlindZone, BlindZoneConfig};
pub use cartesian::{Beam, PointConfig, Points};
pub use deskew::{MotionHistory, MovedSince};
pub(crate) use oriented::WIDEST_GAP;
pub use oriented::{OrientedPoint, on_surfaces, oriented_beams, oriented_cloud, oriented_points};
pub use range_sigma::{Growth, RangeSigma, SigmaBin, SigmaError, SigmaFit, estimate_sigma};
pub(crate) use scatter::{MAX_FLATNESS, Scatter};
pub use sectors::{SectorConfig, SectorRange, sectors};
pub use segmentation::{BreakRule, Run, SegmentationConfig, segment};
pub use spacing::SpacingModel;
pub(crate) use things::{LINK, are_linked};
pub(crate) use thinned::thinned;
pub use walkers::Walkers;
pub(crate) use walkers::unreported_turn;
