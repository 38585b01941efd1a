//! A way over free discs, for trees that have drawn points in vain: it tells where to draw next,
//! and from which vertex to grow.
//!
//! In: a configuration space, a query. Out: discs of free floor from the start to the goal, each
//! within sight of the one before, and random points in them, one disc after another.
//!
//! 1. Places lie on a raster. The neighbours of a place with much room lie as far away as that room
//!    reaches, on a correspondingly coarser raster, so that the leg to them is free: few places in
//!    the open, many at walls. If the room does not reach any neighbour, the leg is tested.
//! 2. A* over these places, with a weighted heuristic, because any way will do. If there is none,
//!    again on finer rasters.
//! 3. Places that can be bypassed in a straight line are dropped. What remains are the discs.
//! 4. A tree draws a point in the next disc and grows there from its vertex in the last one. If
//!    that fails it goes back by one disc, and draws nearer to the disc centres: in the end on the
//!    way itself, which is free.
//!
//! Source: Brock & Kavraki (2001), "Decomposition-based motion planning"; Rickert, Sieverling &
//! Brock (2014), "Balancing exploration and exploitation in sampling-based motion planning",
//! algorithm 1 for the discs and 2 for drawing along them.

use std::cmp::Reverse;
use std::collections::{BTreeMap, BinaryHeap};
use std::f64::consts::{SQRT_2, TAU};

use nalgebra::{Point2, Vector2};
use rand::{Rng, RngExt};

use super::cspace::ConfigSpace;
use super::lattice::AROUND;
use super::path::way_to;
use super::query::Query;
use crate::geom::{Length, Segment, sin_cos};

/// Sides of the rasters, m.
const SIDES: [f64; 3] = [0.1, 0.04, 0.015];
/// Most places on one raster.
const MOST_PLACES: usize = 300_000;
/// Weight of the heuristic: larger finds a longer way sooner.
const WEIGHT: f64 = 2.0;
/// Fraction of the room that a leg may use in any direction: over a grid the room may change by √2
/// per metre.
const REACH: f64 = 0.7;
/// Factor by which points are drawn nearer to the disc centres after each failure.
const CLOSER: f64 = 0.5;
/// More room than this is of no use, m.
const MOST_ROOM: f64 = 100.0;

/// Free floor around a place, m.
#[derive(Clone, Copy, Debug)]
struct Disc {
    centre: Point2<f64>,
    radius: f64,
}

/// How far a tree that follows the discs has come.
#[derive(Clone, Debug)]
pub(super) struct Guide {
    discs: Vec<Disc>,
    /// The tree's vertex in each disc so far; the root is the vertex in the first.
    vertices: Vec<usize>,
    spread: f64,
}

/// A leg for a tree to grow.
#[derive(Clone, Copy, Debug)]
pub(super) struct Guided {
    pub(super) from: usize,
    pub(super) target: Point2<f64>,
}

impl Guide {
    /// A guide for a tree whose root, vertex 0, is the start; `None` if no raster has a way.
    pub(super) fn new(space: &dyn ConfigSpace, query: &Query) -> Option<Self> {
        let way = |side: f64| Places::new(*query, side).way(space);
        let [coarse, finer @ ..] = SIDES;
        let discs = way(coarse).or_else(|| {
            // Most often there is no way at all, which the space proves faster than a search over
            // finer rasters.
            let is_apart = space.are_apart(query.start, query.goal);
            finer.into_iter().filter(|_| !is_apart).find_map(way)
        })?;
        Some(Self {
            discs: straighten(&discs, space),
            vertices: vec![0],
            spread: 0.5,
        })
    }

    /// Step 4; `None` when the goal was reached.
    pub(super) fn draw(&self, rng: &mut dyn Rng) -> Option<Guided> {
        let disc = self.discs.get(self.vertices.len())?;
        let radius = self.spread * disc.radius * rng.random::<f64>().sqrt();
        let (sin, cos) = sin_cos(TAU * rng.random::<f64>());
        Some(Guided {
            from: *self.vertices.last()?,
            target: disc.centre + Vector2::new(cos, sin) * radius,
        })
    }

    /// Takes the result: the vertex at the point drawn, or none.
    pub(super) fn take(&mut self, grown: Option<usize>) {
        if let Some(vertex) = grown {
            self.vertices.push(vertex);
            return;
        }
        self.spread *= CLOSER;
        if self.vertices.len() > 1 {
            self.vertices.pop();
        }
    }
}

