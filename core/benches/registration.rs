//! Matching a scan to a map of surfaces from a start 10 cm and 3° off; and finding it by branch and
//! bound from 3 m off.
#![allow(missing_docs, reason = "criterion's macros")]

use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use nalgebra::{Matrix3, Point2, Vector2};
use slamlab_core::geom::{Length, Pose2};
use slamlab_core::map::{LikelihoodPyramid, SurfelConfig, SurfelMap};
use slamlab_core::points::OrientedPoint;
use slamlab_core::registration::{MatchConfig, Prior, SearchWindow, register, search};

/// A room of 12 m x 8 m with two pillars, a point every 10 cm.
fn room() -> Vec<OrientedPoint> {
    let mut points = vec![];
    let mut wall = |a: (f64, f64), b: (f64, f64)| {
        let (a, b) = (Point2::new(a.0, a.1), Point2::new(b.0, b.1));
        let along = (b - a).normalize();
        let count = ((b - a).length() / 0.1) as usize;
        points.extend((0..count).map(|i| OrientedPoint {
            position: a + along * (0.1 * i as f64),
            normal: Vector2::new(-along.y, along.x),
        }));
    };
    for (low, high) in [
        ((-6.0, -4.0), (6.0, 4.0)),
        ((1.0, 1.0), (1.5, 2.0)),
        ((-3.0, -2.0), (-2.0, -1.6)),
    ] {
        wall(low, (high.0, low.1));
        wall((high.0, low.1), high);
        wall(high, (low.0, high.1));
        wall((low.0, high.1), low);
    }
    points
}

fn bench(c: &mut Criterion) {
    let room = room();
    let mut map = SurfelMap::new(SurfelConfig::default());
    map.insert(room.iter().copied());
    let start = Pose2::new(0.08, -0.06, 0.05);
    let prior = Prior {
        pose: start,
        information: Matrix3::from_diagonal_element(100.0),
    };
    let config = MatchConfig::default();
    c.bench_function("registration/match_to_surfels_450_points", |b| {
        b.iter(|| register(black_box(&room), &map, &start, &prior, &config));
    });
    let places: Vec<_> = room.iter().map(|p| p.position).collect();
    c.bench_function("registration/likelihood_pyramid", |b| {
        b.iter(|| LikelihoodPyramid::new(black_box(&places).iter().copied(), 0.1, 0.1, 7));
    });
    if let Some(pyramid) = LikelihoodPyramid::new(places.iter().copied(), 0.1, 0.1, 7) {
        let far = Pose2::new(2.5, -1.7, 0.3);
        let window = SearchWindow {
            shift: 4.0,
            turn: 0.5,
        };
        c.bench_function("registration/branch_and_bound_4_m_30_degrees", |b| {
            b.iter(|| search(black_box(&places), &pyramid, &far, &window, 0.5));
        });
    }
}

criterion_group!(benches, bench);
criterion_main!(benches);
