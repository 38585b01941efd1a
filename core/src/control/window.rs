//! The dynamic window: of all speeds that the robot can have a moment from now, those that bring it
//! nearest to its way and keep it free.
//!
//! In: a point on the way ahead, what stands around, the speeds at which the robot runs. Out: the
//! speeds to command next.
//!
//! 1. The window: forward speeds and turn rates within what the motors can change in
//!    [`PERIOD`].
//! 2. Each pair is an arc; its free distance is where the robot's disc would first touch a point,
//!    exactly ([`free_on_arc`]).
//! 3. A pair is admissible if the robot can stand within that distance: v t + v²/(2 a), with safe
//!    mode's reaction and braking. Its speed then is what [`super::limit_among_walkers`] leaves of
//!    it: who may walk on would cut it to that anyway.
//! 4. Of those the one with the greatest G = α heading + β distance + γ speed is taken, each term
//!    between 0 and 1: how straight the robot will look at the point on its way, how far the arc is
//!    free, how fast it is.
//!
//! The free distance of an arc keeps off people by [`BERTH`] more: who passes them
//! nearer is slowed down by them.
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

/// What the pilot does about people in its way.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Avoidance {
    /// Keeps to its way, slows down, waits, and plans again.
    #[default]
    KeepsToWay,
    /// The same, but leaves its way by the dynamic window while somebody who walks about holds it
    /// up.
    DynamicWindow,
}

impl Avoidance {
    /// All of them, with the names used by settings, and what a person calls them.
    pub const ALL: [(&'static str, Self, &'static str); 2] = [
        ("keep-to-way", Self::KeepsToWay, "keeps to its way"),
        ("dynamic-window", Self::DynamicWindow, "dynamic window"),
    ];
}

/// Time after which the speeds that are chosen hold, s, as in the paper. Larger: a wider window.
const PERIOD: f64 = 0.25;
/// α: of looking at the point on the way, as in the paper. Larger: it stays nearer to its way.
const HEADING: f64 = 2.0;
/// β: of a free arc. Larger: it makes wider turns around people.
const DISTANCE: f64 = 0.2;
/// γ: of speed. Larger: it would rather go past than wait.
const SPEED: f64 = 0.2;
/// What is free for so long a way is free, m.
const FAR: f64 = 2.0;
/// Room that an arc keeps to people beyond that to things to count as free, m.
const BERTH: f64 = 0.4;
/// Speeds and turn rates that are tried: so many of either.
const SPEEDS: u32 = 5;
const TURNS: u32 = 15;
/// Turn rates below this make a straight line, rad/m.
const STRAIGHT: f64 = 1e-6;

/// What stands around, robot frame of the last scan, m.
#[derive(Clone, Copy, Debug)]
pub struct People<'a> {
    /// All points.
    pub points: &'a Points,
    /// Those of who walks.
    pub walkers: &'a [Point2<f64>],
}

/// The speeds (m/s, rad/s) with the greatest G for a robot that wants to `aim` (robot frame, m);
/// `None` where none is admissible.
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

/// Step 1: pairs all over the window, forward only.
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

/// By how much the robot will not look at `aim`, once it has run so for `period` and stopped
/// turning, rad.
fn heading_error(aim: Point2<f64>, (forward, turn): Speeds, model: &RobotModel) -> f64 {
    let at = arc(forward * PERIOD, turn * PERIOD);
    let turned = turn * PERIOD + turn * turn.abs() / (2.0 * model.max_turn_acceleration);
    let to: Vector2<f64> = aim - at;
    wrap(libm::atan2(to.y, to.x) - turned).abs()
}

/// How far a disc of `radius` moves forward on the arc of the speeds until it touches one of the
/// points, m; at most `most`. A point within the disc stops it at once where it is in front, or
/// beside and farther in than the arc's centre: the disc would come round to it. Else it is left
/// behind.
///
/// The middle of the disc is at distance ρ = v/ω of the arc's centre, a point at distance d; they
/// are `radius` apart where the angle between them has cosine (ρ² + d² − radius²) / (2 ρ d).
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
        // As if it turned to the left.
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
