//! `grid_rays`: a million beams over the cells of `grid_office_1000.txt`, a thousand from each of a thousand places, up to 30 m.
//!
//! The grid is made ready once, outside of the time; what that takes is told beside it. The directions are those of a fan, turned by
//! the heading of each place.

use std::f64::consts::TAU;

use anyhow::Result;
use nalgebra::{Point2, Vector2};
use slamlab_core::geom::sin_cos;
use slamlab_core::map::{CellIndex, CellRect, GridCaster};

use crate::inputs::Inputs;
use crate::timing::{cpu_ms, emit, median_ms};

const BEAMS: usize = 1000;
const CELL: f64 = 0.05;
const RANGE: f64 = 30.0;
const REPEATS: usize = 5;

pub(crate) fn run(inputs: &Inputs) -> Result<()> {
    let rows = inputs.lines("grid_office_1000.txt")?;
    let cells = rows.iter().flat_map(|row| row.bytes());
    let occupied: Vec<bool> = cells.map(|cell| cell == b'1').collect();
    let rect = CellRect {
        min: CellIndex { col: 0, row: 0 },
        max: CellIndex {
            col: rows.first().map_or(0, String::len) as i32,
            row: rows.len() as i32,
        },
    };
    let places = inputs.table::<3>("ray_poses_1000.csv")?;
    let fan: Vec<_> = (0..BEAMS)
        .map(|beam| sin_cos(TAU * beam as f64 / BEAMS as f64))
        .collect();
    let begin = cpu_ms();
    let caster = GridCaster::new(rect, CELL, &occupied);
    let ready = cpu_ms() - begin;
    let (mut sum, mut hits) = (0.0, 0);
    let ms = median_ms(REPEATS, || {
        (sum, hits) = (0.0, 0);
        for [x, y, heading] in &places {
            let (sin, cos) = sin_cos(*heading);
            for (s, c) in &fan {
                let way = Vector2::new(c * cos - s * sin, s * cos + c * sin);
                if let Some(range) = caster.cast(Point2::new(*x, *y), way, RANGE) {
                    sum += range;
                    hits += 1;
                }
            }
        }
        Ok(())
    })?;
    let mean = sum / f64::from(hits);
    let extra = format!("mean_range={mean:.4} hits={hits} preprocess_ms={ready:.1}");
    emit(
        "slamlab-GridCaster",
        "raycast_grid1000_1e6beams",
        ms,
        &extra,
    );
    Ok(())
}
