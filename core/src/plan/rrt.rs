//! Rapidly exploring random tree, one tree as in the paper.
//!
//! In: a configuration space, start and goal, a seeded generator, iteration by iteration. Out: a
//! path, or none yet, and the tree for display.
//!
//! An iteration (TDK 2016 §5.2):
//! 1. Draw a random point; with probability `goal_bias` take the goal instead.
//! 2. Find the nearest point of the tree, on vertices and on edges; an edge is split there.
//! 3. Extend towards the drawn point to the last collision-free one.
//! 4. When the goal is reached, the branch to it is the path.
//!
//! Ours: after some thousand unsuccessful points, every second one is drawn along a way over free
//! discs ([`super::guide`]).

use rand::{Rng, RngExt};

use super::cspace::ConfigSpace;
use super::path::Path;
use super::query::Query;
use super::sampler::{Draws, Sampler};
use super::search::Planning;
use super::tree::Tree;
use crate::bounds::config;
use crate::geom::Segment;

config! {
    /// How trees grow.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct RrtConfig {
        /// Probability that the goal is drawn. Default 0.1, the paper's 10 %; larger is straighter
        /// in the open and sticks at walls. Used by the single tree.
        pub goal_bias: f64 = 0.1,
        /// Most points to draw. Default 3000.
        pub max_iterations: usize = 3000,
        /// Longest leg of all trees but the paper's, which goes on to the last collision-free
        /// point, m. Default 5. Shorter: more vertices, shorter and slower first paths.
        pub range: f64 = 5.0,
        /// Radius in which RRT* looks for better parents, in units of the least that converges
        /// (Karaman & Frazzoli 2011, theorem 38). Default 1; larger is shorter in fewer, slower
        /// iterations.
        pub rewire_factor: f64 = 1.0,
        /// Whether RRT* gets its first path from RRT-Connect, shortened, which finds one many times
        /// sooner. Default true; false is RRT* as published.
        pub is_seeded: bool = true,
    }
}

/// One tree that grows from the start.
#[derive(Debug)]
pub(super) struct Rrt {
    query: Query,
    config: RrtConfig,
    draws: Draws,
    is_guided: bool,
    tree: Tree,
    path: Option<Path>,
}

impl Rrt {
    /// A tree of only the start; both ends of the query must be free.
    pub(super) fn new(
        space: &dyn ConfigSpace,
        query: Query,
        config: RrtConfig,
        sampler: Sampler,
    ) -> Self {
        Self {
            tree: Tree::new(query.start, space.bounds()),
            query,
            config,
            draws: Draws::new(sampler),
            is_guided: false,
            path: None,
        }
    }

    /// Grows along the guide instead, every second time; `false` if there is nothing to follow.
    fn follow_guide(&mut self, space: &dyn ConfigSpace, rng: &mut dyn Rng) -> bool {
        self.is_guided = !self.is_guided;
        let guided = self.is_guided.then(|| self.draws.guided(rng)).flatten();
        let Some(guided) = guided else {
            return false;
        };
        let grown = self.tree.reach(space, guided.from, guided.target);
        self.draws.take(grown);
        if let Some(vertex) = grown.filter(|_| guided.target == self.query.goal) {
            self.finish(vertex);
        }
        true
    }

    fn finish(&mut self, vertex: usize) {
        self.path = Some(Path {
            points: self.tree.branch(vertex),
        });
    }
}

impl Planning for Rrt {
    /// Does steps 1 to 4 once.
    fn iterate(&mut self, space: &dyn ConfigSpace, rng: &mut dyn Rng) -> bool {
        let goal = self.query.goal;
        if self.follow_guide(space, rng) {
            return self.path.is_none();
        }
        let target = if rng.random::<f64>() < self.config.goal_bias {
            goal
        } else {
            self.draws.draw(space, &self.query, rng)
        };
        let grown = self.tree.extend(space, target);
        if let Some(vertex) = grown.filter(|vertex| vertex.arrived && target == goal) {
            self.finish(vertex.index);
        }
        self.path.is_none()
    }

    fn is_found(&self) -> bool {
        self.path.is_some()
    }

    fn path(&self) -> Option<Path> {
        self.path.clone()
    }

    fn edges(&self) -> Vec<Segment> {
        self.tree.edges().collect()
    }

    fn edge_count(&self) -> usize {
        self.tree.edge_count()
    }
}
