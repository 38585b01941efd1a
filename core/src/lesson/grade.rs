//! How far a run of a lesson has reached its goals.

use super::{Goal, Lesson, Measure};
use crate::experiment::Experiment;
use crate::sim::ReachableArea;

/// The result of a run for one goal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mark {
    /// The goal.
    pub goal: Goal,
    /// The measured value, in the unit of the measure; NaN if there is nothing to measure yet.
    pub value: f64,
    /// Whether the goal is met.
    pub is_met: bool,
}

/// The result of a run.
#[derive(Clone, Debug, PartialEq)]
pub struct Grade {
    /// Goal by goal.
    pub marks: Vec<Mark>,
    /// Whether it is final: the task is over, or the time is up.
    pub is_over: bool,
}

impl Grade {
    /// Whether the fault is fixed: the run is over, and has reached all goals.
    #[must_use]
    pub fn is_passed(&self) -> bool {
        self.is_over && self.marks.iter().all(|mark| mark.is_met)
    }
}

impl Lesson {
    /// The result of a run so far. `area` is that of its world, see [`crate::sim::reachable_area`].
    #[must_use]
    pub fn grade(&self, run: &Experiment, area: &ReachableArea) -> Grade {
        let mark = |goal: &Goal| {
            let value = goal.measure.of(run, area);
            let is_met = match goal.measure.is_least() {
                true => value >= goal.bound,
                false => value <= goal.bound,
            };
            Mark {
                goal: *goal,
                value,
                is_met,
            }
        };
        Grade {
            marks: self.goals.iter().map(mark).collect(),
            is_over: self.is_over(run),
        }
    }

    /// Whether a run can be graded: its task is over, or its time is up.
    #[must_use]
    pub fn is_over(&self, run: &Experiment) -> bool {
        run.session().status().is_over() || run.seconds() >= self.seconds
    }
}

impl Measure {
    /// The measured value, in its unit; NaN if there is nothing to measure yet.
    fn of(self, run: &Experiment, area: &ReachableArea) -> f64 {
        match self {
            Self::Explored => run.explored_fraction(area),
            Self::TrajectoryError => run.ate_rmse().unwrap_or(f64::NAN),
            Self::PositionError => run.position_error(),
            Self::WheelDrift => run.odometry_error() / run.record().distance(),
            Self::Nees => run.record().nees_mean().unwrap_or(f64::NAN),
            Self::Contacts => f64::from(run.sim().contacts().total()),
        }
    }
}
