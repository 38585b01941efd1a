//! Paths for a robot that is not round: through doors that the disc around it does not pass.
//!
//! In: walls, an outline, from where to where, the heading at the start. Out: straight legs, with turns on the spot between them,
//! that the outline follows without touching a wall; or the typed reason.
//!
//! 1. A state is a place on a raster whose origin is the start, and one of 16 headings, those of the raster's shortest steps. From a
//!    state the robot turns to any heading, the shorter way round, and drives one step.
//! 2. The disc within the outline rules places out, and the disc around it needs no further test; between the two the outline itself
//!    is tested against the walls near ([`Footprint::turns`], [`Footprint::drives`]).
//! 3. A* over these states: metres, and for each radian as many as the configuration says, so that the robot does not wriggle.
//! 4. Corners that the outline can do without are dropped.
//!
//! Source: Latombe (1991), "Robot motion planning", chapter 9, for the search over places and headings.

use std::cmp::Reverse;
use std::collections::{BTreeMap, BinaryHeap};
use std::rc::Rc;

use nalgebra::{Point2, Vector2};

use super::cspace::{ConfigSpace, SegmentSpace};
use super::footprint::Footprint;
use super::path::{NoPath, Path};
use super::query::Query;
use crate::geom::{Pose2, Segment, wrap};

/// How a path for an outline is looked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OutlineConfig {
    /// Side of the raster, m. Default 0.05; larger is faster, and misses doors that leave less to spare.
    pub side: f64,
    /// What a radian of turning counts, m. Default 0.1; larger makes fewer turns and longer ways.
    pub turning: f64,
    /// Most states to expand. Default 200 000.
    pub max_iterations: usize,
}

impl Default for OutlineConfig {
    fn default() -> Self {
        Self {
            side: 0.05,
            turning: 0.1,
            max_iterations: 200_000,
        }
    }
}

/// Plans for an outline, from a heading in rad; at the goal it may have any.
///
/// `space` holds the walls and the bounds; the outline takes the place of the distance that it keeps.
///
/// # Errors    [`NoPath::StartBlocked`] where the outline does not fit at the start, [`NoPath::GoalBlocked`] where not even the disc
/// within it fits at the goal, [`NoPath::Unreachable`] where that disc provably cannot get there, [`NoPath::Exhausted`] and
/// [`NoPath::BudgetSpent`].
pub fn plan_outline(
    space: &SegmentSpace,
    outline: &Footprint,
    query: Query,
    heading: f64,
    config: &OutlineConfig,
) -> Result<Path, NoPath> {
    let within = space.with_keep(outline.radius_within());
    query.check(&within)?;
    let search = Search {
        walls: space.segments(),
        spare: outline.radius_around() - outline.radius_within(),
        space: &within,
        outline,
        query,
        config,
        places: BTreeMap::new(),
        numbers: BTreeMap::new(),
        states: vec![],
        open: BinaryHeap::new(),
    };
    let path = search.run(heading)?;
    Ok(drop_corners(path, heading, outline, space.segments()))
}

/// The 16 steps, in the order of their headings.
const STEPS: [(i32, i32); 16] = [
    (1, 0),
    (2, 1),
    (1, 1),
    (1, 2),
    (0, 1),
    (-1, 2),
    (-1, 1),
    (-2, 1),
    (-1, 0),
    (-2, -1),
    (-1, -1),
    (-1, -2),
    (0, -1),
    (1, -2),
    (1, -1),
    (2, -1),
];
/// The goal is tried from places so many sides away, or nearer.
const NEAR: f64 = 3.0;

/// A place on the raster.
type At = (i32, i32);

/// What is known of a place: where it is, its room beyond the disc within the outline, and the walls that the outline might touch.
#[derive(Clone)]
struct Place {
    point: Point2<f64>,
    room: f64,
    near: Rc<[Segment]>,
}

/// A place that was come to with a heading.
#[derive(Clone, Copy)]
struct State {
    at: At,
    heading: f64,
    way: f64,
    from: usize,
    is_done: bool,
}

struct Search<'a> {
    walls: &'a [Segment],
    /// By how much the disc around is wider than the disc within, m.
    spare: f64,
    space: &'a SegmentSpace,
    outline: &'a Footprint,
    query: Query,
    config: &'a OutlineConfig,
    /// `None` for places that are not free.
    places: BTreeMap<At, Option<Place>>,
    /// By place and number of the step that led there.
    numbers: BTreeMap<(At, usize), usize>,
    states: Vec<State>,
    /// Way and rest, as bits: those of numbers that are not negative are in order.
    open: BinaryHeap<Reverse<(u64, usize)>>,
}

