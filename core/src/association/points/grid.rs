//! Places sorted by square cell: neighbours are in the nine cells around.

use nalgebra::Point2;

/// Places, sorted by cell.
#[derive(Clone, Debug)]
pub(super) struct PointGrid {
    side: f64,
    /// Cell and index of each place, in order.
    entries: Vec<([i64; 2], usize)>,
}

impl PointGrid {
    /// A grid in which [`Self::near`] finds all places within `reach`, m.
    pub(super) fn new(places: impl Iterator<Item = Point2<f64>>, reach: f64) -> Self {
        // Cells of zero or infinite size would hold nothing or everything.
        let side = if reach.is_finite() {
            reach.max(1e-6)
        } else {
            f64::MAX
        };
        let mut entries: Vec<_> = places
            .enumerate()
            .map(|(number, place)| (cell(place, side), number))
            .collect();
        entries.sort_unstable();
        Self { side, entries }
    }

    /// Indices of all places within reach of a point, and of some beyond.
    pub(super) fn near(&self, point: Point2<f64>) -> impl Iterator<Item = usize> {
        let [column, row] = cell(point, self.side);
        let columns = column.saturating_sub(1)..=column.saturating_add(1);
        columns.flat_map(move |column| {
            let from = [column, row.saturating_sub(1)];
            let to = [column, row.saturating_add(1)];
            let first = self.entries.partition_point(|(cell, _)| *cell < from);
            let end = self.entries.partition_point(|(cell, _)| *cell <= to);
            let entries = self.entries.get(first..end).unwrap_or_default();
            entries.iter().map(|(_, number)| *number)
        })
    }
}

fn cell(place: Point2<f64>, side: f64) -> [i64; 2] {
    [place.x, place.y].map(|coordinate| (coordinate / side).floor() as i64)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::geom::Length;

    proptest! {
        #[test]
        fn all_that_is_within_reach_is_near(
            places in prop::collection::vec((-9.0..9.0_f64, -9.0..9.0_f64), 0..60),
            x in -9.0..9.0_f64, y in -9.0..9.0_f64, reach in 0.0..4.0_f64,
        ) {
            let places: Vec<_> = places.iter().map(|&(x, y)| Point2::new(x, y)).collect();
            let grid = PointGrid::new(places.iter().copied(), reach);
            let at = Point2::new(x, y);
            let mut near: Vec<usize> = grid.near(at).collect();
            near.sort_unstable();
            for (number, place) in places.iter().enumerate() {
                let is_within = (place - at).length() <= reach;
                prop_assert!(!is_within || near.binary_search(&number).is_ok());
            }
            let before = near.len();
            near.dedup();
            prop_assert_eq!(near.len(), before, "each once");
            // Nothing that is more than two cells away.
            for number in near {
                prop_assert!((places[number] - at).amax() <= 2.0 * reach.max(1e-6));
            }
        }
    }

    #[test]
    fn with_any_reach_everything_is_near() {
        let places = [Point2::new(-1e9, 3.0), Point2::new(5.0, 7e11)];
        let grid = PointGrid::new(places.into_iter(), f64::INFINITY);
        assert_eq!(grid.near(Point2::origin()).count(), 2);
    }
}
