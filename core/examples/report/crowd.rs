//! `crowd`: does a robot among people reach its goal, and what does the dynamic window gain? Half a
//! minute for each seed of a world.
//!
//! 1. `crowd` with its ten people, and rooms to which four people are added who walk to and fro
//!    ([`PEOPLED`]); by lidar and the line filter, 20 seeds (`--seeds`, `--world`). The seed draws
//!    noise, wear, people and goal; both ways of avoiding people get the same ones.
//! 2. Two errands: exploring everything, and a goal somewhere.
//! 3. No contact with a wall, and none with a person except those who walk into the robot, in
//!    either case. Time and distance are reported, not judged.

use std::collections::BTreeMap;

use anyhow::{Context, Result};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde_json::Value;
use slamlab_core::control::Avoidance;
use slamlab_core::experiment::ExperimentConfig;
use slamlab_core::geom::Segment;
use slamlab_core::pilot::Mode;
use slamlab_core::sim::{
    Caster, Mover, ReachableArea, SensorModel, Simulation, World, reachable_area,
};

use super::errand::errand;
use super::{Args, Outcome};
use crate::ride::{Ride, summary, world_named};
use crate::statistics::{median, place_between};

const SEEDS: u64 = 20;
/// The world with people of its own, and the worlds to which people are added.
const CROWDED: &str = "crowd";
const PEOPLED: [&str; 2] = ["arena", "office"];
const PEOPLE: usize = 4;
/// Minimum distance of people from walls and the robot's start, m.
const ROOM: f64 = 0.3;
const START_ROOM: f64 = 1.0;
/// An errand that takes longer has failed, s.
const LONGEST: f64 = 1200.0;
const CELL: f64 = 0.05;
const WAYS: [(&str, Avoidance); 2] = [
    ("keeps_to_way", Avoidance::KeepsToWay),
    ("dynamic_window", Avoidance::DynamicWindow),
];

pub(crate) fn measure(args: &Args) -> Result<Outcome> {
    let names = args.worlds([CROWDED].into_iter().chain(PEOPLED))?;
    let mut outcome = Outcome::default();
    let mut contacts: BTreeMap<&str, u32> = BTreeMap::new();
    for name in names {
        let mut runs: BTreeMap<&str, Vec<[Ride; 2]>> = BTreeMap::new();
        for seed in args.seeds(SEEDS) {
            let scene = Scene::drawn(name, seed)?;
            for (label, mode) in [("explore", Mode::Explore), ("goal", scene.goal()?)] {
                let both = [scene.run(mode, WAYS[0].1)?, scene.run(mode, WAYS[1].1)?];
                eprintln!("{name} seed {seed} {label}: {both:?}");
                runs.entry(label).or_default().push(both);
            }
        }
        let mut figures = serde_json::Map::new();
        for (errand, runs) in &runs {
            for (number, (way, _)) in WAYS.into_iter().enumerate() {
                let own: Vec<Ride> = runs.iter().map(|both| both[number]).collect();
                let touched = own.iter().map(|run| run.contacts).sum::<u32>();
                *contacts.entry(way).or_default() += touched;
                figures.insert(format!("{errand}_{way}"), summary(&own));
            }
            let both_done = (runs.iter()).filter(|both| both.iter().all(|run| run.is_done));
            let ratio = median(both_done.map(|[kept, around]| around.seconds / kept.seconds));
            let key = format!("{errand}_time_with_over_without_median");
            figures.insert(key, ratio.into());
        }
        outcome.figure(name, Value::Object(figures));
    }
    for (way, count) in contacts {
        outcome.at_most(&format!("contacts_{way}"), f64::from(count), 0.0);
    }
    Ok(outcome)
}

/// A world with its people.
struct Scene {
    world: World,
    area: ReachableArea,
    seed: u64,
}

impl Scene {
    fn drawn(name: &str, seed: u64) -> Result<Self> {
        let mut world = world_named(name)?;
        let area = reachable_area(&world, world.robot.model().radius(), CELL);
        if PEOPLED.contains(&name) {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            let people = (0..PEOPLE).map(|_| person(&world, &mut rng)).collect();
            world.movers = people;
        }
        Ok(Self { world, area, seed })
    }

    /// A goal somewhere in the world.
    fn goal(&self) -> Result<Mode> {
        let robot = self.world.robot.model();
        let sim = Simulation::new(self.world.clone(), robot, SensorModel::lidar(), self.seed)?;
        let mut rng = ChaCha8Rng::seed_from_u64(!self.seed);
        let goal = errand(&sim, &mut rng).back().copied();
        let goal = goal.context("the robot is shut in")?;
        Ok(Mode::GoTo(self.world.start.inverse() * goal))
    }

    fn run(&self, mode: Mode, avoidance: Avoidance) -> Result<Ride> {
        let robot = self.world.robot.model();
        let (world, sensor) = (self.world.clone(), SensorModel::lidar());
        let mut config = ExperimentConfig::new(world, robot, sensor, self.seed);
        config.mode = mode;
        config.pilot.avoidance = avoidance;
        Ride::of(config, LONGEST, &self.area)
    }
}

/// Somebody who walks to and fro between two places with a clear line of sight.
fn person(world: &World, rng: &mut ChaCha8Rng) -> Mover {
    let caster = Caster::new(world.walls());
    let (low, high) = world.bounds();
    let mut place = || place_between(low, high, rng);
    let start = world.start.position();
    let waypoints = loop {
        let way = Segment::new(place(), place());
        let steps = (way.length() / 0.1).ceil() as u32;
        let is_free = (0..=steps).all(|i| {
            let at = way.a + way.vector() * (f64::from(i) / f64::from(steps.max(1)));
            caster.clearance(at, 1.0) > ROOM
        });
        if way.length() > 2.0 && is_free && way.distance(start) > START_ROOM {
            break vec![way.a, way.b];
        }
    };
    Mover {
        waypoints,
        closed: true,
        speed: rng.random_range(0.5..1.0),
        radius: 0.2,
        pause: rng.random_range(0.0..3.0),
    }
}
