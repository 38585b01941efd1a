//! Which line seen now is which line seen before, and which point is which.

mod assignment;
mod flip;
mod gate;
mod joint;
mod jpda;
mod nearest;
mod points;
mod refinding;

pub use assignment::assign;
pub use flip::{Compared, Flip, FlipOutcome, flips};
pub use gate::{ExpectedLine, Innovation, OrientedLine, gap};
pub use joint::{JointSearch, Paired, Pairing, chi2_survival};
pub use jpda::{Options, joint_probabilities};
pub use nearest::{
    AssociationConfig, AssociationMethod, Candidate, Choice, choose, choose_paired, plausible,
};
pub use points::{PointMatch, PointMatchConfig, PointMatching, are_alike, match_points};
pub use refinding::{RefindingCounts, RefindingCurve};
