//! Regions as polygons.

use nalgebra::{Point2, Vector2};

use super::{NONE, Topology};
use crate::map::outlines;

/// Columns and rows of the cells of a region, the last ones excluded.
#[derive(Clone, Copy)]
struct Extent {
    low: (usize, usize),
    high: (usize, usize),
}

impl Topology {
    /// The outlines of each region, map frame, m: counter-clockwise round the floor, clockwise
    /// round furniture. They are accurate to a cell, and anything thinner is skipped.
    #[must_use]
    pub fn outlines(&self) -> Vec<Vec<Vec<Point2<f64>>>> {
        let extents = self.extents().into_iter().enumerate();
        extents
            .map(|(region, extent)| self.outline(region as u32, extent))
            .collect()
    }

    fn extents(&self) -> Vec<Extent> {
        let none = Extent {
            low: (usize::MAX, usize::MAX),
            high: (0, 0),
        };
        let mut extents = vec![none; self.regions.len()];
        let width = self.rect.width().max(1);
        for (index, &label) in self.labels.iter().enumerate().filter(|(_, l)| **l != NONE) {
            let (col, row) = (index % width, index / width);
            let Extent { low, high } = &mut extents[label as usize];
            *low = (low.0.min(col), low.1.min(row));
            *high = (high.0.max(col + 1), high.1.max(row + 1));
        }
        extents
    }

    fn outline(&self, region: u32, Extent { low, high }: Extent) -> Vec<Vec<Point2<f64>>> {
        let width = self.rect.width();
        let rows = self.labels.chunks(width.max(1)).take(high.1).skip(low.1);
        let cells: Vec<bool> = rows
            .flat_map(|row| row.iter().take(high.0).skip(low.0))
            .map(|&label| label == region)
            .collect();
        let corner = Vector2::new(
            f64::from(self.rect.min.col) + low.0 as f64,
            f64::from(self.rect.min.row) + low.1 as f64,
        );
        let in_map = |at: Point2<f64>| Point2::from((at.coords + corner) * self.resolution);
        // The outlines have the outside of the region on their left; reversed, they have the region
        // there.
        let rings = outlines(high.0 - low.0, &cells, 1.0);
        let rings = rings.into_iter().filter(|ring| ring.len() > 2);
        rings
            .map(|ring| ring.into_iter().rev().map(in_map).collect())
            .collect()
    }
}
