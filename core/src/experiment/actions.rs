//! What a person did to a run, and when. Repeating it at the same periods, with the same
//! configuration, gives the same run to the bit.

use std::collections::VecDeque;

use super::{Experiment, ExperimentError};
use crate::pilot::Mode;
use crate::settings::Settings;

/// What a person can do to a run.
#[derive(Clone, Debug, PartialEq)]
pub enum Action {
    /// See [`Experiment::set_mode`].
    SetMode(Mode),
    /// See [`Experiment::drive`]: m/s and rad/s.
    Drive([f64; 2]),
    /// See [`Experiment::stop`].
    Stop,
    /// See [`Experiment::kidnap`]: to a place drawn from the seed.
    Kidnap,
    /// See [`Experiment::set_door`].
    SetDoor {
        /// Its number.
        door: usize,
        /// Open, or shut.
        open: bool,
    },
    /// See [`Experiment::set_cycle`].
    SetCycle(bool),
    /// See [`Experiment::reconfigure`].
    Configure(Box<Settings>),
}

/// An action, and when it was done.
#[derive(Clone, Debug, PartialEq)]
pub struct TimedAction {
    /// Control periods that had ended by then.
    pub period: u64,
    /// Whether the pilot had already decided on the period that followed, as it has between two
    /// stages of the cycle.
    pub is_decided: bool,
    /// What was done.
    pub action: Action,
}

/// What was done to a run, and what is still to be repeated.
#[derive(Clone, Debug, Default)]
pub(super) struct Actions {
    periods: u64,
    done: Vec<TimedAction>,
    due: VecDeque<TimedAction>,
    /// Whether the present action comes from `due`.
    is_told: bool,
    /// Whether somebody intervened before everything due was done: since then it is a different
    /// run.
    has_forked: bool,
    /// How often somebody did something that was not due.
    by_hand: u32,
    /// Something was done that no list of actions can express.
    untold: Option<&'static str>,
    /// Settings changed by `due`, until they are taken.
    followed: Option<Box<Settings>>,
}

impl Actions {
    pub(super) fn next_period(&mut self) {
        self.periods += 1;
    }

    pub(super) fn note(&mut self, is_decided: bool, action: Action) {
        self.fork();
        self.done.push(TimedAction {
            period: self.periods,
            is_decided,
            action,
        });
    }

    pub(super) fn note_untold(&mut self, what: &'static str) {
        self.fork();
        self.untold.get_or_insert(what);
    }

    /// Somebody does something that is not due: the rest of what was due is dropped.
    pub(super) fn fork(&mut self) {
        self.by_hand += u32::from(!self.is_told);
        if !self.is_told && !self.due.is_empty() {
            self.due.clear();
            self.has_forked = true;
        }
    }

    /// The next action that is due, depending on whether the pilot has decided.
    fn next_due(&mut self, is_decided: bool) -> Option<Action> {
        let when = (self.periods, is_decided);
        let next = self.due.front()?;
        ((next.period, next.is_decided) <= when)
            .then(|| self.due.pop_front())?
            .map(|timed| timed.action)
    }
}

/// Something was done to the run that no list of actions can express.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}: that cannot be done again from a list of actions")]
pub struct Untold(&'static str);

/// Why a run cannot be repeated.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum AgainError {
    /// What was done cannot be expressed.
    #[error(transparent)]
    Untold(#[from] Untold),
    /// Its initial configuration cannot be used.
    #[error(transparent)]
    Start(#[from] ExperimentError),
}

impl Experiment {
    /// Control periods since the beginning.
    #[must_use]
    pub fn periods(&self) -> u64 {
        self.actions.periods
    }

    /// What a person has done so far.
    ///
    /// # Errors    [`Untold`].
    pub fn actions(&self) -> Result<&[TimedAction], Untold> {
        let Actions { done, untold, .. } = &self.actions;
        untold.map_or(Ok(done), |what| Err(Untold(what)))
    }

    /// The same run from its beginning, with everything that was done, or is still to be done, due
    /// at its period.
    ///
    /// # Errors    [`AgainError`].
    pub fn again(&self) -> Result<Self, AgainError> {
        let done = self.actions()?.iter();
        let due = done.chain(&self.actions.due).cloned().collect();
        let mut again = Self::new(self.start.clone())?;
        again.actions.due = due;
        Ok(again)
    }

    /// From here on, `actions`, in order of time, are done each at its period. One that the run
    /// refuses, such as for a door that does not exist, is skipped. If somebody does something else
    /// before all are done, the rest is dropped.
    pub fn follow(&mut self, actions: impl IntoIterator<Item = TimedAction>) {
        self.actions.due.extend(actions);
    }

    /// Whether something is still to be done.
    #[must_use]
    pub fn has_due(&self) -> bool {
        !self.actions.due.is_empty()
    }

    /// Whether somebody intervened before everything that was to be repeated was done.
    #[must_use]
    pub fn has_forked(&self) -> bool {
        self.actions.has_forked
    }

    /// How often somebody did something that was not due. For a repeated run, this shows that it
    /// has become a different run.
    #[must_use]
    pub fn by_hand(&self) -> u32 {
        self.actions.by_hand
    }

    /// The settings that due actions have changed since the last call. A page that shows settings
    /// needs this, because it cannot see that they have changed.
    pub fn take_followed_settings(&mut self) -> Option<Settings> {
        self.actions.followed.take().map(|settings| *settings)
    }

    /// Does what is due.
    pub(super) fn act_as_told(&mut self) {
        self.actions.is_told = true;
        self.act_all_due();
        self.actions.is_told = false;
    }

    fn act_all_due(&mut self) {
        while let Some(action) = self.actions.next_due(self.has_decided) {
            match action {
                Action::SetMode(mode) => self.set_mode(mode),
                Action::Drive([forward, turn]) => self.drive(forward, turn),
                Action::Stop => self.stop(),
                Action::SetCycle(cycle) => self.set_cycle(cycle),
                // What was refused then is refused now, and nothing has changed.
                Action::Kidnap => drop(self.kidnap(None)),
                Action::SetDoor { door, open } => drop(self.set_door(door, open)),
                Action::Configure(settings) => {
                    if self.reconfigure(&settings).is_ok() {
                        self.actions.followed = Some(settings);
                    }
                }
            }
        }
    }
}
