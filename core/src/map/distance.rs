//! Exact Euclidean distance transform.
//!
//! In: a rectangle of cells and which of them are sources (walls, or the unknown). Out: for every
//! cell the distance of its centre from the centre of the nearest source.
//!
//! 1. Along each column the distance g to the nearest source is counted, row by row so that memory
//!    is read in order: first the source below, then the source above, just before step 2 needs it.
//! 2. Along each row the squared distance of column c is the least (c - q)² + g(q)² over all
//!    columns q ([`rows`]).
//!
//! Source: Felzenszwalb & Huttenlocher (2012), "Distance transforms of sampled functions",
//! algorithm 1; step 1 as in Meijster, Roerdink & Hesselink (2000). Linear in the number of cells.
//! Exact, unlike brushfire and chamfer distances, so a door that is wide enough by a centimetre
//! stays passable.

mod rows;

use std::borrow::Cow;

use nalgebra::Point2;
use pulp::NullaryFnOnce;

use self::rows::RowPass;
use super::{CellIndex, CellRect};
use crate::lanes::widened;

/// Distances to the nearest source over a rectangle of cells.
#[derive(Clone, Debug)]
pub struct DistanceField {
    rect: CellRect,
    resolution: f64,
    distances: Vec<f32>,
}

impl DistanceField {
    /// Measures the distance to the sources; `sources` holds the rows of `rect` one after another,
    /// lower row first. Cells beyond the end of `sources` are no sources.
    ///
    /// # Units    `resolution`: side of a cell, m.
    #[must_use]
    pub fn new(rect: CellRect, resolution: f64, sources: &[bool]) -> Self {
        let mut sources = Cow::Borrowed(sources);
        if sources.len() < rect.width() * rect.height() {
            sources.to_mut().resize(rect.width() * rect.height(), false);
        }
        let distances = widened(Transform {
            rect,
            resolution,
            sources: &sources,
        });
        Self {
            rect,
            resolution,
            distances,
        }
    }

    /// All distances in rows from the lower left cell, m, as [`Self::at`].
    #[must_use]
    pub fn into_distances(self) -> Vec<f32> {
        self.distances
    }

    /// Distance of the centre of a cell from the centre of the nearest source, m. Infinite where
    /// there is no source; cells outside the rectangle have the distance of the nearest cell
    /// inside.
    #[inline]
    #[must_use]
    pub fn at(&self, cell: CellIndex) -> f64 {
        let clamp =
            |at: i32, low: i32, high: i32| at.max(low).min(high - 1).wrapping_sub(low) as usize;
        let col = clamp(cell.col, self.rect.min.col, self.rect.max.col);
        let row = clamp(cell.row, self.rect.min.row, self.rect.max.row);
        self.distances
            .get(row * self.rect.width() + col)
            .map_or(f64::INFINITY, |&d| f64::from(d))
    }

    /// Distance at any point of the map, m: bilinear between the centres of cells. Between the
    /// centres its error is less than h²/(4 d) for cells of side h at distance d: under 4 mm for 5
    /// cm cells at 15 cm.
    #[inline]
    #[must_use]
    pub fn at_point(&self, point: Point2<f64>) -> f64 {
        let (x, y) = (
            point.x / self.resolution - 0.5,
            point.y / self.resolution - 0.5,
        );
        let (left, low) = (x.floor(), y.floor());
        let (fx, fy) = (x - left, y - low);
        let at = |col: i32, row: i32| {
            self.at(CellIndex::new(
                (left as i32).saturating_add(col),
                (low as i32).saturating_add(row),
            ))
        };
        let below = lerp(at(0, 0), at(1, 0), fx);
        let above = lerp(at(0, 1), at(1, 1), fx);
        lerp(below, above, fy)
    }
}

/// Linear interpolation. Infinity times zero must not become NaN: either all four corners are
/// infinite or none is.
fn lerp(a: f64, b: f64, t: f64) -> f64 {
    if a.is_finite() && b.is_finite() {
        a + (b - a) * t
    } else {
        a.min(b)
    }
}

/// The whole transform, as one loop for the machine's widest instructions.
struct Transform<'a> {
    rect: CellRect,
    resolution: f64,
    /// One for each cell.
    sources: &'a [bool],
}

impl NullaryFnOnce for Transform<'_> {
    type Output = Vec<f32>;

    #[inline(always)]
    fn call(self) -> Vec<f32> {
        let (width, height) = (self.rect.width(), self.rect.height());
        let gaps = gaps_below(width, height, self.sources);
        let mut distances = vec![f32::INFINITY; width * height];
        let mut pass = RowPass::new(width, self.resolution);
        let mut nearest = vec![u32::MAX; width];
        let rows = distances.chunks_exact_mut(width.max(1));
        for (row, gaps) in rows.zip(gaps.chunks_exact(width.max(1))).rev() {
            for (nearest, below) in nearest.iter_mut().zip(gaps) {
                *nearest = nearest.saturating_add(1).min(*below);
            }
            pass.measure(&nearest, row);
        }
        distances
    }
}

