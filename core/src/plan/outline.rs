//! Paths for a robot that is not round: through doors too narrow for the disc around it.
//!
//! In: walls, an outline, start and goal, the heading at the start unless any will do. Out:
//! straight legs, with turns on the spot between them, that the outline follows without touching a
//! wall; or the typed reason.
//!
//! 1. A state is a place on a raster whose origin is the start, and one of 16 headings, those of
//!    the raster's shortest steps. From a state the robot turns to any heading, in the shorter
//!    direction, and drives one step.
//! 2. Places where the disc within the outline does not fit are ruled out; places where the disc
//!    around it fits need no further test. In between the outline itself is tested against the
//!    walls nearby ([`Footprint::turns`], [`Footprint::drives`]).
//! 3. A* over these states. The cost is in metres, and each radian counts as many as the
//!    configuration says, so that the robot does not wriggle.
//! 4. Corners that the outline does not need are dropped.
//!
//! Source: Latombe (1991), "Robot motion planning", chapter 9, for the search over places and
//! headings.

mod corners;
mod on_grid;

use std::cmp::Reverse;
use std::collections::{BTreeMap, BinaryHeap};
use std::iter::once;
use std::rc::Rc;

use nalgebra::{Point2, Vector2};
use rand::Rng;

use super::cspace::ConfigSpace;
use super::path::{NoPath, Path, way_to};
use super::query::Query;
use super::search::Planning;
use crate::geom::{Footprint, Length, Pose2, Segment, wrap};
use corners::drop_corners;
pub use corners::follows;
pub use on_grid::plan_outline_route;

/// Side of the raster, m; larger is faster, but misses doors with less room to spare.
const SIDE: f64 = 0.05;
/// Cost of a radian of turning, m; larger makes fewer turns and longer ways.
const TURNING: f64 = 0.1;
/// The 16 steps, in the order of their headings.
#[rustfmt::skip]
const STEPS: [(i32, i32); 16] = [
    (1, 0), (2, 1), (1, 1), (1, 2),
    (0, 1), (-1, 2), (-1, 1), (-2, 1),
    (-1, 0), (-2, -1), (-1, -1), (-1, -2),
    (0, -1), (1, -2), (1, -1), (2, -1),
];
/// The goal is tried from places within this many cell sides of it.
const NEAR: f64 = 3.0;

/// A place on the raster.
type At = (i32, i32);

/// A known place: its position, its room beyond the disc within the outline, and the walls that the
/// outline might touch.
#[derive(Clone, Debug)]
struct Place {
    point: Point2<f64>,
    room: f64,
    near: Rc<[Segment]>,
}

/// A place reached with a heading.
#[derive(Clone, Copy, Debug)]
struct State {
    at: At,
    heading: f64,
    way: f64,
    from: usize,
    is_done: bool,
}

/// A resumable search over places and headings, always in the space in which it was begun.
#[derive(Debug)]
pub(super) struct OutlineSearch {
    outline: Footprint,
    query: Query,
    /// Heading at the start, rad; `None`: any.
    heading: Option<f64>,
    /// Difference of radius between the disc around the outline and the disc within it, m.
    spare: f64,
    /// Places by raster index; `None` for those that are not free.
    places: BTreeMap<At, Option<Place>>,
    /// State numbers, by place and number of the step that led there.
    numbers: BTreeMap<(At, usize), usize>,
    states: Vec<State>,
    /// Sum of way and remainder, as bits: the bits of non-negative numbers sort like the numbers.
    open: BinaryHeap<Reverse<(u64, usize)>>,
    iterations: usize,
    path: Option<Path>,
}

impl OutlineSearch {
    /// Begins a search from a heading in rad, or from whichever is best; at the goal the robot may
    /// have any heading.
    ///
    /// `space` holds the walls and the bounds, for the disc within the outline.
    ///
    /// # Errors    [`NoPath::StartBlocked`] if the outline does not fit at the start,
    /// [`NoPath::GoalBlocked`] if not even the disc within it fits at the goal.
    pub(super) fn new(
        space: &dyn ConfigSpace,
        outline: Footprint,
        query: Query,
        heading: Option<f64>,
    ) -> Result<Self, NoPath> {
        query.check(space)?;
        let start = query.start;
        let walls = space.walls_near(start, outline.radius_around());
        let headings = match heading {
            Some(heading) => vec![heading],
            None => STEPS.iter().map(heading_of_step).collect(),
        };
        let fits = |heading: &f64| outline.fits(&Pose2::new(start.x, start.y, *heading), &walls);
        let roots = headings.into_iter().filter(fits).enumerate();
        let states: Vec<State> = roots
            .map(|(number, heading)| State {
                at: (0, 0),
                heading,
                way: 0.0,
                from: number,
                is_done: false,
            })
            .collect();
        if states.is_empty() {
            return Err(NoPath::StartBlocked(start));
        }
        Ok(Self {
            spare: outline.radius_around() - outline.radius_within(),
            outline,
            query,
            heading,
            places: BTreeMap::new(),
            numbers: BTreeMap::new(),
            open: (0..states.len())
                .map(|number| Reverse((0, number)))
                .collect(),
            states,
            iterations: 0,
            path: None,
        })
    }

