//! From two clouds, or a cloud and a map, to the motion between them.
//!
//! Whoever has points and a [`Target`] calls [`locate`]: it matches them by point-to-line distances,
//! and searches where matching fails.

mod correlative;
mod locate;
mod outcome;
mod point_to_line;
mod target;

pub use correlative::{Candidate, SearchWindow, search};
pub use locate::{LocateConfig, Located, SearchConfig, SearchedPrior, locate, search_and_match};
pub use outcome::{Prior, Registration, Verdict};
pub use point_to_line::{MatchConfig, register};
pub use target::Target;
