//! Pure pursuit (Coulter 1992): following a rounded path without stopping at its corners.
//!
//! In: straight pieces, arcs and turns on the spot that join without a kink, and the pose estimate
//! at every tick. Out: forward speed and turn rate, until the last piece ends.
//!
//! 1. The pieces are grouped into runs, each of which is driven without a stop; a turn on the spot
//!    separates two runs, unless it is so small that it can be driven over. A run begins with a
//!    turn towards its beginning.
//! 2. The robot's place on the run is the nearest point a little ahead of its last place: it never
//!    jumps to another part of the run that passes nearby.
//! 3. The robot aims along a circle at a point ahead on the run: turn rate 2 v sin(error) /
//!    distance (pure pursuit, Coulter 1992). The faster the robot may go there, the farther ahead
//!    the point is, because the turn rate takes time to change: with a point too near the robot
//!    would oscillate more and more. In arcs it is nearer, so the robot does not cut them.
//! 4. The speed is limited so that the turn rate of every arc ahead can be driven, braking for it
//!    in time; and it ends in a braking curve as for straight legs.

use nalgebra::Point2;

use super::follow::{BRAKING, FollowConfig, turn_rate, turns_on_spot};
use super::safe::Speeds;
use crate::geom::{Length, Pose2, wrap};
use crate::plan::{Path, Piece};
use crate::robot::RobotModel;

/// Distance between the points of a run, m.
const SPACING: f64 = 0.02;
/// How far ahead of its last place the robot's place on the run is searched for, m.
const WINDOW: f64 = 0.4;
/// Aim point in an arc, as a fraction of the arc's radius ahead: it cuts an arc by about 4 % of its
/// radius.
const AIM_PART: f64 = 0.6;
/// The aim point is at least as far ahead as the robot drives in this time, s.
const HEADWAY: f64 = 0.8;
/// Turns on the spot smaller than this, rad, are driven over, as if they took this distance, m.
const KINK: f64 = 0.35;
const KINK_WAY: f64 = 0.15;
/// Fraction of the highest turn rate with which arcs are driven: the rest is for returning to the
/// run.
const TURN_PART: f64 = 0.7;

#[derive(Clone, Copy, Debug)]
struct Place {
    at: Point2<f64>,
    /// Distance from the beginning of the run, m.
    way: f64,
    /// Absolute curvature, 1/m.
    curvature: f64,
}

/// Follows one rounded path.
#[derive(Clone, Debug)]
pub struct CurveFollower {
    runs: Vec<Vec<Place>>,
    run: usize,
    place: usize,
    is_turning: bool,
}

impl CurveFollower {
    /// A follower for pieces in driving order.
    #[must_use]
    pub fn new(pieces: &[Piece]) -> Self {
        let is_turn =
            |piece: &Piece| matches!(piece, Piece::Turn { turn, .. } if turn.abs() > KINK);
        let runs = pieces.split(is_turn).map(places_of);
        Self {
            runs: runs.filter(|run| run.len() > 1).collect(),
            run: 0,
            place: 0,
            is_turning: true,
        }
    }

    /// The path that is still to be driven, from the robot's place on.
    #[must_use]
    pub fn remaining(&self) -> Path {
        let rest = self.runs.get(self.run..).unwrap_or_default();
        let skipped = |number: usize| if number == 0 { self.place } else { 0 };
        let places = rest
            .iter()
            .enumerate()
            .flat_map(|(number, run)| run.iter().skip(skipped(number)));
        let points = places.map(|place| place.at).collect();
        Path { points }
    }

    /// The speeds for this tick, m/s and rad/s; `None` when the path has been driven.
    pub fn steer(
        &mut self,
        pose: &Pose2,
        model: &RobotModel,
        config: &FollowConfig,
    ) -> Option<Speeds> {
        while let Some(run) = self.runs.get(self.run) {
            self.place = nearest(run, self.place, pose.position());
            let left = way_left(run, self.place, pose.position());
            if left > config.tolerance {
                return self.along(left, pose, model, config);
            }
            self.run += 1;
            self.place = 0;
            self.is_turning = true;
        }
        None
    }

