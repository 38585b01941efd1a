//! `planners`: every planner on the same random queries in every built-in world; where it is goes to standard error.
//!
//! 1. The robot is a disc of the world's robot and 2 cm; walls are those of the world, exact. 1000 queries in each world (or
//!    as many as `--queries` says): start and goal anywhere that is free. Whether a query can be solved at all is told by the
//!    visibility graph, and by a flood that knows nothing of it: where the two differ, the report says so. Among the 50 000 walls of
//!    `campus` one graph takes minutes: there, as many queries as [`ASKING`] seconds hold, and those that take longer than
//!    [`OPTIMUM`] seconds are `undecided` and left out.
//! 2. RRT, RRT-Connect (both shortened by chords as well, and pulled tight), A* and Theta* over 5 cm cells, on the first
//!    part of the queries; RRT* and Informed RRT* for one second of processor time each on some. Success of the solvable, length against the
//!    visibility graph, time.
//! 3. Every path is checked leg by leg against every wall, by sampled points with the distance formula written out here.
//! 4. Queries that cannot be solved, made by walling the goal in: every planner has to say so within its iterations (the graph not in
//!    `campus`).
//!
//! With `--peers FILE` (lines of the peers' programs and of the example `workloads`, from one machine and hour) it does none of this, but
//! compares the planners with the peers' on the peers' queries (`planners/against_peers.rs`).

mod against_peers;

use anyhow::{Context, Result, bail};
use nalgebra::{Point2, Vector2};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use serde_json::{Value, json};
use slamlab_core::geom::Segment;
use slamlab_core::plan::{
    ConfigSpace, NoPath, Path, Planner, Progress, Query, RrtConfig, Sampler, Search, SegmentSpace,
    pull_tight, shorten, solve,
};
use slamlab_core::sim::worlds;

use super::{Args, Outcome};
use crate::clock::cpu_seconds;
use crate::peers::Peers;

const QUERIES: usize = 1000;
const MARGIN: f64 = 0.02;
/// Processor time for the optima of a world, s.
const ASKING: f64 = 300.0;
/// Processor time for one optimum, s.
const OPTIMUM: f64 = 10.0;
/// Processor time of RRT* and Informed RRT*, s.
const SECOND: f64 = 1.0;
/// Iterations of the planners that stop at their first path.
const ITERATIONS: usize = 20_000;
/// One in so many queries is for the slow ones: cells, and those that take a second.
const SLOW: usize = 40;
/// In a world of more walls the visibility graph is not asked to prove anything.
const MANY_WALLS: usize = 5_000;
/// Distance between the points at which a path is checked, m.
const SPACING: f64 = 0.005;

/// Planner, and how paths are made shorter afterwards.
#[derive(Clone, Copy, PartialEq)]
enum Contender {
    Once(Planner),
    Shortened(Planner),
    Tight(Planner),
    Timed(Planner),
}
use Contender::{Once, Shortened, Tight, Timed};

const CONTENDERS: &[(&str, Contender)] = &[
    ("rrt", Once(Planner::Rrt)),
    ("rrt_shortened", Shortened(Planner::Rrt)),
    ("rrt_tight", Tight(Planner::Rrt)),
    ("rrt_connect", Once(Planner::RrtConnect)),
    ("rrt_connect_shortened", Shortened(Planner::RrtConnect)),
    ("rrt_connect_tight", Tight(Planner::RrtConnect)),
    ("a_star", Once(Planner::AStar)),
    ("theta_star", Once(Planner::ThetaStar)),
    ("rrt_star_1s", Timed(Planner::RrtStar)),
    ("informed_rrt_star_1s", Timed(Planner::InformedRrtStar)),
];

