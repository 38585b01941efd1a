//! Which line seen now is which line seen before; which point is which.

mod gate;
mod joint;
mod nearest;
mod points;

pub use gate::{ExpectedLine, Innovation, OrientedLine, gap};
pub use joint::{JointSearch, Paired, Pairing, chi2_survival};
pub use nearest::{
    AssociationConfig, AssociationMethod, Candidate, Choice, choose, choose_paired, plausible,
};
pub use points::{PointMatch, PointMatchConfig, PointMatching, match_points};
