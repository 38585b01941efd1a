//! Renumbers a map after some of its submaps were removed, or one was inserted.
//!
//! In: which submaps are kept, or the one to be inserted. Out: the matcher with these, renumbered;
//! everything that referred to a removed one is removed too. The caller has to see that the pose
//! graph stays connected. Removals made before can no longer be undone ([`super::removal`] keeps
//! its own valid).

use std::collections::BTreeMap;

use nalgebra::Matrix3;

use super::super::free_space::FreeSpace;
use super::super::submap::Indexes;
use super::canvas::Keyframe;
use super::{ScanMatcher, Submap};
use crate::geom::{Pose2, PoseEstimate};
use crate::map::SurfelMap;

impl ScanMatcher {
    /// Keeps the submaps marked in `kept`; if the running one is removed, another has to be begun
    /// ([`Self::begin_anew_behind`]).
    pub(super) fn keep_submaps(&mut self, kept: &[bool]) {
        let mut next = 0;
        let numbers: Vec<Option<usize>> = (kept.iter())
            .map(|kept| {
                let number = kept.then_some(next);
                next += usize::from(*kept);
                number
            })
            .collect();
        let number = |submap: usize| numbers.get(submap).copied().flatten();
        let both = |(a, b): (usize, usize)| Some((number(a)?, number(b)?));
        self.keep_edits(&numbers);
        let mut at = 0;
        self.submaps.retain(|_| {
            at += 1;
            kept.get(at - 1).copied().unwrap_or(false)
        });
        self.graph = self.graph.kept(&numbers);
        self.removals.clear();
        self.keyframes.retain_mut(|keyframe| {
            let number = number(keyframe.submap);
            keyframe.submap = number.unwrap_or_default();
            number.is_some()
        });
        self.trajectory.retain_mut(|track| {
            let number = number(track.submap);
            track.submap = number.unwrap_or_default();
            number.is_some()
        });
        self.rename_pairs(both);
        // The last remaining one at or before it.
        let before = numbers.iter().take(self.last_closed + 1).flatten();
        self.last_closed = before.last().copied().unwrap_or_default();
        if let Some(piece) = &mut self.unplaced {
            piece.first = numbers.iter().take(piece.first).flatten().count();
        }
        // It is not known which part of a redraw in progress stays valid.
        self.redraw = None;
    }

    /// Inserts a submap under this number, with what was drawn from it: the numbers from there on
    /// increase by one.
    pub(super) fn let_in(&mut self, number: usize, submap: Submap, keyframes: Vec<Keyframe>) {
        let higher = |other: usize| other + usize::from(other >= number);
        self.graph.let_in(number, submap.map_from_submap);
        self.submaps.insert(number, submap);
        for keyframe in &mut self.keyframes {
            keyframe.submap = higher(keyframe.submap);
        }
        for track in &mut self.trajectory {
            track.submap = higher(track.submap);
        }
        let first = self.keyframes.partition_point(|k| k.submap < number);
        for edit in &mut self.edits {
            edit.submap = higher(edit.submap);
            edit.after += if edit.after > first {
                keyframes.len()
            } else {
                0
            };
        }
        self.keyframes.splice(first..first, keyframes);
        self.rename_pairs(|(a, b)| Some((higher(a), higher(b))));
        self.last_closed = higher(self.last_closed);
        if let Some(piece) = &mut self.unplaced {
            piece.first = higher(piece.first);
        }
        self.redraw = None;
    }

    /// Gives pairs of submaps their new numbers; pairs without one are dropped.
    fn rename_pairs(&mut self, both: impl Fn((usize, usize)) -> Option<(usize, usize)>) {
        self.jobs = self.jobs.iter().filter_map(|&pair| both(pair)).collect();
        let compared = std::mem::take(&mut self.compared).into_iter();
        self.compared = compared
            .filter_map(|(pair, doubt)| Some((both(pair)?, doubt)))
            .collect::<BTreeMap<_, _>>();
        self.records
            .keep(&both, |edge| self.graph.edge(edge).is_some());
        self.waiting.keep(&both);
        self.newest.clear();
        self.unrefined.clear();
        self.count_loops();
        self.indexes = Indexes::default();
    }

    /// Begins a submap where the last one lies, in which nothing is known yet.
    pub(super) fn begin_anew_behind(&mut self) {
        let map_from_submap = self.map_from_running();
        self.running = SurfelMap::new(self.config.surfels);
        self.running_free = FreeSpace::default();
        self.recent.clear();
        self.local = PoseEstimate::exact(Pose2::identity());
        self.way_cov = Matrix3::zeros();
        let old = self.submaps.len() - 1;
        self.join_to_next(old, &Pose2::identity(), map_from_submap);
        self.submaps.push(Submap::begun_at(map_from_submap, true));
    }
}
