//! The strip that a robot's disc sweeps, and the points in it.
//!
//! In: the points of a scan, the arc of two speeds. Out: how far the disc moves along it before it
//! touches a point.
//!
//! 1. The disc goes along the arc in steps of a centimetre, and may grow with the distance.
//! 2. A point is touched when the disc reaches it and comes nearer to it; points that the disc
//!    moves away from are not in its way.
//! 3. Beside a wall ([`Strip::beside_wall`]) the disc is shrunk to the room that it has now, points
//!    beside it may come a little nearer, and because of noise single points do not count, except
//!    one that the robot itself would touch: it may be a thin post. This does not apply when
//!    something in front is already too near.

use nalgebra::Point2;

use super::safe::Speeds;
use crate::geom::{Length, Pose2};
use crate::points::Points;

/// Step along the arc, m.
const STEP: f64 = 0.01;
/// How much nearer the robot may come to points of a wall that it stands beside, m: they scatter by
/// as much.
const SCATTER: f64 = 0.01;
/// Above this room points may come nearer by [`SCATTER`], m; and the least room that all points
/// keep, m.
pub(super) const TIGHT: f64 = 0.02;
pub(super) const LEAST: f64 = 0.01;
/// Beside a wall this many points at once are needed to touch it: single ones are noise.
const SEVERAL: usize = 3;
/// What lies within 45° of the driving direction is in front: the cosine. One point is enough.
const IN_FRONT: f64 = 0.71;
/// A wall whose points, weighted by their depth, lie less than 70° from the driving direction on
/// average is in front as well: the cosine. Along it the robot would come nearer by a third of the
/// distance driven.
const ASLANT: f64 = 0.35;

/// How far a disc of `radius` moves along the arc of the given speeds before it touches a point of
/// the scan, m; `most` if it does not.
#[must_use]
pub fn free_distance(
    speeds: Speeds,
    points: &Points,
    robot_at_scan_from_robot: &Pose2,
    radius: f64,
    most: f64,
) -> f64 {
    let strip = Strip {
        radius,
        spread: 0.0,
        least: None,
    };
    let near = strip.near(points, robot_at_scan_from_robot, most);
    strip.free_distance(speeds, &near, most)
}

/// The swept area: a disc that grows with the distance.
#[derive(Clone, Copy, Debug)]
pub(super) struct Strip {
    /// Radius at the beginning, m.
    pub(super) radius: f64,
    /// Growth of the radius with the distance, m/m.
    pub(super) spread: f64,
    /// Beside a wall, where points may come a little nearer: the distance that they keep
    /// nevertheless, m.
    pub(super) least: Option<f64>,
}

impl Strip {
    /// Points that the disc may touch within `most` metres, in the current robot frame.
    pub(super) fn near(
        &self,
        points: &Points,
        robot_at_scan_from_robot: &Pose2,
        most: f64,
    ) -> Vec<Point2<f64>> {
        let reach = most + self.radius + self.spread * most;
        points_within(points, robot_at_scan_from_robot, reach)
    }

    /// How far the disc moves before it touches one of the points, m.
    pub(super) fn free_distance(
        &self,
        (forward, turn): Speeds,
        near: &[Point2<f64>],
        most: f64,
    ) -> f64 {
        if near.is_empty() || forward == 0.0 || most.is_nan() || most <= 0.0 {
            return most.max(0.0);
        }
        let steps = (most / STEP).ceil().clamp(1.0, 1e3) as usize;
        let motion_of = |distance: f64| {
            let time = distance / forward.abs();
            arc(forward * time, turn * time)
        };
        let first: Vec<f64> = near.iter().map(|p| p.coords.length()).collect();
        let mut before = first.clone();
        let enough = if self.least.is_some() { SEVERAL } else { 1 };
        let body = self.least.map_or(0.0, |least| least - LEAST);
        let is_near = |now: f64, first: f64| {
            let least = self.least.unwrap_or(f64::INFINITY);
            now < least || now < first - SCATTER
        };
        for step in 1..=steps {
            let distance = most * step as f64 / steps as f64;
            let at = motion_of(distance);
            let radius = self.radius + self.spread * distance;
            let (mut touched, mut is_hit) = (0, false);
            for ((point, before), first) in near.iter().zip(&mut before).zip(&first) {
                let now = (point - at).length();
                if now < radius && now < *before - 1e-9 && is_near(now, *first) {
                    touched += 1;
                    is_hit |= now < body;
                }
                *before = now;
            }
            if touched >= enough || is_hit {
                return most * (step - 1) as f64 / steps as f64;
            }
        }
        most
    }

    /// The strip of a robot (with a disc of `radius`) that stands nearer to a wall than this strip
    /// allows; `None` if that wall is in front of it as it drives `forward`.
    pub(super) fn beside_wall(
        &self,
        near: &[Point2<f64>],
        forward: f64,
        radius: f64,
    ) -> Option<Self> {
        let mut nearest = f64::INFINITY;
        // Left and right: sums of depths, and of their components in front.
        let mut sides = [(0.0, 0.0); 2];
        for point in near {
            let distance = point.coords.length();
            nearest = nearest.min(distance);
            let depth = self.radius - distance;
            if depth <= 0.0 {
                continue;
            }
            let ahead = point.x * forward.signum() / distance.max(1e-9);
            if ahead > IN_FRONT {
                return None;
            }
            let (depths, in_front) = &mut sides[usize::from(point.y < 0.0)];
            *depths += depth;
            *in_front += depth * ahead;
        }
        if sides
            .iter()
            .any(|(depths, in_front)| *in_front > ASLANT * depths)
        {
            return None;
        }
        let tight = self.radius.min(radius + TIGHT);
        Some(Self {
            radius: (nearest - SCATTER).clamp(tight, self.radius),
            spread: 0.0,
            least: Some(radius + LEAST),
        })
    }
}

/// Points of the scan within `reach` of the robot, in its current frame.
pub(super) fn points_within(
    points: &Points,
    robot_at_scan_from_robot: &Pose2,
    reach: f64,
) -> Vec<Point2<f64>> {
    let robot_from_scan = robot_at_scan_from_robot.inverse();
    let ends = (points.hits()).map(|beam| robot_from_scan * beam.end_in_robot);
    ends.filter(|p| p.coords.norm_squared() < reach * reach)
        .collect()
}

/// Where an arc of the given length and turn ends.
pub(super) fn arc(length: f64, turn: f64) -> Point2<f64> {
    let (sin, cos) = crate::geom::sin_cos(0.5 * turn);
    // Chord of the arc: length sin(turn/2)/(turn/2), in direction turn/2.
    let chord = if turn.abs() < 1e-9 {
        length
    } else {
        length * sin / (0.5 * turn)
    };
    Point2::new(chord * cos, chord * sin)
}