impl Search<'_> {
    fn run(mut self, heading: f64) -> Result<Path, NoPath> {
        let Query { start, .. } = self.query;
        let pose = Pose2::new(start.x, start.y, heading);
        if !self.outline.fits(&pose, self.walls) {
            let (x, y) = (start.x, start.y);
            return Err(NoPath::StartBlocked { x, y });
        }
        self.states.push(State {
            at: (0, 0),
            heading,
            way: 0.0,
            from: 0,
            is_done: false,
        });
        self.open.push(Reverse((0, 0)));
        let mut iterations = 0;
        while let Some(Reverse((_, number))) = self.open.pop() {
            if std::mem::replace(&mut self.states[number].is_done, true) {
                continue;
            }
            let state = self.states[number];
            let Some(place) = self.place(state.at) else {
                continue;
            };
            if self.reaches_goal(&state, &place) {
                return Ok(self.path_to(number));
            }
            iterations += 1;
            if iterations > self.config.max_iterations {
                return Err(NoPath::BudgetSpent { iterations });
            }
            for step in 0..STEPS.len() {
                self.try_step(number, &place, step);
            }
        }
        // What the disc within cannot reach, the outline cannot.
        if self.space.are_apart(start, self.query.goal) {
            return Err(self.query.unreachable());
        }
        Err(NoPath::Exhausted { iterations })
    }

    fn place(&mut self, at: At) -> Option<Place> {
        let (space, walls, side) = (self.space, self.walls, self.config.side);
        let point = self.query.start + Vector2::new(f64::from(at.0), f64::from(at.1)) * side;
        let reach = self.outline.radius_around() + (NEAR + 1.0) * side;
        let look = || {
            let room = space.room(point);
            let near = walls.iter().filter(|wall| wall.distance(point) <= reach);
            (room >= 0.0).then(|| Place {
                point,
                room,
                near: near.copied().collect(),
            })
        };
        self.places.entry(at).or_insert_with(look).clone()
    }

    /// Whether the outline can turn and then drive a leg of at most [`NEAR`] sides.
    fn is_free(&self, heading: f64, place: &Place, leg: &Segment) -> bool {
        // Around the disc nothing is near, all along the leg.
        if place.room >= self.spare + leg.length() {
            return true;
        }
        let pose = Pose2::new(place.point.x, place.point.y, heading);
        let turn = wrap(heading_of(leg) - heading);
        self.outline.drives(leg, &place.near) && self.outline.turns(&pose, turn, &place.near)
    }

    fn reaches_goal(&self, state: &State, place: &Place) -> bool {
        let leg = Segment::new(place.point, self.query.goal);
        let is_near = leg.length() <= NEAR * self.config.side;
        is_near && (leg.length() == 0.0 || self.is_free(state.heading, place, &leg))
    }

    fn try_step(&mut self, from: usize, place: &Place, step: usize) {
        let state = self.states[from];
        let at = (state.at.0 + STEPS[step].0, state.at.1 + STEPS[step].1);
        let Some(next) = self.place(at) else {
            return;
        };
        let leg = Segment::new(place.point, next.point);
        let heading = heading_of(&leg);
        let turn = wrap(heading - state.heading).abs();
        let way = state.way + leg.length() + self.config.turning * turn;
        let number = self.numbers.get(&(at, step)).copied();
        let is_known = number.is_some_and(|n| self.states[n].is_done || self.states[n].way <= way);
        if is_known || !self.is_free(state.heading, place, &leg) {
            return;
        }
        let state = State {
            at,
            heading,
            way,
            from,
            is_done: false,
        };
        let number = number.unwrap_or(self.states.len());
        match self.states.get_mut(number) {
            Some(known) => *known = state,
            None => self.states.push(state),
        }
        self.numbers.insert((at, step), number);
        let rest = (self.query.goal - next.point).norm();
        self.open.push(Reverse(((way + rest).to_bits(), number)));
    }

    /// The corners of the way over a state to the goal.
    fn path_to(&mut self, number: usize) -> Path {
        let mut points = vec![self.query.goal];
        let mut at = number;
        while at != 0 {
            points.extend(self.place(self.states[at].at).map(|place| place.point));
            at = self.states[at].from;
        }
        points.push(self.query.start);
        points.dedup();
        points.reverse();
        Path { points }
    }
}

fn heading_of(leg: &Segment) -> f64 {
    let along = leg.vector();
    libm::atan2(along.y, along.x)
}

/// Step 4: again and again from the start, until every corner is needed.
fn drop_corners(mut path: Path, heading: f64, outline: &Footprint, walls: &[Segment]) -> Path {
    let mut at = 1;
    let mut is_shorter = false;
    while at + 1 < path.points.len() {
        let before = match at {
            1 => heading,
            _ => heading_of(&Segment::new(path.points[at - 2], path.points[at - 1])),
        };
        let mut around = vec![path.points[at - 1]];
        around.extend(path.points.iter().skip(at + 1).take(2));
        if outline.follows(&Path { points: around }, before, walls) {
            path.points.remove(at);
            is_shorter = true;
        } else {
            at += 1;
        }
        if at + 1 >= path.points.len() && std::mem::take(&mut is_shorter) {
            at = 1;
        }
    }
    path
}

#[cfg(test)]
mod tests;
