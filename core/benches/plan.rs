//! Planning on a floor of 16 x 12 m in rooms, cells of 5 cm.

use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use nalgebra::{Point2, Vector2};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use slamlab_core::geom::Pose2;
use slamlab_core::map::{Grid, GridConfig, Topology, TopologyConfig};
use slamlab_core::plan::{
    FrontierConfig, GridSpace, Path, Planner, Query, RouteConfig, RrtConfig, Sampler, Search,
    SegmentSpace, Unknown, Wavefront, find_frontiers, plan_route, pull_tight, rect_around, shorten,
};
use slamlab_core::points::{PointConfig, Points};
use slamlab_core::sim::{SensorModel, Simulation, worlds};

const RADIUS: f64 = 0.11;

/// What a lidar sees of `office` from a few places; `None` where the world cannot be built.
fn office() -> Option<Grid> {
    let mut world = worlds::builtin("office")?;
    let start = world.start;
    let mut grid = Grid::new(GridConfig::default()).ok()?;
    for (x, y) in [(1.0, 6.0), (4.0, 6.0), (7.0, 6.0), (11.0, 6.0), (14.5, 6.0)] {
        world.start = Pose2::new(x, y, 0.0);
        let robot = world.robot.model();
        let mut sim = Simulation::new(world.clone(), robot, SensorModel::lidar(), 1).ok()?;
        sim.advance(1.0);
        while let Some(scan) = sim.take_scan() {
            let seen = Points::from_scan(&scan, &Pose2::identity(), &PointConfig::default());
            grid.insert(&seen, &(start.inverse() * world.start));
        }
    }
    Some(grid)
}

fn plan(c: &mut Criterion) {
    let Some(grid) = office() else {
        return;
    };
    let (start, goal) = (Point2::origin(), Point2::new(13.0, 0.2));
    let Some(rect) = rect_around(&grid, &[start], 2, i32::MAX) else {
        return;
    };
    c.bench_function("plan/topology", |b| {
        b.iter(|| Topology::of_grid(black_box(&grid), &TopologyConfig::default()));
    });
    c.bench_function("plan/config_space", |b| {
        b.iter(|| GridSpace::new(black_box(&grid), rect, RADIUS, Unknown::Blocked));
    });
    let space = GridSpace::new(&grid, rect, RADIUS, Unknown::Blocked);
    c.bench_function("plan/wavefront", |b| {
        b.iter(|| Wavefront::new(black_box(&space), start));
    });
    let wave = Wavefront::new(&space, start);
    c.bench_function("plan/frontiers", |b| {
        b.iter(|| find_frontiers(black_box(&space), &wave, &FrontierConfig::default()));
    });
    for (name, planner) in [
        ("plan/route_rrt_connect", Planner::RrtConnect),
        ("plan/route_rrt", Planner::Rrt),
    ] {
        let config = RouteConfig {
            planner,
            ..RouteConfig::default()
        };
        c.bench_function(name, |b| {
            let mut rng = ChaCha8Rng::seed_from_u64(1);
            b.iter(|| plan_route(black_box(&grid), start, goal, RADIUS, &config, &mut rng).is_ok());
        });
    }
}

/// Every planner on the route through the exact walls of `office`, and every way to shorten its
/// path.
fn over_walls(c: &mut Criterion) {
    let Some(world) = worlds::builtin("office") else {
        return;
    };
    let walls = world.walls().into_iter().map(|wall| wall.segment).collect();
    let Ok(space) = SegmentSpace::new(walls, RADIUS, world.bounds()) else {
        return;
    };
    let query = Query {
        start: world.start.position(),
        goal: world.start.position() + Vector2::new(13.0, 0.2),
    };
    for (name, planner) in [
        ("walls/rrt", Planner::Rrt),
        ("walls/rrt_connect", Planner::RrtConnect),
        ("walls/rrt_star_2000", Planner::RrtStar),
        ("walls/informed_rrt_star_2000", Planner::InformedRrtStar),
        ("walls/visibility", Planner::Visibility),
    ] {
        c.bench_function(name, |b| {
            let mut rng = ChaCha8Rng::seed_from_u64(1);
            b.iter(|| {
                let found = find(planner, black_box(&space), query, &mut rng);
                found.is_some()
            });
        });
    }
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let Some(path) = find(Planner::RrtConnect, &space, query, &mut rng) else {
        return;
    };
    c.bench_function("walls/shorten", |b| {
        b.iter(|| shorten(black_box(&path), &space))
    });
    c.bench_function("walls/pull_tight", |b| {
        b.iter(|| pull_tight(black_box(&path), &space))
    });
}

/// The path after at most 2000 iterations.
fn find(
    planner: Planner,
    space: &SegmentSpace,
    query: Query,
    rng: &mut ChaCha8Rng,
) -> Option<Path> {
    let sampler = || Sampler::anywhere(space);
    let mut search = Search::new(planner, space, query, RrtConfig::default(), sampler).ok()?;
    search.step(space, rng, 2000);
    search.path()
}

criterion_group!(benches, plan, over_walls);
criterion_main!(benches);
