//! The map that dead reckoning alone would have drawn, flattened for the page.

use serde::{Deserialize, Serialize};
use tsify::Tsify;
use wasm_bindgen::prelude::wasm_bindgen;

use crate::border::{Typed, typed};
use crate::run::{Source, WebRun};
use crate::view::GridChange;

/// That map where it changed; its frame is the map frame.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Tsify)]
#[tsify(missing_as_null)]
pub struct DeadReckonedChange {
    /// The map is never redrawn: always 0.
    pub generation: u32,
    /// Pass it to the next call to get what changed since.
    pub revision: f64,
    /// Blocks that changed.
    pub grid: Option<GridChange>,
}

#[wasm_bindgen]
impl WebRun {
    /// From here on, also draws the map that dead reckoning alone would have drawn.
    pub fn draw_dead_reckoned(&mut self) {
        match &mut self.source {
            Source::Simulation(sim) => sim.experiment.draw_dead_reckoned(),
            Source::Recording(replay) => replay.draw_dead_reckoned(),
            Source::Live(live) => live.draw_dead_reckoned(),
        }
    }

    /// That map since `revision`; empty if it is not being drawn.
    ///
    /// # Errors    None that a page can cause.
    pub fn dead_reckoned(&self, revision: f64) -> Typed<DeadReckonedChange> {
        let grid = self.session().dead_reckoned();
        typed(&DeadReckonedChange {
            generation: 0,
            revision: grid.map_or(0.0, |grid| grid.revision() as f64),
            grid: grid.and_then(|grid| GridChange::since(grid, revision as u64)),
        })
    }
}
