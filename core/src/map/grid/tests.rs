use std::collections::{BTreeMap, BTreeSet};

use proptest::prelude::*;

use super::*;
use crate::points::fixture::{beam, scan_of};

fn beam_to(end: (f64, f64), is_hit: bool) -> Points {
    let (from, to) = (Point2::origin(), Point2::new(end.0, end.1));
    scan_of([beam(0, from, to, is_hit)])
}

fn grid() -> Grid {
    Grid::new(GridConfig::default()).unwrap()
}

#[test]
fn beam_clears_its_way_and_marks_its_end() {
    let mut grid = grid();
    grid.insert(&beam_to((1.0, 0.02), true), &Pose2::new(0.02, 0.0, 0.0));
    let at = |x: f64| grid.probability(grid.cell_at(Point2::new(x, 0.02)));
    assert!((at(0.5) - 0.4).abs() < 1e-6);
    assert!((at(1.02) - 0.7).abs() < 1e-6);
    assert!((at(1.2) - 0.5).abs() < 1e-12);
}

#[test]
fn repeated_sightings_follow_bayes_until_the_clamp() {
    let mut grid = grid();
    let cell = grid.cell_at(Point2::new(1.01, 0.0));
    let mut odds: f64 = 1.0;
    for _ in 0..3 {
        grid.insert(&beam_to((1.01, 0.0), true), &Pose2::identity());
        odds *= 0.7 / 0.3;
        assert!((grid.probability(cell) - odds / (1.0 + odds)).abs() < 1e-6);
    }
    for _ in 0..50 {
        grid.insert(&beam_to((1.01, 0.0), true), &Pose2::identity());
    }
    assert!((grid.probability(cell) - 0.98).abs() < 1e-6);
    for _ in 0..50 {
        grid.insert(&beam_to((2.0, 0.0), false), &Pose2::identity());
    }
    assert_eq!(grid.state(cell), CellState::Free);
}

/// The cells that a line enters, row by row, or column by column if it is steeper: from where it
/// enters to where it leaves. A line that meets a corner exactly passes it where the longer axis is
/// greater, which the last term decides.
fn entered(start: Point2<f64>, end: Point2<f64>) -> Vec<(i32, i32)> {
    let is_flat = (end.x - start.x).abs() >= (end.y - start.y).abs();
    let [mut a, mut b] = [start, end].map(|p| if is_flat { [p.x, p.y] } else { [p.y, p.x] });
    if a[0] > b[0] {
        (a, b) = (b, a);
    }
    let at = |border: f64| {
        let part = (border - a[1]) / (b[1] - a[1]);
        (a[0] + part * (b[0] - a[0]) + 1.0 / f64::from(1 << 30) / 16.0).min(b[0])
    };
    let (low, high) = (a[1].min(b[1]).floor(), a[1].max(b[1]).floor());
    let mut cells = vec![];
    for row in low as i32..=high as i32 {
        let (below, above) = (f64::from(row), f64::from(row + 1));
        let (enters, leaves) = if a[1] < b[1] {
            (below, above)
        } else {
            (above, below)
        };
        let from = if row == a[1].floor() as i32 {
            a[0]
        } else {
            at(enters)
        };
        let to = if row == b[1].floor() as i32 {
            b[0]
        } else {
            at(leaves)
        };
        let cols = from.floor() as i32..=to.floor() as i32;
        cells.extend(cols.map(|col| if is_flat { (col, row) } else { (row, col) }));
    }
    cells
}

/// Log-odds of each cell ever seen, by definition: for each scan the set of cells hit, and of cells
/// crossed but not hit.
#[derive(Default)]
struct Naive(BTreeMap<(i32, i32), f32>);

impl Naive {
    fn insert(&mut self, points: &Points, map_from_robot: &Pose2, config: &GridConfig) {
        let scale = 1.0 / config.resolution;
        let in_cells = |p: Point2<f64>| Point2::from((*map_from_robot * p).coords * scale);
        let (mut hits, mut crossed) = (BTreeSet::new(), BTreeSet::new());
        for beam in &points.beams {
            let end = in_cells(beam.end_in_robot);
            if beam.is_hit {
                hits.insert((end.x.floor() as i32, end.y.floor() as i32));
            }
            crossed.extend(entered(in_cells(beam.origin_in_robot), end));
        }
        let log_odds = |p: f64| libm::log(p / (1.0 - p)) as f32;
        let limit = log_odds(1.0 - config.clamp);
        for cell in hits.union(&crossed) {
            let by = log_odds(if hits.contains(cell) {
                config.hit
            } else {
                config.miss
            });
            let value = self.0.entry(*cell).or_default();
            *value = (*value + by).clamp(-limit, limit);
        }
    }

    /// Compares every cell, exact to the bit.
    fn check(&self, grid: &Grid) {
        let mut known = 0;
        for (block, cells) in grid.blocks_since(0) {
            for (offset, value) in cells.iter().enumerate() {
                let (col, row) = ((offset % BLOCK_CELLS) as i32, (offset / BLOCK_CELLS) as i32);
                let expected = self
                    .0
                    .get(&(block.col * BLOCK + col, block.row * BLOCK + row));
                known += usize::from(expected.is_some());
                assert_eq!(value.to_bits(), expected.copied().unwrap_or(0.0).to_bits());
            }
        }
        assert_eq!(known, self.0.len());
    }
}

