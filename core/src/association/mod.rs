//! Which line seen now is which line seen before; which point is which.

mod assignment;
mod gate;
mod joint;
mod jpda;
mod nearest;
mod points;

pub use assignment::assign;
pub use gate::{ExpectedLine, Innovation, OrientedLine, gap};
pub use joint::{JointSearch, Paired, Pairing, chi2_survival};
pub use jpda::{Options, joint_probabilities};
pub use nearest::{
    AssociationConfig, AssociationMethod, Candidate, Choice, choose, choose_paired, plausible,
};
pub use points::{PointMatch, PointMatchConfig, PointMatching, match_points};
