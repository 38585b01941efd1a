//! From points to lines, and to points that can be found again, with covariance.

mod accept;
mod circle;
mod classic;
mod columns;
mod config;
mod consensus;
mod corner;
mod crossing;
mod extract;
mod feature;
mod find_points;
mod fit;
mod hough;
mod merge;
mod moments;
mod noise_aware;
mod piece;
mod pilch;
mod point;
mod ransac;
mod spike;

pub use circle::CircleConfig;
pub use classic::Classic;
pub use config::{AcceptConfig, LineConfig, LineError, MergeConfig, SplitRule};
pub use corner::CornerConfig;
pub use crossing::CrossingConfig;
pub use extract::LineExtractor;
pub use feature::LineFeature;
pub use find_points::{PointFeatureConfig, find_points};
pub use fit::{BadBeam, fit_line};
pub use hough::Hough;
pub use noise_aware::NoiseAware;
pub use pilch::Pilch;
pub use point::{PointFeature, PointKind};
pub use ransac::Ransac;
pub use spike::{SpikeConfig, SpikeForm};
