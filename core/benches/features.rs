//! Lines and points from one revolution of the simulated lidar in the office: 360 beams.

use criterion::{Criterion, criterion_group, criterion_main};
use slamlab_core::features::{
    Hough, LineConfig, LineExtractor, PointFeatureConfig, Ransac, SplitRule, find_points,
};
use slamlab_core::geom::Pose2;
use slamlab_core::points::{PointConfig, Points, SegmentationConfig, SpacingModel, segment};
use slamlab_core::robot::RobotModel;
use slamlab_core::sim::{SensorModel, Simulation, worlds};

fn office_points() -> Option<Points> {
    let world = worlds::builtin("office")?;
    let mut sim = Simulation::new(world, RobotModel::rp6(), SensorModel::lidar(), 1).ok()?;
    sim.advance(1.0);
    let scan = sim.take_scan()?;
    Some(Points::from_scan(
        &scan,
        &Pose2::identity(),
        &PointConfig::default(),
    ))
}

fn extraction(c: &mut Criterion) {
    let Some(points) = office_points() else {
        return;
    };
    let mut runs = vec![];
    c.bench_function("breakpoints of 360 beams", |b| {
        b.iter(|| segment(&points, &SegmentationConfig::default(), &mut runs));
    });
    let by = |split| LineConfig {
        split,
        ..LineConfig::default()
    };
    let rules = [
        ("lines of 360 beams", LineConfig::default()),
        ("lines of 360 beams, classic", LineConfig::classic(0.1)),
        (
            "lines of 360 beams, Pilch",
            LineConfig::pilch(SpacingModel::even(360.0)),
        ),
        (
            "lines of 360 beams, RANSAC",
            by(SplitRule::Ransac(Ransac::default())),
        ),
        (
            "lines of 360 beams, Hough",
            by(SplitRule::Hough(Hough::default())),
        ),
    ];
    let mut lines = vec![];
    for (name, config) in rules {
        let mut extractor = LineExtractor::new(config);
        c.bench_function(name, |b| {
            b.iter(|| extractor.extract(&points, &mut lines));
        });
    }
    let (line_config, config) = (LineConfig::default(), PointFeatureConfig::default());
    c.bench_function("corners, spikes, crossings and circles of 360 beams", |b| {
        b.iter(|| find_points(&points, &lines, &line_config, &config));
    });
}

criterion_group!(benches, extraction);
criterion_main!(benches);
