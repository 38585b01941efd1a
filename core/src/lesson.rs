//! Lessons: simulated runs with a fault for a person to fix, graded by measurements.
//!
//! In: a run that began as the lesson says, apart from what was fixed. Out: a mark for each goal.
//!
//! A lesson is an experiment in a [`Link`]. Some of its settings are the fault in the world itself,
//! such as a track that runs farther than its counts say: those stay as they are
//! ([`Lesson::given`]). All others may be changed, and the method too if the lesson allows it. A
//! run is graded when its task is over or its time is up, whichever comes first: a faulty run that
//! never ends fails too.

mod catalogue;
mod grade;
#[cfg(test)]
mod tests;

pub use catalogue::LESSONS;
pub use grade::{Grade, Mark};

use crate::experiment::{Link, LinkError};
use crate::settings;
use crate::slam::Method;

/// A run with a fault.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lesson {
    /// Its name in commands and addresses, unique; it never changes.
    pub name: &'static str,
    /// Its title for people.
    pub title: &'static str,
    /// The visible symptom, not its cause.
    pub fault: &'static str,
    /// The task, and the means allowed.
    pub task: &'static str,
    /// Where to look, for people who do not find it.
    pub hint: &'static str,
    /// Its beginning, as the text of a [`Link`].
    link: &'static str,
    /// Keys of the settings that describe the world: they have to stay as in the link.
    pub given: &'static [&'static str],
    /// Whether another method may be the solution.
    pub is_method_free: bool,
    /// Latest time at which it is graded, s of simulated time.
    pub seconds: f64,
    /// The goals; all must be reached.
    pub goals: &'static [Goal],
}

/// A goal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Goal {
    /// What is measured.
    pub measure: Measure,
    /// The least that is required if [`Measure::is_least`], otherwise the most that is allowed; in
    /// the unit of the measure.
    pub bound: f64,
}

/// The quantities by which a run is graded; only a simulation knows them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Measure {
    /// Part of the reachable area that is known, 0 to 1.
    Explored,
    /// Root mean square distance between estimated and true positions, m, after alignment.
    TrajectoryError,
    /// Distance between estimated and true position now, m.
    PositionError,
    /// Distance between the position by odometry alone and the true one now, as a part of the
    /// distance driven.
    WheelDrift,
    /// Mean NEES of the pose; 3 if its covariance is consistent.
    Nees,
    /// How often the robot touched something.
    Contacts,
}

impl Measure {
    /// The names of all measures, in the order above.
    pub const NAMES: &[&str] = &[
        "explored",
        "trajectory-error",
        "position-error",
        "wheel-drift",
        "nees",
        "contacts",
    ];

    /// Its name in messages.
    #[must_use]
    pub fn name(self) -> &'static str {
        Self::NAMES.get(self as usize).copied().unwrap_or_default()
    }

    /// Whether more is better.
    #[must_use]
    pub fn is_least(self) -> bool {
        self == Self::Explored
    }
}

/// Why a run does not belong to a lesson.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum NotOfLesson {
    /// Another building, sensor, seed, method or way of driving.
    #[error("the lesson's {what} is `{expected}`, this run has `{found}`")]
    Part {
        /// What differs.
        what: &'static str,
        /// What the lesson begins with.
        expected: String,
        /// What the run began with.
        found: String,
    },
    /// The fault was not fixed but removed.
    #[error("`{key}` is how the lesson's world is: it stays {expected}, this run has {found}")]
    Given {
        /// Key of the setting.
        key: &'static str,
        /// Its value in the lesson.
        expected: f64,
        /// Its value in the run.
        found: f64,
    },
    /// The run cannot be read.
    #[error(transparent)]
    Link(#[from] LinkError),
}

impl Lesson {
    /// The lesson with that name.
    #[must_use]
    pub fn named(name: &str) -> Option<&'static Self> {
        LESSONS.iter().find(|lesson| lesson.name == name)
    }

    /// Its beginning.
    ///
    /// # Errors    None for a lesson in [`LESSONS`]; tests check that.
    pub fn begin(&self) -> Result<Link, LinkError> {
        Link::read(self.link)
    }

    /// The same with a proposed solution: another method, other settings.
    ///
    /// # Errors    [`NotOfLesson`].
    pub fn mended(
        &self,
        method: Option<Method>,
        changes: &[(String, f64)],
    ) -> Result<Link, NotOfLesson> {
        let mut link = self.begin()?;
        link.method = method.unwrap_or(link.method);
        link.settings
            .retain(|(key, _)| changes.iter().all(|(changed, _)| changed != key));
        link.settings.extend(changes.iter().cloned());
        self.check(&link)?;
        Ok(link)
    }

    /// Whether a run with this beginning belongs to the lesson, whatever was changed to fix it.
    ///
    /// # Errors    [`NotOfLesson`], naming the first thing that differs.
    pub fn check(&self, run: &Link) -> Result<(), NotOfLesson> {
        let asked = self.begin()?;
        let parts = [
            ("world", asked.world.to_string(), run.world.to_string()),
            (
                "sensor",
                asked.sensor.name().into(),
                run.sensor.name().into(),
            ),
            ("seed", asked.seed.to_string(), run.seed.to_string()),
            (
                "method",
                asked.method.name().into(),
                run.method.name().into(),
            ),
        ];
        let is_free = |what: &str| what == "method" && self.is_method_free;
        for (what, expected, found) in parts {
            if expected != found && !is_free(what) {
                return Err(NotOfLesson::Part {
                    what,
                    expected,
                    found,
                });
            }
        }
        let (_, defaults) = asked.config()?;
        for &key in self.given {
            let default = settings::find(key).ok().and_then(|row| defaults.get(row));
            let number = |link: &Link| {
                let mut named = link.settings.iter().filter(|(name, _)| name == key);
                named.next_back().map(|(_, number)| *number).or(default)
            };
            let (expected, found) = (number(&asked), number(run));
            if expected != found {
                return Err(NotOfLesson::Given {
                    key,
                    expected: expected.unwrap_or(f64::NAN),
                    found: found.unwrap_or(f64::NAN),
                });
            }
        }
        Ok(())
    }
}
