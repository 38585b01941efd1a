//! `plan`: paths for a disc of 0.2 m through the 100 walls of `world_office.csv`, and over the
//! cells of `grid_office_1000.txt`.
//!
//! Time is that of a query from question to path; the space is built once, like the peers'
//! checkers. Every path is checked against every wall one by one, outside the measured time. The
//! visibility graph gives the optimum that lengths are compared with.

use anyhow::{Context, Result, ensure};
use nalgebra::{Point2, Vector2};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use slamlab_core::geom::{Length, Segment};
use slamlab_core::plan::{
    AStar, ConfigSpace, Lattice, Path, Planner, Query, RrtConfig, Sampler, Search, SegmentSpace,
    pull_tight, shorten,
};

use crate::inputs::Inputs;
use crate::timing::{cpu_ms, emit, median};

const KEEP: f64 = 0.2;
const SIDE: f64 = 50.0;

/// What is done with the path that a planner finds.
#[derive(Clone, Copy, PartialEq)]
enum After {
    Nothing,
    Shorten,
    Tighten,
}

use After::{Nothing, Shorten, Tighten};
use Planner::{InformedRrtStar, Rrt, RrtConnect, RrtStar, Visibility};

/// Planner, its iterations, queries, and what is done with the path.
const RUNS: &[(&str, Planner, usize, usize, After)] = &[
    ("RRTConnect", RrtConnect, 100_000, 1000, Nothing),
    ("RRTConnect,shortened", RrtConnect, 100_000, 1000, Shorten),
    ("RRTConnect,tight", RrtConnect, 100_000, 1000, Tighten),
    ("RRT", Rrt, 100_000, 1000, Nothing),
    ("RRTstar2000", RrtStar, 2000, 100, Nothing),
    ("InformedRRTstar2000", InformedRrtStar, 2000, 100, Nothing),
    ("Visibility", Visibility, usize::MAX, 1000, Nothing),
];

pub(crate) fn run(inputs: &Inputs) -> Result<()> {
    over_walls(inputs)?;
    over_cells(inputs)
}

fn over_walls(inputs: &Inputs) -> Result<()> {
    let walls = inputs.segments("world_office.csv")?;
    let ways = inputs.segments("plan_queries_1000.csv")?.into_iter();
    let query = |Segment { a: start, b: goal }| Query { start, goal };
    let queries: Vec<Query> = ways.map(query).collect();
    let bounds = (Point2::origin(), Point2::new(SIDE, SIDE));
    let space = SegmentSpace::new(walls, KEEP, bounds)?;
    let optima: Vec<f64> = queries.iter().map(|query| optimum(&space, query)).collect();
    for run in RUNS {
        measure(run, &space, &queries, &optima)?;
    }
    Ok(())
}

fn optimum(space: &SegmentSpace, query: &Query) -> f64 {
    let mut rng = ChaCha8Rng::seed_from_u64(0);
    let path = find(Visibility, space, query, usize::MAX, &mut rng);
    path.ok().flatten().map_or(f64::NAN, |path| path.length())
}

fn find(
    planner: Planner,
    space: &SegmentSpace,
    query: &Query,
    iterations: usize,
    rng: &mut ChaCha8Rng,
) -> Result<Option<Path>> {
    let sampler = || Sampler::anywhere(space);
    let mut search = Search::new(planner, space, *query, RrtConfig::default(), sampler)?;
    search.step(space, rng, iterations);
    Ok(search.path())
}

