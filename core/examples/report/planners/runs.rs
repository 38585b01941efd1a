//! The results of each planner on the queries that can be solved, and an independent check of its
//! paths.

use nalgebra::Point2;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use serde_json::{Value, json};
use slamlab_core::geom::Segment;
use slamlab_core::plan::{Path, Planner, Progress, Query, RrtConfig, Sampler, Search, Shortening};

use super::SLOW;
use super::scene::{Asked, Scene};
use crate::clock::cpu_seconds;
use crate::statistics::{median, quantile};

/// Processor time of RRT* and Informed RRT*, s.
const SECOND: f64 = 1.0;
/// Iterations of the planners that stop at their first path.
const ITERATIONS: usize = 20_000;
/// Distance between the points at which a path is checked, m.
const SPACING: f64 = 0.005;

/// Planner, and how paths are made shorter afterwards.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Contender {
    Once(Planner),
    Shortened(Planner),
    Tight(Planner),
    Timed(Planner),
}
use Contender::{Once, Shortened, Tight, Timed};

impl Contender {
    fn is_over_cells(self) -> bool {
        matches!(
            self,
            Once(Planner::AStar | Planner::ThetaStar | Planner::Rooms)
        )
    }
}

pub(super) const CONTENDERS: &[(&str, Contender)] = &[
    ("rrt", Once(Planner::Rrt)),
    ("rrt_shortened", Shortened(Planner::Rrt)),
    ("rrt_tight", Tight(Planner::Rrt)),
    ("rrt_connect", Once(Planner::RrtConnect)),
    ("rrt_connect_shortened", Shortened(Planner::RrtConnect)),
    ("rrt_connect_tight", Tight(Planner::RrtConnect)),
    ("a_star", Once(Planner::AStar)),
    ("theta_star", Once(Planner::ThetaStar)),
    ("rooms", Once(Planner::Rooms)),
    ("rrt_star_1s", Timed(Planner::RrtStar)),
    ("informed_rrt_star_1s", Timed(Planner::InformedRrtStar)),
];

/// The results of a planner in a world.
#[derive(Default)]
pub(super) struct Found {
    pub(super) asked: usize,
    times: Vec<f64>,
    pub(super) excess: Vec<f64>,
    pub(super) collisions: usize,
    /// Solvable queries without a path: start and goal.
    unsolved: Vec<Query>,
}

impl Found {
    pub(super) fn to_json(&self) -> Value {
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

pub(super) fn run(scene: &Scene, asked: &Asked, contender: Contender) -> Found {
    let mut found = Found::default();
    let is_slow = matches!(contender, Timed(_)) || contender.is_over_cells();
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
            _ if contender.is_over_cells() => false,
            _ => search.iterations() >= ITERATIONS,
        };
        if is_spent || matches!(progress, Progress::Finished | Progress::Failed(_)) {
            break;
        }
    }
    let path = search.path()?;
    Some(match contender {
        Once(_) | Timed(_) => path,
        Shortened(_) => Shortening::Chords.apply(&path, space),
        Tight(_) => Shortening::Tight.apply(&path, space),
    })
}

/// Whether a path misses its ends, or a point of it comes too close to a wall. Walls farther from a
/// leg than it is long need not be checked.
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

/// Distance of a point from a wall, written out independently.
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
