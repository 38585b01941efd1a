//! Walkers: something stands where there was free space just before.
//!
//! In: each scan's points and the motion since the previous scan. Out: those points of the newest
//! scan that belong to a walker, or to one who stopped a few seconds ago and may walk on.
//!
//! 1. Correct the motion since the previous scan by the turn that odometry missed ([`turn`]).
//!    Slipping tracks turn a robot by five degrees in half a metre straight on, and then every wall
//!    at a flat angle would seem to walk.
//! 2. A hit has entered free space if an older scan saw past it: all its beams in that direction,
//!    and a little to each side for the error of odometry since, ended behind it. What was hidden
//!    then, or lay in a gap between beams, has not entered. The beams of a moving robot do not
//!    start at one place, so each is compared from its own origin; otherwise every edge that comes
//!    into sight would seem to walk.
//! 3. Two such hits beside each other, in two scans, mark a place where somebody walks. A single
//!    hit may be noise.
//! 4. Hits near such a place belong to it. The place is forgotten when nothing is near it any more,
//!    and at the latest [`MEMORY`] after somebody was last seen to walk there (a second for each
//!    scan that saw them walk): somebody who paused may walk on, and something that only seemed to
//!    move is soon forgotten.
//!
//! A sensor that sweeps only when the robot stands is too slow for this; [`Walkers::partial_scan`]
//! compares single readings on the move with its last scan.
//!
//! A robot that turns by half a radian a second or more sees only fast walkers: its heading is too
//! uncertain to see others.
//!
//! Ours; step 2 is the visibility test by which Lindström & Eklundh (2001), "Detecting and tracking
//! moving objects from a mobile platform using a laser range scanner", find what violates free
//! space.

mod partial_scan;
mod turn;

use std::collections::VecDeque;
use std::f64::consts::{PI, TAU};

use nalgebra::{Point2, Vector2};

use super::{Beam, Points};
use crate::geom::{Length, Pose2, sin_cos};
use crate::robot::Stamp;

/// Range within which walkers are searched for, m: a robot must know of them there to stop in time.
const REACH: f64 = 4.0;
/// How far an older beam has to extend behind a hit, m: eight times a lidar's noise. Larger: slow
/// walkers are seen later.
const BEHIND: f64 = 0.08;
/// Hits this near to a place where somebody walked belong to that walker, m: about the radius of a
/// person.
const SIZE: f64 = 0.3;
/// A walker who stands still may walk on for this long, s: people in each other's way stand for
/// more than five, and then step aside.
const MEMORY: f64 = 15.0;
/// Number of scans kept for comparison: two thirds of a second of a lidar at 5.5 Hz.
const KEPT: usize = 3;
/// Greatest age of a scan for comparison, s: a sensor that scans on command is too slow.
const OLDEST: f64 = 1.0;
/// Beams farther apart than this give no picture of free space, rad.
const COARSE: f64 = 0.06;
/// Possible error of odometry: a fraction of the distance; and in a turn, with errors that grow
/// with its root: four and a half standard deviations for tracks that slip by 5e-3 rad²/rad.
const DRIFT: f64 = 0.06;
const TURN_DRIFT: f64 = 0.32;
/// Possible turn by slip of a robot that drives straight on: as many standard deviations, which
/// grow with the root of the distance (1e-3 m²/m for each of two tracks 0.33 m apart), rad for the
/// first metre.
const WAY_DRIFT: f64 = 0.61;
/// A walker is remembered for this long for each scan that saw them walk, s: after few scans it may
/// have been an error of the odometry.
const PER_SIGHTING: f64 = 1.0;
/// Number of scans that must have seen somebody walk: a single one may be an error of the odometry.
const CONFIRMED: u32 = 2;
/// Widest window of directions that is compared, to each side, rad.
const SEAM: f64 = 0.5;
/// Least distance from the sensor that is used, m: anything nearer counts as this far.
const NEAR: f64 = 0.1;
/// Least number of beams that have to look past a hit, and least fraction of those that fit there:
/// the sweep of a turning robot leaves directions out.
const LEAST_BEAMS: f64 = 3.0;
const COVERED: f64 = 0.7;

/// Finds walkers; by default none were seen yet.
#[derive(Clone, Debug, Default)]
pub struct Walkers {
    /// Older scans, the newest at the back.
    past: VecDeque<Past>,
    places: Vec<Place>,
    /// Walkers that single readings found since the last scan.
    newcomers: Vec<partial_scan::Newcomer>,
    points: Vec<Point2<f64>>,
}

