//! Changes of the map by hand, for the page.

use nalgebra::Point2;
use tsify::Ts;
use wasm_bindgen::prelude::wasm_bindgen;

use crate::border::{EditName, EditRow, WebError, flat};
use crate::run::{Source, WebRun};

#[wasm_bindgen]
impl WebRun {
    /// Changes the map: x y of the corners of a region, or of a polyline, map frame, m.
    ///
    /// # Errors    A sentence on why it is impossible: another method than scan matching, or wrong
    /// corners.
    pub fn edit(&mut self, what: &Ts<EditName>, corners: &[f64]) -> Result<(), WebError> {
        let kind = what.to_rust()?.into();
        let (pairs, _) = corners.as_chunks::<2>();
        let corners: Vec<_> = pairs.iter().map(|[x, y]| Point2::new(*x, *y)).collect();
        match &mut self.source {
            Source::Simulation(sim) => sim.experiment.edit(kind, &corners)?,
            Source::Recording(replay) => replay.edit(kind, &corners)?,
            Source::Live(live) => live.edit(kind, &corners)?,
        }
        Ok(())
    }

    /// Takes back the last change; `false` if there is none.
    pub fn undo_edit(&mut self) -> bool {
        match &mut self.source {
            Source::Simulation(sim) => sim.experiment.undo_edit(),
            Source::Recording(replay) => replay.undo_edit(),
            Source::Live(live) => live.undo_edit(),
        }
    }

    /// Outlines of the changes that are still in place, see `EDIT`.
    #[must_use]
    pub fn edits(&self) -> Vec<f32> {
        let edits = self
            .slam()
            .view()
            .map
            .into_iter()
            .flat_map(|map| map.edits());
        let sides = edits.enumerate().flat_map(|(number, edit)| {
            let kind = EditName::from(&edit.kind);
            let around = (kind == EditName::Erase).then(|| edit.corners[0]);
            let corners: Vec<_> = edit.corners.into_iter().chain(around).collect();
            let side = move |ends: &[Point2<f64>]| EditRow {
                x1: ends[0].x as f32,
                y1: ends[0].y as f32,
                x2: ends[1].x as f32,
                y2: ends[1].y as f32,
                kind: f32::from(kind as u8),
                number: number as f32,
            };
            corners.windows(2).map(side).collect::<Vec<_>>()
        });
        flat(sides)
    }
}
