//! Submaps and loop closures, for the page.

use serde::{Deserialize, Serialize};
use slamlab_core::estimation::{ClosureRecord, Join, LoopsClosed, ScanMatcher, ShownSubmap};
use slamlab_core::format::smap::Smap;
use tsify::{Ts, Tsify};
use wasm_bindgen::prelude::wasm_bindgen;

use crate::border::{
    ClosureOutcome, ClosureRow, ExtentRow, Float32Array, SubmapRow, Typed, Uint32Array, WebError,
    flat, typed,
};
use crate::export::{ExportError, SavedFile};
use crate::run::{Source, WebRun};
use crate::view::{flag, polyline};

/// Maximum number of surface points of a submap that the page is given: enough to see its walls.
const MOST_SURFACES: usize = 120;

/// Submaps and loop closures. Surfaces are in the frame of their submap and are therefore sent only
/// once, wherever it moves.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Tsify)]
pub struct Submaps {
    /// Pass it to the next call to get what changed since.
    pub version: f64,
    /// All submaps, see `SUBMAP`; the last one is still in progress.
    pub poses: Float32Array,
    /// Number of values in `surfaces` for each newly completed submap.
    pub lengths: Uint32Array,
    /// x y of their surfaces.
    pub surfaces: Float32Array,
    /// The extent of each of those submaps, see `EXTENT`.
    pub extents: Float32Array,
    /// How many submaps, counted from the first, can be removed.
    pub removable: usize,
    /// The number of the submap that was removed last and can be put back.
    pub undoable: Option<usize>,
    /// All remembered placements of one submap in another, see `CLOSURE`.
    pub closures: Float32Array,
    /// The outcome of each.
    pub outcomes: Vec<ClosureOutcome>,
}

#[wasm_bindgen]
impl WebRun {
    /// Submaps and loop closures, for a reader who knows `version` of them and the surfaces of the
    /// first `known`; nothing if that version is the newest, and for methods without submaps.
    ///
    /// # Errors    None that a page can cause.
    pub fn submaps(&self, version: f64, known: u32) -> Result<Option<Ts<Submaps>>, WebError> {
        let matcher = self.slam().view().map;
        let changed = matcher.filter(|m| m.submaps_version() as f64 != version);
        let submaps = changed.map(|m| Submaps::of(m, known as usize));
        submaps.as_ref().map(typed).transpose()
    }

    /// Removes a submap from the map, by its number.
    ///
    /// # Errors    A sentence on why it is impossible: another method than scan matching, or a
    /// submap that is needed.
    pub fn remove_submap(&mut self, submap: usize) -> Result<(), WebError> {
        self.landmarks.forget();
        match &mut self.source {
            Source::Simulation(sim) => sim.experiment.remove_submap(submap)?,
            Source::Recording(replay) => replay.remove_submap(submap)?,
            Source::Live(live) => live.remove_submap(submap)?,
        }
        Ok(())
    }

    /// Puts back the submap that was removed last, and returns its number; `None` if there is none
    /// to put back.
    pub fn undo_removal(&mut self) -> Option<usize> {
        self.landmarks.forget();
        match &mut self.source {
            Source::Simulation(sim) => sim.experiment.undo_removal(),
            Source::Recording(replay) => replay.undo_removal(),
            Source::Live(live) => live.undo_removal(),
        }
    }

    /// One submap as a file, named after `stem`.
    ///
    /// # Errors    A sentence on why there is no such file.
    pub fn submap_file(&self, submap: usize, stem: &str) -> Typed<SavedFile> {
        let matcher = self.slam().view().map.ok_or(ExportError::NoSubmaps)?;
        let smap = Smap::of_submap(matcher, submap)?;
        let name = format!("{stem}-submap-{submap}.smap");
        typed(&SavedFile::new(name, "text/plain", smap.write()))
    }
}

