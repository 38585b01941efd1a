//! Visibility graph for a disc among walls: the shortest possible path, or the proof that there is
//! none.
//!
//! In: walls as segments, the distance to keep from them, a query; corner by corner. Out: the
//! shortest path.
//!
//! 1. A taut path among capsules consists of straight legs and of arcs round ends of walls; each
//!    leg touches the circles that it joins. The graph has a node for each such leg at its far end;
//!    an edge is an arc followed by the next leg.
//! 2. Legs from a circle are searched for when the search first leaves that circle, and kept.
//! 3. A* over that graph: the remaining way is at least the straight line.
//! 4. An exhausted search is a proof: if there is any path there is a taut one.
//! 5. Arcs are returned as corners of polygons around them, so the path never comes nearer to a
//!    wall than allowed; it is longer than the arcs by less than 0.03 % of their length.
//!
//! Circles are larger than the distance to keep by [`SPARE`], so that rounding does not make a leg
//! along a wall touch that wall.
//!
//! Source: Liu & Arimoto (1992), "Path planning using a tangent graph for mobile robots among
//! polygonal and curved obstacles"; the proof in Laumond (1987) for smooth obstacles.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use nalgebra::{Point2, Vector2};
use rand::Rng;

use super::cspace::ConfigSpace;
use super::path::{Path, way_to};
use super::query::Query;
use super::search::Planning;
use super::tangents::{Blocked, Tangent, Wound};
use crate::geom::{Length, Segment, sin_cos};

/// By how much circles are larger than the distance to keep, m.
const SPARE: f64 = 1e-6;
/// Largest angle of an arc that one corner stands for, rad.
const CORNER: f64 = 0.05;

/// A leg to the circle that it ends on.
#[derive(Clone, Copy, Debug)]
struct Link {
    to: u32,
    tangent: Tangent,
    is_done: bool,
}

/// The far end of a leg.
#[derive(Clone, Copy, Debug)]
struct Arrival {
    circle: u32,
    tangent: Tangent,
    /// Length of the way from the start, m.
    way: f64,
    /// The arrival from which the leg's circle was reached.
    before: Option<u32>,
}

/// Waiting arrivals, the least sum of way and remainder first: that sum as bits (the bits of
/// non-negative numbers sort like the numbers), the circle from which the leg comes, its number
/// there, the arrival before, and the way as bits.
type Open = BinaryHeap<Reverse<(u64, u32, u32, u32, u64)>>;

/// Circle 0 is the start, 1 the goal; then each end of a wall twice, once for each direction of
/// winding.
const START: u32 = 0;
const GOAL: u32 = 1;
const NONE: u32 = u32::MAX;

/// A search over taut paths.
#[derive(Debug)]
pub(super) struct Visibility {
    query: Query,
    keep: f64,
    circles: Vec<Wound>,
    /// Blocked arcs of each circle; `None` before they are needed.
    blocked: Vec<Option<Blocked>>,
    /// Legs from each circle; `None` before the search leaves it.
    links: Vec<Option<Vec<Link>>>,
    open: Open,
    arrivals: Vec<Arrival>,
    goal: Option<usize>,
}

impl Visibility {
    /// Begins at the start. `None` if the space has obstacles other than walls.
    pub(super) fn new(space: &dyn ConfigSpace, query: Query) -> Option<Self> {
        let (walls, keep) = space.walls()?;
        let point = |centre| Wound {
            centre,
            radius: 0.0,
        };
        let mut circles = vec![point(query.start), point(query.goal)];
        for centre in ends_of(walls) {
            circles.extend([1.0, -1.0].map(|sign| Wound {
                centre,
                radius: sign * (keep + SPARE),
            }));
        }
        let mut search = Self {
            query,
            keep,
            blocked: vec![None; circles.len() / 2],
            links: vec![None; circles.len()],
            circles,
            open: Open::new(),
            arrivals: vec![],
            goal: None,
        };
        search.find_links(space, START);
        search.offer_from(None, START);
        Some(search)
    }

    /// Step 2: all free legs from a circle.
    fn find_links(&mut self, space: &dyn ConfigSpace, from: u32) {
        if self.links[from as usize].is_some() {
            return;
        }
        let mut links = vec![];
        let circle = self.circles[from as usize];
        let is_shut = from != START && self.blocked_on(space, from).is_all();
        for to in (GOAL..self.circles.len() as u32).filter(|_| !is_shut) {
            let other = self.circles[to as usize];
            let tangent = (other.centre != circle.centre)
                .then(|| Tangent::between(&circle, &other))
                .flatten();
            if let Some(tangent) = tangent.filter(|t| space.leg_is_free(&t.leg)) {
                links.push(Link {
                    to,
                    tangent,
                    is_done: false,
                });
            }
        }
        self.links[from as usize] = Some(links);
    }

