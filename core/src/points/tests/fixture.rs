//! Points for tests: made by hand, or what an exact lidar at the robot's centre sees of walls. σ is
//! 1 cm, the stamp 0. And noise.

use std::f64::consts::TAU;

use nalgebra::{Point2, Vector2};
use rand::{Rng, RngExt};

use super::{Beam, Points};
use crate::geom::{Length, Pose2, Segment, unit_vector};
use crate::robot::Stamp;

/// A beam from one place of the robot frame to another.
pub(crate) fn beam(
    beam_idx: usize,
    origin_in_robot: Point2<f64>,
    end_in_robot: Point2<f64>,
    is_hit: bool,
) -> Beam {
    Beam {
        beam_idx,
        origin_in_robot,
        end_in_robot,
        range: (end_in_robot - origin_in_robot).length(),
        sigma: 0.01,
        is_hit,
        quality: None,
        age: 0.0,
    }
}

/// A hit of a beam from the robot's centre.
pub(crate) fn hit(beam_idx: usize, end_in_robot: Point2<f64>) -> Beam {
    beam(beam_idx, Point2::origin(), end_in_robot, true)
}

/// A beam from the robot's centre along a unit vector.
pub(crate) fn beam_along(
    beam_idx: usize,
    direction: Vector2<f64>,
    range: f64,
    is_hit: bool,
) -> Beam {
    let end = Point2::from(direction * range);
    Beam {
        range,
        ..beam(beam_idx, Point2::origin(), end, is_hit)
    }
}

/// The beams as one scan.
pub(crate) fn scan_of(beams: impl IntoIterator<Item = Beam>) -> Points {
    Points {
        stamp: Stamp(0),
        sensor_in_robot: Point2::origin(),
        bearing_sigma: 0.0,
        beams: beams.into_iter().collect(),
    }
}

/// One scan of these points and nothing else.
pub(crate) fn scan_of_hits(ends_in_robot: impl IntoIterator<Item = Point2<f64>>) -> Points {
    let ends = ends_in_robot.into_iter().enumerate();
    scan_of(ends.map(|(beam_idx, end)| hit(beam_idx, end)))
}

/// Range to the nearest of the walls along a unit vector of the robot frame; infinite if there is
/// none, m.
pub(crate) fn range_to(
    walls: &[Segment],
    world_from_robot: &Pose2,
    direction_in_robot: Vector2<f64>,
) -> f64 {
    let along = world_from_robot.rotate(direction_in_robot);
    let ranges = walls
        .iter()
        .filter_map(|wall| wall.hit_by_ray(world_from_robot.position(), along));
    ranges.fold(f64::INFINITY, f64::min)
}

/// Beams all round, 360 of them, the first one ahead: each ends at a wall, or at `max_range` (m) if
/// none is nearer.
pub(crate) fn look(walls: &[Segment], world_from_robot: &Pose2, max_range: f64) -> Points {
    let bearings = (0..360).map(|beam_idx| TAU * f64::from(beam_idx) / 360.0);
    look_along(bearings, walls, world_from_robot, max_range)
}

/// The same along these bearings, robot frame, rad.
pub(crate) fn look_along(
    bearings: impl Iterator<Item = f64>,
    walls: &[Segment],
    world_from_robot: &Pose2,
    max_range: f64,
) -> Points {
    scan_of(bearings.enumerate().map(|(beam_idx, bearing)| {
        let direction = unit_vector(bearing);
        let range = range_to(walls, world_from_robot, direction);
        beam_along(beam_idx, direction, range.min(max_range), range < max_range)
    }))
}

/// A normal deviate by Box and Muller: noise that shares no code with the simulator's.
pub(crate) fn normal(rng: &mut impl Rng) -> f64 {
    let (u, v): (f64, f64) = (rng.random(), rng.random());
    (-2.0 * libm::log(1.0 - u)).sqrt() * libm::cos(TAU * v)
}
