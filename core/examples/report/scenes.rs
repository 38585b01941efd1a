//! In: a seed and a noise level. Out: a scan of a room, and the wall that each beam truly hit.
//!
//! 1. A rectangular room of 3 to 7 m with one corner cut off, one to three boxes of 0.3 to 1.2 m at
//!    any angle, one or two round pillars of 0.1 to 0.3 m.
//! 2. 360 beams from a place at least 0.4 m from everything, with Gaussian noise; one beam in a
//!    hundred is cut short at random.

use std::f64::consts::TAU;

use nalgebra::{Point2, Vector2};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use slamlab_core::geom::{Length, Segment, sides_of, sin_cos, unit_vector};
use slamlab_core::points::{Beam, Points};
use slamlab_core::robot::Stamp;

use crate::score::Scene;
use crate::statistics::normal;

pub(crate) const BEAMS: usize = 360;
const WILD: f64 = 0.01;

impl Scene {
    pub(crate) fn drawn(seed: u64, sigma: f64) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let (walls, pillars) = (walls(&mut rng), pillars(&mut rng));
        let sensor = place(&walls, &pillars, &mut rng);
        let turn = rng.random_range(0.0..TAU);
        let (mut beams, mut truth) = (vec![], vec![]);
        for beam_idx in 0..BEAMS {
            let bearing = TAU * beam_idx as f64 / BEAMS as f64;
            let (range, wall) = nearest(&walls, &pillars, sensor, unit_vector(bearing + turn));
            let is_wild = rng.random_bool(WILD);
            let noisy = range + sigma * normal(&mut rng);
            let wild = rng.random_range(0.3..1.0) * range;
            let seen = if is_wild { wild } else { noisy }.max(0.05);
            let at = Point2::from(unit_vector(bearing) * range);
            truth.push(wall.filter(|_| !is_wild).map(|wall| (wall, at)));
            beams.push(hit(beam_idx, bearing, seen, sigma));
        }
        let points = Points {
            stamp: Stamp(0),
            sensor_in_robot: Point2::origin(),
            bearing_sigma: 0.0,
            beams,
        };
        Self {
            points,
            truth,
            sigma,
        }
    }
}

/// A beam from the middle of the robot that hit something.
pub(crate) fn hit(beam_idx: usize, bearing: f64, range: f64, sigma: f64) -> Beam {
    Beam {
        beam_idx,
        origin_in_robot: Point2::origin(),
        end_in_robot: Point2::from(unit_vector(bearing) * range),
        range,
        sigma,
        is_hit: true,
        quality: None,
        age: 0.0,
    }
}

fn walls(rng: &mut ChaCha8Rng) -> Vec<Segment> {
    let (w, h) = (rng.random_range(3.0..7.0), rng.random_range(3.0..7.0));
    let (cut_x, cut_y) = (rng.random_range(0.5..1.5), rng.random_range(0.5..1.5));
    let (x, y) = (w - cut_x, h - cut_y);
    let room = [(0.0, 0.0), (w, 0.0), (w, y), (x, h), (0.0, h)];
    let mut walls: Vec<_> = sides(&room.map(|(x, y)| Point2::new(x, y))).collect();
    for _ in 0..rng.random_range(1..4) {
        let (x, y) = (rng.random_range(0.2..0.8), rng.random_range(0.2..0.8));
        let centre = Point2::new(x * w, y * h);
        let (a, b) = (rng.random_range(0.15..0.6), rng.random_range(0.15..0.6));
        let (sin, cos) = sin_cos(rng.random_range(0.0..TAU));
        let corner = |(x, y): (f64, f64)| {
            centre + Vector2::new(x * a * cos - y * b * sin, x * a * sin + y * b * cos)
        };
        walls.extend(sides(&SQUARE.map(corner)));
    }
    walls
}

/// Corners of a square of side 2 around the origin.
pub(crate) const SQUARE: [(f64, f64); 4] = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];

/// The sides of a polygon.
pub(crate) fn sides(corners: &[Point2<f64>]) -> impl Iterator<Item = Segment> {
    sides_of(corners).map(|(a, b)| Segment::new(*a, *b))
}

/// Centres and radii.
fn pillars(rng: &mut ChaCha8Rng) -> Vec<(Point2<f64>, f64)> {
    let count = rng.random_range(1..3);
    let mut pillar = |_| {
        let centre = Point2::new(rng.random_range(0.5..5.0), rng.random_range(0.5..5.0));
        (centre, rng.random_range(0.1..0.3))
    };
    (0..count).map(&mut pillar).collect()
}

/// A place inside the room (whose lower left 2.5 m are never cut), clear of everything.
fn place(walls: &[Segment], pillars: &[(Point2<f64>, f64)], rng: &mut ChaCha8Rng) -> Point2<f64> {
    let mut clear = 0.4;
    loop {
        let place = Point2::new(rng.random_range(0.4..2.5), rng.random_range(0.4..2.5));
        let free = walls.iter().map(|w| w.distance(place));
        let round = pillars.iter().map(|(c, r)| (place - c).length() - r);
        // A crowded corner must not keep the search going for ever; inside a box is as good a place
        // as any.
        clear *= 0.999;
        if free.chain(round).all(|distance| distance > clear) {
            return place;
        }
    }
}

/// Distance along a ray to what it hits first, and the number of the wall if it is one.
fn nearest(
    walls: &[Segment],
    pillars: &[(Point2<f64>, f64)],
    origin: Point2<f64>,
    direction: Vector2<f64>,
) -> (f64, Option<usize>) {
    let flat = walls.iter().enumerate().filter_map(|(number, wall)| {
        let distance = wall.hit_by_ray(origin, direction)?;
        Some((distance, Some(number)))
    });
    let round = pillars.iter().filter_map(|(centre, radius)| {
        let to_centre = centre - origin;
        let along = to_centre.dot(&direction);
        let half = (radius * radius - to_centre.norm_squared() + along * along).sqrt();
        // NaN if the ray passes by.
        (along - half > 0.0).then_some((along - half, None))
    });
    flat.chain(round)
        .fold((12.0, None), |a, b| if b.0 < a.0 { b } else { a })
}
