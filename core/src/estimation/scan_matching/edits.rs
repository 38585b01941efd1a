//! Changes that a person has made to the map: erased regions, drawn walls and glass.
//!
//! In: corners in the map. Out: the grid with the changes, also after it is redrawn, and the list
//! of changes for display. They are a layer over the grid: nothing is matched to them, and erased
//! surfaces still help to localise.
//!
//! 1. A change is kept in the frame of the submap whose centre is nearest: it moves with what it
//!    was drawn over when a loop closes.
//! 2. An erased region is unknown again. What was seen before is removed from it; what is seen
//!    later is drawn. When the grid is redrawn, the region is erased between the same keyframes.
//! 3. Walls and glass stay occupied, whatever beams say: beams pass through glass. A wall is
//!    removed too if all of its corners are erased later.

use nalgebra::Point2;

use super::{ScanMatcher, Submap};
use crate::geom::{Length, ring_holds};
use crate::map::Grid;
use crate::snapshot::{snapshot, snapshot_names};

/// What a person changes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EditKind {
    /// A region is unknown again.
    Erase,
    /// A wall stands along a polyline.
    Wall,
    /// Glass stands along a polyline.
    Glass,
}

/// A change, for display.
#[derive(Clone, Debug, PartialEq)]
pub struct ShownEdit {
    /// What it does.
    pub kind: EditKind,
    /// Corners of the region, or of the polyline, map frame, m.
    pub corners: Vec<Point2<f64>>,
}

/// Why the map cannot be changed in this way.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum EditError {
    /// Too few corners, or too many.
    #[error("{corners} corners; expected {least} to {MOST_CORNERS}")]
    Corners {
        /// How many there are.
        corners: usize,
        /// How many there have to be.
        least: usize,
    },
    /// A corner that is not finite or is too far away.
    #[error("a corner is not finite, or farther away than {FARTHEST} m")]
    Nowhere,
}

/// A change, in the frame of a submap.
#[derive(Clone, Debug)]
pub(super) struct Edit {
    kind: EditKind,
    pub(super) submap: usize,
    corners: Vec<Point2<f64>>,
    /// The number of keyframes that had been drawn before it.
    pub(super) after: usize,
}

snapshot_names!(EditKind {
    Erase = 0,
    Wall = 1,
    Glass = 2,
});
snapshot!(
    Edit {
        kind,
        submap,
        corners,
        after
    },
    |edit| edit
        .corners
        .iter()
        .all(|corner| corner.coords.amax() < FARTHEST),
    "a change lies too far away"
);

/// The most corners of a change.
const MOST_CORNERS: usize = 1000;
/// Corners must be nearer to the origin than this in x and y, m.
const FARTHEST: f64 = 10_000.0;

impl ScanMatcher {
    /// Changes the map.
    ///
    /// # Errors    [`EditError`]; the map then stays as it was.
    pub fn edit(&mut self, kind: EditKind, corners: &[Point2<f64>]) -> Result<(), EditError> {
        let least = match kind {
            EditKind::Erase => 3,
            EditKind::Wall | EditKind::Glass => 2,
        };
        if !(least..=MOST_CORNERS).contains(&corners.len()) {
            let corners = corners.len();
            return Err(EditError::Corners { corners, least });
        }
        // NaN fails this test too.
        let is_near = |corner: &Point2<f64>| corner.iter().all(|v| v.abs() < FARTHEST);
        if !corners.iter().all(is_near) {
            return Err(EditError::Nowhere);
        }
        if kind == EditKind::Erase {
            let placed = |edit: &Edit| edit.placed(&self.submaps);
            let kept = self.edits.iter().filter(|edit| {
                edit.kind == EditKind::Erase
                    || !placed(edit).iter().all(|c| ring_holds(corners, *c))
            });
            self.edits = kept.cloned().collect();
        }
        let sum = corners
            .iter()
            .fold(Point2::origin(), |sum, c| sum + c.coords);
        let submap = self.nearest_submap(sum / corners.len() as f64);
        let submap_from_map = self.submaps[submap].drawn_at.inverse();
        let edit = Edit {
            kind,
            submap,
            corners: corners
                .iter()
                .map(|corner| submap_from_map * *corner)
                .collect(),
            after: self.keyframes.len(),
        };
        edit.apply(&self.submaps, &mut self.grid);
        self.edits.push(edit);
        Ok(())
    }

