//! Lessons, for the page: what there is to mend, and what a try has achieved.

use serde::{Deserialize, Serialize};
use slamlab_core::lesson::{self, LESSONS, Lesson, NotOfLesson};
use tsify::{Ts, Tsify};
use wasm_bindgen::prelude::wasm_bindgen;

use crate::border::{MeasureName, WebError, typed};
use crate::link;
use crate::run::WebRun;
use crate::setup::Setup;

crate::border::kinds! { Setup: NotOfLesson; }

/// A run with a fault; see `Lesson` of the core.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Tsify)]
#[serde(rename_all = "camelCase")]
pub struct LessonInfo {
    pub name: String,
    pub title: String,
    pub fault: String,
    pub task: String,
    pub hint: String,
    /// The setup that it begins with.
    pub setup: Setup,
    /// Time at which it is graded at the latest, s.
    pub seconds: f64,
}

/// The result of a try for one goal.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Tsify)]
#[serde(rename_all = "camelCase")]
pub struct Mark {
    /// What is measured.
    pub measure: MeasureName,
    /// Whether the bound is a minimum; otherwise it is a maximum.
    pub is_least: bool,
    /// The bound, in the unit of the measure.
    pub bound: f64,
    /// The measured value, in that unit; NaN while there is none.
    pub value: f64,
    /// Whether it meets the bound.
    pub is_met: bool,
}

/// The result of a try.
#[derive(Clone, Debug, PartialEq, Serialize, Tsify)]
#[serde(rename_all = "camelCase")]
pub struct Grade {
    /// Goal by goal.
    pub marks: Vec<Mark>,
    /// Whether the grade is final: the errand is over, or the time is up.
    pub is_over: bool,
    /// Whether it is final, and all goals are met.
    pub is_passed: bool,
}

impl From<lesson::Grade> for Grade {
    fn from(grade: lesson::Grade) -> Self {
        let mark = |mark: &lesson::Mark| Mark {
            measure: mark.goal.measure.into(),
            is_least: mark.goal.measure.is_least(),
            bound: mark.goal.bound,
            value: mark.value,
            is_met: mark.is_met,
        };
        Self {
            marks: grade.marks.iter().map(mark).collect(),
            is_over: grade.is_over,
            is_passed: grade.is_passed(),
        }
    }
}

/// All lessons.
///
/// # Errors    None that a page can cause.
pub(crate) fn lessons() -> Result<Vec<LessonInfo>, WebError> {
    let info = |lesson: &Lesson| {
        Ok(LessonInfo {
            name: lesson.name.to_owned(),
            title: lesson.title.to_owned(),
            fault: lesson.fault.to_owned(),
            task: lesson.task.to_owned(),
            hint: lesson.hint.to_owned(),
            setup: Setup {
                lesson: Some(lesson.name.to_owned()),
                ..link::setup_of(lesson.begin()?)?
            },
            seconds: lesson.seconds,
        })
    };
    LESSONS.iter().map(info).collect()
}

#[wasm_bindgen]
impl WebRun {
    /// The grade of this try at a lesson, now or when it was over; nothing if the run is not a
    /// lesson. Costs more than a step.
    ///
    /// # Errors    None that a page can cause.
    pub fn grade(&self) -> Result<Option<Ts<Grade>>, WebError> {
        let sim = self.simulated().ok();
        let grade = sim.and_then(|sim| sim.grade());
        grade.map(|grade| typed(&Grade::from(grade))).transpose()
    }
}
