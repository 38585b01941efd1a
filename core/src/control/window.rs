//! The dynamic window: of all speeds that the robot can have a moment from now, those that best
//! keep it on its way and in free space.
//!
//! In: a point on the way ahead, the points around, the robot's actual speeds. Out: the speeds to
//! command next.
//!
//! 1. The window: forward speeds and turn rates within what the motors can change in
//!    [`PERIOD`].
//! 2. Each pair is an arc; its free distance is where the robot's disc would first touch a point,
//!    exactly ([`free_on_arc`]).
//! 3. A pair is admissible if the robot can stop within that distance: v t + v²/(2 a), with safe
//!    mode's reaction and braking. Its speed is then limited by [`super::limit_among_walkers`], as
//!    safe mode would do anyway.
//! 4. Of those the one with the greatest G = α heading + β distance + γ speed is taken, each term
//!    between 0 and 1: how well the robot will face the point on its way, how far the arc is free,
//!    how fast it is.
//!
//! The free distance of an arc keeps an additional [`BERTH`] from people: passing them nearer would
//! slow the robot down.
//!
//! Source: Fox, Burgard & Thrun (1997), "The dynamic window approach to collision avoidance", eqs.
//! (13) to (16), without smoothing; the reaction time is ours.

use std::f64::consts::{PI, TAU};

use nalgebra::{Point2, Vector2};

use super::safe::{Limits, Speeds, Underway};
use super::separation::limit_among_walkers;
use super::strip::{arc, points_within};
use crate::geom::{Length, wrap};
use crate::points::Points;
use crate::robot::RobotModel;

/// What the pilot does about people who block its way.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Avoidance {
    /// It keeps to its way, slows down, waits, and plans again.
    #[default]
    KeepsToWay,
    /// The same, but it leaves its way by the dynamic window while a walker holds it up.
    DynamicWindow,
}

impl Avoidance {
    /// All variants, with their names in settings and their names for people.
    pub const ALL: [(&'static str, Self, &'static str); 2] = [
        ("keep-to-way", Self::KeepsToWay, "keeps to its way"),
        ("dynamic-window", Self::DynamicWindow, "dynamic window"),
    ];
}

/// Time after which the chosen speeds are reached, s, as in the paper. Larger: a wider window.
const PERIOD: f64 = 0.25;
/// α: weight of facing the point on the way, as in the paper. Larger: it stays nearer to its way.
const HEADING: f64 = 2.0;
/// β: weight of a free arc. Larger: it makes wider turns around people.
const DISTANCE: f64 = 0.2;
/// γ: weight of speed. Larger: it prefers passing to waiting.
const SPEED: f64 = 0.2;
/// An arc that is free for this distance counts as fully free, m.
const FAR: f64 = 2.0;
/// Additional room that an arc keeps from people, beyond that from things, m.
const BERTH: f64 = 0.4;
/// Speeds and turn rates that are tried: this many of each.
const SPEEDS: u32 = 5;
const TURNS: u32 = 15;
/// Curvatures below this make a straight line, rad/m.
const STRAIGHT: f64 = 1e-6;

/// The points around, robot frame of the last scan, m.
#[derive(Clone, Copy, Debug)]
pub struct People<'a> {
    /// All points.
    pub points: &'a Points,
    /// Those of walkers.
    pub walkers: &'a [Point2<f64>],
}