    /// Expands one state; returns whether there is more to do.
    fn expand_next(&mut self, space: &dyn ConfigSpace) -> bool {
        if self.path.is_some() {
            return false;
        }
        let Some(Reverse((_, number))) = self.open.pop() else {
            return false;
        };
        if std::mem::replace(&mut self.states[number].is_done, true) {
            return true;
        }
        let state = self.states[number];
        let Some(place) = self.place(space, state.at) else {
            return true;
        };
        if self.reaches_goal(&state, &place) {
            let path = self.path_to(number);
            self.path = Some(drop_corners(path, self.heading, &self.outline, space));
            return false;
        }
        self.iterations += 1;
        for step in 0..STEPS.len() {
            self.try_step(space, number, &place, step);
        }
        true
    }

    fn place(&mut self, space: &dyn ConfigSpace, at: At) -> Option<Place> {
        let point = self.query.start + Vector2::new(f64::from(at.0), f64::from(at.1)) * SIDE;
        let reach = self.outline.radius_around() + (NEAR + 1.0) * SIDE;
        let measured = || {
            let room = space.room(point);
            (room >= 0.0).then(|| Place {
                point,
                room,
                // No wall is near the disc around the outline, whatever the step.
                near: match room >= self.spare + NEAR * SIDE {
                    true => Rc::from([]),
                    false => space.walls_near(point, reach).into(),
                },
            })
        };
        self.places.entry(at).or_insert_with(measured).clone()
    }

    /// Whether the outline can turn and then drive a leg of at most [`NEAR`] sides.
    fn is_free(&self, heading: f64, place: &Place, leg: &Segment) -> bool {
        // No wall is near the disc around the outline, all along the leg.
        if place.room >= self.spare + leg.length() {
            return true;
        }
        let pose = Pose2::new(place.point.x, place.point.y, heading);
        let turn = wrap(leg.heading() - heading);
        self.outline.drives(leg, &place.near) && self.outline.turns(&pose, turn, &place.near)
    }

    fn reaches_goal(&self, state: &State, place: &Place) -> bool {
        let leg = Segment::new(place.point, self.query.goal);
        let is_near = leg.length() <= NEAR * SIDE;
        is_near && (leg.length() == 0.0 || self.is_free(state.heading, place, &leg))
    }

    fn try_step(&mut self, space: &dyn ConfigSpace, from: usize, place: &Place, step: usize) {
        let state = self.states[from];
        let at = (state.at.0 + STEPS[step].0, state.at.1 + STEPS[step].1);
        let Some(next) = self.place(space, at) else {
            return;
        };
        let leg = Segment::new(place.point, next.point);
        let heading = leg.heading();
        let turn = wrap(heading - state.heading).abs();
        let way = state.way + leg.length() + TURNING * turn;
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
        let rest = (self.query.goal - next.point).length();
        self.open.push(Reverse(((way + rest).to_bits(), number)));
    }

    /// The corners of the way to the goal over a state.
    fn path_to(&self, number: usize) -> Path {
        let before = |&at: &usize| Some(self.states[at].from).filter(|from| *from != at);
        let way = way_to(number, before).into_iter().skip(1);
        let between = way.filter_map(|at| self.point(self.states[at].at));
        let ends = (self.query.start, self.query.goal);
        let mut points: Vec<_> = once(ends.0).chain(between).chain([ends.1]).collect();
        points.dedup();
        Path { points }
    }

    /// The point of a place, if it was found free.
    fn point(&self, at: At) -> Option<Point2<f64>> {
        Some(self.places.get(&at)?.as_ref()?.point)
    }
}

impl Planning for OutlineSearch {
    fn iterate(&mut self, space: &dyn ConfigSpace, _rng: &mut dyn Rng) -> bool {
        self.expand_next(space)
    }

    fn is_found(&self) -> bool {
        self.path.is_some()
    }

    fn path(&self) -> Option<Path> {
        self.path.clone()
    }

    fn edges(&self) -> Vec<Segment> {
        let edge = |state: &State| {
            let from = self.states[state.from].at;
            let leg = Segment::new(self.point(from)?, self.point(state.at)?);
            // At the start nothing was driven yet.
            (from != state.at).then_some(leg)
        };
        self.states.iter().filter_map(edge).collect()
    }

    fn edge_count(&self) -> usize {
        let is_driven = |state: &&State| self.states[state.from].at != state.at;
        self.states.iter().filter(is_driven).count()
    }
}

fn heading_of_step(step: &(i32, i32)) -> f64 {
    libm::atan2(f64::from(step.1), f64::from(step.0))
}

#[cfg(test)]
mod tests;
