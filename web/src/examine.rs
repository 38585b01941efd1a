//! One thing of the map, asked for when somebody points at it.

use nalgebra::Point2;
use slamlab_core::map::{CellFigures, CellState};
use wasm_bindgen::prelude::wasm_bindgen;

use crate::border::{CellRow, flat};
use crate::run::WebRun;

#[wasm_bindgen]
impl WebRun {
    /// What is known of the cell that holds a point, map frame, m, see `CELL`.
    #[must_use]
    pub fn cell(&self, x: f64, y: f64) -> Vec<f64> {
        let figures = self.slam().layers().figures(Point2::new(x, y));
        flat([CellRow::from(figures)])
    }
}

impl From<CellFigures> for CellRow {
    fn from(of: CellFigures) -> Self {
        Self {
            col: f64::from(of.cell.col),
            row: f64::from(of.cell.row),
            resolution: of.resolution,
            log_odds: of.log_odds,
            probability: of.probability,
            state: match of.state {
                CellState::Unknown => 0.0,
                CellState::Free => -1.0,
                CellState::Occupied => 1.0,
            },
            of_sensor: of.of_sensor,
            of_sonars: of.of_sonars.unwrap_or(f64::NAN),
            hit: of.hit,
            miss: of.miss,
            limit: of.limit,
            after_hit: of.after_hit,
            after_miss: of.after_miss,
        }
    }
}
