//! One scan of eight lines against maps of 10 to 1 000 walls: associate, update, all in one.

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use nalgebra::{Matrix2, Matrix3, Point2, Vector2};
use slamlab_core::estimation::{EkfConfig, EkfSlam, SweepTiming};
use slamlab_core::features::LineFeature;
use slamlab_core::geom::{Line, Pose2};
use slamlab_core::robot::{Odometry, Stamp};

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

fn updates(c: &mut Criterion) {
    let mut group = c.benchmark_group("update with 8 lines");
    let now = SweepTiming::at_once(Stamp(0));
    for n in [10, 50, 200, 1000] {
        let Ok(mut slam) = EkfSlam::new(EkfConfig::default()) else {
            continue;
        };
        let walls: Vec<_> = (0..n).map(wall).collect();
        // Often enough to be confirmed: what was seen once is soon forgotten.
        for _ in 0..4 {
            let _ = slam.update(&walls, &now).is_ok();
        }
        let known = slam.landmarks().filter(|l| l.is_confirmed).count();
        let standing = Odometry {
            motion: Pose2::identity(),
            cov: Matrix3::identity() * 1e-6,
            ..Odometry::standing(Stamp(0))
        };
        let seen = walls.get(..8.min(n)).unwrap_or_default();
        group.bench_function(BenchmarkId::from_parameter(known), |b| {
            b.iter(|| {
                let predicted = slam.predict(&standing).is_ok();
                (predicted, slam.update(seen, &now).map(|r| r.matches.len()))
            });
        });
    }
    group.finish();
}

criterion_group!(benches, updates);
criterion_main!(benches);
