//! From points to lines with covariance.

mod fit;
mod split_merge;

pub use fit::{FitError, LineFeature, fit_line};
pub use split_merge::{LineConfig, LineExtractor};
