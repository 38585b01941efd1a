//! `explore`: does a robot in an unknown building see all of it, by itself and on a short path?
//! Some minutes for each seed of all worlds; what was run goes to standard error.
//!
//! 1. Every built-in world but `campus` (days of driving), by lidar and the line filter, 20 seeds
//!    (`--seeds`, `--world`): by each strategy (`--strategy`), including the nearest frontier. The
//!    seed draws noise and wear, the same for all strategies.
//! 2. The same with the four rangers in the worlds where they are enough ([`RANGER_WORLDS`]), with
//!    a scan at each stop.
//! 3. A run ends by itself; it fails after an hour of simulated time, with the rangers three.
//!    Explored is the part of the area that a robot of its size could see from where it could
//!    stand; the path length is the true one.
//! 4. Contacts are with what the robot drove into. People who walk into a standing robot are
//!    counted separately, and are not its fault.

use std::collections::{BTreeMap, BTreeSet};

use anyhow::{Result, ensure};
use serde_json::{Map, Value};
use slamlab_core::experiment::ExperimentConfig;
use slamlab_core::pilot::Mode;
use slamlab_core::plan::FrontierChoice;
use slamlab_core::sim::{ReachableArea, SensorKind, reachable_area, worlds};

use super::{Args, Outcome, chosen};
use crate::clock::cpu_seconds;
use crate::ride::{Ride, summary, world_named};
use crate::statistics::median;

const SEEDS: u64 = 20;
const SKIPPED: &str = "campus";
/// Worlds whose halls a ranger of 1.5 m can follow, and where nobody walks: a robot that can only
/// scan while standing stops for everyone who approaches.
const RANGER_WORLDS: [&str; 6] = ["arena", "doors", "office", "corridor", "loop", "maze"];
const CELL: f64 = 0.05;
/// The median of each world has to reach this part of the reachable area.
const EXPLORED: f64 = 0.95;
/// In this part of the worlds the path has to be shorter than with nearest frontiers.
const SHORTER: f64 = 0.8;

pub(crate) fn measure(args: &Args) -> Result<Outcome> {
    let names = args.worlds(worlds::NAMES.into_iter().filter(|n| *n != SKIPPED))?;
    let strategies = strategies(&args.strategies)?;
    let sensors = chosen("sensor", args.sensor.as_slice(), ["lidar", "rangers"])?;
    let mut outcome = Outcome::default();
    let mut total = Totals::default();
    for name in names {
        let mut figures = Map::new();
        for sensor in &sensors {
            let sensor: SensorKind = sensor.parse()?;
            if sensor == SensorKind::Rangers && !RANGER_WORLDS.contains(&name) {
                continue;
            }
            let scene = Scene::of(name, sensor)?;
            let rows = args.seeds(SEEDS).map(|seed| scene.row(&strategies, seed));
            let rows: Vec<Row> = rows.collect::<Result<_>>()?;
            figures.insert(sensor.name().into(), total.take(sensor, &rows));
        }
        outcome.figure(name, Value::Object(figures));
    }
    total.require(&mut outcome);
    Ok(outcome)
}

/// The strategies that were asked for, or all.
fn strategies(asked: &[String]) -> Result<Vec<Strategy>> {
    let all = FrontierChoice::ALL.map(|(label, choice, _)| (label, choice));
    let names = chosen("strategy", asked, all.map(|(label, _)| label))?;
    let own = label(FrontierChoice::default());
    ensure!(
        names.contains(&own),
        "the requirements are on `{own}`: name it as well"
    );
    Ok(all
        .into_iter()
        .filter(|(label, _)| names.contains(label))
        .collect())
}

