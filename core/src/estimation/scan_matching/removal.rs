//! A submap that a person removes from the map, and puts back.
//!
//! In: the number of a submap. Out: the map without what was seen in it. The robot was there all
//! the same: its trajectory stays, attached to the next submap from where both lie now.
//!
//! 1. Postponed work is done first, so that nothing waits for what is gone.
//! 2. The submaps joined to it are joined directly, as when newer submaps cover it (`pruning`).
//! 3. The submap is kept, with everything that refers to it, for as long as the run goes on. It
//!    comes back where it lay in the next one, with its own joins in place of those that bypass it.
//!    What the robot saw meanwhile stays. Removals are undone in turn, the last one first.
//!
//! The submaps after it are renumbered. If submaps are removed other than by hand (`pruning`,
//! `going_on`), the numbers in what is kept are no longer valid, and it cannot come back.

use std::ops::Range;

use super::super::pose_graph::{Edge, EdgeId};
use super::canvas::Keyframe;
use super::records::ClosureRecord;
use super::{ScanMatcher, Submap};
use crate::geom::Pose2;

/// Why a submap cannot be removed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum RemovalError {
    /// There is no submap of this number.
    #[error("there is no submap {submap}: the map has {count}, counted from 0")]
    Missing {
        /// The number.
        submap: usize,
        /// How many there are.
        count: usize,
    },
    /// The robot is in it, or another piece is attached to it.
    #[error("submap {submap} is still needed: the robot, or what it maps by itself, begins in it")]
    Needed {
        /// The number.
        submap: usize,
    },
    /// Without it, nothing tells how its neighbours lie to each other.
    #[error("submap {submap} is joined to no other: without it the map has no place")]
    Alone {
        /// The number.
        submap: usize,
    },
}

/// The most removals that can be undone: each keeps a submap with its keyframes.
const MOST_KEPT: usize = 16;

/// A removed submap. Submap numbers are those from before the removal.
#[derive(Clone, Debug)]
pub(super) struct Removal {
    number: usize,
    submap: Submap,
    next_from_submap: Pose2,
    keyframes: Vec<Keyframe>,
    /// The range of trajectory poses in it.
    scans: Range<usize>,
    /// Its joins, with the records of those that are closures.
    joins: Vec<(EdgeId, Edge, Option<ClosureRecord>)>,
    /// The joins that bypass it and took their place.
    past: Vec<EdgeId>,
    /// The pairs in which it was compared, each with the doubt at that time.
    compared: Vec<((usize, usize), f64)>,
    was_next_loose: bool,
}

impl ScanMatcher {
    /// Removes a submap from the map, with all that was seen in it.
    ///
    /// # Errors    [`RemovalError`]; the map then stays as it was.
    pub fn remove_submap(&mut self, submap: usize) -> Result<(), RemovalError> {
        self.check_removable(submap)?;
        self.compare_all();
        self.refine(usize::MAX, true);
        // That may have placed a separate piece, and renumbered the rest.
        self.check_removable(submap)?;
        let mut removal = self.removal_of(submap);
        let past = self.join_past(submap);
        removal.past = past.ok_or(RemovalError::Alone { submap })?;
        self.carry_way(submap);
        let numbers = 0..self.submaps.len();
        let kept: Vec<bool> = numbers.map(|at| at != submap).collect();
        let mut removals = std::mem::take(&mut self.removals);
        self.keep_submaps(&kept);
        // One for the removed submap, and one for the change.
        self.moves += 2;
        self.redraw_at_once();
        if removals.len() == MOST_KEPT {
            removals.remove(0);
        }
        removals.push(removal);
        self.removals = removals;
        Ok(())
    }

    fn check_removable(&self, submap: usize) -> Result<(), RemovalError> {
        let count = self.submaps.len();
        if submap >= count {
            return Err(RemovalError::Missing { submap, count });
        }
        if submap >= self.removable() {
            return Err(RemovalError::Needed { submap });
        }
        Ok(())
    }

