//! Two trees that grow towards each other.
//!
//! In: a configuration space, start and goal, a seeded generator, iteration by iteration. Out: a
//! path, or none yet, and the trees for display.
//!
//! An iteration:
//! 1. One tree grows a step towards a random point, from the vertex nearest to it; the first time,
//!    towards the other root.
//! 2. The other tree grows towards the new vertex, as many steps as are free. If it arrives, the
//!    two branches form the path.
//! 3. The trees swap roles.
//!
//! It needs far fewer iterations than one tree when the last metres lead through a door. After some
//! thousand unsuccessful points the tree from the start follows a way over free discs
//! ([`super::guide`]); that is ours.
//!
//! Source: Kuffner & LaValle (2000), "RRT-Connect: an efficient approach to single-query path
//! planning".

use rand::Rng;

use super::cspace::ConfigSpace;
use super::path::Path;
use super::query::Query;
use super::rrt::RrtConfig;
use super::sampler::{Draws, Sampler};
use super::search::Planning;
use super::tree::Grown;
use super::vertex_tree::VertexTree;
use crate::geom::Segment;

/// Two trees, from the start and from the goal.
#[derive(Debug)]
pub(super) struct RrtConnect {
    query: Query,
    config: RrtConfig,
    draws: Draws,
    growing: VertexTree,
    other: VertexTree,
    /// Whether `growing` is the tree from the start.
    from_start: bool,
    is_first: bool,
    path: Option<Path>,
}

impl RrtConnect {
    /// Two trees of only a root; both ends of the query must be free.
    pub(super) fn new(
        space: &dyn ConfigSpace,
        query: Query,
        config: RrtConfig,
        sampler: Sampler,
    ) -> Self {
        Self {
            growing: VertexTree::new(query.start, space.bounds()),
            other: VertexTree::new(query.goal, space.bounds()),
            from_start: true,
            is_first: true,
            query,
            config,
            draws: Draws::new(sampler),
            path: None,
        }
    }

    fn join(&mut self, grown: usize, met: usize) {
        let mut points = self.growing.branch(grown);
        points.extend(self.other.branch(met).into_iter().rev().skip(1));
        if !self.from_start {
            points.reverse();
        }
        self.path = Some(Path { points });
    }

    /// Step 1.
    fn grow(&mut self, space: &dyn ConfigSpace, rng: &mut dyn Rng) -> Option<Grown> {
        let step = self.config.range;
        let guided = self.from_start.then(|| self.draws.guided(rng)).flatten();
        if let Some(guided) = guided {
            let (from, target) = (guided.from, guided.target);
            let grown = self.growing.connect_from(from, space, target, step);
            let arrived = grown.filter(|vertex| vertex.arrived);
            self.draws.take(arrived.map(|vertex| vertex.index));
            return grown;
        }
        let target = if std::mem::take(&mut self.is_first) {
            self.query.goal
        } else {
            self.draws.draw(space, &self.query, rng)
        };
        self.growing.extend(space, target, step)
    }
}

impl Planning for RrtConnect {
    /// Does steps 1 to 3 once.
    fn iterate(&mut self, space: &dyn ConfigSpace, rng: &mut dyn Rng) -> bool {
        let step = self.config.range;
        if let Some(grown) = self.grow(space, rng) {
            let point = self.growing.point(grown.index);
            let joined = self.other.connect(space, point, step);
            if let Some(met) = joined.filter(|v| v.arrived) {
                self.join(grown.index, met.index);
                return false;
            }
        }
        std::mem::swap(&mut self.growing, &mut self.other);
        self.from_start = !self.from_start;
        true
    }

    fn is_found(&self) -> bool {
        self.path.is_some()
    }

    fn path(&self) -> Option<Path> {
        self.path.clone()
    }

    fn edges(&self) -> Vec<Segment> {
        self.growing.edges().chain(self.other.edges()).collect()
    }

    fn edge_count(&self) -> usize {
        self.growing.edge_count() + self.other.edge_count()
    }
}
