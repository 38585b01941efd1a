//! A map without some of its submaps.
//!
//! In: which submaps are kept. Out: the matcher with these alone, numbered anew; what named another
//! is gone with it. Whether the pose graph still hangs together is the caller's matter.

use std::collections::BTreeMap;

use nalgebra::Matrix3;

use super::super::free_space::FreeSpace;
use super::super::submap::Indexes;
use super::{ScanMatcher, Submap};
use crate::geom::{Pose2, PoseEstimate};
use crate::map::SurfelMap;

impl ScanMatcher {
    /// Keeps the submaps that are `kept`; the running one may go too, and then another has to be
    /// begun ([`Self::begin_anew_behind`]).
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
        self.jobs = self.jobs.iter().filter_map(|&pair| both(pair)).collect();
        let compared = std::mem::take(&mut self.compared).into_iter();
        self.compared = compared
            .filter_map(|(pair, doubt)| Some((both(pair)?, doubt)))
            .collect::<BTreeMap<_, _>>();
        self.records
            .keep(both, |edge| self.graph.edge(edge).is_some());
        self.waiting.keep(both);
        self.newest.clear();
        self.unrefined.clear();
        self.closures = self.records.accepted().count();
        self.indexes = Indexes::default();
        // The last that is left at or before it.
        let before = numbers.iter().take(self.last_closed + 1).flatten();
        self.last_closed = before.last().copied().unwrap_or_default();
        if let Some(piece) = &mut self.unplaced {
            piece.first = numbers.iter().take(piece.first).flatten().count();
        }
        // Of a drawing that had begun it is not known what of it stays.
        self.redraw = None;
    }

    /// Begins a submap where the last one lies, on which nothing is known yet.
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
