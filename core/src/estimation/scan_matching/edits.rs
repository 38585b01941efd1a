//! What a person has changed on the map: regions that were erased, walls and glass that were drawn.
//!
//! In: corners in the map. Out: the grid with the changes, also after it was drawn anew, and the
//! list of changes to look at. They are a layer over the grid: nothing is matched to them, and
//! surfaces that were erased still help to find a place.
//!
//! 1. A change is kept in the frame of the submap whose middle is nearest: it moves with what it
//!    was drawn over when a loop closes.
//! 2. A region that is erased is unknown again. What was seen before is gone from it; what is seen
//!    later is drawn. When the grid is drawn anew it is erased between the same keyframes.
//! 3. Walls and glass stay occupied, whatever beams say: glass is what they go through. A wall of
//!    which all corners are erased later goes too.

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

/// A change, to look at.
#[derive(Clone, Debug, PartialEq)]
pub struct ShownEdit {
    /// What it does.
    pub kind: EditKind,
    /// Corners of the region, or of the polyline, map frame, m.
    pub corners: Vec<Point2<f64>>,
}

/// Why the map cannot be changed so.
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
    /// A corner that is nowhere.
    #[error("a corner is not finite, or farther away than {FARTHEST} m")]
    Nowhere,
}

/// A change, in the frame of a submap.
#[derive(Clone, Debug)]
pub(super) struct Edit {
    kind: EditKind,
    pub(super) submap: usize,
    corners: Vec<Point2<f64>>,
    /// So many keyframes had been drawn.
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

/// Most corners of a change.
const MOST_CORNERS: usize = 1000;
/// Corners lie no farther from the origin than this, m.
const FARTHEST: f64 = 10_000.0;

impl ScanMatcher {
    /// Changes the map.
    ///
    /// # Errors    [`EditError`]; then it stays as it is.
    pub fn edit(&mut self, kind: EditKind, corners: &[Point2<f64>]) -> Result<(), EditError> {
        let least = match kind {
            EditKind::Erase => 3,
            EditKind::Wall | EditKind::Glass => 2,
        };
        if !(least..=MOST_CORNERS).contains(&corners.len()) {
            let corners = corners.len();
            return Err(EditError::Corners { corners, least });
        }
        // NaN is not near either.
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

    /// Takes back the last change; `false` where there is none.
    pub fn undo_edit(&mut self) -> bool {
        let is_undone = self.edits.pop().is_some();
        if is_undone {
            self.redraw_at_once();
        }
        is_undone
    }

    /// What was changed and is still there, in the order in which it was.
    pub fn edits(&self) -> impl ExactSizeIterator<Item = ShownEdit> {
        self.edits.iter().map(|edit| ShownEdit {
            kind: edit.kind,
            corners: edit.placed(&self.submaps),
        })
    }

    /// The submap, of those that are shown, whose middle is nearest.
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

    /// Lays walls and glass over the grid again, where a keyframe was drawn over them.
    pub(super) fn lay_walls(&mut self) {
        lay_walls(&self.edits, &self.submaps, &mut self.grid);
    }

    /// The changes that are left where some submaps are gone: those of a submap that is gone are
    /// kept in the frame of one that follows. To be called before any is gone.
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
    /// The same in a map that has so many submaps and keyframes before it.
    pub(super) fn behind(self, submaps: usize, keyframes: usize) -> Self {
        Self {
            submap: self.submap + submaps,
            after: self.after + keyframes,
            ..self
        }
    }

    /// Its corners where it is drawn.
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

/// Erases what was erased when so many keyframes had been drawn.
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
