//! What the map is worth that scan matching has made.
//!
//! In: the closed submaps where they lie, and the pose graph. Out: [`MapQuality`]. It takes a
//! second for an hour's drive, so it is made when somebody asks.

use super::ScanMatcher;
use crate::estimation::map_quality::{MapQuality, Placed, Untied};
use crate::robot::Stamp;

/// A submap whose way to the next is known worse than this, m, was left by a robot that was lost.
const LOST_SIGMA: f64 = 0.2;

impl ScanMatcher {
    /// Whether the map is whole, and where it is torn. What was seen since the last submap was
    /// closed is left out.
    #[must_use]
    pub fn quality(&self) -> MapQuality {
        let closed = self.submaps.len().saturating_sub(1);
        let seen = self.seen(closed);
        let placed: Vec<Placed<'_>> = (self.submaps[..closed].iter().zip(seen))
            .map(|(submap, seen)| Placed {
                submap: &submap.closed,
                map_from_submap: submap.map_from_submap,
                seen,
            })
            .collect();
        let config = &self.config;
        MapQuality::of(
            &placed,
            &self.untied(closed),
            &config.surfels,
            &config.matching,
        )
    }

    /// When each of the first submaps was seen, from and to.
    fn seen(&self, count: usize) -> Vec<[Stamp; 2]> {
        let mut seen: Vec<Option<[Stamp; 2]>> = vec![None; count];
        for track in &self.trajectory {
            if let Some(seen) = seen.get_mut(track.submap) {
                let from = seen.map_or(track.stamp, |[from, _]| from);
                *seen = Some([from, track.stamp]);
            }
        }
        // A submap begins with a scan of its own; without one it lies between its neighbours.
        let mut last = [Stamp(0); 2];
        seen.into_iter()
            .map(|seen| {
                last = seen.unwrap_or([last[1]; 2]);
                last
            })
            .collect()
    }

    /// The ways between submaps that no closed loop spans, those on end as one.
    fn untied(&self, count: usize) -> Vec<Untied> {
        // Whether the way from each submap to the next is spanned, and known badly.
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
                *lost = (cov[(0, 0)] + cov[(1, 1)]).sqrt() > LOST_SIGMA;
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
                doubt: self.doubts(begin)[end].shift,
                is_lost: is_lost[begin..end].contains(&true),
            });
            first = end;
        }
        untied
    }
}
