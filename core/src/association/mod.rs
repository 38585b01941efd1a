//! Which line seen now is which line seen before.

mod gate;
mod nearest;

pub use gate::{ExpectedLine, Innovation, OrientedLine};
pub use nearest::{AssociationConfig, Candidate, Choice, choose};