pub(crate) fn measure(args: &Args) -> Result<Outcome> {
    let mut outcome = Outcome::default();
    if let Some(file) = &args.peers {
        against_peers::compare(&mut outcome, &Peers::read(file)?)?;
        return Ok(outcome);
    }
    let count = args.queries.unwrap_or(QUERIES);
    if let Some(name) = args
        .worlds
        .iter()
        .find(|name| worlds::builtin(name).is_none())
    {
        bail!(
            "there is no world `{name}`; there are {}",
            worlds::NAMES.join(", ")
        );
    }
    let (mut informed, mut shortened) = (vec![], vec![]);
    let mut totals = Totals::default();
    let wanted = |name: &&str| args.worlds.is_empty() || args.worlds.iter().any(|w| w == name);
    for name in worlds::NAMES.into_iter().filter(wanted) {
        let scene = Scene::of(name)?;
        let began = cpu_seconds();
        let asked = Asked::draw(&scene, count);
        let mut say = Progressed::new(name, began);
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
                "informed_rrt_star_1s" => informed.extend(found.excess.iter().copied()),
                "rrt_shortened" => shortened.extend(found.excess.iter().copied()),
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
    outcome.at_most(
        "informed_1s_length_over_optimum_median",
        median(&informed),
        1.02,
    );
    outcome.at_most(
        "informed_1s_length_over_optimum_p90",
        quantile(&informed, 0.9),
        1.02,
    );
    outcome.at_most(
        "rrt_shortened_length_over_optimum_median",
        median(&shortened),
        1.05,
    );
    Ok(outcome)
}

/// Tells on standard error what was measured, and the processor time that it took.
struct Progressed {
    world: &'static str,
    since: f64,
}

impl Progressed {
    fn new(world: &'static str, since: f64) -> Self {
        Self { world, since }
    }

    fn done(&mut self, what: &str, queries: usize) {
        let now = cpu_seconds();
        let took = now - std::mem::replace(&mut self.since, now);
        eprintln!("{}: {what}, {queries} queries, {took:.1} s", self.world);
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
        outcome.at_most("paths_that_collide", self.collisions as f64, 0.0);
        outcome.at_most("solvable_queries_without_path", self.unsolved as f64, 0.0);
        outcome.at_most(
            "disagreements_of_graph_and_flood",
            self.disagreements as f64,
            0.0,
        );
        outcome.at_most("unsolvable_queries_not_said_so", self.unsaid as f64, 0.0);
    }
}

struct Scene {
    space: SegmentSpace,
}

impl Scene {
    fn of(name: &str) -> Result<Self> {
        let world = worlds::builtin(name).with_context(|| format!("there is no world `{name}`"))?;
        let keep = world.robot.model().radius() + MARGIN;
        let walls = world.walls().into_iter().map(|w| w.segment).collect();
        Ok(Self {
            space: SegmentSpace::new(walls, keep, world.bounds())?,
        })
    }

    fn free_place(&self, rng: &mut ChaCha8Rng) -> Point2<f64> {
        let sampler = Sampler::anywhere(&self.space);
        loop {
            let place = sampler.draw(rng);
            if self.space.is_free(place) {
                return place;
            }
        }
    }
}

/// Queries that can be solved, and the shortest ways.
#[derive(Default)]
struct Asked {
    queries: Vec<Query>,
    optima: Vec<f64>,
    /// Of the visibility graph, ms.
    times: Vec<f64>,
    undecided: usize,
    disagreements: usize,
}

impl Asked {
    fn draw(scene: &Scene, count: usize) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(11);
        let mut asked = Self::default();
        let until = cpu_seconds() + ASKING;
        for number in 0..count {
            let query = Query {
                start: scene.free_place(&mut rng),
                goal: scene.free_place(&mut rng),
            };
            let begin = cpu_seconds();
            if begin > until {
                break;
            }
            let answer = optimum(scene, query, &mut rng);
            asked.times.push(1e3 * (cpu_seconds() - begin));
            let Some(path) = answer else {
                asked.undecided += 1;
                continue;
            };
            // The flood proves less: it may leave open what the graph shuts, never the other way round.
            let is_shut = number % SLOW == 0 && scene.space.are_apart(query.start, query.goal);
            if let Some(path) = path {
                asked.disagreements += usize::from(is_shut);
                asked.queries.push(query);
                asked.optima.push(path.length());
            }
        }
        asked
    }
}

