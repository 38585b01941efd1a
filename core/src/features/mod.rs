//! From points to lines with covariance.

mod accept;
mod classic;
mod columns;
mod config;
mod consensus;
mod extract;
mod feature;
mod fit;
mod hough;
mod merge;
mod moments;
mod noise_aware;
mod piece;
mod pilch;
mod ransac;

pub use classic::Classic;
pub use config::{AcceptConfig, LineConfig, LineError, MergeConfig, SplitRule};
pub use extract::LineExtractor;
pub use feature::LineFeature;
pub use fit::{BadBeam, fit_line};
pub use hough::Hough;
pub use noise_aware::NoiseAware;
pub use pilch::Pilch;
pub use ransac::Ransac;
