//! `grid`: 1 000 scans of 360 beams drawn into the occupancy grid, 5 cm cells, by each rule for
//! free cells.
//!
//! As with the peers, a beam without return clears 30 m, poses are known, and the time is from
//! ranges to cells.

use std::f64::consts::{PI, TAU};

use anyhow::{Context, Result};
use nalgebra::{Point2, Vector2};
use slamlab_core::geom::{Pose2, unit_vector};
use slamlab_core::map::{CellState, Evidence, FreeCells, Grid, GridConfig};

use crate::inputs::Inputs;
use crate::timing::{emit, median_ms};

const BEAMS: usize = 360;
/// What a beam without return clears, m.
const CLEARS: f64 = 30.0;
const REPEATS: usize = 5;

pub(crate) fn run(inputs: &Inputs) -> Result<()> {
    let scans = inputs.rows::<{ 3 + BEAMS }>("map_scans_1000x360.csv")?;
    let directions: Vec<_> = (0..BEAMS)
        .map(|beam| unit_vector(TAU * beam as f64 / BEAMS as f64 - PI))
        .collect();
    for (name, free_cells) in [
        ("crossed", FreeCells::Crossed),
        ("bresenham", FreeCells::Bresenham),
        ("area", FreeCells::Area),
    ] {
        let config = GridConfig {
            free_cells,
            ..GridConfig::default()
        };
        let mut drawn = None;
        let ms = median_ms(REPEATS, || {
            let mut grid = Grid::new(config)?;
            for scan in &scans {
                let pose = Pose2::new(scan[0], scan[1], scan[2]);
                grid.draw(&evidence(&scan[3..], &directions), &pose);
            }
            drawn = Some(grid);
            Ok(())
        })?;
        let grid = drawn.context("nothing was drawn")?;
        let cells = grid.blocks_since(0).flat_map(|(_, cells)| cells);
        let is_occupied = |odds: &&f32| grid.state_of(**odds) == CellState::Occupied;
        let occupied = cells.filter(is_occupied).count();
        let peer = format!("slamlab-Grid({name})");
        let extra = format!("occupied_cells={occupied} (no-return beams clear 30 m)");
        emit(&peer, "gridmap_1000x360_2000x2000", ms, &extra);
    }
    Ok(())
}

/// The evidence of a scan, with every beam believed to its end; -1 means no range.
fn evidence(ranges: &[f64], directions: &[Vector2<f64>]) -> Evidence {
    let mut evidence = Evidence::default();
    for (&range, direction) in ranges.iter().zip(directions) {
        let is_hit = range > 0.0;
        let end = Point2::from(*direction * if is_hit { range } else { CLEARS });
        evidence.free.push([Point2::origin(), end]);
        if is_hit {
            evidence.hits.push(end);
        }
    }
    evidence
}
