//! `planners`: every planner on the same random queries in every built-in world; progress goes to
//! standard error.
//!
//! 1. The robot is the disc of the world's robot plus 2 cm; walls are those of the world, exact.
//!    1000 queries in each world (or as many as `--queries` says): start and goal anywhere that is
//!    free. Whether a query can be solved at all is decided by the visibility graph, and
//!    independently by a flood fill: where the two differ, the report says so. Among the 50 000
//!    walls of `campus` one graph takes minutes: there, as many queries are asked as fit in
//!    `ASKING` seconds, and those that take longer than `OPTIMUM` seconds are `undecided` and
//!    skipped.
//! 2. RRT, RRT-Connect (both shortened by chords, as in driving, and pulled tight), A* and Theta*
//!    over 5 cm cells, on the first part of the queries; RRT* and Informed RRT* for one second of
//!    processor time each on some. Success on the solvable queries, length against the visibility
//!    graph, time.
//! 3. Every path is checked leg by leg against every wall, at sampled points, with the distance
//!    formula written out here.
//! 4. Queries that cannot be solved, because the goal is walled in: every planner has to say so
//!    within its iterations (the graph not in `campus`).
//!
//! With `--peers FILE` (lines of the peers' programs and of the example `workloads`, from one
//! machine and hour) it does none of this, but compares the planners with the peers' on the peers'
//! queries (`planners/against_peers.rs`).

mod against_peers;
mod runs;
mod scene;
mod unsolvable;

use anyhow::Result;
use serde_json::Value;
use slamlab_core::sim::worlds;

use super::{Args, Outcome};
use crate::clock::cpu_seconds;
use crate::peers::Peers;
use crate::statistics::{median, quantile};
use runs::{CONTENDERS, run};
use scene::{Asked, Scene};
use unsolvable::unsolvable;

const QUERIES: usize = 1000;
/// The slow planners (over cells, or with one second each) get one in this many queries.
const SLOW: usize = 40;

pub(crate) fn measure(args: &Args) -> Result<Outcome> {
    let mut outcome = Outcome::default();
    if let Some(file) = &args.peers {
        against_peers::compare(&mut outcome, &Peers::read(file)?)?;
        return Ok(outcome);
    }
    let count = args.queries.unwrap_or(QUERIES);
    let mut lengths = Worst::default();
    let mut totals = Totals::default();
    for name in args.worlds(worlds::NAMES)? {
        let scene = Scene::of(name)?;
        let mut say = Progressed {
            world: name,
            since: cpu_seconds(),
        };
        let asked = Asked::draw(&scene, count);
        say.done("optima", asked.queries.len());
        let mut figures = serde_json::Map::new();
        figures.insert("walls".into(), scene.space.segments().len().into());
        figures.insert("asked".into(), asked.times.len().into());
        figures.insert("solvable".into(), asked.optima.len().into());
        figures.insert("undecided".into(), asked.undecided.into());
        figures.insert("visibility_ms_median".into(), median(&asked.times).into());
        totals.disagreements += asked.disagreements;
        for (label, contender) in CONTENDERS {
            let found = run(&scene, &asked, *contender);
            say.done(label, found.asked);
            match *label {
                "informed_rrt_star_1s" => {
                    lengths.informed_median.push(median(&found.excess));
                    lengths.informed_p90.push(quantile(&found.excess, 0.9));
                }
                "rrt_shortened" => lengths.shortened_median.push(median(&found.excess)),
                _ => {}
            }
            totals.collisions += found.collisions;
            totals.unsolved += found.asked - found.excess.len();
            figures.insert((*label).into(), found.to_json());
        }
        let unsaid = unsolvable(&scene, &asked, count.min(100));
        say.done("unsolvable", unsaid.asked);
        figures.insert("unsolvable".into(), unsaid.to_json());
        totals.unsaid += unsaid.unsaid;
        outcome.figure(name, Value::Object(figures));
    }
    totals.require(&mut outcome);
    lengths.require(&mut outcome);
    Ok(outcome)
}

/// Reports on standard error what was measured, and the processor time that it took.
struct Progressed {
    world: &'static str,
    since: f64,
}

impl Progressed {
    fn done(&mut self, what: &str, queries: usize) {
        let now = cpu_seconds();
        let took = now - std::mem::replace(&mut self.since, now);
        eprintln!("{}: {what}, {queries} queries, {took:.1} s", self.world);
    }
}

/// Lengths over the optimum, one per world: the claim must hold in the worst of them.
#[derive(Default)]
struct Worst {
    informed_median: Vec<f64>,
    informed_p90: Vec<f64>,
    shortened_median: Vec<f64>,
}

impl Worst {
    fn require(&self, outcome: &mut Outcome) {
        for (planner, part, lengths, most) in [
            ("informed_1s", "median", &self.informed_median, 1.02),
            ("informed_1s", "p90", &self.informed_p90, 1.02),
            ("rrt_shortened", "median", &self.shortened_median, 1.05),
        ] {
            let key = format!("{planner}_length_over_optimum_{part}_in_worst_world");
            outcome.at_most(&key, quantile(lengths, 1.0), most);
        }
    }
}

/// What must not happen in any world.
#[derive(Default)]
struct Totals {
    collisions: usize,
    unsolved: usize,
    disagreements: usize,
    unsaid: usize,
}

impl Totals {
    fn require(&self, outcome: &mut Outcome) {
        for (key, count) in [
            ("paths_that_collide", self.collisions),
            ("solvable_queries_without_path", self.unsolved),
            ("disagreements_of_graph_and_flood", self.disagreements),
            ("unsolvable_queries_not_said_so", self.unsaid),
        ] {
            outcome.at_most(key, count as f64, 0.0);
        }
    }
}