/// A place that was found.
#[derive(Clone, Copy, Debug)]
struct Place {
    disc: Disc,
    at: (i32, i32),
    /// Length of the way from the start, m.
    way: f64,
    from: usize,
    is_done: bool,
}

/// Places on a raster whose origin is the start.
struct Places {
    query: Query,
    side: f64,
    /// By column and row; `None` for those that are not free.
    numbers: BTreeMap<(i32, i32), Option<usize>>,
    places: Vec<Place>,
    /// Sum of way and weighted remainder, as bits: the bits of non-negative numbers sort like the
    /// numbers.
    open: BinaryHeap<Reverse<(u64, usize)>>,
}

impl Places {
    fn new(query: Query, side: f64) -> Self {
        Self {
            query,
            side,
            numbers: BTreeMap::new(),
            places: vec![],
            open: BinaryHeap::new(),
        }
    }

    /// Step 2: the discs from the start to the goal, its own without radius.
    fn way(mut self, space: &dyn ConfigSpace) -> Option<Vec<Disc>> {
        let start = self.number(space, (0, 0))?;
        self.offer(start, start, 0.0);
        while let Some(Reverse((_, number))) = self.open.pop() {
            let place = &mut self.places[number];
            if std::mem::replace(&mut place.is_done, true) {
                continue;
            }
            let place = *place;
            if self.sees_goal(space, &place) {
                return Some(self.discs_to(number));
            }
            if self.places.len() > MOST_PLACES {
                return None;
            }
            self.expand(space, number, place);
        }
        None
    }

    fn sees_goal(&self, space: &dyn ConfigSpace, place: &Place) -> bool {
        let rest = (self.query.goal - place.disc.centre).length();
        let leg = Segment::new(place.disc.centre, self.query.goal);
        rest <= (REACH * place.disc.radius).max(4.0 * self.side) && space.leg_is_free(&leg)
    }

    /// Step 1.
    fn expand(&mut self, space: &dyn ConfigSpace, number: usize, place: Place) {
        // Rounding to the coarser raster lengthens a step by half, and diagonal steps are longer
        // still.
        let reach = REACH * place.disc.radius / (1.5 * SQRT_2 * self.side);
        let is_inside = reach >= 1.0;
        let step = 1 << (reach as u32).max(1).ilog2();
        for (dx, dy) in AROUND {
            let onto = |at: i32, by: i32| (at + by * step + (step >> 1)) & !(step - 1);
            let at = (onto(place.at.0, dx), onto(place.at.1, dy));
            let Some(next) = self.number(space, at) else {
                continue;
            };
            let leg = Segment::new(place.disc.centre, self.places[next].disc.centre);
            // A way with room is worth a detour: it has fewer places.
            let narrow = self.side / (self.side + self.places[next].disc.radius);
            let way = place.way + leg.length() * (1.0 + narrow);
            let known = &self.places[next];
            if !known.is_done && way < known.way && (is_inside || space.leg_is_free(&leg)) {
                self.offer(next, number, way);
            }
        }
    }

    fn number(&mut self, space: &dyn ConfigSpace, at: (i32, i32)) -> Option<usize> {
        let (query, side, places) = (&self.query, self.side, &mut self.places);
        *self.numbers.entry(at).or_insert_with(|| {
            let off = Vector2::new(f64::from(at.0), f64::from(at.1)) * side;
            let centre = query.start + off;
            let radius = space.room(centre);
            if radius.is_nan() || radius < 0.0 {
                return None;
            }
            places.push(Place {
                // Without a wall the room is infinite.
                disc: Disc {
                    centre,
                    radius: radius.min(MOST_ROOM),
                },
                at,
                way: f64::INFINITY,
                from: 0,
                is_done: false,
            });
            Some(places.len() - 1)
        })
    }

    fn offer(&mut self, number: usize, from: usize, way: f64) {
        let place = &mut self.places[number];
        (place.way, place.from) = (way, from);
        let sum = way + WEIGHT * (self.query.goal - place.disc.centre).length();
        self.open.push(Reverse((sum.to_bits(), number)));
    }

    fn discs_to(&self, number: usize) -> Vec<Disc> {
        let before = |&at: &usize| Some(self.places[at].from).filter(|from| *from != at);
        let way = way_to(number, before).into_iter();
        let goal = Disc {
            centre: self.query.goal,
            radius: 0.0,
        };
        way.map(|at| self.places[at].disc).chain([goal]).collect()
    }
}

