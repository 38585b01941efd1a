//! From two clouds, or a cloud and a map, to the motion between them.

mod correlative;
mod point_to_line;

pub use correlative::{Candidate, SearchWindow, search};
pub use point_to_line::{MatchConfig, Prior, Registration, Verdict, match_to_surfels};
