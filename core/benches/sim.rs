//! The speed of the simulator: scans of `campus`, and simulated seconds. How the cost of a ray
//! grows with the number of walls is a separate claim: `report -- ray-cast`.

use std::f64::consts::TAU;
use std::hint::black_box;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use nalgebra::{Point2, Vector2};
use slamlab_core::robot::{Command, RobotModel};
use slamlab_core::sim::{Caster, Fan, SensorModel, Simulation, reachable_area, worlds};

/// Scans of 360 beams from ten places of `campus`, ray by ray and all at once.
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

/// One simulated second of driving to and fro.
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
    targets = campus, second, area
}
criterion_main!(benches);
