//! Merges two maps of one building.
//!
//! In: two matchers. Out: one with the map of both, or why their relative pose is not proved.
//!
//! The second map is added to the first as a piece whose place is unknown (`going_on`): its submaps
//! are compared with those of the first, in the whole map and in all directions, and the two become
//! one map only with proof. So what is accepted here is what would be accepted for a robot that
//! drove through the first map and saw what is in the second.

use std::f64::consts::PI;

use super::going_on::{BETWEEN_RUNS, Piece};
use super::{Redraw, SavedMap, ScanMatcher};
use crate::geom::pose_cov;
use crate::robot::Stamp;

/// Why two maps cannot be merged.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MapMergeError {
    /// One of them is empty.
    #[error("the {which} map holds nothing that was seen")]
    Empty {
        /// Which: `first` or `second`.
        which: &'static str,
    },
    /// They have no part in common, or it is not proved which part that is.
    #[error(
        "it is not proved where the maps overlap: the best place of the second in the first has \
         evidence {evidence:.1} of {asked:.1} that is asked for, in submaps that lie wholly on \
         one another, and what contradicts it has {rival:.1}"
    )]
    NotProved {
        /// Of the best placement.
        evidence: f64,
        /// The evidence required.
        asked: f64,
        /// Of the best placement that contradicts it.
        rival: f64,
    },
}

/// Two maps merged into one.
#[derive(Debug)]
pub struct MergedMaps {
    /// The map, in the frame of the first.
    pub matcher: ScanMatcher,
    /// Added to the stamps of the second map, µs, so that they follow those of the first.
    pub stamp_shift: u64,
}

impl MergedMaps {
    /// The map for saving, with the `times` of the first and of the second map
    /// ([`SavedMap::times`]).
    #[must_use]
    pub fn saved(&self, times: [&[(Stamp, f64)]; 2]) -> SavedMap {
        let [first, second] = times;
        let later = |(stamp, seconds): &(Stamp, f64)| {
            let stamp = Stamp(stamp.0.saturating_add(self.stamp_shift));
            (stamp, *seconds)
        };
        let times = first.iter().copied().chain(second.iter().map(later));
        self.matcher.saved(times.collect())
    }
}

impl ScanMatcher {
    /// Merges this map with another.
    ///
    /// # Errors    [`MapMergeError`].
    pub fn merged(mut self, mut other: Self) -> Result<MergedMaps, MapMergeError> {
        for (which, map) in [("first", &mut self), ("second", &mut other)] {
            map.drop_piece();
            map.finish();
            if map.keyframes.is_empty() {
                return Err(MapMergeError::Empty { which });
            }
        }
        // Nothing was mapped in the last submap.
        let last = self.submaps.len() - 1;
        let kept: Vec<bool> = (0..self.submaps.len()).map(|at| at < last).collect();
        self.keep_submaps(&kept);
        let first = self.submaps.len();
        let stamp_shift = self.take_over(other);
        let cov = pose_cov(self.extent(), PI);
        self.join_loosely(first, cov);
        self.compare_piece(first);
        if !self.is_placed() {
            return Err(self.best_of_placements(first));
        }
        // By now it is known which submaps lie near each other.
        self.compare_piece(first);
        self.finish();
        Ok(MergedMaps {
            matcher: self,
            stamp_shift,
        })
    }

    /// Appends the submaps of another map, as a piece that may lie anywhere.
    fn take_over(&mut self, other: Self) -> u64 {
        let first = self.submaps.len();
        let last_stamp = self.trajectory.iter().map(|t| t.stamp.0).max();
        let first_stamp = other.trajectory.iter().map(|t| t.stamp.0).min();
        let stamp_shift = match (last_stamp, first_stamp) {
            (Some(last), Some(begin)) if begin <= last => last - begin + BETWEEN_RUNS,
            _ => 0,
        };
        let edges = self.graph.append(&other.graph);
        let records = self.records.append(other.records, first, edges);
        self.waiting.append(other.waiting, first, records);
        let keyframes = self.keyframes.len();
        let edits = other.edits.into_iter();
        self.edits
            .extend(edits.map(|edit| edit.behind(first, keyframes)));
        self.submaps.extend(other.submaps);
        self.keyframes
            .extend(other.keyframes.into_iter().map(|mut keyframe| {
                keyframe.submap += first;
                keyframe
            }));
        self.trajectory
            .extend(other.trajectory.into_iter().map(|mut track| {
                track.submap += first;
                track.stamp = Stamp(track.stamp.0.saturating_add(stamp_shift));
                track
            }));
        let compared = other.compared.into_iter();
        self.compared
            .extend(compared.map(|((a, b), doubt)| ((a + first, b + first), doubt)));
        self.count_loops();
        self.last_closed = first;
        let aside = std::mem::replace(&mut self.grid, other.grid);
        self.grid_version += 1;
        self.redraw = None::<Redraw>;
        self.unplaced = Some(Piece {
            first,
            aside: Some(aside),
        });
        // A run would go on in the second map.
        self.running = other.running;
        self.running_free = other.running_free;
        self.local = other.local;
        self.is_blind = other.is_blind;
        self.motion = other.motion;
        self.gathering = other.gathering;
        self.recent = other.recent;
        self.last_keyframe = other.last_keyframe;
        self.way_cov = other.way_cov;
        self.pending = other.pending;
        stamp_shift
    }

    /// Compares all submaps from `first` on with those before them.
    fn compare_piece(&mut self, first: usize) {
        for new in first..self.submaps.len() - 1 {
            self.plan_comparisons(new);
        }
        self.compare_all();
    }

    fn best_of_placements(&self, first: usize) -> MapMergeError {
        let judged = self
            .records
            .iter()
            .filter(|r| r.old < first && r.new >= first);
        let proofs = judged.filter_map(|record| record.proof);
        let best = proofs.max_by(|a, b| a.evidence.total_cmp(&b.evidence));
        MapMergeError::NotProved {
            evidence: best.map_or(0.0, |proof| proof.evidence),
            rival: best.map_or(0.0, |proof| proof.rival),
            asked: best.map_or_else(|| self.asked_for_anywhere(), |proof| proof.asked),
        }
    }
}

#[cfg(test)]
mod tests;