/// The shortest path, if there is one; `None` where the graph took too long to tell.
#[allow(clippy::option_option, reason = "not known is another thing than none")]
fn optimum(scene: &Scene, query: Query, rng: &mut ChaCha8Rng) -> Option<Option<Path>> {
    let space = &scene.space;
    let sampler = || Sampler::anywhere(space);
    let config = RrtConfig::default();
    let Ok(mut search) = Search::new(Planner::Visibility, space, query, config, sampler) else {
        return Some(None);
    };
    let begin = cpu_seconds();
    while cpu_seconds() - begin < OPTIMUM {
        match search.step(space, rng, 1) {
            Progress::Finished => return Some(search.path()),
            Progress::Failed(_) => return Some(None),
            _ => {}
        }
    }
    None
}

/// What a planner did in a world.
#[derive(Default)]
struct Found {
    asked: usize,
    times: Vec<f64>,
    excess: Vec<f64>,
    collisions: usize,
    /// Solvable queries without a path: start and goal.
    unsolved: Vec<Query>,
}

impl Found {
    fn to_json(&self) -> Value {
        json!({
            "queries": self.asked,
            "solved": self.excess.len(),
            "length_over_optimum_median": median(&self.excess),
            "length_over_optimum_p95": quantile(&self.excess, 0.95),
            "ms_median": median(&self.times),
            "ms_p95": quantile(&self.times, 0.95),
            "unsolved": self.unsolved.iter().map(|q| [q.start.x, q.start.y, q.goal.x, q.goal.y]).collect::<Vec<_>>(),
        })
    }
}

fn run(scene: &Scene, asked: &Asked, contender: Contender) -> Found {
    let mut found = Found::default();
    let is_slow = matches!(
        contender,
        Timed(_) | Once(Planner::AStar) | Once(Planner::ThetaStar)
    );
    let every = if is_slow { SLOW } else { 1 };
    let numbered = asked.queries.iter().zip(&asked.optima).enumerate();
    for (number, (query, optimum)) in numbered.step_by(every) {
        let mut rng = ChaCha8Rng::seed_from_u64(number as u64);
        let begin = cpu_seconds();
        let path = find(scene, *query, contender, &mut rng);
        found.asked += 1;
        found.times.push(1e3 * (cpu_seconds() - begin));
        if let Some(path) = path {
            found.excess.push(path.length() / optimum.max(1e-9));
            found.collisions += usize::from(collides(&path, query, scene));
        } else {
            found.unsolved.push(*query);
        }
    }
    found
}

fn find(scene: &Scene, query: Query, contender: Contender, rng: &mut ChaCha8Rng) -> Option<Path> {
    let space = &scene.space;
    let (Once(planner) | Shortened(planner) | Tight(planner) | Timed(planner)) = contender;
    let sampler = || Sampler::anywhere(space);
    let mut search = Search::new(planner, space, query, RrtConfig::default(), sampler).ok()?;
    let begin = cpu_seconds();
    loop {
        let progress = search.step(space, rng, 100);
        let is_spent = match contender {
            Timed(_) => cpu_seconds() - begin >= SECOND,
            Once(Planner::AStar | Planner::ThetaStar) => false,
            _ => search.iterations() >= ITERATIONS,
        };
        if is_spent || matches!(progress, Progress::Finished | Progress::Failed(_)) {
            break;
        }
    }
    let path = search.path()?;
    Some(match contender {
        Once(_) | Timed(_) => path,
        Shortened(_) => shorten(&path, space),
        Tight(_) => pull_tight(&shorten(&path, space), space),
    })
}