/// The speeds (m/s, rad/s) with the greatest G for a robot that wants to `aim` (robot frame, m);
/// `None` if none is admissible.
#[must_use]
pub fn choose_in_window(
    aim: Point2<f64>,
    around: &People,
    underway: &Underway,
    (model, safe): Limits,
) -> Option<Speeds> {
    let radius = model.radius() + safe.gap;
    let near = points_within(around.points, &underway.since_scan, radius + FAR);
    let robot_from_scan = underway.since_scan.inverse();
    let people: Vec<Point2<f64>> = (around.walkers.iter())
        .map(|walker| robot_from_scan * *walker)
        .collect();
    let braking = safe.braking_of(model.max_acceleration);
    let mut best: Option<(f64, Speeds)> = None;
    for (forward, turn) in window(underway.runs, model) {
        let free = free_on_arc((forward, turn), &near, radius, FAR);
        if braking.way(forward) > free {
            continue;
        }
        let wish = (forward, turn);
        let (forward, _) = limit_among_walkers(wish, around.walkers, underway, (model, safe));
        let apart = radius + BERTH;
        let free = free_on_arc((forward, turn), &people, apart, FAR).min(free);
        let off = heading_error(aim, (forward, turn), model);
        let value =
            HEADING * (1.0 - off / PI) + DISTANCE * free / FAR + SPEED * forward / model.max_speed;
        if best.is_none_or(|(most, _)| value > most) {
            best = Some((value, (forward, turn)));
        }
    }
    best.map(|(_, speeds)| speeds)
}

/// Step 1: pairs that cover the window, forward only.
fn window((forward, turn): Speeds, model: &RobotModel) -> impl Iterator<Item = Speeds> {
    let over = |at: f64, by: f64, [least, most]: [f64; 2], number: u32| {
        let (low, high) = ((at - by).clamp(least, most), (at + by).clamp(least, most));
        move |i: u32| low + (high - low) * f64::from(i) / f64::from(number - 1)
    };
    let (speed_change, turn_change) = (
        model.max_acceleration * PERIOD,
        model.max_turn_acceleration * PERIOD,
    );
    let most_turn = model.max_turn_rate;
    let speeds = over(forward, speed_change, [0.0, model.max_speed], SPEEDS);
    let turns = over(turn, turn_change, [-most_turn, most_turn], TURNS);
    (0..SPEEDS).flat_map(move |i| {
        let (speed, turns) = (speeds(i), turns);
        (0..TURNS).map(move |j| (speed, turns(j)))
    })
}

/// By what angle the robot will not face `aim`, once it has driven like this for [`PERIOD`] and
/// stopped turning, rad.
fn heading_error(aim: Point2<f64>, (forward, turn): Speeds, model: &RobotModel) -> f64 {
    let at = arc(forward * PERIOD, turn * PERIOD);
    let turned = turn * PERIOD + turn * turn.abs() / (2.0 * model.max_turn_acceleration);
    let to: Vector2<f64> = aim - at;
    wrap(libm::atan2(to.y, to.x) - turned).abs()
}

/// How far a disc of `radius` moves forward on the arc of the speeds until it touches one of the
/// points, m; at most `most`. A point within the disc stops it at once if it is in front, or to the
/// side beyond the arc's centre: the disc would come round to it. Otherwise the disc moves away
/// from it.
///
/// The centre of the disc is at distance ρ = v/ω of the arc's centre, a point at distance d; they
/// are `radius` apart when the angle between them has cosine (ρ² + d² − radius²) / (2 ρ d).
fn free_on_arc((forward, turn): Speeds, points: &[Point2<f64>], radius: f64, most: f64) -> f64 {
    if forward <= 0.0 {
        return 0.0;
    }
    let bend = turn / forward;
    let touches = points.iter().filter_map(|point| {
        if point.coords.length() < radius {
            return (point.x > 0.0 || bend * point.y > 1.0).then_some(0.0);
        }
        if bend.abs() < STRAIGHT {
            let ahead = (radius * radius - point.y * point.y).max(0.0).sqrt();
            return (point.y.abs() < radius && point.x > 0.0).then_some(point.x - ahead);
        }
        // The point as seen by a robot that turns to the left.
        let rho = 1.0 / bend.abs();
        let from_centre = Vector2::new(point.x, point.y * bend.signum() - rho);
        let distance = from_centre.length();
        let cosine = (rho * rho + distance * distance - radius * radius) / (2.0 * rho * distance);
        if cosine.abs() > 1.0 {
            return None;
        }
        let at_point = libm::atan2(from_centre.x, -from_centre.y);
        Some(rho * (at_point - libm::acos(cosine)).rem_euclid(TAU))
    });
    touches.fold(most, f64::min)
}

#[cfg(test)]
mod tests;
