//! Which of the accepted placements close a loop.
//!
//! In: where the submaps lie. Out: for each placement, whether the robot had been away in between.
//! Neighbours on the trajectory lie well on each other without a loop: what both show was never out
//! of sight.

use nalgebra::{Point2, distance};

use super::ScanMatcher;
use super::records::{ClosureFate, ClosureRecord};

/// A robot that was less far away than this, m, has not come back.
const LEAST_AWAY: f64 = 3.0;

/// The origins of the submaps, and the distance to each along those before it, m.
#[derive(Clone, Debug)]
pub struct LoopsClosed(Vec<(Point2<f64>, f64)>);

impl LoopsClosed {
    fn along(origins: impl Iterator<Item = Point2<f64>>) -> Self {
        let mut way = Vec::new();
        for origin in origins {
            let (before, length) = way.last().copied().unwrap_or((origin, 0.0));
            way.push((origin, length + distance(&before, &origin)));
        }
        Self(way)
    }

    /// Whether a placement is accepted and closes a loop. It closes none if its submaps are
    /// neighbours: if the path between them is no longer than twice their distance apart, plus a
    /// few metres away and back.
    #[must_use]
    pub fn closes(&self, record: &ClosureRecord) -> bool {
        matches!(record.fate, ClosureFate::Accepted { .. })
            && self.was_away_between(record.old, record.new)
    }

    fn was_away_between(&self, old: usize, new: usize) -> bool {
        let ends = self.0.get(old).zip(self.0.get(new));
        ends.is_some_and(|((from, before), (to, after))| {
            after - before >= 2.0 * (distance(from, to) + LEAST_AWAY)
        })
    }
}

impl ScanMatcher {
    /// Which of the placements close a loop, as the submaps lie now.
    #[must_use]
    pub fn loops_closed(&self) -> LoopsClosed {
        LoopsClosed::along(
            self.submaps()
                .map(|submap| submap.map_from_submap.position()),
        )
    }

    /// Counts the closed loops, after submaps or records have changed.
    pub(super) fn count_loops(&mut self) {
        let loops = self.loops_closed();
        let accepted = self.records.iter();
        self.closures = accepted.filter(|record| loops.closes(record)).count();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_loop_is_closed_only_where_the_robot_had_been_away() {
        // Along a corridor, around its corner, and back along the same corridor.
        let way = [0.0, 4.0, 8.0, 8.0, 8.0, 4.0, 0.0].into_iter();
        let way = way.zip([0.0, 0.0, 0.0, 4.0, 0.0, 0.0, 0.0]);
        let loops = LoopsClosed::along(way.map(|(x, y)| Point2::new(x, y)));
        // 8 m straight on; 12 m to a place that is 8.9 m away: neighbours.
        assert!(!loops.was_away_between(0, 2) && !loops.was_away_between(0, 3));
        // Out and back: by 8 m, by 16 m, and by all of it.
        assert!(loops.was_away_between(2, 4));
        assert!(loops.was_away_between(1, 5) && loops.was_away_between(0, 6));
        // A submap that no longer exists closes nothing.
        assert!(!loops.was_away_between(0, 7));
    }
}