/// Whether a path misses its ends, or a point of it comes nearer to a wall than it may. Walls farther from a leg than it is
/// long need no look.
fn collides(path: &Path, query: &Query, scene: &Scene) -> bool {
    let keep = scene.space.keep() - 1e-9;
    let ends = path.points.first().zip(path.points.last());
    if ends != Some((&query.start, &query.goal)) {
        return true;
    }
    path.legs().any(|leg| {
        let middle = Point2::from(0.5 * (leg.a.coords + leg.b.coords));
        let reach = 0.5 * leg.length() + keep;
        let walls = scene.space.segments().iter();
        let near: Vec<_> = walls.filter(|w| distance(w, middle) <= reach).collect();
        let pieces = (leg.length() / SPACING).ceil().max(1.0) as usize;
        (0..=pieces).any(|i| {
            let at = leg.a + leg.vector() * (i as f64 / pieces as f64);
            near.iter().any(|wall| distance(wall, at) < keep)
        })
    })
}

/// Distance of a point from a wall, written out once more.
fn distance(wall: &Segment, at: Point2<f64>) -> f64 {
    let (along, from) = (wall.b - wall.a, at - wall.a);
    let squared = along.x * along.x + along.y * along.y;
    let part = if squared > 0.0 {
        ((from.x * along.x + from.y * along.y) / squared).clamp(0.0, 1.0)
    } else {
        0.0
    };
    let (dx, dy) = (from.x - part * along.x, from.y - part * along.y);
    (dx * dx + dy * dy).sqrt()
}

/// Queries without a path.
#[derive(Default)]
struct Unsolvable {
    asked: usize,
    unsaid: usize,
    times: Vec<f64>,
}

impl Unsolvable {
    fn to_json(&self) -> Value {
        json!({
            "asked": self.asked,
            "not_said_so": self.unsaid,
            "ms_median": median(&self.times),
            "ms_p95": quantile(&self.times, 0.95),
        })
    }
}

/// Walls the goal in with a square, and asks every planner in turn; the iterations are those of a robot that has to answer.
fn unsolvable(scene: &Scene, asked: &Asked, count: usize) -> Unsolvable {
    const PLANNERS: [Planner; 4] = [
        Planner::RrtConnect,
        Planner::Rrt,
        Planner::InformedRrtStar,
        Planner::Visibility,
    ];
    let mut said = Unsolvable::default();
    let config = RrtConfig {
        max_iterations: 3000,
        ..RrtConfig::default()
    };
    let mut rng = ChaCha8Rng::seed_from_u64(12);
    let half = 3.0 * scene.space.keep();
    let far = |q: &&Query| {
        let off = (q.start - q.goal).abs();
        off.max() > half + scene.space.keep()
    };
    for (number, query) in asked.queries.iter().filter(far).take(count).enumerate() {
        let mut walls = scene.space.segments().to_vec();
        let corner = |x: f64, y: f64| query.goal + Vector2::new(x, y) * half;
        let corners = [
            corner(-1.0, -1.0),
            corner(1.0, -1.0),
            corner(1.0, 1.0),
            corner(-1.0, 1.0),
        ];
        walls.extend((0..4).map(|i| Segment::new(corners[i], corners[(i + 1) % 4])));
        let bounds = scene.space.bounds();
        let Ok(space) = SegmentSpace::new(walls, scene.space.keep(), bounds) else {
            continue;
        };
        if !space.is_free(query.start) {
            continue;
        }
        // To look at every leg among tens of thousands of walls takes the graph hours.
        let n_planners = PLANNERS.len() - usize::from(scene.space.segments().len() > MANY_WALLS);
        let planner = PLANNERS[number % n_planners];
        let mut config = config;
        if planner == Planner::Visibility {
            config.max_iterations = usize::MAX;
        }
        let begin = cpu_seconds();
        let answer = solve(planner, &space, *query, &config, &mut rng);
        said.times.push(1e3 * (cpu_seconds() - begin));
        said.asked += 1;
        said.unsaid += usize::from(!matches!(answer.path, Err(NoPath::Unreachable { .. })));
    }
    said
}

fn median(values: &[f64]) -> f64 {
    quantile(values, 0.5)
}

/// NaN of none.
fn quantile(values: &[f64], part: f64) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let at = (part * sorted.len() as f64) as usize;
    let last = sorted.len().saturating_sub(1);
    sorted.get(at.min(last)).copied().unwrap_or(f64::NAN)
}
