//! Rapidly exploring random trees.
//!
//! In: a configuration space, start and goal, a budget, a seeded generator. Out: a path or none, the budget used, and
//! the trees to be drawn.
//!
//! One tree (TDK 2016 §5.2):
//! 1. Draw a random point; with probability `goal_bias` take the goal instead.
//! 2. Find the nearest point of the tree, on vertices and on edges; an edge is split there.
//! 3. Extend towards the drawn point to the last collision-free one.
//! 4. Stop when the goal is reached or the budget is spent.
//!
//! Two trees (Kuffner & LaValle 2000, "RRT-Connect"): one from either end; whenever one has grown, the other is
//! extended straight towards the new point, and they change places. It needs far fewer iterations where the last metres
//! lead through a door.

use nalgebra::Point2;
use rand::{Rng, RngExt};

use super::cspace::ConfigSpace;
use super::path::Path;
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
}

impl Default for RrtConfig {
    fn default() -> Self {
        Self {
            goal_bias: 0.1,
            max_iterations: 3000,
            min_growth: 0.02,
        }
    }
}

/// What came of growing.
#[derive(Clone, Debug)]
pub struct Growth {
    /// The path, if the goal was reached.
    pub path: Option<Path>,
    /// Points drawn.
    pub iterations: usize,
    /// Legs of all trees.
    pub tree: Vec<Segment>,
}

/// One tree from `start`, which must be free, as must be `goal`.
///
/// `draw` gives the random points, [`anywhere`] for the source's; one that knows where the free space is needs fewer.
pub fn rrt<S: ConfigSpace + ?Sized, R: Rng>(
    space: &S,
    start: Point2<f64>,
    goal: Point2<f64>,
    config: &RrtConfig,
    rng: &mut R,
    mut draw: impl FnMut(&mut R) -> Point2<f64>,
) -> Growth {
    let mut tree = Tree::new(start, space.bounds());
    for iteration in 1..=config.max_iterations {
        let target = if rng.random::<f64>() < config.goal_bias {
            goal
        } else {
            draw(rng)
        };
        let Some(vertex) = extend(&mut tree, space, target, config) else {
            continue;
        };
        if vertex.arrived && target == goal {
            return Growth {
                path: Some(Path {
                    points: tree.branch(vertex.index),
                }),
                iterations: iteration,
                tree: tree.edges().collect(),
            };
        }
    }
    Growth {
        path: None,
        iterations: config.max_iterations,
        tree: tree.edges().collect(),
    }
}

/// Two trees, from `start` and from `goal`, both of which must be free.
pub fn rrt_connect<S: ConfigSpace + ?Sized, R: Rng>(
    space: &S,
    start: Point2<f64>,
    goal: Point2<f64>,
    config: &RrtConfig,
    rng: &mut R,
    mut draw: impl FnMut(&mut R) -> Point2<f64>,
) -> Growth {
    let mut growing = Tree::new(start, space.bounds());
    let mut other = Tree::new(goal, space.bounds());
    let mut from_start = true;
    for iteration in 1..=config.max_iterations {
        // The first attempt joins the roots.
        let target = if iteration == 1 { goal } else { draw(rng) };
        if let Some(grown) = extend(&mut growing, space, target, config) {
            let point = growing.branch_end(grown.index);
            let joined = extend(&mut other, space, point, config).filter(|v| v.arrived);
            if let Some(met) = joined {
                let mut points = growing.branch(grown.index);
                points.extend(other.branch(met.index).into_iter().rev().skip(1));
                if !from_start {
                    points.reverse();
                }
                return Growth {
                    path: Some(Path { points }),
                    iterations: iteration,
                    tree: growing.edges().chain(other.edges()).collect(),
                };
            }
        }
        std::mem::swap(&mut growing, &mut other);
        from_start = !from_start;
    }
    Growth {
        path: None,
        iterations: config.max_iterations,
        tree: growing.edges().chain(other.edges()).collect(),
    }
}

/// Random points anywhere within the bounds of a space.
pub fn anywhere<S: ConfigSpace + ?Sized, R: Rng>(space: &S) -> impl FnMut(&mut R) -> Point2<f64> {
    let (low, high) = space.bounds();
    move |rng| {
        let (x, y) = (rng.random::<f64>(), rng.random::<f64>());
        Point2::new(low.x + (high.x - low.x) * x, low.y + (high.y - low.y) * y)
    }
}

struct Grown {
    index: usize,
    /// Whether the target itself was reached.
    arrived: bool,
}

/// Steps 2 and 3: from the nearest point of the tree to the last collision-free one towards `target`.
fn extend<S: ConfigSpace + ?Sized>(
    tree: &mut Tree,
    space: &S,
    target: Point2<f64>,
    config: &RrtConfig,
) -> Option<Grown> {
    let nearest = tree.nearest(target);
    if nearest.distance == 0.0 {
        return Some(Grown {
            index: tree.split(&nearest),
            arrived: true,
        });
    }
    let leg = Segment::new(nearest.point, target);
    let free = space.free_length(&leg);
    let arrived = free >= leg.length();
    if !arrived && free < config.min_growth {
        return None;
    }
    let point = if arrived {
        target
    } else {
        leg.a + leg.vector() * (free / leg.length())
    };
    let vertex = tree.split(&nearest);
    Some(Grown {
        index: tree.grow(vertex, point),
        arrived,
    })
}
