//! Which line seen now is which line seen before.

mod gate;
mod joint;
mod nearest;

pub use gate::{ExpectedLine, Innovation, OrientedLine};
pub use joint::{JointConfig, JointMatches, Pairing, chi2_survival, joint_matches};
pub use nearest::{AssociationConfig, AssociationMethod, Candidate, Choice, choose, choose_paired};
