//! One run, for the page: SLAM and pilot with their source, a simulation, a recording or a live
//! robot.

use std::cell::OnceCell;

use serde::{Deserialize, Serialize};
use slamlab_core::experiment::Experiment;
use slamlab_core::hash::StateHash;
use slamlab_core::lesson::{Grade, Lesson};
use slamlab_core::live::Live;
use slamlab_core::pilot::Pilot;
use slamlab_core::replay::Replay;
use slamlab_core::robot::RobotModel;
use slamlab_core::session::Session;
use slamlab_core::settings::{self, Settings};
use slamlab_core::sim::ReachableArea;
use slamlab_core::slam::Slam;
use tsify::{Ts, Tsify};
use wasm_bindgen::prelude::wasm_bindgen;

use crate::border::{Level, SettingValues, Typed, WebError, names, typed};
use crate::landmarks::FoundLandmarks;
use crate::status::RunStatus;

names! {
    /// The source of a run.
    SourceKind { Sim = "sim", Replay = "replay", Bridge = "bridge" }
}

/// Why a run cannot do what was requested.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum RunError {
    /// Only a simulation can do it.
    #[error("only a simulation can do that")]
    NoSimulation,
    /// Only a robot behind a bridge has it.
    #[error("only a robot behind a bridge can do that")]
    NotLive,
    /// A real robot cannot go back in time.
    #[error("what a real robot did cannot be done again: record it, and open the recording here")]
    Past,
    /// A recorded robot cannot be driven.
    #[error("a recording cannot be driven")]
    Recorded,
    /// σ(ρ) cannot be estimated from a live robot.
    #[error(
        "σ(ρ) is estimated from a recording: record the standing robot, and open the recording here"
    )]
    NotRecorded,
    /// Only scan matching keeps what a later run needs.
    #[error("only the map of scan matching can be saved to go on in: choose that method")]
    NoSavedMap,
}

crate::border::kinds! { Question: RunError; }

/// The source of a run.
#[derive(Debug)]
pub(crate) enum Source {
    Simulation(Box<Simulated>),
    Recording(Box<Replay>),
    Live(Box<Live>),
}

/// A simulated robot.
#[derive(Debug)]
pub(crate) struct Simulated {
    pub(crate) experiment: Experiment,
    /// Settings of its robot and sensor before any change.
    pub(crate) defaults: Settings,
    /// What can be explored at all; computed on first use.
    pub(crate) area: OnceCell<ReachableArea>,
    /// Of a followed link: number of periods until it was made, and the hash of the state then.
    pub(crate) expected: Option<(u64, u64)>,
    /// The lesson that it is a try at.
    pub(crate) lesson: Option<&'static Lesson>,
    /// The grade when the try was over.
    pub(crate) graded: OnceCell<Grade>,
}

impl Simulated {
    pub(crate) fn new(experiment: Experiment, defaults: Settings) -> Self {
        Self {
            experiment,
            defaults,
            area: OnceCell::new(),
            expected: None,
            lesson: None,
            graded: OnceCell::new(),
        }
    }
}

/// A message to a person.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Tsify)]
pub struct Notice {
    /// Its severity.
    pub level: Level,
    /// The sentence.
    pub text: String,
}

/// A robot that is mapped, finds itself, plans and drives; or a log of one that is mapped.
#[wasm_bindgen]
#[derive(Debug)]
pub struct WebRun {
    pub(crate) source: Source,
    pub(crate) landmarks: FoundLandmarks,
}

#[wasm_bindgen]
impl WebRun {
    /// First half of a simulated control period: the pilot decides. Other sources decide by
    /// themselves.
    pub fn decide(&mut self) {
        if let Source::Simulation(sim) = &mut self.source {
            sim.experiment.decide();
        }
    }

    /// The smallest step: the second half of a simulated control period, or the next scan of a
    /// recording; false if there is none left. A live robot goes at its own pace.
    ///
    /// # Errors    A scan that cannot be used.
    pub fn advance(&mut self) -> Result<bool, WebError> {
        match &mut self.source {
            Source::Simulation(sim) => {
                sim.experiment.advance()?;
                sim.note_grade();
                Ok(true)
            }
            Source::Recording(replay) => Ok(replay.step()?),
            Source::Live(_) => Ok(true),
        }
    }

