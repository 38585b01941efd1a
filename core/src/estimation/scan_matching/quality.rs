//! The quality of the map that scan matching has made.
//!
//! In: the closed submaps where they lie, and the pose graph. Out: [`MapQuality`]. It takes a
//! second for an hour's drive, so it is computed on request, and submap by submap if others are
//! waiting meanwhile ([`MapJudgement`]).

use std::collections::BTreeMap;

use super::ScanMatcher;
use crate::estimation::map_quality::{
    ClosedLoop, MapJudgement, MapQuality, Parted, Placed, Unjudgeable, Untied, doubt_ahead,
};
use crate::estimation::submap::Doubt;
use crate::geom::Length;
use crate::robot::Stamp;

/// If walls ahead are known worse than this, m, after the motion from a submap to the next, the
/// robot was lost there.
const LOST_SIGMA: f64 = 0.2;
/// One stretch follows another if the time between them is at most this part of the shorter one.
const MOST_GAP: f64 = 0.5;

impl ScanMatcher {
    /// Whether the map is whole, and where it is torn. What was seen since the last submap was
    /// closed is not included.
    #[must_use]
    pub fn quality(&self) -> MapQuality {
        let mut judgement = self.judgement();
        while self.judge_on(&mut judgement) {}
        self.judged(&judgement)
    }

    /// Starts a judgement of the map as it is now. The map may change meanwhile.
    #[must_use]
    pub fn judgement(&self) -> MapJudgement {
        let closed = self.submaps.len().saturating_sub(1);
        let poses = self.submaps.iter().map(|submap| submap.map_from_submap);
        let places = poses.zip(self.seen(closed)).collect();
        let (untied, parted) = (self.untied(closed), self.parted(closed));
        let loops = self.closed_loops(closed);
        MapJudgement::new(places, untied, parted, loops, self.unjudgeable())
    }

    /// The closed loops in the order of time, and how far off their paths were: of each submap only
    /// the longest, because loops closed together are off alike.
    fn closed_loops(&self, count: usize) -> Vec<ClosedLoop> {
        let seen = self.seen(count);
        let mut loops: BTreeMap<usize, ClosedLoop> = BTreeMap::new();
        for (_, _, record) in self.records.accepted() {
            let ends = seen.get(record.old).zip(seen.get(record.new));
            let (Some((earlier, later)), Some(error)) = (ends, record.loop_error) else {
                continue;
            };
            let known = loops.get(&record.new).map(|known| known.error.doubt.shift);
            if known.is_none_or(|known| error.doubt.shift > known) {
                let (earlier, later) = (*earlier, *later);
                let closed = ClosedLoop {
                    earlier,
                    later,
                    error,
                };
                loops.insert(record.new, closed);
            }
        }
        loops.into_values().collect()
    }

    /// Why the map, including the running submap, cannot be judged: no scan was matched to another,
    /// so nothing could contradict.
    fn unjudgeable(&self) -> Option<Unjudgeable> {
        let closed = self.submaps.iter().map(|submap| &submap.closed);
        let has_surfaces = !self.running.surfels().is_empty()
            || closed.into_iter().any(|closed| closed.surfaces().len() > 0);
        if !has_surfaces {
            Some(Unjudgeable::NoSurfaces)
        } else if self.trajectory.len() < 2 {
            Some(Unjudgeable::OneScan)
        } else if self.keyframes.len() < 2 && self.is_blind {
            Some(Unjudgeable::Unmatched)
        } else {
            None
        }
    }

    /// Continues the judgement by one submap; `false` when none is left.
    pub fn judge_on(&self, judgement: &mut MapJudgement) -> bool {
        let placed = self.placed(judgement);
        let config = &self.config;
        judgement.step(&placed, &config.surfels, &config.matching)
    }

    /// The result of [`Self::quality`], as far as it was judged.
    #[must_use]
    pub fn judged(&self, judgement: &MapJudgement) -> MapQuality {
        judgement.quality(&self.placed(judgement))
    }