impl Submaps {
    fn of(matcher: &ScanMatcher, known: usize) -> Self {
        let complete = matcher.submaps().len().saturating_sub(1);
        let mut lengths = vec![];
        let mut surfaces = vec![];
        let mut extents = vec![];
        for submap in matcher.submaps().take(complete).skip(known) {
            let every = submap.surfaces().len().div_ceil(MOST_SURFACES).max(1);
            let points: Vec<_> = submap.surfaces().step_by(every).collect();
            lengths.push(2 * points.len() as u32);
            surfaces.extend(polyline(&points));
            let extent = submap.extent();
            extents.push(ExtentRow {
                width: extent.x as f32,
                height: extent.y as f32,
                surfaces: submap.surfaces().len() as f32,
            });
        }
        let records = matcher.closure_records();
        let loops = matcher.loops_closed();
        Self {
            version: matcher.submaps_version() as f64,
            poses: flat(
                matcher
                    .submaps()
                    .zip(matcher.joins())
                    .map(|(submap, join)| row_of(&submap, join)),
            ),
            lengths: lengths.into(),
            surfaces: surfaces.into(),
            extents: flat(extents),
            removable: matcher.removable(),
            undoable: matcher.undoable_removal(),
            closures: flat(records.map(|record| closure_row(matcher, &loops, record))),
            outcomes: matcher.closure_records().map(Into::into).collect(),
        }
    }
}

fn row_of(submap: &ShownSubmap<'_>, join: Option<Join>) -> SubmapRow {
    let pose = submap.map_from_submap;
    let figure = |of: fn(&Join) -> f64| join.as_ref().map_or(f32::NAN, |join| of(join) as f32);
    SubmapRow {
        x: pose.x() as f32,
        y: pose.y() as f32,
        heading: pose.heading() as f32,
        loose: flag(submap.is_loose) as f32,
        keyframes: submap.keyframes as f32,
        off_x: figure(|join| join.residual.off.x()),
        off_y: figure(|join| join.residual.off.y()),
        off_turn: figure(|join| join.residual.off.heading()),
        chi2: figure(|join| join.residual.chi2),
        join_shift: figure(|join| join.doubt.shift),
        join_turn: figure(|join| join.doubt.turn),
        info_xx: figure(|join| join.residual.information[(0, 0)]),
        info_xy: figure(|join| join.residual.information[(0, 1)]),
        info_xt: figure(|join| join.residual.information[(0, 2)]),
        info_yy: figure(|join| join.residual.information[(1, 1)]),
        info_yt: figure(|join| join.residual.information[(1, 2)]),
        info_tt: figure(|join| join.residual.information[(2, 2)]),
    }
}

fn closure_row(matcher: &ScanMatcher, loops: &LoopsClosed, record: &ClosureRecord) -> ClosureRow {
    let residual = matcher.residual(record);
    let information = residual.information;
    let proof = record.proof;
    let figure = |value: Option<f64>| value.map_or(f32::NAN, |v| v as f32);
    ClosureRow {
        old: record.old as f32,
        new: record.new as f32,
        x: record.motion.x() as f32,
        y: record.motion.y() as f32,
        heading: record.motion.heading() as f32,
        off_x: residual.off.x() as f32,
        off_y: residual.off.y() as f32,
        off_turn: residual.off.heading() as f32,
        chi2: residual.chi2 as f32,
        doubt_shift: record.doubt.shift as f32,
        doubt_turn: record.doubt.turn as f32,
        searched: flag(record.is_searched) as f32,
        overlap: record.overlap as f32,
        part: record.part as f32,
        evidence: figure(proof.map(|p| p.evidence)),
        asked: figure(proof.map(|p| p.asked)),
        rival: figure(proof.map(|p| p.rival)),
        info_xx: information[(0, 0)] as f32,
        info_xy: information[(0, 1)] as f32,
        info_xt: information[(0, 2)] as f32,
        info_yy: information[(1, 1)] as f32,
        info_yt: information[(1, 2)] as f32,
        info_tt: information[(2, 2)] as f32,
        loop_closed: flag(loops.closes(record)) as f32,
    }
}
