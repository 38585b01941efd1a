//! `ray-cast`: how fast rays are cast in `campus`, and how the cost of a ray grows with the number
//! of walls. About 10 s.
//!
//! 1. Rays from random places in random directions, 12 m long, the worst case for a cache; and
//!    scans of 360 beams from random places, ray by ray and all at once as a fan. The requirement
//!    is on the slower two: ray by ray.
//! 2. Buildings of 100 to 50 000 walls, alike except for their size; scans of 360 beams. The cost
//!    of a beam is fitted by a + b ln n, and by c nᵖ: an exponent near 0 indicates log n, 1 would
//!    mean trying every wall.
//! 3. Every distance of 20 000 random rays, against all walls tried one by one.
//!
//! Times are processor times, the minimum of several runs: disturbances only add.

use std::f64::consts::TAU;
use std::hint::black_box;

use anyhow::{Context, Result};
use nalgebra::{Point2, Vector2};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde_json::json;
use slamlab_core::geom::{Segment, sin_cos, unit_vector};
use slamlab_core::sim::{Caster, Fan, Material, Wall};

use super::{Args, Outcome};
use crate::clock::least_seconds;
use crate::ride::world_named;
use crate::statistics::{fit_line, place_between};

const RANGE: f64 = 12.0;
const BEAMS: usize = 360;
const SCANS: usize = 300;
const WALLS: [usize; 9] = [100, 200, 500, 1_000, 2_000, 5_000, 10_000, 20_000, 50_000];
/// Maximum exponent of the cost of a ray against n.
const MOST_EXPONENT: f64 = 0.25;

type Ray = (Point2<f64>, Vector2<f64>);

pub(crate) fn measure(args: &Args) -> Result<Outcome> {
    let mut outcome = Outcome::default();
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let campus = world_named("campus")?;
    let (_, high) = campus.bounds();
    let caster = Caster::new(campus.walls());
    outcome.figure("campus_walls", caster.walls().len());
    let places = places(high, &mut rng);
    let random = rays(high, args.seeds.unwrap_or(1) as usize * 200_000, &mut rng);
    let rays_alone = 1.0 / time_rays(&caster, &random);
    outcome.at_least("campus_random_rays_per_second", rays_alone, 1e6);
    let beams = 1.0 / time_scans(&caster, &places);
    outcome.at_least("campus_scan_beams_per_second", beams, 1e6);
    let fan = 1.0 / time_fans(&caster, &places)?;
    outcome.figure("campus_fan_beams_per_second", fan);
    let other = Caster::new(building(1_000).0);
    let others = rays(Point2::new(40.0, 40.0), 18_000, &mut rng);
    let wrong = unlike_brute_force(&caster, &random[..2_000]) + unlike_brute_force(&other, &others);
    outcome.at_most("rays_unlike_brute_force", wrong as f64, 0.0);
    growth(&mut outcome)?;
    Ok(outcome)
}

/// The cost of a beam against the number of walls.
fn growth(outcome: &mut Outcome) -> Result<()> {
    let (mut table, mut logs, mut powers) = (vec![], vec![], vec![]);
    for walls in WALLS {
        let (walls, side) = building(walls);
        let mut rng = ChaCha8Rng::seed_from_u64(4);
        let places = places(Point2::new(side, side), &mut rng);
        let caster = Caster::new(walls);
        let alone = 1e9 * time_scans(&caster, &places);
        let fan = 1e9 * time_fans(&caster, &places)?;
        let n = caster.walls().len() as f64;
        table.push(json!({ "walls": n, "ns_per_beam": alone, "fan_ns_per_beam": fan }));
        logs.push((n.ln(), alone));
        powers.push((n.ln(), alone.ln()));
    }
    outcome.figure("growth", table);
    let (at_one, per_e_fold, off) = fit_line(&logs);
    outcome.figure("log_fit_ns_at_1_wall", at_one);
    outcome.figure("log_fit_ns_per_factor_e", per_e_fold);
    outcome.figure("log_fit_rms_ns", off);
    outcome.at_most("power_fit_exponent", fit_line(&powers).1, MOST_EXPONENT);
    Ok(())
}