/// An older scan.
#[derive(Clone, Debug)]
struct Past {
    stamp: Stamp,
    /// `robot_now_from_robot_then`.
    now_from_then: Pose2,
    sensor: Point2<f64>,
    hits: Vec<Point2<f64>>,
    /// Beams by bearing; those within [`SEAM`] of ±π appear twice, a full turn apart.
    beams: Vec<PastBeam>,
    spacing: f64,
    /// How far from `sensor` beams began, because the robot drove during the sweep, m.
    parallax: f64,
}

/// A beam of an older scan, from its origin.
#[derive(Clone, Copy, Debug)]
struct PastBeam {
    bearing: f64,
    origin: Point2<f64>,
    /// Unit direction.
    along: Vector2<f64>,
    range: f64,
}

/// Where somebody walked, in the current robot frame, and when.
#[derive(Clone, Copy, Debug)]
struct Place {
    at: Point2<f64>,
    walked: Stamp,
    /// Number of scans that saw it.
    sightings: u32,
}

impl Walkers {
    /// Takes a scan's points, and the motion since the scan before (`robot_before_from_robot_now`).
    pub fn update(&mut self, points: &Points, moved: &Pose2) {
        let is_recent = |past: &Past| points.stamp.since(past.stamp) <= OLDEST;
        self.past.retain(is_recent);
        let now_from_before = self.unreported_turn(points, moved) * moved.inverse();
        for past in &mut self.past {
            past.now_from_then = now_from_before * past.now_from_then;
        }
        for place in &mut self.places {
            place.at = now_from_before * place.at;
        }
        let near = |p: &Point2<f64>| (p - points.sensor_in_robot).length() < REACH;
        let hits: Vec<Point2<f64>> = points.hits().map(|b| b.end_in_robot).filter(near).collect();
        self.newcomers.clear();
        self.see_walking(&hits, points.stamp);
        self.keep_places(&hits, points.stamp);
        self.past.extend(Past::of(points));
        if self.past.len() > KEPT {
            self.past.pop_front();
        }
    }

    /// Points of walkers, and of people who may walk on, robot frame at the newest scan, m.
    #[must_use]
    pub fn points(&self) -> &[Point2<f64>] {
        &self.points
    }

    /// Step 1.
    fn unreported_turn(&self, points: &Points, moved: &Pose2) -> Pose2 {
        let Some(past) = self.past.back() else {
            return Pose2::identity();
        };
        let in_robot_before = past.hits.iter().map(|hit| past.now_from_then * *hit);
        unreported_turn(in_robot_before, moved, points)
    }

    /// Steps 2 and 3.
    fn see_walking(&mut self, hits: &[Point2<f64>], now: Stamp) {
        let looked_past = |hit| {
            let mut past = self.past.iter();
            past.any(|past| past.looked_past(hit, BEHIND, TURN_DRIFT))
        };
        let known = self.places.clone();
        let mut before: Option<Point2<f64>> = None;
        for hit in hits {
            let has_entered = looked_past(*hit);
            if has_entered && before.is_some_and(|b: Point2<f64>| (b - hit).length() < SIZE) {
                let near = known.iter().filter(|p| (p.at - hit).length() < 2.0 * SIZE);
                self.places.push(Place {
                    at: *hit,
                    walked: now,
                    sightings: 1 + near.map(|place| place.sightings).max().unwrap_or(0),
                });
            }
            before = has_entered.then_some(*hit);
        }
    }

    /// Step 4.
    fn keep_places(&mut self, hits: &[Point2<f64>], now: Stamp) {
        // Newest first, so that of coinciding places the one with the newest time is kept.
        self.places
            .sort_by_key(|place| std::cmp::Reverse(place.walked));
        let mut kept: Vec<Place> = vec![];
        for place in &self.places {
            let is_same = |other: &Place| (other.at - place.at).length() < 0.5 * SIZE;
            let is_there = hits.iter().any(|hit| (hit - place.at).length() < SIZE);
            let memory = MEMORY.min(PER_SIGHTING * f64::from(place.sightings));
            if now.since(place.walked) <= memory && is_there && !kept.iter().any(is_same) {
                kept.push(*place);
            }
        }
        self.places = kept;
        let is_theirs = |hit: &&Point2<f64>| {
            let mut places = self.places.iter().filter(|p| p.sightings >= CONFIRMED);
            places.any(|place| (place.at - **hit).length() < SIZE)
        };
        self.points = hits.iter().filter(is_theirs).copied().collect();
    }
}

