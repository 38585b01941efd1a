//! A submap that a person takes out of the map, and puts back.
//!
//! In: the number of a submap. Out: the map without what was seen in it. The robot was there all
//! the same: its way stays, carried by the next submap from where both lie now.
//!
//! 1. What was put off is done first, so that nothing waits for what is gone.
//! 2. What the submap was joined to is joined past it, as where newer submaps cover it (`pruning`).
//! 3. The map as it was is kept, to be put back, as long as nothing was seen and nothing changed by
//!    hand since. Removals come back in turn, the last one first.
//!
//! Submaps that follow are numbered anew.

use super::ScanMatcher;

/// Why a submap cannot be taken out.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum RemovalError {
    /// There is none of this number.
    #[error("there is no submap {submap}: the map has {count}, counted from 0")]
    Missing {
        /// The number.
        submap: usize,
        /// How many there are.
        count: usize,
    },
    /// It carries the robot, or another piece of the way.
    #[error("submap {submap} is still needed: the robot, or what it maps by itself, begins in it")]
    Needed {
        /// The number.
        submap: usize,
    },
    /// Nothing says how its neighbours lie to each other without it.
    #[error("submap {submap} is joined to no other: without it the map has no place")]
    Alone {
        /// The number.
        submap: usize,
    },
}

/// Most removals that can be taken back: each keeps a whole map.
const MOST_KEPT: usize = 4;

/// The map before a submap was taken out.
#[derive(Clone, Debug)]
pub(super) struct Removal {
    before: Box<ScanMatcher>,
    /// Scans and changes by hand when it was taken out.
    at: [usize; 2],
}

impl ScanMatcher {
    /// Takes a submap out of the map, with all that was seen in it.
    ///
    /// # Errors    [`RemovalError`]; then the map stays as it was.
    pub fn remove_submap(&mut self, submap: usize) -> Result<(), RemovalError> {
        let count = self.submaps.len();
        if submap >= count {
            return Err(RemovalError::Missing { submap, count });
        }
        if submap >= self.removable() {
            return Err(RemovalError::Needed { submap });
        }
        self.compare_all();
        self.refine(usize::MAX, true);
        let mut removals = std::mem::take(&mut self.removals);
        let before = Box::new(self.clone());
        if !self.join_past(submap) {
            self.removals = removals;
            return Err(RemovalError::Alone { submap });
        }
        self.carry_way(submap);
        let kept: Vec<bool> = (0..count).map(|at| at != submap).collect();
        self.keep_submaps(&kept);
        // One for the submap that is gone, and one for the change.
        self.moves += 2;
        self.redraw_at_once();
        let at = self.seen_and_changed();
        removals.retain(|removal| removal.at == at);
        if removals.len() == MOST_KEPT {
            removals.remove(0);
        }
        removals.push(Removal { before, at });
        self.removals = removals;
        Ok(())
    }

    /// So many submaps can be taken out, the first ones: not that in which the robot is, nor, while
    /// it maps a piece by itself, those of the piece and the one that it left the map in.
    #[must_use]
    pub fn removable(&self) -> usize {
        let count = self.submaps.len();
        let behind = self.unplaced.as_ref().map_or(count, |piece| piece.first);
        behind.saturating_sub(1)
    }

    /// Puts back the submap that was taken out last; `false` where there is none, or something was
    /// seen or changed since.
    pub fn undo_removal(&mut self) -> bool {
        if !self.can_undo_removal() {
            return false;
        }
        let Some(Removal { before, .. }) = self.removals.pop() else {
            return false;
        };
        let now = std::mem::replace(self, *before);
        let grown = now.submaps_version().saturating_sub(self.submaps_version());
        self.moves += grown + 1;
        self.grid_version = now.grid_version + 1;
        // What the robot counted meanwhile is of the same way.
        self.pending = now.pending;
        self.removals = now.removals;
        true
    }

    /// Whether [`Self::undo_removal`] has something to put back.
    #[must_use]
    pub fn can_undo_removal(&self) -> bool {
        let last = self.removals.last();
        last.is_some_and(|removal| removal.at == self.seen_and_changed())
    }

    fn seen_and_changed(&self) -> [usize; 2] {
        [self.trajectory.len(), self.edits.len()]
    }

    /// Lays the way through a submap into the next, where both lie now.
    fn carry_way(&mut self, submap: usize) {
        let [this, next] = [submap, submap + 1].map(|at| self.submaps[at].map_from_submap);
        let next_from_this = next.delta_to(&this);
        for track in self.trajectory.iter_mut().filter(|t| t.submap == submap) {
            track.submap = submap + 1;
            track.submap_from_robot = next_from_this * track.submap_from_robot;
        }
    }
}

#[cfg(test)]
mod tests;
