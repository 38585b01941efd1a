//! Drawing scans into the occupancy grid: 1000 scans of 360 beams over a map of 100 m x 100 m at 5
//! cm.
#![allow(missing_docs, reason = "criterion's macros")]

use std::f64::consts::TAU;
use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use slamlab_core::geom::Pose2;
use slamlab_core::map::{FreeCells, Grid, GridConfig};
use slamlab_core::points::{PointConfig, Points};
use slamlab_core::robot::{Scan, Stamp};

/// A room of 12 m x 8 m with ripples, seen from its middle.
fn points() -> Points {
    let bearings: Vec<f64> = (0..360).map(|i| TAU * f64::from(i) / 360.0).collect();
    let ranges = bearings
        .iter()
        .map(|&b| {
            let (sin, cos) = libm::sincos(b);
            ((6.0 / cos.abs()).min(4.0 / sin.abs()) + 0.3 * libm::sin(9.0 * b)) as f32
        })
        .collect();
    let scan = Scan {
        stamp: Stamp(0),
        robot_from_sensor: Pose2::identity(),
        sigmas: vec![0.01; bearings.len()],
        bearings,
        ranges,
        bearing_sigma: 0.0,
        max_range: 20.0,
        sweep: 0.0,
        qualities: vec![],
    };
    Points::from_scan(&scan, &Pose2::identity(), &PointConfig::default())
}

fn bench(c: &mut Criterion) {
    let points = points();
    let poses: Vec<_> = (0..1000)
        .map(|i| {
            let t = f64::from(i) * 0.01;
            Pose2::new(40.0 * libm::sin(t), 40.0 * libm::sin(0.7 * t), t)
        })
        .collect();
    let mut group = c.benchmark_group("grid");
    group.sample_size(10);
    for (_, free_cells, _) in FreeCells::ALL {
        let config = GridConfig {
            free_cells,
            ..GridConfig::default()
        };
        let name = format!("insert_1000_scans_of_360_{free_cells:?}").to_lowercase();
        group.bench_function(name, |b| {
            b.iter(|| {
                let mut grid = Grid::new(config).ok();
                if let Some(grid) = &mut grid {
                    for pose in &poses {
                        grid.insert(black_box(&points), pose);
                    }
                }
                grid
            });
        });
    }
    group.finish();
}

criterion_group!(benches, bench);
criterion_main!(benches);
