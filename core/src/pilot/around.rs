//! Leaving the way to go around people who stand or walk in it.
//!
//! In: the speeds that the follower requests. Out: those speeds, or those of the dynamic window.
//!
//! 1. The window is used only while people hold the robot up: safe mode has cut the request below
//!    [`HELD`] of it, because of a walker, for [`HELD_FOR`]. Most people are out of the way by
//!    then, and turning aside for them would only lengthen the drive.
//! 2. It ends as soon as safe mode would let [`FREE`] of the follower's request through.
//!
//! The times and fractions are ours.

use nalgebra::Point2;

use super::{Pilot, Situation};
use crate::control::{Avoidance, People, Speeds, choose_in_window};
use crate::geom::Length;
use crate::plan::Path;
use crate::points::Points;
use crate::robot::Stamp;

/// How far ahead on its way the robot looks for a point to aim at, m.
const AHEAD: f64 = 1.0;
/// A robot that may use less than this fraction of the requested speed is held up; one that may use
/// more than the next fraction is free again.
const HELD: f64 = 0.5;
const FREE: f64 = 0.8;
/// A robot that was held up for this long goes around, s.
const HELD_FOR: f64 = 1.0;

/// Somebody this near may be what the robot cannot pass, m.
const NEAR: f64 = 1.0;

/// Whether the robot goes around somebody.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Detour {
    /// Time since when it is held up.
    held: Option<Stamp>,
    is_on: bool,
}

impl Detour {
    /// Takes the fraction of its request that the robot may use.
    fn update(&mut self, part: f64, now: Stamp) {
        if part >= FREE || (part >= HELD && !self.is_on) {
            *self = Self::default();
            return;
        }
        let since = *self.held.get_or_insert(now);
        self.is_on |= now.since(since) >= HELD_FOR;
    }
}

impl Pilot {
    /// The speeds that the follower requests, or, if the robot is to go around somebody who holds
    /// it up, those of the dynamic window. The window is for the disc: a robot that goes by its
    /// outline keeps to its way. If no pair of speeds is admissible the request stays, for safe
    /// mode to limit.
    pub(super) fn around_people(&mut self, wish: Speeds, now: &Situation) -> Speeds {
        let turns_on_spot = wish.0 <= 0.0;
        let (Some(points), false) = (now.points, turns_on_spot) else {
            return wish;
        };
        if self.config.avoidance == Avoidance::KeepsToWay || self.goes_by_outline(now) {
            return wish;
        }
        let part = self.part_let_through(wish, points, now);
        self.errand.detour.update(part, now.stamp);
        if !self.errand.detour.is_on {
            return wish;
        }
        let here = now.estimate.pose;
        let follower = self.errand.follower.as_ref();
        let ahead = follower.and_then(|f| point_along(&f.remaining(here.position()), AHEAD));
        let Some(aim) = ahead else {
            return wish;
        };
        let underway = self.underway(points, now);
        let people = People {
            points,
            walkers: now.walkers,
        };
        let aim = here.inverse() * aim;
        choose_in_window(aim, &people, &underway, (&self.model, &self.config.safe)).unwrap_or(wish)
    }

    /// The fraction that people leave of the speed that things leave. Separation keeps the robot
    /// farther from people than from things. If things leave no speed at all, people hold it up
    /// only if some are near.
    fn part_let_through(&self, wish: Speeds, points: &Points, now: &Situation) -> f64 {
        if now.walkers.is_empty() {
            return 1.0;
        }
        let safe = self.limited(wish, points, now, &self.config.safe);
        if safe.among_things.0 > 0.0 {
            return safe.among_people.0 / safe.among_things.0;
        }
        f64::from(u8::from(!people_are_near(now)))
    }
}

/// Whether a walker, or somebody who walked a moment ago, is right beside the robot.
pub(super) fn people_are_near(now: &Situation) -> bool {
    let here = now.motion_since_scan.position();
    let mut walkers = now.walkers.iter();
    walkers.any(|walker| (walker - here).length() < NEAR)
}

/// The point at this distance along a path, or its end; `None` for an empty path.
fn point_along(path: &Path, way: f64) -> Option<Point2<f64>> {
    let mut left = way;
    for leg in path.legs() {
        let length = leg.length();
        if length >= left {
            return Some(leg.a + leg.vector() * (left / length.max(1e-9)));
        }
        left -= length;
    }
    path.points.last().copied()
}
