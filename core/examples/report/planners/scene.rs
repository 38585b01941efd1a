//! Worlds, and random queries in them with their shortest paths.

use anyhow::Result;
use nalgebra::Point2;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use slamlab_core::plan::{
    ConfigSpace, Path, Planner, Progress, Query, RrtConfig, Sampler, Search, SegmentSpace,
};

use super::SLOW;
use crate::clock::cpu_seconds;
use crate::ride::world_named;

const MARGIN: f64 = 0.02;
/// Processor time for all optimal paths of a world, s.
const ASKING: f64 = 300.0;
/// Processor time for one optimal path, s.
const OPTIMUM: f64 = 10.0;

pub(super) struct Scene {
    pub(super) space: SegmentSpace,
}

impl Scene {
    pub(super) fn of(name: &str) -> Result<Self> {
        let world = world_named(name)?;
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

/// Queries that can be solved, and their shortest paths.
#[derive(Default)]
pub(super) struct Asked {
    pub(super) queries: Vec<Query>,
    pub(super) optima: Vec<f64>,
    /// Times of the visibility graph, ms.
    pub(super) times: Vec<f64>,
    pub(super) undecided: usize,
    pub(super) disagreements: usize,
}

impl Asked {
    pub(super) fn draw(scene: &Scene, count: usize) -> Self {
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
            // The flood fill proves less: it may leave open what the graph closes, never the other
            // way round.
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

/// The shortest path, if there is one; `None` if the graph took too long to tell.
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
