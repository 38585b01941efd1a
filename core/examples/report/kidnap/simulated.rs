//! A kidnapped robot in `office`, which knows the walls and drives on to random places. It is
//! steered by the truth, because how soon it is found must not depend on where it believes to be.

use std::collections::VecDeque;

use anyhow::Result;
use nalgebra::{Point2, Vector2};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use slamlab_core::experiment::{Experiment, ExperimentConfig};
use slamlab_core::geom::Length;
use slamlab_core::pilot::Mode;
use slamlab_core::sim::SensorModel;
use slamlab_core::slam::Method;

use super::Belief;
use crate::errand::errand;
use crate::ride::world_named;
use crate::statistics::{median, quantile};
use crate::threads::each;
use crate::{Args, Outcome};

const WORLD: &str = "office";
const SEEDS: u64 = 50;
/// Driving time before, s.
const BEFORE: f64 = 30.0;
/// A robot not found within this time counts as not found, s.
const LONGEST: f64 = 180.0;
/// Driving time after it was found, s: it has to stay found.
const AFTER: f64 = 10.0;

/// The outcome for a kidnapped robot.
struct Fate {
    /// Greatest error before the kidnapping, m.
    error_before: f64,
    /// Time until it was no longer sure, s.
    noticed: Option<f64>,
    /// Time until it was found, s.
    found: Option<f64>,
    /// Time sure and wrong after it had noticed, s.
    deceived: f64,
    /// Error at the end, m.
    error_after: f64,
}

pub(super) fn measure(args: &Args, outcome: &mut Outcome) -> Result<()> {
    let seeds: Vec<u64> = args.seeds(SEEDS).collect();
    let fates = each(seeds.len(), |i| run(seeds[i]))?;
    for (seed, fate) in seeds.iter().zip(&fates) {
        let Fate {
            noticed,
            found,
            deceived,
            error_after,
            error_before,
        } = fate;
        eprintln!(
            "{WORLD} seed {seed}: noticed {noticed:?} s, found {found:?} s, deceived {deceived:.2} s, before {error_before:.3} m, after {error_after:.3} m"
        );
    }
    let runs = fates.len() as f64;
    let found: Vec<f64> = fates.iter().filter_map(|fate| fate.found).collect();
    let noticed = fates.iter().filter_map(|fate| fate.noticed);
    outcome.figure("kidnapped_runs", runs);
    outcome.at_least("kidnapped_found_part", found.len() as f64 / runs, 0.98);
    let never = fates.iter().map(|fate| fate.found.unwrap_or(LONGEST));
    let until: Vec<f64> = never.collect();
    outcome.at_most("kidnapped_found_after_s_median", median(&until), 20.0);
    outcome.figure("kidnapped_found_after_s_p90", quantile(&until, 0.9));
    outcome.figure(
        "kidnapped_noticed_after_s_median",
        median(noticed.collect::<Vec<f64>>()),
    );
    let deceived: f64 = fates.iter().map(|fate| fate.deceived).sum();
    outcome.figure("kidnapped_sure_and_wrong_s", deceived);
    let before = fates
        .iter()
        .map(|fate| fate.error_before)
        .fold(0.0, f64::max);
    outcome.figure("tracking_error_m_max", before);
    let errors: Vec<f64> = fates.iter().map(|fate| fate.error_after).collect();
    outcome.figure("found_error_m_median", median(&errors));
    Ok(())
}

fn run(seed: u64) -> Result<Fate> {
    let world = world_named(WORLD)?;
    let robot = world.robot.model();
    let mut config = ExperimentConfig::new(world, robot, SensorModel::lidar(), seed);
    config.method = Method::ParticleLocalisation;
    config.mode = Mode::Manual;
    config.slam.particles.seed = seed;
    let mut driver = Driver {
        experiment: Experiment::new(config)?,
        rng: ChaCha8Rng::seed_from_u64(seed),
        route: VecDeque::new(),
    };
    let mut fate = Fate {
        error_before: 0.0,
        noticed: None,
        found: None,
        deceived: 0.0,
        error_after: 0.0,
    };
    while driver.experiment.seconds() < BEFORE {
        let belief = driver.step()?;
        fate.error_before = fate.error_before.max(belief.off[0]);
    }
    driver.experiment.kidnap(None)?;
    driver.route.clear();
    let mut last = BEFORE;
    loop {
        let belief = driver.step()?;
        let now = driver.experiment.seconds();
        let since = now - BEFORE;
        if fate.noticed.is_none() && !belief.is_sure {
            fate.noticed = Some(since);
        }
        if fate.noticed.is_some() && belief.is_deceived() {
            fate.deceived += now - last;
        }
        last = now;
        if fate.found.is_none() && fate.noticed.is_some() && belief.is_found() {
            fate.found = Some(since);
        }
        fate.error_after = belief.off[0];
        let end = fate.found.map_or(LONGEST, |found| found + AFTER);
        if since >= end {
            // If it gets lost again, it does not count as found.
            fate.found = fate.found.filter(|_| belief.is_found());
            return Ok(fate);
        }
    }
}

struct Driver {
    experiment: Experiment,
    rng: ChaCha8Rng,
    route: VecDeque<Point2<f64>>,
}

impl Driver {
    fn step(&mut self) -> Result<Belief> {
        if self.route.is_empty() {
            self.route = errand(self.experiment.sim(), &mut self.rng);
        }
        self.steer();
        self.experiment.step()?;
        Ok(Belief::of(
            self.experiment.session(),
            &self.experiment.truth(),
        ))
    }

    /// Steers for a point of the route a little ahead.
    fn steer(&mut self) {
        let pose = self.experiment.sim().truth();
        let is_passed = |p: &Point2<f64>| (p - pose.position()).length() < 0.25;
        while self.route.front().is_some_and(is_passed) {
            self.route.pop_front();
        }
        let Some(&goal) = self.route.front() else {
            return;
        };
        let ahead: Vector2<f64> = (pose.inverse() * goal).coords;
        let error = libm::atan2(ahead.y, ahead.x);
        let forward = if error.abs() > 0.4 { 0.0 } else { 0.25 };
        self.experiment
            .drive(forward, (2.5 * error).clamp(-1.0, 1.0));
    }
}
