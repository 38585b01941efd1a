//! The line filter by the number of walls it knows: move, correct by one match, add a wall, and whole scans of eight lines.

use criterion::{BatchSize, BenchmarkId, Criterion, criterion_group, criterion_main};
use nalgebra::{Matrix2, Matrix3, Point2, Vector2};
use slamlab_core::association::AssociationMethod;
use slamlab_core::estimation::{EkfConfig, EkfError, EkfSlam, SweepTiming};
use slamlab_core::features::LineFeature;
use slamlab_core::geom::{Line, Pose2};
use slamlab_core::robot::{Odometry, Stamp};

const SIZES: [usize; 3] = [100, 300, 1000];
const NOW: SweepTiming = SweepTiming {
    stamp: Stamp(0),
    lag: 0.0,
    seconds: 0.0,
    n_beams: 0,
};

/// The `i`-th wall of a fan around the robot.
fn wall(i: usize) -> LineFeature {
    let alpha = 2.399_963 * i as f64;
    let line = Line::new(alpha, 1.0 + 0.02 * i as f64);
    let foot = Point2::from(line.normal() * line.r());
    let tangent = Vector2::new(-line.normal().y, line.normal().x);
    LineFeature {
        line,
        cov: Matrix2::new(1e-5, 0.0, 0.0, 1e-5),
        ends: [foot - tangent, foot + tangent],
        seen_from_origin_side: true,
        first_beam: 0,
        last_beam: 0,
        n_points: 20,
        chi2: 18.0,
        by_heading: [Vector2::zeros(); 2],
    }
}

/// A filter that knows `n` walls.
fn mapped(n: usize, method: AssociationMethod) -> Result<EkfSlam, EkfError> {
    let mut config = EkfConfig::default();
    config.association.method = method;
    let mut slam = EkfSlam::new(config)?;
    let walls: Vec<_> = (0..n).map(wall).collect();
    // Often enough to be confirmed: what was seen once is soon forgotten.
    for _ in 0..4 {
        slam.update(&walls, &NOW)?;
    }
    Ok(slam)
}

fn standing() -> Odometry {
    Odometry {
        motion: Pose2::identity(),
        cov: Matrix3::identity() * 1e-6,
        ..Odometry::standing(Stamp(0))
    }
}

/// One scan; how many of its lines were matched.
fn scan(slam: &mut EkfSlam, seen: &[LineFeature]) -> usize {
    let predicted = slam.predict(&standing()).is_ok();
    let matched = slam.update(seen, &NOW).map_or(0, |r| r.matches.len());
    matched * usize::from(predicted)
}

/// The odometry goes into the covariance when a scan comes, here one without a line.
fn predict(c: &mut Criterion) {
    let mut group = c.benchmark_group("predict");
    for n in SIZES {
        let Ok(mut slam) = mapped(n, AssociationMethod::Nearest) else {
            continue;
        };
        group.bench_function(BenchmarkId::from_parameter(n), |b| {
            b.iter(|| scan(&mut slam, &[]));
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
            b.iter(|| scan(&mut slam, &seen));
        });
    }
    group.finish();
}

/// A wall that is not known yet; the filter is copied for each, outside of the time.
fn augment(c: &mut Criterion) {
    let mut group = c.benchmark_group("augment by 1 line");
    for n in SIZES {
        let Ok(slam) = mapped(n, AssociationMethod::Nearest) else {
            continue;
        };
        let seen = [wall(n + 10)];
        group.bench_function(BenchmarkId::from_parameter(n), |b| {
            let copy = || slam.clone();
            b.iter_batched_ref(copy, |slam| scan(slam, &seen), BatchSize::LargeInput);
        });
    }
    group.finish();
}

/// Each line by itself, and all lines together (JCBB).
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
                b.iter(|| scan(&mut slam, &seen));
            });
        }
        group.finish();
    }
}

criterion_group!(benches, predict, one_match, augment, eight_lines);
criterion_main!(benches);
