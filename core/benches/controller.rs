//! One period of the drive controller, of which a robot runs a thousand per second, and the design
//! of its gains.

use std::f64::consts::TAU;
use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use slamlab_core::robot::DriveTrain;
use slamlab_core::robot::controller::{DriveController, Wish};

const PERIOD: f64 = 1e-3;
const RADIANS_PER_COUNT: f64 = TAU / 625.0;

fn controller(c: &mut Criterion) {
    let train = DriveTrain::rp6();
    c.bench_function("controller/design", |b| {
        b.iter(|| DriveController::new(black_box(&train), PERIOD, RADIANS_PER_COUNT));
    });
    let Ok(mut controller) = DriveController::new(&train, PERIOD, RADIANS_PER_COUNT) else {
        return;
    };
    let wish = Wish {
        speed: 10.0,
        acceleration: 0.0,
    };
    let mut seconds = 0.0;
    c.bench_function("controller/step", |b| {
        b.iter(|| {
            // The shafts follow the command as an encoder counts it, so the observer never comes to
            // rest.
            seconds += PERIOD;
            let count = (wish.speed * seconds / RADIANS_PER_COUNT) as i64;
            controller.step(black_box([count, count]), [wish, wish])
        });
    });
}

criterion_group!(benches, controller);
criterion_main!(benches);