    /// Step 1: every leg that an arc leads to from an arrival (or any leg from the start).
    fn offer_from(&mut self, arrival: Option<usize>, from: u32) {
        let circle = self.circles[from as usize];
        let came = arrival.map(|a| self.arrivals[a]);
        let Some(links) = &self.links[from as usize] else {
            return;
        };
        for (number, link) in links.iter().enumerate().filter(|(_, l)| !l.is_done) {
            let mut way = link.tangent.length;
            if let Some(came) = came {
                let turn = circle.turn(came.tangent.heading, link.tangent.heading);
                let begin = circle.angle_at(came.tangent.heading);
                let blocked = self.blocked[from as usize / 2].as_ref();
                if !blocked.is_some_and(|b| b.is_free(begin, turn, circle.radius)) {
                    continue;
                }
                way += came.way + turn * circle.radius.abs();
            }
            let sum = way + (self.query.goal - link.tangent.leg.b).length();
            let before = arrival.map_or(NONE, |a| a as u32);
            let entry = (sum.to_bits(), from, number as u32, before, way.to_bits());
            self.open.push(Reverse(entry));
        }
    }

    fn blocked_on(&mut self, space: &dyn ConfigSpace, circle: u32) -> &Blocked {
        let wound = self.circles[circle as usize];
        let walls = space.walls().map_or(&[][..], |(walls, _)| walls);
        self.blocked[circle as usize / 2].get_or_insert_with(|| {
            let (centre, radius) = (wound.centre, wound.radius.abs());
            Blocked::new(centre, radius, self.keep, walls, space.bounds())
        })
    }

    /// Step 5: corners around the arc from an arrival to a heading.
    fn wind(&self, came: &Arrival, heading: f64, points: &mut Vec<Point2<f64>>) {
        let circle = self.circles[came.circle as usize];
        let turn = circle.turn(came.tangent.heading, heading);
        let pieces = (turn / CORNER).ceil().max(1.0);
        let step = turn / pieces * circle.radius.signum();
        let begin = circle.angle_at(came.tangent.heading);
        let radius = circle.radius.abs() / libm::cos(0.5 * step);
        for piece in 0..pieces as usize {
            let (sin, cos) = sin_cos(begin + step * (piece as f64 + 0.5));
            points.push(circle.centre + Vector2::new(cos, sin) * radius);
        }
    }
}

impl Planning for Visibility {
    /// Takes the next leg.
    fn iterate(&mut self, space: &dyn ConfigSpace, _rng: &mut dyn Rng) -> bool {
        if self.goal.is_some() {
            return false;
        }
        let Some(Reverse((_, from, number, before, way))) = self.open.pop() else {
            return false;
        };
        let links = self.links[from as usize].as_mut();
        let Some(link) = links.and_then(|links| links.get_mut(number as usize)) else {
            return true;
        };
        if std::mem::replace(&mut link.is_done, true) {
            return true;
        }
        let circle = link.to;
        self.arrivals.push(Arrival {
            circle,
            tangent: link.tangent,
            way: f64::from_bits(way),
            before: (before != NONE).then_some(before),
        });
        let arrival = self.arrivals.len() - 1;
        if circle == GOAL {
            self.goal = Some(arrival);
            return false;
        }
        self.find_links(space, circle);
        self.offer_from(Some(arrival), circle);
        true
    }

    fn is_found(&self) -> bool {
        self.goal.is_some()
    }

    fn path(&self) -> Option<Path> {
        let before = |leg: &Arrival| leg.before.map(|before| self.arrivals[before as usize]);
        let legs = way_to(self.arrivals[self.goal?], before);
        let mut points = vec![self.query.start];
        for pair in legs.windows(2) {
            self.wind(&pair[0], pair[1].tangent.heading, &mut points);
        }
        points.push(self.query.goal);
        points.dedup();
        Some(Path { points })
    }

    fn edges(&self) -> Vec<Segment> {
        self.arrivals.iter().map(|a| a.tangent.leg).collect()
    }

    fn edge_count(&self) -> usize {
        self.arrivals.len()
    }
}

/// Ends of walls, each once.
fn ends_of(walls: &[Segment]) -> Vec<Point2<f64>> {
    let mut ends: Vec<Point2<f64>> = walls.iter().flat_map(|w| [w.a, w.b]).collect();
    ends.sort_unstable_by(|p, q| p.x.total_cmp(&q.x).then(p.y.total_cmp(&q.y)));
    ends.dedup();
    ends
}