/// Step 3: from each disc to the farthest one that doubling steps find in sight.
fn straighten(discs: &[Disc], space: &dyn ConfigSpace) -> Vec<Disc> {
    let mut kept: Vec<Disc> = discs.first().copied().into_iter().collect();
    let mut at = 0;
    while at + 1 < discs.len() {
        let sees = |to: usize| {
            let leg = Segment::new(discs[at].centre, discs[to].centre);
            leg.length() > 0.0 && space.leg_is_free(&leg)
        };
        let (mut next, mut step) = (at + 1, 1);
        while next + step < discs.len() && sees(next + step) {
            next += step;
            step *= 2;
        }
        at = next;
        kept.push(discs[at]);
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::rrt::Rrt;
    use crate::plan::rrt_connect::RrtConnect;
    use crate::plan::search::Planning;
    use crate::plan::{RrtConfig, Sampler, SegmentSpace};
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    const KEEP: f64 = 0.2;

    /// Walls across a hall of 40 x 10 m, each with its gap at the opposite end from the last.
    fn serpentine(gap: f64) -> (SegmentSpace, Query) {
        let wall =
            |x: f64, low: f64, high: f64| Segment::new(Point2::new(x, low), Point2::new(x, high));
        let walls = (1..40).map(|i| {
            let x = f64::from(i);
            if i % 2 == 0 {
                wall(x, 0.0, 10.0 - gap)
            } else {
                wall(x, gap, 10.0)
            }
        });
        let bounds = (Point2::origin(), Point2::new(40.0, 10.0));
        let query = Query {
            start: Point2::new(0.5, 9.07),
            goal: Point2::new(39.5, 1.0),
        };
        (
            SegmentSpace::new(walls.collect(), KEEP, bounds).unwrap(),
            query,
        )
    }

    /// Least distance of the leg from a wall, sampled every 5 mm.
    fn least_distance(leg: &Segment, walls: &[Segment]) -> f64 {
        let pieces = (leg.length() / 0.005).ceil() as i32;
        let at = |i: i32| leg.a + leg.vector() * (f64::from(i) / f64::from(pieces.max(1)));
        let places = (0..=pieces).flat_map(|i| walls.iter().map(move |w| w.distance(at(i))));
        places.fold(f64::INFINITY, f64::min)
    }

    #[test]
    fn discs_are_free_and_each_sees_the_next() {
        let (space, query) = serpentine(0.7);
        let guide = Guide::new(&space, &query).unwrap();
        let centres: Vec<_> = guide.discs.iter().map(|disc| disc.centre).collect();
        assert_eq!(centres.first(), Some(&query.start));
        assert_eq!(centres.last(), Some(&query.goal));
        for pair in centres.windows(2) {
            let leg = Segment::new(pair[0], pair[1]);
            assert!(least_distance(&leg, space.segments()) >= KEEP - 1e-9);
        }
        for disc in &guide.discs {
            let room = space
                .segments()
                .iter()
                .map(|w| w.distance(disc.centre) - KEEP);
            assert!(disc.radius <= room.fold(f64::INFINITY, f64::min) + 1e-9);
        }
    }

    #[test]
    fn gaps_too_narrow_for_the_coarse_raster_are_found_on_a_finer_one_and_shut_ones_are_not() {
        // Between a wall's end and the bounds, 5 cm remain for the robot's centre.
        let (space, query) = serpentine(KEEP + 0.05);
        assert!(Places::new(query, SIDES[0]).way(&space).is_none());
        assert!(Guide::new(&space, &query).is_some());
        let (space, query) = serpentine(KEEP - 0.02);
        assert!(Guide::new(&space, &query).is_none());
    }

    #[test]
    fn trees_that_draw_in_vain_come_through_forty_gaps() {
        let (space, query) = serpentine(0.6);
        for seed in 0..5 {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            let config = RrtConfig::default();
            let anywhere = || Sampler::anywhere(&space);
            let mut one = Rrt::new(&space, query, config, anywhere());
            let mut two = RrtConnect::new(&space, query, config, anywhere());
            for _ in 0..config.max_iterations {
                one.iterate(&space, &mut rng);
                two.iterate(&space, &mut rng);
                if one.is_found() && two.is_found() {
                    break;
                }
            }
            for path in [one.path(), two.path()] {
                let path = path.unwrap();
                assert_eq!(path.points.first(), Some(&query.start));
                assert_eq!(path.points.last(), Some(&query.goal));
                let legs = path
                    .legs()
                    .map(|leg| least_distance(&leg, space.segments()));
                assert!(legs.fold(f64::INFINITY, f64::min) >= KEEP - 1e-9);
            }
        }
    }
}
