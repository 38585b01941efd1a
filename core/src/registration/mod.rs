//! From two clouds, or a cloud and a map, to the motion between them.
//!
//! Whoever has points and a [`Target`] calls [`locate`]: it matches them by the
//! [`RegistrationMethod`] of its config, and searches where matching fails. A new registration
//! method is a file here and a row of the table below.

mod correlative;
mod locate;
mod outcome;
mod point_to_line;
mod target;

pub use correlative::{Candidate, SearchWindow, search};
pub use locate::{LocateConfig, Located, SearchConfig, SearchedPrior, locate, search_and_match};
pub use outcome::{Prior, Registration, Verdict};
pub use point_to_line::MatchConfig;
pub use target::Target;

use crate::geom::Pose2;
use crate::points::OrientedPoint;

/// How a pose that is nearly right is made exact.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum RegistrationMethod {
    /// Distances of points to lines (Censi 2008).
    #[default]
    PointToLine,
}

/// Matches `points` to `target`, from `start`, by the method of `config`.
#[must_use]
pub fn register<T: Target>(
    points: &[OrientedPoint],
    target: &T,
    start: &Pose2,
    prior: &Prior,
    config: &MatchConfig,
) -> Registration {
    // One row for each method.
    let register = match config.method {
        RegistrationMethod::PointToLine => point_to_line::register,
    };
    register(points, target, start, prior, config)
}
