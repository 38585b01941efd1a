//! What one map says about walls of another that lie somewhere in it: like [`agreement`] for points
//! on surfaces, with cells in place of surfaces.
//!
//! [`agreement`]: super::super::agreement

use nalgebra::Point2;

use super::super::agreement::{AGREES_WITHIN, Agreement, CONTRADICTS_BEYOND, Says};
use crate::geom::Pose2;
use crate::map::{CellIndex, CellState, Grid};

/// Of the walls of either map about which the other says something, this part has to agree.
const LEAST_PART: f64 = 0.92;

/// What `grid` says about `walls` that lie at `pose` in it.
pub(super) fn said(walls: &[Point2<f64>], pose: &Pose2, grid: &Grid) -> Agreement {
    Agreement::sum(walls.iter().map(|wall| says(grid, *pose * *wall)))
}

/// Whether nearly everything about which something is said agrees.
pub(super) fn fits(said: &Agreement) -> bool {
    said.part() >= LEAST_PART
}

/// What a grid says about a wall at a place.
fn says(grid: &Grid, place: Point2<f64>) -> Says {
    let cells = |metres: f64| (metres / grid.resolution()).ceil() as i32;
    let (near, far) = (cells(AGREES_WITHIN), cells(CONTRADICTS_BEYOND));
    let middle = grid.cell_at(place);
    let mut is_free = true;
    let mut nearest = i32::MAX;
    for row in -far..=far {
        for col in -far..=far {
            let cell = CellIndex::new(
                middle.col.saturating_add(col),
                middle.row.saturating_add(row),
            );
            let away = col.abs().max(row.abs());
            match grid.state(cell) {
                CellState::Occupied => nearest = nearest.min(away),
                CellState::Free => {}
                CellState::Unknown if away <= 1 => is_free = false,
                CellState::Unknown => {}
            }
        }
    }
    match nearest {
        _ if nearest <= near => Says::Agrees,
        i32::MAX if is_free => Says::Contradicts,
        _ => Says::Nothing,
    }
}
