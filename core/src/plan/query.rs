//! The question that every planner gets, and the state of its search.

use nalgebra::Point2;

use super::cspace::ConfigSpace;
use super::path::NoPath;

/// Start and goal, map frame, m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Query {
    /// Where the robot's centre is.
    pub start: Point2<f64>,
    /// Where it should go.
    pub goal: Point2<f64>,
}

impl Query {
    /// Whether the robot can stand at both ends.
    ///
    /// # Errors    [`NoPath::StartBlocked`], [`NoPath::GoalBlocked`].
    pub fn check(&self, space: &dyn ConfigSpace) -> Result<(), NoPath> {
        if !space.is_free(self.start) {
            return Err(NoPath::StartBlocked(self.start));
        }
        if !space.is_free(self.goal) {
            return Err(NoPath::GoalBlocked(self.goal));
        }
        Ok(())
    }
}

/// The state of a search.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Progress {
    /// No path yet; more steps may find one.
    Searching,
    /// There is a path; more steps may make it shorter.
    Improving,
    /// There is a path, and this planner cannot make it shorter.
    Finished,
    /// There is no path, or this planner cannot find one.
    Failed(NoPath),
}

impl Progress {
    /// Whether more steps change nothing.
    #[must_use]
    pub fn is_over(&self) -> bool {
        matches!(self, Self::Finished | Self::Failed(_))
    }
}