    /// The present numbers.
    ///
    /// # Errors    None that a page can cause.
    pub fn status(&self) -> Typed<RunStatus> {
        typed(&match &self.source {
            Source::Simulation(sim) => sim.status(),
            Source::Recording(replay) => RunStatus {
                time: replay.time(),
                progress: replay.progress(),
                ..RunStatus::of(replay.session(), false).with_truth(replay.truth())
            },
            Source::Live(live) => RunStatus::of(live.session(), true),
        })
    }

    /// Changes settings that take effect at once.
    ///
    /// # Errors    A sentence on an invalid setting; then none is changed.
    pub fn configure(&mut self, values: &Ts<SettingValues>) -> Result<(), WebError> {
        let values = values.to_rust()?;
        match &mut self.source {
            Source::Simulation(sim) => sim.configure(&values),
            Source::Recording(replay) => {
                let mut settings = replay.log().settings();
                let method = replay.session().slam().method();
                values.apply_to(&mut settings, settings::Source::Recording, method)?;
                Ok(replay.reconfigure(&settings)?)
            }
            Source::Live(live) => Ok(live.reconfigure(values.0.into_iter().collect())?),
        }
    }

    /// Messages for a person since the last call.
    ///
    /// # Errors    None that a page can cause.
    pub fn notices(&mut self) -> Result<Vec<Ts<Notice>>, WebError> {
        let notices: Vec<Notice> = match &mut self.source {
            Source::Simulation(_) => vec![],
            Source::Recording(replay) => {
                let level = Level::Warn;
                let notes = replay.take_notes().into_iter();
                notes.map(|text| Notice { level, text }).collect()
            }
            Source::Live(live) => live.take_notes().into_iter().map(Into::into).collect(),
        };
        notices.iter().map(typed).collect()
    }

    /// Fingerprint of the state: all of it for a simulation, the trajectory for a recording, pose
    /// and map for a live robot; 16 hexadecimal digits.
    #[must_use]
    pub fn state_hash(&self) -> String {
        let hash = match &self.source {
            Source::Simulation(sim) => sim.experiment.state_hash(),
            Source::Recording(replay) => replay.state_hash(),
            Source::Live(live) => {
                let mut hash = StateHash::new();
                live.session().slam().add_to(&mut hash);
                hash.finish()
            }
        };
        format!("{hash:016x}")
    }
}

impl WebRun {
    pub(crate) fn session(&self) -> &Session {
        match &self.source {
            Source::Simulation(sim) => sim.experiment.session(),
            Source::Recording(replay) => replay.session(),
            Source::Live(live) => live.session(),
        }
    }

    pub(crate) fn of(source: Source) -> Self {
        Self {
            source,
            landmarks: FoundLandmarks::default(),
        }
    }

    pub(crate) fn slam(&self) -> &Slam {
        self.session().slam()
    }

    /// The robot; for a recording whose log does not say, a Pioneer, since most were recorded with
    /// one.
    pub(crate) fn robot(&self) -> &RobotModel {
        self.session().robot()
    }

    pub(crate) fn pilot(&self) -> &Pilot {
        self.session().pilot()
    }

    /// # Errors    [`RunError::NoSimulation`].
    pub(crate) fn simulated(&self) -> Result<&Simulated, RunError> {
        match &self.source {
            Source::Simulation(sim) => Ok(sim),
            _ => Err(RunError::NoSimulation),
        }
    }

    /// # Errors    [`RunError::NoSimulation`].
    pub(crate) fn simulated_mut(&mut self) -> Result<&mut Simulated, RunError> {
        match &mut self.source {
            Source::Simulation(sim) => Ok(sim),
            _ => Err(RunError::NoSimulation),
        }
    }

    /// # Errors    [`RunError::NotLive`].
    pub(crate) fn live(&self) -> Result<&Live, RunError> {
        match &self.source {
            Source::Live(live) => Ok(live),
            _ => Err(RunError::NotLive),
        }
    }

    /// # Errors    [`RunError::NotLive`].
    pub(crate) fn live_mut(&mut self) -> Result<&mut Live, RunError> {
        match &mut self.source {
            Source::Live(live) => Ok(live),
            _ => Err(RunError::NotLive),
        }
    }
}