/// A strategy, by name.
type Strategy = (&'static str, FrontierChoice);

/// The runs of one seed, by the strategies' names.
type Row = BTreeMap<&'static str, Ride>;

struct Scene {
    name: &'static str,
    sensor: SensorKind,
    area: ReachableArea,
}

impl Scene {
    fn of(name: &'static str, sensor: SensorKind) -> Result<Self> {
        let world = world_named(name)?;
        let area = reachable_area(&world, world.robot.model().radius(), CELL);
        Ok(Self { name, sensor, area })
    }

    fn row(&self, strategies: &[Strategy], seed: u64) -> Result<Row> {
        let mut runs = Row::new();
        for &(label, choice) in strategies {
            let began = cpu_seconds();
            let run = self.explore(choice, seed)?;
            let (name, sensor, took) = (self.name, self.sensor.name(), cpu_seconds() - began);
            eprintln!(
                "{name} {sensor} seed {seed} {label}: {run:?}; {took:.1} s of processor time"
            );
            runs.insert(label, run);
        }
        Ok(runs)
    }

    fn explore(&self, choice: FrontierChoice, seed: u64) -> Result<Ride> {
        let world = world_named(self.name)?;
        let robot = world.robot.model();
        let mut config = ExperimentConfig::new(world, robot, self.sensor.model(), seed);
        config.mode = Mode::Explore;
        config.pilot.frontier.choice = choice;
        Ride::of(config, longest(self.sensor), &self.area)
    }
}

/// A longer run counts as failed, s. A robot that stands still for each scan takes longer.
fn longest(sensor: SensorKind) -> f64 {
    match sensor {
        SensorKind::Rangers => 3.0 * 3600.0,
        _ => 3600.0,
    }
}

/// Requirements over all worlds together.
#[derive(Default)]
struct Totals {
    worlds: u32,
    shorter: u32,
    contacts: u32,
    not_ended: usize,
    least_explored: Option<f64>,
}

impl Totals {
    /// Adds the runs of a world to the totals, and returns its figures.
    fn take(&mut self, sensor: SensorKind, rows: &[Row]) -> Value {
        let mut figures = Map::new();
        let labels: BTreeSet<&str> = rows.iter().flat_map(|row| row.keys().copied()).collect();
        for label in labels {
            let runs = rows.iter().filter_map(|row| row.get(label).copied());
            figures.insert(label.into(), summary(&runs.collect::<Vec<_>>()));
        }
        // The requirements apply to the robot's default.
        let own = label(FrontierChoice::default());
        let by = |choice| median_ratio(rows, own, label(choice));
        let (ratio, by_room) = (by(FrontierChoice::Nearest), by(FrontierChoice::RoomByRoom));
        figures.insert("way_over_nearest_frontier_median".into(), ratio.into());
        figures.insert("way_over_room_by_room_median".into(), by_room.into());
        let own = || rows.iter().filter_map(|row| row.get(own));
        self.contacts += own().map(|run| run.contacts).sum::<u32>();
        self.not_ended += own().filter(|run| !run.is_done).count();
        if sensor == SensorKind::Lidar {
            self.worlds += 1;
            self.shorter += u32::from(ratio < 1.0);
            let explored = median(own().map(|run| run.explored));
            self.least_explored = Some(self.least_explored.unwrap_or(1.0).min(explored));
        }
        Value::Object(figures)
    }

    fn require(&self, outcome: &mut Outcome) {
        outcome.at_most("contacts", f64::from(self.contacts), 0.0);
        outcome.at_most("runs_that_do_not_end", self.not_ended as f64, 0.0);
        if let Some(least) = self.least_explored {
            let part = f64::from(self.shorter) / f64::from(self.worlds);
            outcome.at_least("worlds_with_shorter_way_part", part, SHORTER);
            outcome.at_least("explored_by_lidar_median_of_worst_world", least, EXPLORED);
        }
    }
}

/// Median ratio of path lengths of two strategies in the same run, where both were driven.
fn median_ratio(rows: &[Row], one: &str, other: &str) -> f64 {
    let pairs = (rows.iter()).filter_map(|row| row.get(one).zip(row.get(other)));
    median(pairs.map(|(one, other)| one.way / other.way))
}

/// The name of a strategy.
fn label(choice: FrontierChoice) -> &'static str {
    let found = FrontierChoice::ALL.iter().find(|(_, c, _)| *c == choice);
    found.map_or("", |(label, ..)| label)
}