    fn along(
        &mut self,
        left: f64,
        pose: &Pose2,
        model: &RobotModel,
        config: &FollowConfig,
    ) -> Option<Speeds> {
        let run = &self.runs[self.run];
        let here = run[self.place];
        let fastest = speed(run, self.place, left, model, config);
        let ahead = config.look_ahead.max(HEADWAY * fastest);
        let sharpest = sharpest(run, self.place, ahead);
        let aim = aim(run, here.way + ahead.min(AIM_PART / sharpest.max(1e-9)));
        let to_aim = aim - pose.position();
        let distance = to_aim.length().max(1e-3);
        let error = wrap(libm::atan2(to_aim.y, to_aim.x) - pose.heading());
        self.is_turning = turns_on_spot(self.is_turning, error);
        if self.is_turning {
            let turn = turn_rate(error, model, config);
            return Some((0.0, turn));
        }
        let (sin, _) = crate::geom::sin_cos(error);
        let bend = 2.0 * sin / distance;
        let most_turn = config.pace * model.max_turn_rate;
        let forward = fastest.min(most_turn / bend.abs().max(1e-9));
        Some((forward, (forward * bend).clamp(-most_turn, most_turn)))
    }
}

/// Points of a run, the ends of all pieces among them.
fn places_of(pieces: &[Piece]) -> Vec<Place> {
    let mut places: Vec<Place> = vec![];
    let mut way = 0.0;
    for piece in pieces {
        if let (Piece::Turn { turn, .. }, Some(last)) = (piece, places.last_mut()) {
            last.curvature = last.curvature.max(turn.abs() / KINK_WAY);
        }
        if piece.length() <= 1e-6 {
            continue;
        }
        let curvature = match piece {
            Piece::Arc { radius, .. } => 1.0 / radius.max(1e-6),
            _ => 0.0,
        };
        let count = (piece.length() / SPACING).ceil().max(1.0) as usize;
        let first = usize::from(!places.is_empty());
        for i in first..=count {
            let part = i as f64 / count as f64;
            places.push(Place {
                at: piece.point(part),
                way: way + part * piece.length(),
                curvature,
            });
        }
        way += piece.length();
    }
    places
}

fn nearest(run: &[Place], from: usize, position: Point2<f64>) -> usize {
    let last = run[from].way + WINDOW;
    let near = (from..run.len()).take_while(|&i| run[i].way <= last);
    let off = |i: &usize| (run[*i].at - position).norm_squared();
    near.min_by(|a, b| off(a).total_cmp(&off(b)))
        .unwrap_or(from)
}

/// Distance to the end of the run, m; near its last point measured along its direction, and
/// negative beyond.
fn way_left(run: &[Place], place: usize, position: Point2<f64>) -> f64 {
    let last = run[run.len() - 1];
    if place + 1 < run.len() {
        return last.way - run[place].way;
    }
    let along = last.at - run[run.len() - 2].at;
    (last.at - position).dot(&along) / along.length().max(1e-9)
}

/// The greatest curvature within `ahead` metres.
fn sharpest(run: &[Place], from: usize, ahead: f64) -> f64 {
    let until = run[from].way + ahead;
    let near = run[from..].iter().take_while(|place| place.way <= until);
    near.map(|place| place.curvature).fold(0.0, f64::max)
}

/// The point at a distance along the run; straight on beyond its end.
fn aim(run: &[Place], way: f64) -> Point2<f64> {
    let next = run.partition_point(|place| place.way < way);
    let (a, b) = match next {
        0 => (run[0], run[1]),
        n if n < run.len() => (run[n - 1], run[n]),
        _ => (run[run.len() - 2], run[run.len() - 1]),
    };
    a.at + (b.at - a.at) * ((way - a.way) / (b.way - a.way).max(1e-9))
}

/// The speed from which the robot can brake for every arc ahead, and for the end.
fn speed(run: &[Place], from: usize, left: f64, model: &RobotModel, config: &FollowConfig) -> f64 {
    let brake = BRAKING * model.max_acceleration;
    let most = config.pace * model.max_speed;
    let turn = TURN_PART * config.pace * model.max_turn_rate;
    let left = left.max(0.0);
    let mut speed = most.min((2.0 * brake * left).sqrt()).min(2.0 * left + 0.01);
    let begin = run[from].way;
    for place in &run[from..] {
        let ahead = place.way - begin;
        if 2.0 * brake * ahead > most * most {
            break;
        }
        let there = turn / place.curvature.max(1e-9);
        speed = speed.min((there * there + 2.0 * brake * ahead).sqrt());
    }
    speed
}

#[cfg(test)]
mod tests;
