//! The line filter against the number of walls in its map: predict, correct by one match, add a
//! wall, and whole scans of eight lines.

#[path = "../examples/shared/mapped_filter.rs"]
mod mapped_filter;

use criterion::{BatchSize, BenchmarkId, Criterion, criterion_group, criterion_main};
use slamlab_core::association::AssociationMethod;

use mapped_filter::{mapped, observe, wall};

const SIZES: [usize; 3] = [100, 300, 1000];

/// Odometry enters the covariance when a scan arrives; here one without lines.
fn predict(c: &mut Criterion) {
    let mut group = c.benchmark_group("predict");
    for n in SIZES {
        let Ok(mut slam) = mapped(n, AssociationMethod::Nearest) else {
            continue;
        };
        group.bench_function(BenchmarkId::from_parameter(n), |b| {
            b.iter(|| observe(&mut slam, &[]));
        });
    }
    group.finish();
}

fn one_match(c: &mut Criterion) {
    let mut group = c.benchmark_group("update with 1 line");
    for n in SIZES {
        let Ok(mut slam) = mapped(n, AssociationMethod::Nearest) else {
            continue;
        };
        let seen = [wall(0)];
        group.bench_function(BenchmarkId::from_parameter(n), |b| {
            b.iter(|| observe(&mut slam, &seen));
        });
    }
    group.finish();
}

/// A wall that is not in the map yet. The filter is copied for each, outside the measured time.
fn augment(c: &mut Criterion) {
    let mut group = c.benchmark_group("augment by 1 line");
    for n in SIZES {
        let Ok(slam) = mapped(n, AssociationMethod::Nearest) else {
            continue;
        };
        let seen = [wall(n + 10)];
        group.bench_function(BenchmarkId::from_parameter(n), |b| {
            let copy = || slam.clone();
            b.iter_batched_ref(copy, |slam| observe(slam, &seen), BatchSize::LargeInput);
        });
    }
    group.finish();
}

/// Lines matched one by one, and all together (JCBB).
fn eight_lines(c: &mut Criterion) {
    let methods = [
        ("update with 8 lines", AssociationMethod::Nearest),
        ("update with 8 lines, JCBB", AssociationMethod::Joint),
    ];
    let seen: Vec<_> = (0..8).map(wall).collect();
    for (name, method) in methods {
        let mut group = c.benchmark_group(name);
        for n in [10].into_iter().chain(SIZES) {
            let Ok(mut slam) = mapped(n, method) else {
                continue;
            };
            group.bench_function(BenchmarkId::from_parameter(n), |b| {
                b.iter(|| observe(&mut slam, &seen));
            });
        }
        group.finish();
    }
}

criterion_group!(benches, predict, one_match, augment, eight_lines);
criterion_main!(benches);
