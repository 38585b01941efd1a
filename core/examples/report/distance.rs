//! `distance`: is the distance transform exact, and does its time grow linearly with the number of
//! cells? About 20 s.
//!
//! 1. Every cell of 40 grids of up to 128 x 128, from empty over a single source to half of all
//!    cells, against the minimum distance over all sources tried one by one.
//! 2. Time per cell for squares of 256 to 4096 cells, one cell in 200 a source. The exponent of the
//!    time against the number of cells, from a line through the logarithms, must be near 1. Beside
//!    it, the time of a pass that reads a byte and writes four, over as many cells: the limit that
//!    memory sets.
//!
//! Times are processor times, the minimum of several runs.

use std::hint::black_box;

use anyhow::Result;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde_json::json;
use slamlab_core::map::{CellIndex, CellRect, DistanceField};

use crate::clock::least_seconds;
use crate::statistics::fit_line;
use crate::{Args, Outcome};

const SIDES: [usize; 5] = [256, 512, 1024, 2048, 4096];
const DENSITY: f64 = 0.005;
const CELL: f64 = 0.05;
/// Linear is 1; what fits in the caches is a little cheaper per cell.
const MOST_EXPONENT: f64 = 1.1;
/// Rounding of an `f32` at the distances that occur, m.
const ROUNDING: f64 = 1e-6;

pub(crate) fn measure(args: &Args) -> Result<Outcome> {
    let mut outcome = Outcome::default();
    exactness(&mut outcome, args.seeds.unwrap_or(40));
    growth(&mut outcome);
    Ok(outcome)
}

fn exactness(outcome: &mut Outcome, grids: u64) {
    let (mut cells, mut wrong, mut most) = (0, 0, 0.0_f64);
    for seed in 0..grids {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let (width, height) = (rng.random_range(1..=128), rng.random_range(1..=128));
        let density = [0.0, 0.0005, 0.01, 0.5][seed as usize % 4];
        let sources = random(width * height, density, &mut rng);
        let field = DistanceField::new(rect(width, height), CELL, &sources);
        let placed: Vec<_> = (0..sources.len()).filter(|at| sources[*at]).collect();
        for at in 0..sources.len() {
            let (col, row) = (at % width, at / width);
            let squared = placed.iter().map(|s| {
                let (dx, dy) = ((s % width).abs_diff(col), (s / width).abs_diff(row));
                dx * dx + dy * dy
            });
            let nearest = squared.min();
            let expected = nearest.map_or(f64::INFINITY, |s| (s as f64).sqrt() * CELL);
            let found = field.at(CellIndex::new(col as i32, row as i32));
            cells += 1;
            if found != expected {
                most = most.max((found - expected).abs());
                wrong += usize::from((found - expected).abs() > ROUNDING || !found.is_finite());
            }
        }
    }
    outcome.figure("cells_compared", cells);
    outcome.figure("largest_difference_m", most);
    outcome.at_most("cells_unlike_brute_force", wrong as f64, 0.0);
}

fn growth(outcome: &mut Outcome) {
    let (mut table, mut logs) = (vec![], vec![]);
    for side in SIDES {
        let cells = (side * side) as f64;
        let mut rng = ChaCha8Rng::seed_from_u64(7);
        let sources = random(side * side, DENSITY, &mut rng);
        let square = rect(side, side);
        let transform = least_seconds(|| {
            black_box(DistanceField::new(square, CELL, black_box(&sources)));
        });
        let mut out = vec![0.0_f32; side * side];
        let pass = least_seconds(|| {
            for (out, source) in out.iter_mut().zip(black_box(&sources)) {
                *out = f32::from(u8::from(*source));
            }
            black_box(&mut out);
        });
        let (ns, streaming) = (1e9 * transform / cells, 1e9 * pass / cells);
        let row = json!({ "cells": cells, "ns_per_cell": ns, "streaming_ns_per_cell": streaming });
        table.push(row);
        logs.push((cells.ln(), (cells * ns).ln()));
    }
    outcome.figure("growth", table);
    let exponent = fit_line(&logs).1;
    outcome.at_most("time_over_cells_exponent", exponent, MOST_EXPONENT);
}

fn rect(width: usize, height: usize) -> CellRect {
    CellRect {
        min: CellIndex { col: 0, row: 0 },
        max: CellIndex::new(width as i32, height as i32),
    }
}

fn random(cells: usize, density: f64, rng: &mut ChaCha8Rng) -> Vec<bool> {
    (0..cells).map(|_| rng.random::<f64>() < density).collect()
}
