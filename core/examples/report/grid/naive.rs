//! The occupancy grid once more, directly from the definitions and without regard to speed: a table
//! of cells, and each rule in its plain form.

use std::collections::{HashMap, HashSet};

use nalgebra::Point2;
use slamlab_core::geom::Length;
use slamlab_core::map::{CellIndex, FreeCells, Grid, GridConfig};

use super::Seen;

type Cell = (i32, i32);
/// Ends of a free ray, in cells.
type Way = [Point2<f64>; 2];

/// Cells farther than this from a side are surely inside or outside; in cells squared.
const TOUCHES: f64 = 1e-6;
/// Between beams farther apart than this nothing is free, rad.
const GAP: f64 = 0.1;

/// Log-odds by cell.
#[derive(Default)]
pub(super) struct NaiveGrid {
    odds: HashMap<Cell, f32>,
    unsure: HashSet<Cell>,
}

impl NaiveGrid {
    pub(super) fn draw(&mut self, seen: &Seen, config: &GridConfig) {
        let log_odds = |p: f64| (p / (1.0 - p)).ln() as f32;
        let limit = log_odds(1.0 - config.clamp);
        let hits: HashSet<Cell> = (seen.evidence.hits.iter())
            .map(|hit| cell(in_cells(seen, config, *hit)))
            .collect();
        let (free, unsure) = free(seen, config);
        self.unsure.extend(unsure);
        let hit = hits.iter().map(|cell| (*cell, log_odds(config.hit)));
        let missed = free.difference(&hits);
        let miss = missed.map(|cell| (*cell, log_odds(config.miss)));
        for (cell, by) in hit.chain(miss).collect::<Vec<_>>() {
            let odds = self.odds.entry(cell).or_default();
            *odds = (*odds + by).min(limit).max(-limit);
        }
    }

    /// Cells that differ in any bit, cells compared, and cells skipped.
    pub(super) fn differences(&self, grid: &Grid) -> [usize; 3] {
        let mut all: HashSet<Cell> = self.odds.keys().copied().collect();
        if let Some(rect) = grid.rect_where(|odds| odds != 0.0) {
            let known = rect.cells().filter(|cell| grid.log_odds(*cell) != 0.0);
            all.extend(known.map(|CellIndex { col, row }| (col, row)));
        }
        let sure: Vec<_> = all.difference(&self.unsure).collect();
        let differs = |cell: &&&Cell| {
            let own = self.odds.get(**cell).copied().unwrap_or(0.0);
            own.to_bits() != odds_in(grid, ***cell).to_bits()
        };
        let wrong = sure.iter().filter(differs).count();
        [wrong, sure.len(), all.len() - sure.len()]
    }
}

/// Cells that are free, and those for which this is uncertain.
fn free(seen: &Seen, config: &GridConfig) -> (HashSet<Cell>, Vec<Cell>) {
    let way = |way: &[Point2<f64>; 2]| way.map(|end| in_cells(seen, config, end));
    let ways: Vec<Way> = seen.evidence.free.iter().map(way).collect();
    match config.free_cells {
        FreeCells::Crossed => (ways.iter().flat_map(crossed).collect(), vec![]),
        FreeCells::Bresenham => (ways.iter().flat_map(bresenham).collect(), vec![]),
        FreeCells::Area => between(&ways),
    }
}

/// A ray is cut wherever it crosses a border of cells; each piece lies in the cell of its middle.
fn crossed(way: &Way) -> Vec<Cell> {
    let [start, end] = way;
    let delta = end - start;
    let mut cuts = vec![0.0, 1.0];
    for axis in 0..2 {
        let (low, high) = (start[axis].min(end[axis]), start[axis].max(end[axis]));
        let borders = (low.ceil() as i64)..=(high.floor() as i64);
        cuts.extend(borders.map(|border| (border as f64 - start[axis]) / delta[axis]));
    }
    cuts.sort_by(f64::total_cmp);
    let middle = |cut: &[f64]| start + delta * (0.5 * (cut[0] + cut[1]));
    cuts.windows(2).map(middle).map(cell).collect()
}

/// One cell per step along the longer axis, the other coordinate rounded.
fn bresenham(way: &Way) -> Vec<Cell> {
    let ((ax, ay), (bx, by)) = (cell(way[0]), cell(way[1]));
    let n = (bx - ax).abs().max((by - ay).abs());
    let off = |d: i32, i: i32| {
        let part = f64::from(d.abs()) * f64::from(i) / f64::from(n.max(1));
        d.signum() * (part + 0.5).floor() as i32
    };
    let step = |i| (ax + off(bx - ax, i), ay + off(by - ay, i));
    (0..=n).map(step).collect()
}

/// Cells whose centre lies in the triangle between a ray and the next one around.
fn between(ways: &[Way]) -> (HashSet<Cell>, Vec<Cell>) {
    let (mut inside, mut unsure) = (HashSet::new(), vec![]);
    for (at, way) in ways.iter().enumerate() {
        let next = &ways[(at + 1) % ways.len()];
        let (along, on) = (way[1] - way[0], next[1] - next[0]);
        if along.angle(&on) > GAP {
            continue;
        }
        let [a, b, c] = [way[0], a_cell_short(way), a_cell_short(next)];
        let corners = [a, b, c];
        let (low, high) = (a.inf(&b).inf(&c), a.sup(&b).sup(&c));
        for row in low.y.floor() as i32..=high.y.floor() as i32 {
            for col in low.x.floor() as i32..=high.x.floor() as i32 {
                match is_in_triangle((col, row), &corners) {
                    Some(true) => {
                        inside.insert((col, row));
                    }
                    Some(false) => {}
                    None => unsure.push((col, row)),
                }
            }
        }
    }
    (inside, unsure)
}

/// `None` if the centre lies on a side.
fn is_in_triangle((col, row): Cell, corners: &[Point2<f64>; 3]) -> Option<bool> {
    let centre = Point2::new(f64::from(col) + 0.5, f64::from(row) + 0.5);
    let area = |i: usize| {
        let (a, b) = (corners[i], corners[(i + 1) % 3]);
        (b - a).perp(&(centre - a))
    };
    let areas = [area(0), area(1), area(2)];
    let is_within = |least: f64| {
        areas.iter().all(|area| *area > least) || areas.iter().all(|area| *area < -least)
    };
    match (is_within(TOUCHES), is_within(-TOUCHES)) {
        (true, _) => Some(true),
        (false, true) => None,
        (false, false) => Some(false),
    }
}

fn a_cell_short([start, end]: &Way) -> Point2<f64> {
    let cells = (end - start).length();
    start + (end - start) * ((cells - 1.0).max(0.0) / cells)
}

fn in_cells(seen: &Seen, config: &GridConfig, p: Point2<f64>) -> Point2<f64> {
    (seen.pose * p) * (1.0 / config.resolution)
}

fn cell(p: Point2<f64>) -> Cell {
    (p.x.floor() as i32, p.y.floor() as i32)
}

fn odds_in(grid: &Grid, (col, row): Cell) -> f32 {
    grid.log_odds(CellIndex { col, row })
}
