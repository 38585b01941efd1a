//! A simulated robot from the beginning of a task to its end.

use anyhow::{Context, Result};
use slamlab_core::experiment::{Experiment, ExperimentConfig};
use slamlab_core::pilot::Status;
use slamlab_core::sim::{ReachableArea, World, worlds};

/// What became of a task.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ride {
    pub(crate) is_done: bool,
    pub(crate) explored: f64,
    pub(crate) way: f64,
    pub(crate) seconds: f64,
    /// Contacts with walls, and with people who did not walk into the robot.
    pub(crate) contacts: u32,
    pub(crate) walked_in: u32,
}

impl Ride {
    /// Drives until the task is over, or for so many simulated seconds.
    pub(crate) fn of(config: ExperimentConfig, longest: f64, area: &ReachableArea) -> Result<Self> {
        let mut experiment = Experiment::new(config)?;
        while !experiment.session().status().is_over() && experiment.seconds() < longest {
            experiment.step()?;
        }
        let figures = experiment.figures(area);
        let contacts = figures.contacts;
        Ok(Self {
            is_done: matches!(experiment.session().status(), Status::Finished(_)),
            explored: figures.explored_fraction,
            way: figures.distance,
            seconds: figures.sim_seconds,
            contacts: contacts.walls + contacts.drove_into_mover,
            walked_in: contacts.mover_walked_in,
        })
    }
}

/// The built-in world of this name.
pub(crate) fn world_named(name: &str) -> Result<World> {
    worlds::builtin(name).with_context(|| format!("there is no world `{name}`"))
}
