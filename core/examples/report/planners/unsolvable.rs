//! Queries that cannot be solved, and which planners say so.

use nalgebra::Vector2;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use serde_json::{Value, json};
use slamlab_core::plan::{
    ConfigSpace, NoPath, Planner, Progress, Query, RrtConfig, Sampler, Search, SegmentSpace,
};

use super::scene::{Asked, Scene};
use crate::clock::cpu_seconds;
use crate::scenes::{SQUARE, sides};
use crate::statistics::{median, quantile};

/// In a world with more walls the visibility graph is not asked for a proof.
const MANY_WALLS: usize = 5_000;

/// Iterations of the planners that draw samples.
const ITERATIONS: usize = 3000;

/// Queries without a path.
#[derive(Default)]
pub(super) struct Unsolvable {
    pub(super) asked: usize,
    pub(super) unsaid: usize,
    times: Vec<f64>,
}

impl Unsolvable {
    pub(super) fn to_json(&self) -> Value {
        json!({
            "asked": self.asked,
            "not_said_so": self.unsaid,
            "ms_median": median(&self.times),
            "ms_p95": quantile(&self.times, 0.95),
        })
    }
}

/// Walls the goal in with a square, and asks every planner in turn, with the iterations that a
/// robot allows before it needs an answer.
pub(super) fn unsolvable(scene: &Scene, asked: &Asked, count: usize) -> Unsolvable {
    const PLANNERS: [Planner; 4] = [
        Planner::RrtConnect,
        Planner::Rrt,
        Planner::InformedRrtStar,
        Planner::Visibility,
    ];
    let mut said = Unsolvable::default();
    let mut rng = ChaCha8Rng::seed_from_u64(12);
    let half = 3.0 * scene.space.keep();
    let far = |q: &&Query| (q.start - q.goal).abs().max() > half + scene.space.keep();
    for (number, query) in asked.queries.iter().filter(far).take(count).enumerate() {
        let mut walls = scene.space.segments().to_vec();
        let corner = |(x, y)| query.goal + Vector2::new(x, y) * half;
        walls.extend(sides(&SQUARE.map(corner)));
        let bounds = scene.space.bounds();
        let Ok(space) = SegmentSpace::new(walls, scene.space.keep(), bounds) else {
            continue;
        };
        if !space.is_free(query.start) {
            continue;
        }
        // Among tens of thousands of walls the graph would take hours to check every leg.
        let n_planners = PLANNERS.len() - usize::from(scene.space.segments().len() > MANY_WALLS);
        let planner = PLANNERS[number % n_planners];
        let most = match planner {
            Planner::Visibility => usize::MAX,
            _ => ITERATIONS,
        };
        let begin = cpu_seconds();
        let is_said = says_unreachable(planner, &space, *query, most, &mut rng);
        said.times.push(1e3 * (cpu_seconds() - begin));
        said.asked += 1;
        said.unsaid += usize::from(!is_said);
    }
    said
}

/// Whether a planner that finds no path, or the space after it, proves that there is none.
fn says_unreachable(
    planner: Planner,
    space: &SegmentSpace,
    query: Query,
    iterations: usize,
    rng: &mut ChaCha8Rng,
) -> bool {
    let sampler = || Sampler::anywhere(space);
    let config = RrtConfig::default();
    let Ok(mut search) = Search::new(planner, space, query, config, sampler) else {
        return false;
    };
    let progress = search.step(space, rng, iterations);
    search.path().is_none()
        && (matches!(progress, Progress::Failed(NoPath::Unreachable { .. }))
            || space.are_apart(query.start, query.goal))
}
