//! `rounding`: do rounded corners and tight paths get a robot to its goal sooner, and as safely?
//! About 2 min for 10 seeds.
//!
//! 1. A robot with a lidar and no prior knowledge goes to the goal of its world, back to where it
//!    began, and to the goal once more, with the line filter: the whole loop, its errors included.
//! 2. The same with the default paths (chords, a stop at each corner), pulled tight, rounded, and
//!    both; in each of four worlds, with the same seeds.
//! 3. All errands have to end at the goal without a contact; the rounded ones must not take longer
//!    in the median.

use anyhow::{Context, Result};
use nalgebra::Point2;
use serde_json::{Value, json};
use slamlab_core::experiment::{Experiment, ExperimentConfig};
use slamlab_core::pilot::Mode;
use slamlab_core::plan::Shortening;
use slamlab_core::sim::SensorKind;

use super::{Args, Outcome};
use crate::ride::{carry_out, world_named};
use crate::statistics::median;

const SEEDS: u64 = 10;
const WORLDS: [&str; 4] = ["arena", "doors", "office", "maze"];
/// An errand that takes longer has failed, s.
const LONGEST: f64 = 400.0;

const VARIANTS: [(&str, Shortening, bool); 4] = [
    ("chords", Shortening::Chords, false),
    ("tight", Shortening::Tight, false),
    ("chords_rounded", Shortening::Chords, true),
    ("tight_rounded", Shortening::Tight, true),
];

pub(crate) fn measure(args: &Args) -> Result<Outcome> {
    let mut outcome = Outcome::default();
    let (mut contacts, mut missed) = (0.0, 0);
    for world in WORLDS {
        let mut figures = serde_json::Map::new();
        let mut medians = vec![];
        for (name, shortening, is_rounded) in VARIANTS {
            let rides = (args.seeds(SEEDS)).map(|seed| ride(world, seed, shortening, is_rounded));
            let rides: Vec<Ride> = rides.collect::<Result<_>>()?;
            let seconds = median(rides.iter().map(|r| r.seconds));
            contacts += rides.iter().map(|r| r.contacts).sum::<f64>();
            missed += rides.iter().map(|r| r.missed).sum::<usize>();
            figures.insert(name.into(), to_json(&rides, seconds));
            medians.push(seconds);
        }
        outcome.figure(world, Value::Object(figures));
        let key = format!("{world}_rounded_over_chords_seconds");
        outcome.at_most(&key, medians[2] / medians[0], 1.0);
    }
    outcome.at_most("contacts", contacts, 0.0);
    outcome.at_most("errands_missed", missed as f64, 0.0);
    Ok(outcome)
}

struct Ride {
    seconds: f64,
    metres: f64,
    contacts: f64,
    /// Errands that did not end at the goal.
    missed: usize,
}

fn to_json(rides: &[Ride], seconds: f64) -> Value {
    json!({
        "seconds_median": seconds,
        "metres_median": median(rides.iter().map(|r| r.metres)),
        "contacts": rides.iter().map(|r| r.contacts).sum::<f64>(),
        "errands_missed": rides.iter().map(|r| r.missed).sum::<usize>(),
    })
}

fn ride(world: &str, seed: u64, shortening: Shortening, is_rounded: bool) -> Result<Ride> {
    let world = world_named(world)?;
    let goal = world.goal.context("a world without a goal")?;
    let there = world.start.inverse() * goal;
    let robot = world.robot.model();
    let mut config = ExperimentConfig::new(world, robot, SensorKind::Lidar.model(), seed);
    config.mode = Mode::Manual;
    config.pilot.route.shortening = shortening;
    config.pilot.route.is_rounded = is_rounded;
    let mut experiment = Experiment::new(config)?;
    let mut missed = 0;
    for goal in [there, Point2::origin(), there] {
        experiment.set_mode(Mode::GoTo(goal));
        missed += usize::from(!carry_out(&mut experiment, LONGEST, |_| Ok(()))?);
    }
    Ok(Ride {
        seconds: experiment.seconds(),
        metres: experiment.record().distance(),
        contacts: f64::from(experiment.sim().contacts().total()),
        missed,
    })
}