    /// Undoes the last change; `false` if there is none.
    pub fn undo_edit(&mut self) -> bool {
        let is_undone = self.edits.pop().is_some();
        if is_undone {
            self.redraw_at_once();
        }
        is_undone
    }

    /// The changes that are still there, in the order in which they were made.
    pub fn edits(&self) -> impl ExactSizeIterator<Item = ShownEdit> {
        self.edits.iter().map(|edit| ShownEdit {
            kind: edit.kind,
            corners: edit.placed(&self.submaps),
        })
    }

    /// The submap, among those shown, whose centre is nearest.
    fn nearest_submap(&self, place: Point2<f64>) -> usize {
        let first = self.unplaced.as_ref().map_or(0, |piece| piece.first);
        let far = |at: &usize| {
            let submap = &self.submaps[*at];
            (submap.drawn_at * submap.closed.centre - place).length()
        };
        (first..self.submaps.len())
            .min_by(|a, b| far(a).total_cmp(&far(b)))
            .unwrap_or_default()
    }

    /// Lays walls and glass over the grid again after a keyframe was drawn over them.
    pub(super) fn lay_walls(&mut self) {
        lay_walls(&self.edits, &self.submaps, &mut self.grid);
    }

    /// Keeps changes when some submaps are removed: those of a removed submap move to the frame of
    /// one that follows. Call it before any is removed.
    pub(super) fn keep_edits(&mut self, numbers: &[Option<usize>]) {
        let left: Vec<usize> = (0..numbers.len())
            .filter(|&at| numbers[at].is_some())
            .collect();
        let is_left = |k: &super::canvas::Keyframe| numbers.get(k.submap).copied().flatten();
        let mut edits = std::mem::take(&mut self.edits);
        edits.retain_mut(|edit| {
            let next = left.partition_point(|&at| at < edit.submap);
            let Some(&host) = left.get(next).or(left.last()) else {
                return false;
            };
            let host_from_old =
                (self.submaps[host].drawn_at.inverse()) * self.submaps[edit.submap].drawn_at;
            for corner in &mut edit.corners {
                *corner = host_from_old * *corner;
            }
            edit.submap = numbers[host].unwrap_or_default();
            let before = self.keyframes.iter().take(edit.after);
            edit.after = before.filter_map(is_left).count();
            true
        });
        self.edits = edits;
    }
}

impl Edit {
    /// The same change in a map that has this many submaps and keyframes before it.
    pub(super) fn behind(self, submaps: usize, keyframes: usize) -> Self {
        Self {
            submap: self.submap + submaps,
            after: self.after + keyframes,
            ..self
        }
    }

    /// Its corners, where they are drawn.
    fn placed(&self, submaps: &[Submap]) -> Vec<Point2<f64>> {
        let at = submaps[self.submap].drawn_at;
        self.corners.iter().map(|corner| at * *corner).collect()
    }

    fn apply(&self, submaps: &[Submap], grid: &mut Grid) {
        let corners = self.placed(submaps);
        match self.kind {
            EditKind::Erase => grid.forget_within(&corners),
            EditKind::Wall | EditKind::Glass => {
                corners
                    .windows(2)
                    .for_each(|way| grid.occupy(way[0], way[1]));
            }
        }
    }
}

/// Applies the erasures that were made when this many keyframes had been drawn.
pub(super) fn erase(edits: &[Edit], submaps: &[Submap], after: usize, grid: &mut Grid) {
    let erased = edits.iter().filter(|edit| edit.kind == EditKind::Erase);
    erased
        .filter(|edit| edit.after == after)
        .for_each(|edit| edit.apply(submaps, grid));
}

/// Lays walls and glass over a grid.
pub(super) fn lay_walls(edits: &[Edit], submaps: &[Submap], grid: &mut Grid) {
    let walls = edits.iter().filter(|edit| edit.kind != EditKind::Erase);
    walls.for_each(|edit| edit.apply(submaps, grid));
}

#[cfg(test)]
mod tests;
