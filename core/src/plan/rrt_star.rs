//! RRT* and Informed RRT*: one tree that is rewired wherever that makes a branch shorter.
//!
//! In: a configuration space, start and goal, a seeded generator, iteration by iteration. Out: a
//! path that keeps getting shorter and converges to the shortest possible, and the tree.
//!
//! Before there is a path, two trees grow as in RRT-Connect; their path, shortened, is the first
//! branch (unless `is_seeded` is false). Then, an iteration:
//! 1. Draw a point. Once there is a path of length c, Informed RRT* draws from the ellipse of all
//!    points over which a way of length at most c can lead; its foci are start and goal. Points
//!    over which no such way can lead are dropped.
//! 2. Extend from the nearest vertex towards the point, by at most `range`; drop it if that leg is
//!    blocked.
//! 3. The parent of the new vertex is the nearby vertex that gives it the shortest way from the
//!    start.
//! 4. Nearby vertices with a shorter way from the start over the new vertex get it as their parent;
//!    their descendants move with them.
//! 5. The goal, a vertex of its own, is tried from every new vertex that could shorten the way to
//!    it.
//!
//! "Nearby" means within a radius that shrinks with √(ln n / n) over n vertices, the least for
//! which the path converges to the shortest.
//!
//! Source: Karaman & Frazzoli (2011), "Sampling-based algorithms for optimal motion planning",
//! algorithm 6; Gammell, Srinivasa & Barfoot (2014), "Informed RRT*", eq. (3) to (8) in two
//! dimensions.

use std::f64::consts::{PI, TAU};

use nalgebra::{Point2, Vector2};
use rand::{Rng, RngExt};

use super::branches::Branches;
use super::cspace::ConfigSpace;
use super::path::{Path, way_to};
use super::point_index::PointIndex;
use super::query::Query;
use super::rrt::RrtConfig;
use super::rrt_connect::RrtConnect;
use super::sampler::Sampler;
use super::search::Planning;
use super::shorten::shorten;
use super::tree::MIN_GROWTH;
use crate::geom::{Length, Segment, sin_cos};

/// Smaller gains are rounding, m.
const LEAST_GAIN: f64 = 1e-9;
/// Most draws in an iteration, if points lie outside the bounds or no shorter way can lead over
/// them.
const DRAWS: usize = 16;

/// A tree from the start that keeps getting shorter.
#[derive(Debug)]
pub(super) struct RrtStar {
    query: Query,
    config: RrtConfig,
    sampler: Sampler,
    is_informed: bool,
    bounds: (Point2<f64>, Point2<f64>),
    index: PointIndex,
    branches: Branches,
    /// The vertex from which the goal is reached, and the length of the path.
    goal: Option<(usize, f64)>,
    /// The search that finds the first path.
    scout: Option<Box<RrtConnect>>,
    /// Nearby vertices of the new one: the way to it over each, m, and the distance.
    near: Vec<(f64, f64, usize)>,
}

impl RrtStar {
    /// A tree of only the start; both ends of the query must be free. `is_informed` makes it
    /// Informed RRT*.
    pub(super) fn new(
        space: &dyn ConfigSpace,
        query: Query,
        config: RrtConfig,
        sampler: Sampler,
        is_informed: bool,
    ) -> Self {
        let bounds = space.bounds();
        let mut index = PointIndex::new(bounds);
        index.insert(query.start);
        let scout = || RrtConnect::new(space, query, config, sampler.clone());
        let mut star = Self {
            scout: config.is_seeded.then(|| Box::new(scout())),
            query,
            config,
            sampler,
            is_informed,
            bounds,
            index,
            branches: Branches::new(),
            goal: None,
            near: vec![],
        };
        star.try_goal(space, 0);
        star
    }

    /// Does steps 1 to 5 once.
    fn grow(&mut self, space: &dyn ConfigSpace, rng: &mut dyn Rng) {
        if let Some(mut scout) = self.scout.take() {
            scout.iterate(space, rng);
            match scout.path() {
                Some(path) => self.plant(space, &shorten(&path, space)),
                None => self.scout = Some(scout),
            }
            return;
        }
        let length = self.length();
        let mut drawn = self.draw(rng);
        for _ in 1..DRAWS {
            if self.least_way_over(drawn) < length {
                break;
            }
            drawn = self.draw(rng);
        }
        if self.least_way_over(drawn) >= length {
            return;
        }
        let Some((point, nearest)) = self.extend(space, drawn) else {
            return;
        };
        self.collect_near(point);
        let Some((parent, way)) = self.best_parent(space, point, nearest) else {
            return;
        };
        if way + (self.query.goal - point).length() >= self.length() {
            return;
        }
        self.index.insert(point);
        let vertex = self.branches.grow(parent, way);
        self.rewire(space, vertex);
        self.try_goal(space, vertex);
    }

    /// Makes a free path from the start to the goal a branch of the tree.
    fn plant(&mut self, space: &dyn ConfigSpace, path: &Path) {
        let mut vertex = 0;
        for leg in path.legs().take(path.points.len().saturating_sub(2)) {
            let way = self.branches.way_to(vertex) + leg.length();
            self.index.insert(leg.b);
            vertex = self.branches.grow(vertex, way);
        }
        self.try_goal(space, vertex);
    }

    /// Length of the path, m; infinite while there is none. Computed from the tree as it is,
    /// because rewiring shortens the path too.
    fn length(&self) -> f64 {
        self.goal.map_or(f64::INFINITY, |(vertex, last)| {
            self.branches.way_to(vertex) + last
        })
    }

