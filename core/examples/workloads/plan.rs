//! `plan`: paths for a disc of 0.2 m through the 100 walls of `world_office.csv`, and over the
//! cells of `grid_office_1000.txt`.
//!
//! Time is that of a query from question to path; the space is made once, as the peers' checkers
//! are. Every path is checked against every wall one by one, outside of the time. The visibility
//! graph gives the optimum that lengths are compared with.

use anyhow::{Context, Result, ensure};
use nalgebra::Point2;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use slamlab_core::geom::Segment;
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

/// Planner, its iterations, queries, and what is done with the path.
const RUNS: &[(&str, Planner, usize, usize, After)] = &[
    (
        "RRTConnect",
        Planner::RrtConnect,
        100_000,
        1000,
        After::Nothing,
    ),
    (
        "RRTConnect,shortened",
        Planner::RrtConnect,
        100_000,
        1000,
        After::Shorten,
    ),
    (
        "RRTConnect,tight",
        Planner::RrtConnect,
        100_000,
        1000,
        After::Tighten,
    ),
    ("RRT", Planner::Rrt, 100_000, 1000, After::Nothing),
    ("RRTstar2000", Planner::RrtStar, 2000, 100, After::Nothing),
    (
        "InformedRRTstar2000",
        Planner::InformedRrtStar,
        2000,
        100,
        After::Nothing,
    ),
    (
        "Visibility",
        Planner::Visibility,
        usize::MAX,
        1000,
        After::Nothing,
    ),
];

pub(crate) fn run(inputs: &Inputs) -> Result<()> {
    over_walls(inputs)?;
    over_cells(inputs)
}

fn over_walls(inputs: &Inputs) -> Result<()> {
    let walls: Vec<Segment> = (inputs.table::<4>("world_office.csv")?.into_iter())
        .map(|[ax, ay, bx, by]| Segment::new(Point2::new(ax, ay), Point2::new(bx, by)))
        .collect();
    let queries: Vec<Query> = (inputs.table::<4>("plan_queries_1000.csv")?.into_iter())
        .map(|[ax, ay, bx, by]| Query {
            start: Point2::new(ax, ay),
            goal: Point2::new(bx, by),
        })
        .collect();
    let bounds = (Point2::origin(), Point2::new(SIDE, SIDE));
    let space = SegmentSpace::new(walls, KEEP, bounds)?;
    let optima: Vec<f64> = queries.iter().map(|query| optimum(&space, query)).collect();
    for run in RUNS {
        measure(run, &space, &queries, &optima)?;
    }
    Ok(())
}

fn optimum(space: &SegmentSpace, query: &Query) -> f64 {
    let sampler = || Sampler::anywhere(space);
    let search = Search::new(
        Planner::Visibility,
        space,
        *query,
        RrtConfig::default(),
        sampler,
    );
    let mut rng = ChaCha8Rng::seed_from_u64(0);
    let found = search.ok().and_then(|mut search| {
        search.step(space, &mut rng, usize::MAX);
        search.path()
    });
    found.map_or(f64::NAN, |path| path.length())
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
        let sampler = || Sampler::anywhere(space);
        let mut search = Search::new(*planner, space, *query, RrtConfig::default(), sampler)?;
        search.step(space, &mut rng, *iterations);
        let path = search.path().map(|path| match after {
            After::Nothing => path,
            After::Shorten => shorten(&path, space),
            After::Tighten => pull_tight(&shorten(&path, space), space),
        });
        times.push(cpu_ms() - begin);
        if let Some(path) = path {
            check(&path, query, space)?;
            lengths.push(path.length());
            straight.push(path.length() / (query.goal - query.start).norm());
            excess.push(path.length() / optima[number]);
        }
    }
    let asked = times.len() as f64;
    let solved = 100.0 * lengths.len() as f64 / asked;
    let mean = times.iter().sum::<f64>() / asked;
    let middle = median(&mut times);
    let late = times[times.len() * 95 / 100];
    let (long, ratio, over) = (
        median(&mut lengths),
        median(&mut straight),
        median(&mut excess),
    );
    let worst = excess.last().copied().unwrap_or(f64::NAN);
    let extra = format!(
        "ok={solved:.1}% mean_ms={mean:.4} p95_ms={late:.4} median_len_m={long:.2} len/straight={ratio:.3} \
         len/optimum={over:.4} worst={worst:.4}"
    );
    emit(
        &format!("slamlab-{name}"),
        "plan_office_per_query",
        middle,
        &extra,
    );
    Ok(())
}

/// Every leg against every wall.
fn check(path: &Path, query: &Query, space: &SegmentSpace) -> Result<()> {
    let ends = (path.points.first(), path.points.last());
    ensure!(
        ends == (Some(&query.start), Some(&query.goal)),
        "a path from {ends:?} for {query:?}"
    );
    for leg in path.legs() {
        let walls = space.segments().iter();
        let nearest = walls
            .map(|w| w.distance_to(&leg))
            .fold(f64::INFINITY, f64::min);
        ensure!(
            nearest > KEEP - 1e-9,
            "{leg:?} comes {nearest} m near a wall"
        );
    }
    Ok(())
}

/// Nothing but cells: no room, and every leg free that steps over open ones.
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
    let rows = inputs.lines("grid_office_1000.txt")?;
    let width = rows.first().map_or(0, String::len);
    let open: Vec<bool> = rows
        .iter()
        .flat_map(|row| row.bytes().map(|cell| cell == b'0'))
        .collect();
    let (mut times, mut cells) = (vec![], 0.0);
    let lattice = Lattice::from_cells(Point2::origin(), 1.0, width, &open);
    for [ax, ay, bx, by] in inputs.table::<4>("astar_queries_100.csv")? {
        let centre = |x: f64, y: f64| Point2::new(x + 0.5, y + 0.5);
        let query = Query {
            start: centre(ax, ay),
            goal: centre(bx, by),
        };
        let begin = cpu_ms();
        let mut search = AStar::new(lattice.clone(), &query);
        while search.iterate(&CellsOnly) {}
        let path = search
            .path()
            .with_context(|| format!("{query:?} was not solved"))?;
        times.push(cpu_ms() - begin);
        cells += path.length();
    }
    let mean = times.iter().sum::<f64>() / times.len() as f64;
    let extra = format!("mean_ms={mean:.2} total_cost_cells={cells:.1} (no corner cutting)");
    emit(
        "slamlab-AStar",
        "astar_grid1000_per_query",
        median(&mut times),
        &extra,
    );
    Ok(())
}
