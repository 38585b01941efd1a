//! What a person sees of a map, flattened for the page.

use nalgebra::Point2;
use slamlab_core::geom::{Pose2, Segment};
use slamlab_core::map::{CellState, Grid};
use slamlab_core::points::Points;
use slamlab_core::slam::Slam;
use wasm_bindgen::prelude::wasm_bindgen;

/// Blocks of the grid that changed.
#[wasm_bindgen]
#[derive(Clone, Debug, PartialEq)]
pub struct GridBlocks {
    revision: u64,
    index: Vec<i32>,
    cells: Vec<u8>,
}

#[wasm_bindgen]
impl GridBlocks {
    /// Hand it in next time to get what changed since.
    #[wasm_bindgen(getter)]
    #[must_use]
    pub fn revision(&self) -> f64 {
        self.revision as f64
    }

    /// Column and row of each block, in blocks.
    #[wasm_bindgen(getter)]
    #[must_use]
    pub fn index(&self) -> Vec<i32> {
        self.index.clone()
    }

    /// 64 x 64 cells of each block in rows from the lower left: 0 unknown, else 1 + 254 p, p the probability of an
    /// obstacle.
    #[wasm_bindgen(getter)]
    #[must_use]
    pub fn cells(&self) -> Vec<u8> {
        self.cells.clone()
    }
}

impl GridBlocks {
    /// The blocks of `grid` that changed after `since`.
    #[must_use]
    pub fn since(grid: &Grid, since: f64) -> Self {
        let mut blocks = Self {
            revision: grid.revision(),
            index: vec![],
            cells: vec![],
        };
        for (block, log_odds) in grid.blocks_since(since as u64) {
            blocks.index.extend([block.col, block.row]);
            blocks.cells.extend(log_odds.iter().map(|&l| tone(l)));
        }
        blocks
    }
}

/// A probability as one byte that keeps "nothing known" apart from "as likely as not".
fn tone(log_odds: f32) -> u8 {
    if log_odds == 0.0 {
        return 0;
    }
    let p = 1.0 / (1.0 + (-log_odds).exp());
    1 + (254.0 * p).round() as u8
}

/// Area known to be free, m².
pub(crate) fn free_area(grid: &Grid) -> f64 {
    let free = grid
        .blocks_since(0)
        .flat_map(|(_, cells)| cells)
        .filter(|&&l| grid.state_of(l) == CellState::Free)
        .count();
    free as f64 * grid.resolution() * grid.resolution()
}

/// x y of what the scan hit, map frame.
pub(crate) fn hits(points: Option<&Points>, map_from_robot: &Pose2) -> Vec<f32> {
    let hits = points.into_iter().flat_map(Points::hits);
    hits.flat_map(|beam| flat(*map_from_robot * beam.end_in_robot))
        .collect()
}

/// For each wall: alpha, r, var alpha, cov alpha r, var r, x1, y1, x2, y2, matched in the last scan, confirmed.
pub(crate) fn lines(slam: &Slam) -> Vec<f64> {
    let is_matched = |id| slam.matches().iter().any(|m| m.landmark == id);
    let mut numbers = vec![];
    for wall in slam.landmarks() {
        let [a, b] = wall.ends;
        numbers.extend([
            wall.line.alpha(),
            wall.line.r(),
            wall.cov[(0, 0)],
            wall.cov[(0, 1)],
            wall.cov[(1, 1)],
        ]);
        numbers.extend([a.x, a.y, b.x, b.y]);
        numbers
            .extend([is_matched(wall.id), wall.is_confirmed].map(|yes| f64::from(u8::from(yes))));
    }
    numbers
}

/// x1 y1 x2 y2 of each segment, moved into the map frame.
pub(crate) fn segments<'a>(
    segments: impl Iterator<Item = &'a Segment>,
    map_from: &Pose2,
) -> Vec<f32> {
    segments
        .flat_map(|s| [flat(*map_from * s.a), flat(*map_from * s.b)])
        .flatten()
        .collect()
}

/// x y of each point.
pub(crate) fn polyline(points: &[Point2<f64>]) -> Vec<f32> {
    points.iter().copied().flat_map(flat).collect()
}

fn flat(point: Point2<f64>) -> [f32; 2] {
    [point.x as f32, point.y as f32]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_known_is_not_as_likely_as_not() {
        assert_eq!(tone(0.0), 0);
        assert_eq!(tone(1e-6), 128);
        assert_eq!(tone(-30.0), 1);
        assert_eq!(tone(30.0), 255);
    }
}