/// Cells that are as free as the clamp allows are skipped, and whole blocks of them share their
/// memory: neither changes the result.
#[test]
fn a_hall_seen_for_long_and_then_filled_is_that_of_the_naive_grid() {
    let (mut grid, mut naive) = (grid(), Naive::default());
    let config = *grid.config();
    let pose = Pose2::new(1.6, 1.6, 0.0);
    let mut see = |radius: f64, is_hit: bool, times: usize| {
        let mut points = beam_to((0.0, 0.0), false);
        points.beams = (0..1200)
            .map(|beam| crate::geom::sin_cos(std::f64::consts::TAU * f64::from(beam) / 1200.0))
            .flat_map(|(sin, cos)| beam_to((radius * cos, radius * sin), is_hit).beams)
            .collect();
        for _ in 0..times {
            grid.insert(&points, &pose);
            naive.insert(&points, &pose, &config);
        }
        naive.check(&grid);
        let blocks = grid.directory.iter();
        blocks
            .filter(|(_, block)| std::ptr::eq(block.cells(), &*grid.free))
            .count()
    };
    assert_eq!(see(6.0, true, 1), 0);
    let shared = see(6.0, true, 20);
    assert!(shared >= 4, "{shared}");
    assert_eq!(see(1.0, true, 3), shared - 1);
    assert_eq!(see(6.0, false, 30), shared);
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, ..ProptestConfig::default() })]
    #[test]
    fn every_cell_is_that_of_the_naive_grid(
        scans in proptest::collection::vec(
            (
                (-9.0..9.0_f64, -9.0..9.0_f64, -3.2..3.2_f64),
                proptest::collection::vec(((-12.0..12.0_f64, -12.0..12.0_f64), any::<bool>()), 0..40),
            ),
            1..12,
        ),
        grain in prop_oneof![Just(0.0), Just(0.5)],
    ) {
        // Half of the cases have their ends on the borders of cells, where rounding decides.
        let snap = |v: f64| if grain > 0.0 { (v / grain).round() * grain } else { v };
        let config = GridConfig::default();
        let (mut grid, mut naive) = (grid(), Naive::default());
        for ((x, y, heading), ends) in &scans {
            let pose = Pose2::new(snap(*x), snap(*y), if grain > 0.0 { 0.0 } else { *heading });
            let mut points = beam_to((0.0, 0.0), false);
            points.beams = ends
                .iter()
                .flat_map(|&(end, is_hit)| beam_to((snap(end.0), snap(end.1)), is_hit).beams)
                .collect();
            grid.insert(&points, &pose);
            naive.insert(&points, &pose, &config);
        }
        naive.check(&grid);
    }
}

#[test]
fn grows_to_all_sides_and_keeps_what_it_knew() {
    let mut grid = grid();
    let ends = [
        (30.0, 0.0),
        (-30.0, 1.0),
        (0.0, 40.0),
        (1.0, -40.0),
        (-90.0, -90.0),
    ];
    for end in ends {
        grid.insert(&beam_to(end, true), &Pose2::identity());
    }
    for end in ends {
        assert_eq!(
            grid.state(grid.cell_at(Point2::new(end.0, end.1))),
            CellState::Occupied,
            "{end:?}"
        );
    }
    let bounds = grid.bounds().unwrap();
    assert!(bounds.min.col <= -1800 && bounds.max.row >= 800);
}

#[test]
fn absurd_points_take_no_memory() {
    let mut grid = grid();
    grid.insert(&beam_to((1e7, 1e7), true), &Pose2::identity());
    grid.insert(&beam_to((f64::NAN, 0.0), true), &Pose2::identity());
    assert!(grid.block_count() <= 70_000);
    assert!(matches!(grid.is_whole(), Err(GridError::Full { .. })));
}

#[test]
fn a_full_grid_says_so_and_keeps_what_it_has() {
    let config = GridConfig {
        max_blocks: 2,
        ..GridConfig::default()
    };
    let mut grid = Grid::new(config).unwrap();
    grid.insert(&beam_to((1.01, 0.0), true), &Pose2::identity());
    assert_eq!(grid.is_whole(), Ok(()));
    // Four blocks in a row: two of them are more than it may hold.
    grid.insert(&beam_to((12.0, 0.0), false), &Pose2::identity());
    let error = grid.is_whole().unwrap_err();
    assert_eq!(
        error.to_string(),
        "grid: holds 2 blocks of at most 2; what was seen beyond is skipped"
    );
    let at = |x: f64| grid.probability(grid.cell_at(Point2::new(x, 0.0)));
    assert!(at(0.5) < 0.4 && at(5.0) < 0.5 && at(1.01) > 0.5);
    assert!((at(11.0) - 0.5).abs() < 1e-12);
}

#[test]
fn only_changed_blocks_are_reported() {
    let mut grid = grid();
    grid.insert(&beam_to((30.0, 0.0), true), &Pose2::identity());
    let before = grid.revision();
    grid.insert(&beam_to((1.0, 1.0), true), &Pose2::identity());
    let changed: Vec<_> = grid
        .blocks_since(before)
        .map(|(b, _)| (b.col, b.row))
        .collect();
    assert_eq!(changed, [(0, 0)]);
    assert_eq!(grid.blocks_since(0).count(), grid.block_count());
}

#[test]
fn bad_configuration_is_named() {
    let config = GridConfig {
        resolution: 0.0,
        ..GridConfig::default()
    };
    let error = Grid::new(config).unwrap_err().to_string();
    assert_eq!(error, "grid: resolution is 0, expected 0.01 to 0.5");
}
