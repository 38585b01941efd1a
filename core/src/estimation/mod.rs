//! From motions and matches to poses with covariance.

mod block_cholesky;
mod pose_graph;
mod relations;
mod scan_matching;
mod submap;

pub use pose_graph::{Edge, GraphError, GraphReport, Kernel, PoseGraph, information_at_end};
pub use relations::{RelationErrors, relation_errors};
pub use scan_matching::{MatchReport, ScanMatcher, ScanMatcherConfig, ScanMatcherError};
pub use submap::ClosureConfig;