    /// What has to be kept of a submap to put it back; `past` is not known yet.
    fn removal_of(&self, number: usize) -> Removal {
        let submap = self.submaps[number].clone();
        let next = &self.submaps[number + 1];
        let own = self.keyframes.iter().filter(|k| k.submap == number);
        let has_scan = |at: &usize| self.trajectory[*at].submap == number;
        let first = (0..self.trajectory.len()).find(has_scan);
        let last = (0..self.trajectory.len()).rfind(has_scan);
        let edges = self.graph.edge_ids().iter().zip(self.graph.edges());
        let joins = edges.filter(|(_, edge)| edge.from == number || edge.to == number);
        let record_of = |id: EdgeId| {
            let mut accepted = self.records.accepted();
            let record = accepted.find(|(_, edge, _)| *edge == id);
            record.map(|(_, _, record)| *record)
        };
        let compared = self.compared.iter().map(|(pair, doubt)| (*pair, *doubt));
        Removal {
            number,
            next_from_submap: next.map_from_submap.delta_to(&submap.map_from_submap),
            was_next_loose: next.is_loose,
            keyframes: own.cloned().collect(),
            scans: first
                .zip(last)
                .map_or(0..0, |(first, last)| first..last + 1),
            joins: joins
                .map(|(id, edge)| (*id, *edge, record_of(*id)))
                .collect(),
            past: vec![],
            compared: compared
                .filter(|((a, b), _)| *a == number || *b == number)
                .collect(),
            submap,
        }
    }

    /// How many submaps, counted from the first, can be removed: not the one in which the robot is,
    /// nor, while it maps a separate piece, those of the piece and the one in which it left the
    /// map.
    #[must_use]
    pub fn removable(&self) -> usize {
        let count = self.submaps.len();
        let behind = self.unplaced.as_ref().map_or(count, |piece| piece.first);
        behind.saturating_sub(1)
    }

    /// Puts back the submap that was removed last, and returns its number; `None` if none can come
    /// back.
    pub fn undo_removal(&mut self) -> Option<usize> {
        self.undoable_removal()?;
        self.compare_all();
        self.refine(usize::MAX, true);
        let Removal {
            number,
            mut submap,
            next_from_submap,
            keyframes,
            scans,
            joins,
            past,
            compared,
            was_next_loose,
        } = self.removals.pop()?;
        let next = self.submaps.get_mut(number)?;
        next.is_loose = was_next_loose;
        submap.map_from_submap = next.map_from_submap * next_from_submap;
        self.let_in(number, submap, keyframes);
        for track in self.trajectory.get_mut(scans).into_iter().flatten() {
            if track.submap == number + 1 {
                track.submap = number;
                track.submap_from_robot = next_from_submap.inverse() * track.submap_from_robot;
            }
        }
        for edge in past {
            self.graph.remove_edge(edge);
        }
        // Under their own names: an earlier removal may have created them.
        for (id, edge, record) in joins {
            if let (Some(_), Some(record)) = (self.graph.put_back(id, edge), record) {
                self.records.take_back(record);
            }
        }
        self.count_loops();
        // Placements that waited for proof are gone: they are found again.
        let is_closed = |(old, new)| {
            let mut accepted = self.records.accepted();
            accepted.any(|(_, _, record)| (record.old, record.new) == (old, new))
        };
        let (closed, open) = compared
            .into_iter()
            .partition::<Vec<_>, _>(|(pair, _)| is_closed(*pair));
        self.compared.extend(closed);
        self.jobs.extend(open.into_iter().map(|(pair, _)| pair));
        // If later closures have moved its neighbours, it moves along.
        self.optimize();
        self.redraw_at_once();
        Some(number)
    }

    /// The number of the submap that [`Self::undo_removal`] puts back.
    #[must_use]
    pub fn undoable_removal(&self) -> Option<usize> {
        self.removals.last().map(|removal| removal.number)
    }

    /// Moves the trajectory through a submap into the next one, as both lie now.
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
