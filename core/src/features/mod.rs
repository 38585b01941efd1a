//! From points to lines with covariance, and to the points where lines cross.

mod accept;
mod classic;
mod columns;
mod config;
mod extract;
mod feature;
mod fit;
mod intersection;
mod merge;
mod moments;
mod noise_aware;
mod piece;
mod pilch;

pub use classic::Classic;
pub use config::{AcceptConfig, LineConfig, LineError, MergeConfig, SplitRule};
pub use extract::LineExtractor;
pub use feature::{LineFeature, SegmentFeature};
pub use fit::{FitError, fit_line};
pub use intersection::{
    Intersection, IntersectionConfig, IntersectionError, intersect, intersections,
};
pub use noise_aware::NoiseAware;
pub use pilch::Pilch;