    /// Whatever is added or rewired, no way over `point` is shorter.
    fn least_way_over(&self, point: Point2<f64>) -> f64 {
        (point - self.query.start).length() + (self.query.goal - point).length()
    }

    fn draw(&self, rng: &mut dyn Rng) -> Point2<f64> {
        let longest = self.length();
        let foci = self.query.goal - self.query.start;
        let (major, least) = (0.5 * longest, foci.length());
        let minor = 0.5 * (longest * longest - least * least).max(0.0).sqrt();
        // If the ellipse is larger than the area otherwise drawn from, dropping points is cheaper.
        if !self.is_informed || !longest.is_finite() || PI * major * minor > self.sampler.area() {
            return self.sampler.draw(rng);
        }
        let centre = self.query.start + 0.5 * foci;
        let axis = if least > 0.0 {
            foci / least
        } else {
            Vector2::x()
        };
        let (low, high) = self.bounds;
        for _ in 0..DRAWS {
            let radius = rng.random::<f64>().sqrt();
            let (sin, cos) = sin_cos(TAU * rng.random::<f64>());
            let (u, v) = (major * radius * cos, minor * radius * sin);
            let point = centre + axis * u + Vector2::new(-axis.y, axis.x) * v;
            if point >= low && point <= high {
                return point;
            }
        }
        self.sampler.draw(rng)
    }

    /// Step 2: the new point, and the vertex from which it was reached.
    fn extend(&self, space: &dyn ConfigSpace, drawn: Point2<f64>) -> Option<(Point2<f64>, usize)> {
        let (nearest, distance) = self.index.nearest(drawn)?;
        let from = self.index.points()[nearest];
        let reach = distance.min(self.config.range);
        let aim = if reach < distance {
            from + (drawn - from) * (reach / distance)
        } else {
            drawn
        };
        let is_free = space.leg_is_free(&Segment::new(from, aim));
        (is_free && reach >= MIN_GROWTH).then_some((aim, nearest))
    }

    /// Collects the vertices within the radius of the new point, the shortest way over them first.
    fn collect_near(&mut self, point: Point2<f64>) {
        let n = self.index.points().len() as f64;
        // Theorem 38: γ > (2 (1 + 1/d))^(1/d) (μ / ζ)^(1/d), with d = 2 and ζ = π.
        let gamma = (3.0 * self.sampler.area() / PI).sqrt();
        let radius = self.config.rewire_factor * gamma * (libm::log(n + 1.0) / n).sqrt();
        let radius = radius.min(self.config.range);
        let (near, branches) = (&mut self.near, &self.branches);
        near.clear();
        self.index.within(point, radius, |vertex, squared| {
            let distance = squared.sqrt();
            near.push((branches.way_to(vertex) + distance, distance, vertex));
        });
        near.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.2.cmp(&b.2)));
    }

    /// Step 3: the parent and the way to the new point. The leg from `nearest` is known to be free.
    fn best_parent(
        &self,
        space: &dyn ConfigSpace,
        point: Point2<f64>,
        nearest: usize,
    ) -> Option<(usize, f64)> {
        let points = self.index.points();
        let known = self.branches.way_to(nearest) + (point - points[nearest]).length();
        for &(way, distance, vertex) in &self.near {
            if way >= known {
                break;
            }
            if distance == 0.0 {
                // The vertex exists already.
                return None;
            }
            if space.leg_is_free(&Segment::new(points[vertex], point)) {
                return Some((vertex, way));
            }
        }
        Some((nearest, known))
    }

    /// Step 4.
    fn rewire(&mut self, space: &dyn ConfigSpace, vertex: usize) {
        let (points, way) = (self.index.points(), self.branches.way_to(vertex));
        for &(over, distance, near) in &self.near {
            let through = way + distance;
            let is_shorter = through + LEAST_GAIN < over - distance;
            // The test is repeated, because rewiring may have shortened ways meanwhile.
            if is_shorter
                && through + LEAST_GAIN < self.branches.way_to(near)
                && space.leg_is_free(&Segment::new(points[vertex], points[near]))
            {
                self.branches.hang(near, vertex, through);
            }
        }
    }

    /// Step 5.
    fn try_goal(&mut self, space: &dyn ConfigSpace, vertex: usize) {
        let point = self.index.points()[vertex];
        let last = (self.query.goal - point).length();
        let is_shorter = self.branches.way_to(vertex) + last + LEAST_GAIN < self.length();
        if is_shorter && space.leg_is_free(&Segment::new(point, self.query.goal)) {
            self.goal = Some((vertex, last));
        }
    }
}

impl Planning for RrtStar {
    fn iterate(&mut self, space: &dyn ConfigSpace, rng: &mut dyn Rng) -> bool {
        self.grow(space, rng);
        true
    }

    fn is_found(&self) -> bool {
        self.goal.is_some()
    }

    fn path(&self) -> Option<Path> {
        let way = way_to(self.goal?.0, |at| self.branches.parent(*at));
        let mut points: Vec<_> = way.iter().map(|&at| self.index.points()[at]).collect();
        points.push(self.query.goal);
        points.dedup();
        Some(Path { points })
    }

    fn edges(&self) -> Vec<Segment> {
        if let Some(scout) = &self.scout {
            return scout.edges();
        }
        let points = self.index.points();
        let legs = (0..points.len()).filter_map(|v| Some((self.branches.parent(v)?, v)));
        legs.map(|(a, b)| Segment::new(points[a], points[b]))
            .collect()
    }

    fn edge_count(&self) -> usize {
        match &self.scout {
            Some(scout) => scout.edge_count(),
            // Every vertex except the root has an edge to its parent.
            None => self.index.points().len().saturating_sub(1),
        }
    }
}