/// Number of cells down to the nearest source in the same column, 0 at a source; `u32::MAX` if
/// there is none below.
#[inline(always)]
fn gaps_below(width: usize, height: usize, sources: &[bool]) -> Vec<u32> {
    let mut gaps = vec![u32::MAX; width * height];
    let mut last = vec![u32::MAX; width];
    let rows = gaps.chunks_exact_mut(width.max(1));
    for (row, sources) in rows.zip(sources.chunks_exact(width.max(1))) {
        for ((gap, last), is_source) in row.iter_mut().zip(&mut last).zip(sources) {
            *last = last.saturating_add(1) * u32::from(!is_source);
            *gap = *last;
        }
    }
    gaps
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn rect(col: i32, row: i32, width: usize, height: usize) -> CellRect {
        CellRect {
            min: CellIndex { col, row },
            max: CellIndex::new(col + width as i32, row + height as i32),
        }
    }

    proptest! {
        #[test]
        fn equals_brute_force(
            width in 1_usize..24, height in 1_usize..24, col in -40..40, row in -40..40,
            seed in proptest::collection::vec(0_u8..20, 24 * 24),
        ) {
            let sources: Vec<bool> = seed.iter().take(width * height).map(|&s| s == 0).collect();
            let rect = rect(col, row, width, height);
            let field = DistanceField::new(rect, 0.05, &sources);
            for r in 0..height {
                for c in 0..width {
                    let brute = (0..width * height)
                        .filter(|&i| sources[i])
                        .map(|i| {
                            let (dc, dr) = ((i % width) as f64 - c as f64, (i / width) as f64 - r as f64);
                            (dc * dc + dr * dr).sqrt() * 0.05
                        })
                        .fold(f64::INFINITY, f64::min);
                    let cell = CellIndex { col: col + c as i32, row: row + r as i32 };
                    let found = field.at(cell);
                    prop_assert!(found == brute || (found - brute).abs() < 1e-6, "{found} against {brute}");
                }
            }
        }

        #[test]
        fn between_the_centres_the_error_keeps_its_bound(
            sources in proptest::collection::vec(0_usize..900, 1..6), x in 0.3..1.2_f64, y in 0.3..1.2_f64,
        ) {
            let mut mask = vec![false; 900];
            for &s in &sources { mask[s] = true; }
            let field = DistanceField::new(rect(0, 0, 30, 30), 0.05, &mask);
            let exact = sources.iter()
                .map(|&s| libm::hypot((s % 30) as f64 * 0.05 + 0.025 - x, (s / 30) as f64 * 0.05 + 0.025 - y))
                .fold(f64::INFINITY, f64::min);
            let found = field.at_point(Point2::new(x, y));
            // Never much too large: an error on that side would let a robot touch a wall.
            prop_assert!(exact < 0.12 || found - exact < 0.0025 / (4.0 * exact) + 1e-5, "{found} against {exact}");
            prop_assert!((found - exact).abs() < 0.05 * 0.7072);
        }
    }

    /// Wide rows with few sources: near and far cells in one row, and the words of eight and
    /// sixteen cells that end within it.
    #[test]
    fn far_sources_are_those_of_brute_force_too() {
        for (width, places) in [
            (700, vec![(3, 0)]),
            (701, vec![(350, 4), (690, 0)]),
            (
                645,
                vec![(0, 2), (200, 0), (210, 4), (400, 1), (520, 3), (644, 0)],
            ),
            (129, vec![(128, 4)]),
        ] {
            let mut sources = vec![false; width * 5];
            for &(col, row) in &places {
                sources[row * width + col] = true;
            }
            let field = DistanceField::new(rect(0, 0, width, 5), 0.05, &sources);
            for (at, found) in field.distances.iter().enumerate() {
                let squared = places.iter().map(|(col, row)| {
                    let (dc, dr) = (col.abs_diff(at % width), row.abs_diff(at / width));
                    dc * dc + dr * dr
                });
                let expected = squared
                    .min()
                    .map_or(f64::INFINITY, |s| (s as f64).sqrt() * 0.05);
                assert_eq!(*found, expected as f32, "{width}: {at}");
            }
        }
    }

    #[test]
    fn no_source_is_infinitely_far_and_no_cells_are_no_trouble() {
        let none = DistanceField::new(rect(0, 0, 3, 2), 0.05, &[false; 6]);
        assert!(none.at(CellIndex { col: 1, row: 1 }).is_infinite());
        assert!(none.at_point(Point2::new(0.06, 0.05)).is_infinite());
        let empty = DistanceField::new(rect(0, 0, 0, 0), 0.05, &[]);
        assert!(empty.at(CellIndex { col: 0, row: 0 }).is_infinite());
    }
}