    /// The submaps as they lay when the judgement began; the contents of a closed one never change.
    fn placed(&self, judgement: &MapJudgement) -> Vec<Placed<'_>> {
        let submaps = self.submaps.iter().zip(&judgement.places);
        submaps
            .map(|(submap, (map_from_submap, seen))| Placed {
                submap: &submap.closed,
                map_from_submap: *map_from_submap,
                seen: *seen,
            })
            .collect()
    }

    /// When each of the first `count` submaps was seen, from and to.
    fn seen(&self, count: usize) -> Vec<[Stamp; 2]> {
        let mut seen: Vec<Option<[Stamp; 2]>> = vec![None; count];
        for track in &self.trajectory {
            if let Some(seen) = seen.get_mut(track.submap) {
                let from = seen.map_or(track.stamp, |[from, _]| from);
                *seen = Some([from, track.stamp]);
            }
        }
        // A submap begins with a scan of its own; if it has none, it lies between its neighbours.
        let mut last = [Stamp(0); 2];
        seen.into_iter()
            .map(|seen| {
                last = seen.unwrap_or([last[1]; 2]);
                last
            })
            .collect()
    }

    /// How far apart neighbours that share scans lie. If part of the path between them is missing
    /// (pruned, or scans lost), nothing was drawn that could be apart.
    fn parted(&self, count: usize) -> Vec<Parted> {
        let poses = self.graph.poses();
        let seen = self.seen(count);
        let parted = self.graph.edges().iter().filter_map(|edge| {
            let shares_scans = edge.cauchy.is_none()
                && edge.to == edge.from + 1
                && edge.to < count
                && !self.submaps[edge.to].is_loose
                && follows_at_once(seen[edge.from], seen[edge.to]);
            let present = poses[edge.from].delta_to(&poses[edge.to]);
            let off = edge.motion.delta_to(&present);
            shares_scans.then(|| Parted {
                earlier: edge.from,
                shift: off.position().coords.length(),
                turn: off.heading().abs(),
            })
        });
        parted.collect()
    }

    /// The paths between submaps that no closed loop spans; consecutive ones count as one.
    fn untied(&self, count: usize) -> Vec<Untied> {
        // Whether the path from each submap to the next is spanned, and whether it is known badly.
        let mut spans = vec![0_i32; count + 1];
        let mut is_lost = vec![false; count];
        for edge in self.graph.edges() {
            let (first, last) = (edge.from.min(edge.to), edge.from.max(edge.to));
            if edge.cauchy.is_some() {
                spans[first.min(count)] += 1;
                spans[last.min(count)] -= 1;
            } else if let (Some(lost), Some(cov)) =
                (is_lost.get_mut(first), edge.information.try_inverse())
            {
                *lost = doubt_ahead(&Doubt::of(&cov)) > LOST_SIGMA;
            }
        }
        let mut open = 0;
        let is_tied: Vec<bool> = (spans.iter().take(count))
            .map(|change| {
                open += change;
                open > 0
            })
            .collect();
        let mut untied = vec![];
        let mut first = 0;
        while let Some(begin) = (first..count.saturating_sub(1)).find(|&at| !is_tied[at]) {
            let end = (begin..count - 1)
                .find(|&at| is_tied[at])
                .unwrap_or(count - 1);
            untied.push(Untied {
                between: [begin, end],
                doubt: doubt_ahead(&self.doubts(begin)[end]),
                is_lost: is_lost[begin..end].contains(&true),
            });
            first = end;
        }
        untied
    }
}

fn follows_at_once(before: [Stamp; 2], after: [Stamp; 2]) -> bool {
    let lasts = |[from, to]: [Stamp; 2]| to.seconds() - from.seconds();
    let gap = after[0].seconds() - before[1].seconds();
    gap <= MOST_GAP * lasts(before).min(lasts(after))
}
