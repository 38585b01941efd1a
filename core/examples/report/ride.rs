//! A simulated robot from the beginning to the end of a task.

use anyhow::{Context, Result};
use serde_json::{Value, json};
use slamlab_core::experiment::{Experiment, ExperimentConfig};
use slamlab_core::pilot::Status;
use slamlab_core::sim::{ReachableArea, World, worlds};

use crate::statistics::median;

/// The outcome of a task.
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
    /// Drives until the task is over, for at most `longest` simulated seconds.
    pub(crate) fn of(config: ExperimentConfig, longest: f64, area: &ReachableArea) -> Result<Self> {
        let mut experiment = Experiment::new(config)?;
        let is_done = carry_out(&mut experiment, longest, |_| Ok(()))?;
        let figures = experiment.figures(area);
        let contacts = figures.contacts;
        Ok(Self {
            is_done,
            explored: figures.explored_fraction,
            way: figures.distance,
            seconds: figures.sim_seconds,
            contacts: contacts.walls + contacts.drove_into_mover,
            walked_in: contacts.mover_walked_in,
        })
    }
}

/// Summary of the rides in one world.
pub(crate) fn summary(rides: &[Ride]) -> Value {
    let of = |value: fn(&Ride) -> f64| rides.iter().map(value);
    let sum = |value: fn(&Ride) -> u32| rides.iter().map(value).sum::<u32>();
    json!({
        "runs": rides.len(),
        "done": sum(|ride| ride.is_done.into()),
        "explored_median": median(of(|ride| ride.explored)),
        "explored_least": of(|ride| ride.explored).fold(1.0, f64::min),
        "way_m_median": median(of(|ride| ride.way)),
        "simulated_s_median": median(of(|ride| ride.seconds)),
        "contacts": sum(|ride| ride.contacts),
        "people_who_walked_in": sum(|ride| ride.walked_in),
    })
}

/// Lets the robot go on until its task is over, for at most `longest` simulated seconds; returns
/// whether it is done. `see` is called after each step.
pub(crate) fn carry_out(
    experiment: &mut Experiment,
    longest: f64,
    mut see: impl FnMut(&Experiment) -> Result<()>,
) -> Result<bool> {
    let begin = experiment.seconds();
    loop {
        // Step first: an earlier task has ended.
        experiment.step()?;
        see(experiment)?;
        let status = experiment.session().status();
        if status.is_over() || experiment.seconds() - begin >= longest {
            return Ok(matches!(status, Status::Finished(_)));
        }
    }
}

/// The built-in world of this name.
pub(crate) fn world_named(name: &str) -> Result<World> {
    worlds::builtin(name).with_context(|| format!("there is no world `{name}`"))
}
