//! From motions and matches to poses with covariance.

mod relations;
mod scan_matching;

pub use relations::{RelationErrors, relation_errors};
pub use scan_matching::{MatchReport, ScanMatcher, ScanMatcherConfig, ScanMatcherError};
