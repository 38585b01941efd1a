//! Lessons: simulated runs with a fault that a person is to mend, graded by what is measured.
//!
//! In: a run that began as a lesson says, but for what was mended. Out: a mark for each goal.
//!
//! A lesson is an experiment in a [`Link`]. Of its settings some are the fault in the world itself,
//! as a track that runs farther than is counted: those stay as they are ([`Lesson::given`]). All
//! others may be changed, and the method where the lesson says so. A run is graded when its errand
//! is over or its time is up, whichever comes first: an unmended run that never ends fails too.

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
    /// As people call it.
    pub title: &'static str,
    /// What is seen to go wrong; not why.
    pub fault: &'static str,
    /// What is to be done about it, and by what means.
    pub task: &'static str,
    /// Where to look, for who does not find it.
    pub hint: &'static str,
    /// How it begins, as text of a [`Link`].
    link: &'static str,
    /// Keys of the settings that are how the world is: they have to stay as the link says.
    pub given: &'static [&'static str],
    /// Whether another method may be the way out.
    pub is_method_free: bool,
    /// When it is graded at the latest, s of simulated time.
    pub seconds: f64,
    /// What has to be reached, all of it.
    pub goals: &'static [Goal],
}

/// What has to be reached.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Goal {
    /// What is measured.
    pub measure: Measure,
    /// The least that is asked for where [`Measure::is_least`], otherwise the most that is allowed;
    /// in the unit of the measure.
    pub bound: f64,
}

/// What a run is graded by; only a simulation knows it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Measure {
    /// Part of the reachable area that is known, 0 to 1.
    Explored,
    /// Root mean square of the distances of the estimated from the true positions, m, after
    /// alignment.
    TrajectoryError,
    /// Distance of the estimated from the true position now, m.
    PositionError,
    /// Distance of the position by odometry alone from the true one now, as a part of the way that
    /// was driven.
    WheelDrift,
    /// Mean NEES of the pose; 3 if its covariance is honest.
    Nees,
    /// How often the robot touched something.
    Contacts,
}

impl Measure {
    /// The names of all, in the order above.
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

/// Why a run is none of a lesson.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum NotOfLesson {
    /// Another building, sensor, seed, method or way to drive.
    #[error("the lesson's {what} is `{expected}`, this run has `{found}`")]
    Part {
        /// What it is.
        what: &'static str,
        /// What the lesson begins with.
        expected: String,
        /// What the run began with.
        found: String,
    },
    /// The fault was not mended but taken away.
    #[error("`{key}` is how the lesson's world is: it stays {expected}, this run has {found}")]
    Given {
        /// Key of the setting.
        key: &'static str,
        /// Its number in the lesson.
        expected: f64,
        /// Its number in the run.
        found: f64,
    },
    /// The run cannot be read.
    #[error(transparent)]
    Link(#[from] LinkError),
}

impl Lesson {
    /// The lesson of that name.
    #[must_use]
    pub fn named(name: &str) -> Option<&'static Self> {
        LESSONS.iter().find(|lesson| lesson.name == name)
    }

    /// How it begins.
    ///
    /// # Errors    None of a lesson in [`LESSONS`]; tests hold that.
    pub fn begin(&self) -> Result<Link, LinkError> {
        Link::read(self.link)
    }

    /// The same with what is to mend it: another method, other settings.
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

    /// Whether a run that began like this is one of the lesson, whatever was mended.
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
