//! Safe mode by the robot's outline: for ways through which the disc around it does not fit.
//!
//! In: the requested speeds, the last scan's points, the robot's actual speeds, its outline. Out:
//! speeds that stop before contact.
//!
//! 1. Turning: the outline is turned in steps of 2° over the angle that the robot needs to stop;
//!    the rate is limited so that it stops before a point comes into the outline. Unlike a disc, an
//!    outline can touch by turning alone.
//! 2. Driving: the outline is moved along the arcs of [`super::safe`], in steps of a centimetre.
//!    The first point that comes into it gives the free distance, and the speed follows from that
//!    as for the disc.
//! 3. Both are done with the gap around the outline; if that leaves no speed, the robot creeps with
//!    a centimetre around it, because points of door posts scatter. A point that is already nearer
//!    may come a little nearer, but never nearer than 5 mm to the body: a bound that is taken anew
//!    at each tick would let the robot creep into a wall, tick by tick.

use nalgebra::Point2;

use super::safe::{CREEP, Limits, Speeds, Underway, within_model};
use super::strip::{LEAST, arc, points_within};
use crate::geom::{Footprint, Pose2};
use crate::points::Points;
use crate::robot::RobotModel;

/// Steps along an arc, m, and of a turn, rad.
const STEP: f64 = 0.01;
const TURN_STEP: f64 = 0.035;
/// Points scatter: one that is already in the way may come nearer by this much, m, but to the body
/// no nearer than the same.
const SCATTER: f64 = 0.005;
/// A point that the outline moves away from or along may come nearer by rounding, m.
const ROUNDING: f64 = 1e-9;
/// With next to no room the robot turns no faster than this, rad/s.
const SLOW_TURN: f64 = 0.2;

/// The speeds (m/s, rad/s) that are safe for an outline, or for the disc if the robot is one.
#[must_use]
pub fn limit_outline(wish: Speeds, points: &Points, underway: &Underway, limits: Limits) -> Speeds {
    let (model, config) = limits;
    let grown = Grown::new(model, config.gap).zip(Grown::new(model, LEAST.min(config.gap)));
    let Some((wide, tight)) = grown else {
        return super::limit_speed(wish, points, underway, limits);
    };
    let (forward, turn) = within_model(wish, model);
    let near_within = |most: f64| {
        let reach = most + wide.outline.radius_around();
        points_within(points, &underway.since_scan, reach)
    };
    let turn = limit_turn(turn, &near_within(0.0), [&wide, &tight], limits);
    if forward == 0.0 {
        return (0.0, turn);
    }
    let braking = config.braking_of(model.max_acceleration);
    let longest = braking.way(forward);
    let near = near_within(longest);
    let runs = (underway.runs.0 * forward > 0.0).then_some(underway.runs);
    let arcs = underway.turns(turn).map(|turn| (forward, turn));
    let free = |outline: &Grown| {
        let arcs = arcs.iter().copied().chain(runs);
        arcs.map(|arc| free_distance(outline, arc, &near, longest))
            .fold(longest, f64::min)
    };
    let speed_for = |free: f64| braking.speed_within(free, forward, longest);
    let mut speed = speed_for(free(&wide));
    if speed < CREEP.min(forward.abs()) {
        speed = speed_for(free(&tight)).min(CREEP).max(speed);
    }
    (speed.copysign(forward), turn)
}

fn limit_turn(
    turn: f64,
    near: &[Point2<f64>],
    [wide, tight]: [&Grown; 2],
    (model, config): Limits,
) -> f64 {
    let braking = config.braking_of(model.max_turn_acceleration);
    let longest = braking.way(turn);
    if turn == 0.0 || near.is_empty() {
        return turn;
    }
    let rate_for = |outline: &Grown| {
        let steps = (longest / TURN_STEP).ceil().max(1.0);
        let pose_at = |part: f64| Pose2::new(0.0, 0.0, part * longest.copysign(turn));
        let free = match outline.free_steps(near, steps as usize, pose_at) {
            done if done >= steps as usize => longest,
            done => longest * done as f64 / steps,
        };
        braking.speed_within(free, turn, longest)
    };
    let mut rate = rate_for(wide);
    if rate < SLOW_TURN.min(turn.abs()) {
        rate = rate_for(tight).min(SLOW_TURN).max(rate);
    }
    rate.copysign(turn)
}

/// How far the outline moves along the arc of two speeds before a point comes into it, m.
fn free_distance(outline: &Grown, (forward, turn): Speeds, near: &[Point2<f64>], most: f64) -> f64 {
    let steps = (most / STEP).ceil().clamp(1.0, 1e3);
    let pose_at = |part: f64| {
        let time = part * most / forward.abs();
        let at = arc(forward * time, turn * time);
        Pose2::new(at.x, at.y, turn * time)
    };
    most * outline.free_steps(near, steps as usize, pose_at) as f64 / steps
}

/// The robot's outline with a margin around it.
struct Grown {
    outline: Footprint,
    /// Margin, m.
    margin: f64,
}

impl Grown {
    /// `None` for a disc.
    fn new(model: &RobotModel, margin: f64) -> Option<Self> {
        let outline = model.outline(margin)?;
        Some(Self { outline, margin })
    }

    /// How many of the steps can be done before a point comes into the outline, or goes deeper into
    /// it by more than points scatter.
    fn free_steps(
        &self,
        near: &[Point2<f64>],
        steps: usize,
        pose_at: impl Fn(f64) -> Pose2,
    ) -> usize {
        let first: Vec<f64> = near.iter().map(|p| self.outline.distance(*p)).collect();
        let deepest = (SCATTER - self.margin).min(0.0);
        let is_free = |step: &usize| {
            let robot = pose_at(*step as f64 / steps as f64).inverse();
            near.iter().zip(&first).all(|(point, &first)| {
                let now = self.outline.distance(robot * *point);
                let least = (first - SCATTER).max(deepest).min(first - ROUNDING);
                now >= least.min(0.0)
            })
        };
        (1..=steps).take_while(is_free).count()
    }
}

#[cfg(test)]
mod tests;