fn measure(
    (name, planner, iterations, count, after): &(&str, Planner, usize, usize, After),
    space: &SegmentSpace,
    queries: &[Query],
    optima: &[f64],
) -> Result<()> {
    let (mut times, mut lengths, mut straight, mut excess) = (vec![], vec![], vec![], vec![]);
    for (number, query) in queries.iter().enumerate().take(*count) {
        let mut rng = ChaCha8Rng::seed_from_u64(number as u64);
        let begin = cpu_ms();
        let path = find(*planner, space, query, *iterations, &mut rng)?.map(|path| match after {
            Nothing => path,
            Shorten => shorten(&path, space),
            Tighten => pull_tight(&shorten(&path, space), space),
        });
        times.push(cpu_ms() - begin);
        if let Some(path) = path {
            check(&path, query, space)?;
            lengths.push(path.length());
            straight.push(path.length() / (query.goal - query.start).length());
            excess.push(path.length() / optima[number]);
        }
    }
    let asked = times.len() as f64;
    let solved = 100.0 * lengths.len() as f64 / asked;
    let mean = times.iter().sum::<f64>() / asked;
    let middle = median(&mut times);
    let late = times[times.len() * 95 / 100];
    let (long, ratio) = (median(&mut lengths), median(&mut straight));
    let over = median(&mut excess);
    let worst = excess.last().copied().unwrap_or(f64::NAN);
    let extra = format!(
        "ok={solved:.1}% mean_ms={mean:.4} p95_ms={late:.4} median_len_m={long:.2} len/straight={ratio:.3} \
         len/optimum={over:.4} worst={worst:.4}"
    );
    let peer = format!("slamlab-{name}");
    emit(&peer, "plan_office_per_query", middle, &extra);
    Ok(())
}

/// Checks every leg against every wall.
fn check(path: &Path, query: &Query, space: &SegmentSpace) -> Result<()> {
    let ends = (path.points.first(), path.points.last());
    let is_whole = ends == (Some(&query.start), Some(&query.goal));
    ensure!(is_whole, "a path from {ends:?} for {query:?}");
    for leg in path.legs() {
        let distances = space.segments().iter().map(|w| w.distance_to(&leg));
        let nearest = distances.fold(f64::INFINITY, f64::min);
        let keeps_off = nearest > KEEP - 1e-9;
        ensure!(keeps_off, "{leg:?} comes {nearest} m near a wall");
    }
    Ok(())
}

/// A grid without clearance: every leg over open cells is free.
struct CellsOnly;

impl ConfigSpace for CellsOnly {
    fn walls_near(&self, _point: Point2<f64>, _reach: f64) -> Vec<Segment> {
        vec![]
    }

    fn room(&self, _point: Point2<f64>) -> f64 {
        f64::INFINITY
    }

    fn step(&self) -> f64 {
        1.0
    }

    fn bounds(&self) -> (Point2<f64>, Point2<f64>) {
        (Point2::origin(), Point2::new(1000.0, 1000.0))
    }
}

fn over_cells(inputs: &Inputs) -> Result<()> {
    let text = inputs.text("grid_office_1000.txt")?;
    let width = text.lines().next().map_or(0, str::len);
    let cells = text.lines().flat_map(str::bytes);
    let open: Vec<bool> = cells.map(|cell| cell == b'0').collect();
    let (mut times, mut cells) = (vec![], 0.0);
    let lattice = Lattice::from_cells(Point2::origin(), 1.0, width, &open);
    let to_centre = Vector2::new(0.5, 0.5);
    for Segment { a, b } in inputs.segments("astar_queries_100.csv")? {
        let query = Query {
            start: a + to_centre,
            goal: b + to_centre,
        };
        let begin = cpu_ms();
        let mut search = AStar::new(lattice.clone(), &query);
        while search.iterate(&CellsOnly) {}
        let path = search.path();
        let path = path.with_context(|| format!("{query:?} was not solved"))?;
        times.push(cpu_ms() - begin);
        cells += path.length();
    }
    let mean = times.iter().sum::<f64>() / times.len() as f64;
    let extra = format!("mean_ms={mean:.2} total_cost_cells={cells:.1} (no corner cutting)");
    let (workload, middle) = ("astar_grid1000_per_query", median(&mut times));
    emit("slamlab-AStar", workload, middle, &extra);
    Ok(())
}