/// Seconds per ray.
fn time_rays(caster: &Caster, rays: &[Ray]) -> f64 {
    let cast = || {
        let hits = rays.iter().filter_map(|(o, d)| caster.cast(*o, *d, RANGE));
        black_box(hits.map(|h| h.distance).sum::<f64>());
    };
    least_seconds(cast) / rays.len() as f64
}

/// Seconds per beam of scans whose beams are cast one by one, including the computation of their
/// directions.
fn time_scans(caster: &Caster, places: &[Point2<f64>]) -> f64 {
    let cast = || {
        let mut sum = 0.0;
        for place in places {
            for beam in 0..BEAMS {
                let direction = unit_vector(TAU * beam as f64 / BEAMS as f64);
                let hit = caster.cast(*place, direction, RANGE);
                sum += hit.map_or(RANGE, |h| h.distance);
            }
        }
        black_box(sum);
    };
    least_seconds(cast) / (places.len() * BEAMS) as f64
}

/// Seconds per beam of scans whose beams are cast at once.
fn time_fans(caster: &Caster, places: &[Point2<f64>]) -> Result<f64> {
    let mut fan = Fan::new(BEAMS, 0.0, TAU / BEAMS as f64).context("more than a round")?;
    let cast = || {
        let mut sum = 0.0;
        for place in places {
            caster.cast_fan(*place, 0.0, RANGE, &mut fan);
            let hits = fan.distances().iter().filter(|d| d.is_finite());
            sum += hits.sum::<f64>();
        }
        black_box(sum);
    };
    Ok(least_seconds(cast) / (places.len() * BEAMS) as f64)
}

/// Rays whose distances differ from those found by trying every wall.
fn unlike_brute_force(caster: &Caster, rays: &[Ray]) -> usize {
    let differs = |(origin, direction): &&Ray| {
        let all = caster.walls().iter();
        let hits = all.filter_map(|w| w.segment.hit_by_ray(*origin, *direction));
        let expect = hits.filter(|d| *d <= RANGE).min_by(f64::total_cmp);
        let found = caster.cast(*origin, *direction, RANGE).map(|h| h.distance);
        match (found, expect) {
            (Some(found), Some(expect)) => (found - expect).abs() > 1e-9,
            (found, expect) => found.is_some() != expect.is_some(),
        }
    };
    rays.iter().filter(differs).count()
}

fn places(high: Point2<f64>, rng: &mut ChaCha8Rng) -> Vec<Point2<f64>> {
    let mut place = |_| place_between(Point2::origin(), high, rng);
    (0..SCANS).map(&mut place).collect()
}

fn rays(high: Point2<f64>, count: usize, rng: &mut ChaCha8Rng) -> Vec<Ray> {
    let mut ray = |_| {
        let origin = place_between(Point2::origin(), high, rng);
        (origin, unit_vector(rng.random_range(0.0..TAU)))
    };
    (0..count).map(&mut ray).collect()
}

/// Rooms of 4 x 4 m side by side with doors and furniture, ten walls each; and the side of the
/// building, m.
fn building(walls: usize) -> (Vec<Wall>, f64) {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let rooms = ((walls as f64 / 10.0).sqrt().ceil() as usize).max(1);
    let mut all = Vec::new();
    let mut add = |ax: f64, ay: f64, bx: f64, by: f64| {
        all.push(Wall {
            segment: Segment::new(Point2::new(ax, ay), Point2::new(bx, by)),
            material: Material::Opaque,
        });
    };
    for index in 0..rooms * rooms {
        let (x, y) = (4.0 * (index % rooms) as f64, 4.0 * (index / rooms) as f64);
        let door = rng.random_range(0.5..2.5);
        add(x, y, x + door, y);
        add(x + door + 0.9, y, x + 4.0, y);
        add(x, y, x, y + door);
        add(x, y + door + 0.9, x, y + 4.0);
        for _ in 0..6 {
            let (u, v) = (rng.random_range(0.3..3.5), rng.random_range(0.3..3.5));
            let (sin, cos) = sin_cos(rng.random_range(0.0..TAU));
            add(x + u, y + v, x + u + 0.4 * cos, y + v + 0.4 * sin);
        }
    }
    all.truncate(walls);
    (all, 4.0 * rooms as f64)
}
