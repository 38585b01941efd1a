//! How fast worlds are seen and driven through: rays against the number of walls, and simulated seconds per second.

use std::f64::consts::TAU;
use std::hint::black_box;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use nalgebra::{Point2, Vector2};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use slamlab_core::geom::Segment;
use slamlab_core::robot::{Command, RobotModel};
use slamlab_core::sim::{
    Caster, Fan, Material, SensorModel, Simulation, Wall, reachable_area, worlds,
};

/// Rooms of 4 x 4 m side by side, each of 4 walls with a door and some furniture: about `n` walls.
fn building(n: usize) -> (Vec<Wall>, f64) {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let rooms = ((n as f64 / 10.0).sqrt().ceil() as usize).max(1);
    let mut walls = Vec::new();
    let mut add = |ax: f64, ay: f64, bx: f64, by: f64| {
        walls.push(Wall {
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
            let turn: f64 = rng.random_range(0.0..TAU);
            let (dx, dy) = (0.4 * libm::cos(turn), 0.4 * libm::sin(turn));
            add(x + u, y + v, x + u + dx, y + v + dy);
        }
    }
    walls.truncate(n);
    (walls, 4.0 * rooms as f64)
}

fn rays(side: f64) -> Vec<(Point2<f64>, Vector2<f64>)> {
    let mut rng = ChaCha8Rng::seed_from_u64(2);
    (0..10_000)
        .map(|_| {
            let turn: f64 = rng.random_range(0.0..TAU);
            let origin = Point2::new(rng.random_range(0.0..side), rng.random_range(0.0..side));
            (origin, Vector2::new(libm::cos(turn), libm::sin(turn)))
        })
        .collect()
}

fn cast(c: &mut Criterion) {
    let mut group = c.benchmark_group("cast");
    for n in [100, 1_000, 50_000] {
        let (walls, side) = building(n);
        let rays = rays(side);
        let caster = Caster::new(walls.clone());
        group.throughput(Throughput::Elements(rays.len() as u64));
        group.bench_with_input(BenchmarkId::new("grid", n), &rays, |b, rays| {
            b.iter(|| {
                rays.iter()
                    .filter_map(|(o, d)| caster.cast(*o, *d, 12.0))
                    .map(|h| h.distance)
                    .sum::<f64>()
            });
        });
        if n <= 1_000 {
            group.bench_with_input(BenchmarkId::new("every_wall", n), &rays, |b, rays| {
                b.iter(|| {
                    rays.iter()
                        .filter_map(|(o, d)| {
                            let hits = walls.iter().filter_map(|w| w.segment.hit_by_ray(*o, *d));
                            hits.min_by(f64::total_cmp)
                        })
                        .sum::<f64>()
                });
            });
        }
        group.bench_with_input(BenchmarkId::new("build", n), &walls, |b, walls| {
            b.iter(|| Caster::new(black_box(walls.clone())));
        });
    }
    group.finish();
}

/// Scans of 360 beams from ten places of `campus`, each ray alone and all at once.
fn campus(c: &mut Criterion) {
    let Some((caster, mut fan)) = worlds::builtin("campus")
        .map(|w| Caster::new(w.walls()))
        .zip(Fan::new(360, 0.0, TAU / 360.0))
    else {
        return;
    };
    let places: Vec<_> = (0..10)
        .map(|k| Point2::new(30.0 * f64::from(k) + 8.0, 24.0 * f64::from(k) + 12.0))
        .collect();
    let mut group = c.benchmark_group("campus");
    group.throughput(Throughput::Elements(3600));
    group.bench_function("ray_by_ray", |b| {
        b.iter(|| {
            let mut sum = 0.0;
            for place in &places {
                for beam in 0..360 {
                    let angle = TAU * f64::from(beam) / 360.0;
                    let direction = Vector2::new(libm::cos(angle), libm::sin(angle));
                    let hit = caster.cast(*place, direction, 12.0);
                    sum += hit.map_or(12.0, |h| h.distance);
                }
            }
            sum
        });
    });
    group.bench_function("fan", |b| {
        b.iter(|| {
            for place in &places {
                caster.cast_fan(*place, 0.0, 12.0, &mut fan);
                black_box(fan.distances());
            }
        });
    });
    group.finish();
}

/// One simulated second, driving to and fro.
fn second(c: &mut Criterion) {
    let mut group = c.benchmark_group("simulated_second");
    for (sensor, model) in [
        ("lidar", SensorModel::lidar()),
        ("rangers", SensorModel::rangers()),
    ] {
        for name in ["arena", "office"] {
            let Some(world) = worlds::builtin(name) else {
                continue;
            };
            let Ok(mut sim) = Simulation::new(world, RobotModel::rp6(), model.clone(), 1) else {
                continue;
            };
            let mut forward = 0.2;
            group.bench_function(BenchmarkId::new(sensor, name), |b| {
                b.iter(|| {
                    forward = -forward;
                    sim.command(Command::Velocity { forward, turn: 0.3 });
                    for _ in 0..20 {
                        sim.advance(0.05);
                        black_box(sim.take_scan());
                    }
                });
            });
        }
    }
    group.finish();
}

fn area(c: &mut Criterion) {
    if let Some(office) = worlds::builtin("office") {
        c.bench_function("reachable_area/office", |b| {
            b.iter(|| reachable_area(black_box(&office), 0.11, 0.05));
        });
    }
}

criterion_group! {
    name = benches;
    config = Criterion::default().sample_size(20).measurement_time(std::time::Duration::from_secs(2));
    targets = cast, campus, second, area
}
criterion_main!(benches);
