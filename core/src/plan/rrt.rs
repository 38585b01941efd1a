//! Rapidly exploring random tree, one tree as in the source.
//!
//! In: a configuration space, start and goal, a seeded generator, iteration by iteration. Out: a path or none yet, and the
//! tree to be drawn.
//!
//! An iteration (TDK 2016 §5.2):
//! 1. Draw a random point; with probability `goal_bias` take the goal instead.
//! 2. Find the nearest point of the tree, on vertices and on edges; an edge is split there.
//! 3. Extend towards the drawn point to the last collision-free one.
//! 4. When the goal is reached, the branch to it is the path.
//!
//! Ours: after a thousand points in vain they are drawn only where anything can be reached at all.

use nalgebra::Point2;
use rand::{Rng, RngExt};

use super::cspace::ConfigSpace;
use super::path::Path;
use super::query::Query;
use super::sampler::Sampler;
use super::tree::Tree;
use crate::geom::Segment;

/// How trees grow.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RrtConfig {
    /// Probability that the goal is drawn. Default 0.1, the source's 10 %; larger is straighter in the open and sticks
    /// at walls. Used by the single tree.
    pub goal_bias: f64,
    /// Most points to draw. Default 3000.
    pub max_iterations: usize,
    /// Growth shorter than this is dropped, m. Default 0.02: trees do not swarm along walls.
    pub min_growth: f64,
    /// Longest leg of all trees but the source's, which goes on to the last collision-free point, m. Default 5. Shorter:
    /// more vertices, shorter and slower first paths.
    pub range: f64,
    /// Radius in which RRT* looks for better parents, in units of the least that converges (Karaman & Frazzoli 2011,
    /// theorem 38). Default 1; larger is shorter in fewer, slower iterations.
    pub rewire_factor: f64,
    /// Whether RRT* gets its first path from RRT-Connect, shortened, which finds one many times sooner. Default true; false
    /// is RRT* as published.
    pub is_seeded: bool,
}

impl Default for RrtConfig {
    fn default() -> Self {
        Self {
            goal_bias: 0.1,
            max_iterations: 3000,
            min_growth: 0.02,
            range: 5.0,
            rewire_factor: 1.0,
            is_seeded: true,
        }
    }
}

/// One tree that grows from the start.
#[derive(Clone, Debug)]
pub struct Rrt {
    query: Query,
    config: RrtConfig,
    sampler: Sampler,
    drawn: usize,
    tree: Tree,
    path: Option<Path>,
}

impl Rrt {
    /// A tree of the start alone; both ends of the query must be free.
    #[must_use]
    pub fn new<S: ConfigSpace + ?Sized>(
        space: &S,
        query: Query,
        config: RrtConfig,
        sampler: Sampler,
    ) -> Self {
        Self {
            tree: Tree::new(query.start, space.bounds()),
            query,
            config,
            sampler,
            drawn: 0,
            path: None,
        }
    }

    /// Steps 1 to 4, once.
    pub fn iterate<S: ConfigSpace + ?Sized, R: Rng>(&mut self, space: &S, rng: &mut R) {
        let goal = self.query.goal;
        let target = if rng.random::<f64>() < self.config.goal_bias {
            goal
        } else {
            self.draw(space, rng)
        };
        let grown = self.tree.extend(space, target, self.config.min_growth);
        if let Some(vertex) = grown
            && vertex.arrived
            && target == goal
        {
            self.path = Some(Path {
                points: self.tree.branch(vertex.index),
            });
        }
    }

    fn draw<S: ConfigSpace + ?Sized, R: Rng>(&mut self, space: &S, rng: &mut R) -> Point2<f64> {
        self.drawn += 1;
        self.sampler.narrow(self.drawn, space, self.query.start);
        self.sampler.draw(rng)
    }

    /// The path, if the goal was reached.
    #[must_use]
    pub fn path(&self) -> Option<&Path> {
        self.path.as_ref()
    }

    /// The legs of the tree.
    #[must_use]
    pub fn edges(&self) -> Vec<Segment> {
        self.tree.edges().collect()
    }
}