impl Past {
    /// `None` for too few beams, or too coarse ones.
    fn of(points: &Points) -> Option<Self> {
        let sensor = points.sensor_in_robot;
        let by_bearing = |a: &PastBeam, b: &PastBeam| a.bearing.total_cmp(&b.bearing);
        let mut beams: Vec<PastBeam> = points.beams.iter().filter_map(PastBeam::of).collect();
        beams.sort_by(by_bearing);
        let gap = |pair: &[PastBeam]| pair[1].bearing - pair[0].bearing;
        let mut gaps: Vec<f64> = beams.windows(2).map(gap).collect();
        let middle = gaps.len() / 2;
        if (gaps.len() as f64) < LEAST_BEAMS {
            return None;
        }
        let (_, spacing, _) = gaps.select_nth_unstable_by(middle, f64::total_cmp);
        let spacing = *spacing;
        // Those near the seam at ±π appear on both sides of it.
        let round = beams.iter().filter(|beam| beam.bearing.abs() > PI - SEAM);
        let turned = |beam: &PastBeam| PastBeam {
            bearing: beam.bearing - beam.bearing.signum() * TAU,
            ..*beam
        };
        let again: Vec<PastBeam> = round.map(turned).collect();
        beams.extend(again);
        beams.sort_by(by_bearing);
        (spacing < COARSE).then(|| Self {
            stamp: points.stamp,
            now_from_then: Pose2::identity(),
            sensor,
            hits: points.hits().map(|beam| beam.end_in_robot).collect(),
            beams,
            spacing,
            parallax: parallax(points),
        })
    }

    /// Whether all beams towards a point (current robot frame) extended behind it, by `behind`
    /// metres. Odometry may err in a turn by `turn_drift` rad for the first radian.
    fn looked_past(&self, point: Point2<f64>, behind: f64, turn_drift: f64) -> bool {
        let point = self.now_from_then.inverse() * point;
        let to = point - self.sensor;
        let (distance, bearing) = (to.length().max(NEAR), libm::atan2(to.y, to.x));
        let moved = &self.now_from_then;
        let (turned, way) = (moved.heading().abs(), moved.position().coords.length());
        let blur = DRIFT * way;
        let half = 1.6 * self.spacing + turn_drift * turned.sqrt() + blur / distance;
        let half = half.min(SEAM);
        let (sin_half, _) = sin_cos(half);
        let window = (half + self.parallax / distance).min(SEAM);
        let first = self
            .beams
            .partition_point(|beam| beam.bearing < bearing - window);
        let (mut beside, beams) = (0, 2.0 * half / self.spacing);
        for beam in &self.beams[first..] {
            if beam.bearing > bearing + window {
                break;
            }
            let to = point - beam.origin;
            let distance = to.length();
            if beam.along.dot(&to) <= 0.0 || beam.along.perp(&to).abs() > sin_half * distance {
                continue;
            }
            if beam.range <= distance + behind + blur {
                return false;
            }
            beside += 1;
        }
        beside as f64 >= (COVERED * beams).max(LEAST_BEAMS)
    }
}

impl PastBeam {
    /// `None` for a beam without length.
    fn of(beam: &Beam) -> Option<Self> {
        let to = beam.end_in_robot - beam.origin_in_robot;
        let range = to.length();
        (range > 0.0).then(|| Self {
            bearing: libm::atan2(to.y, to.x),
            origin: beam.origin_in_robot,
            along: to / range,
            range,
        })
    }
}

/// The turn about the sensor that odometry missed since the scan before: it takes things from where
/// odometry puts them in the current robot frame to where they are (step 1 of [`Walkers`]).
/// `before` are hits of the scan before, in the robot frame of that time; `moved` is
/// `robot_before_from_robot_now` by odometry.
pub(crate) fn unreported_turn(
    before: impl Iterator<Item = Point2<f64>>,
    moved: &Pose2,
    points: &Points,
) -> Pose2 {
    let sensor = points.sensor_in_robot;
    let now_from_before = moved.inverse();
    let before = before.map(|hit| now_from_before * hit - sensor);
    let now = points.hits().map(|beam| beam.end_in_robot - sensor);
    let (way, turned) = (moved.position().coords.length(), moved.heading().abs());
    let most = TURN_DRIFT * turned.sqrt() + WAY_DRIFT * way.sqrt();
    let turn = turn::between(before, now, most.min(SEAM));
    let about_sensor = Pose2::new(sensor.x, sensor.y, turn);
    about_sensor * Pose2::new(-sensor.x, -sensor.y, 0.0)
}

#[cfg(test)]
mod tests;

/// How far from the sensor's position at the end of a sweep its beams began, m.
fn parallax(points: &Points) -> f64 {
    let begins = points.beams.iter().map(|beam| beam.origin_in_robot);
    begins
        .map(|begin| (begin - points.sensor_in_robot).length())
        .fold(0.0, f64::max)
}
