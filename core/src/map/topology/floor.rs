//! The floor and what bounds it.
//!
//! In: states of cells. Out: a raster with a closed rim: free cells, bounding cells, and the
//! clearance of each cell.

use nalgebra::{Point2, Vector2};

use super::TopologyConfig;
use crate::geom::Length;
use crate::map::{CellRect, CellState, DistanceField, spread, without_stripes};

/// A raster with a rim of one cell, so that every cell within has eight neighbours.
pub(super) struct Floor {
    rect: CellRect,
    resolution: f64,
    pub(super) width: usize,
    /// The believed state of each cell.
    pub(super) states: Vec<CellState>,
    /// Whether it bounds the floor: neither free nor furniture.
    pub(super) bounds: Vec<bool>,
    /// Distance of each cell's centre from that of the nearest bounding cell, m.
    pub(super) clearance: Vec<f32>,
}

impl Floor {
    pub(super) fn new(
        rect: CellRect,
        resolution: f64,
        states: &[CellState],
        config: &TopologyConfig,
    ) -> Self {
        let rect = rect.grown(1);
        let width = rect.width();
        let states = with_rim(width, rect.height(), states);
        let seen = without_stripes(&states, width);
        let mut bounds: Vec<bool> = seen.iter().map(|&s| s != CellState::Free).collect();
        leave_out_islands(&mut bounds, width, config.island / resolution);
        let clearance = DistanceField::new(rect, resolution, &bounds);
        Self {
            rect,
            resolution,
            width,
            states,
            bounds,
            clearance: clearance.into_distances(),
        }
    }

    pub(super) fn resolution(&self) -> f64 {
        self.resolution
    }

    pub(super) fn rect(&self) -> CellRect {
        self.rect
    }

    pub(super) fn is_free(&self, cell: usize) -> bool {
        self.states[cell] == CellState::Free
    }

    /// The four neighbours of a cell that is not on the rim. Steps over corners are left out,
    /// because they would lead through thin diagonal walls.
    pub(super) fn neighbours(&self, cell: usize) -> [usize; 4] {
        [cell - self.width, cell - 1, cell + 1, cell + self.width]
    }

    /// Centre of a cell, in cells from the raster's lower left corner.
    pub(super) fn place(&self, cell: usize) -> Point2<f64> {
        Point2::new(
            (cell % self.width) as f64 + 0.5,
            (cell / self.width) as f64 + 0.5,
        )
    }

    /// A place of the raster in the map, m.
    pub(super) fn in_map(&self, place: Point2<f64>) -> Point2<f64> {
        let corner = Vector2::new(f64::from(self.rect.min.col), f64::from(self.rect.min.row));
        Point2::from((corner + place.coords) * self.resolution)
    }

    /// The width at a cell of the ridge, m: what bounds it lies anywhere within its cells, on
    /// average at their centre.
    pub(super) fn width_at(clearance: f32) -> f64 {
        2.0 * f64::from(clearance)
    }
}

fn with_rim(width: usize, height: usize, states: &[CellState]) -> Vec<CellState> {
    let mut padded = vec![CellState::Unknown; width * height];
    let inner = width.saturating_sub(2);
    if inner > 0 {
        let rows = padded.chunks_mut(width).skip(1).zip(states.chunks(inner));
        for (row, cells) in rows.take(height.saturating_sub(2)) {
            row[1..=cells.len()].copy_from_slice(cells);
        }
    }
    padded
}

/// Removes islands that reach no farther than `reach` cells from their middle. Cells that touch at
/// a corner belong together.
fn leave_out_islands(bounds: &mut [bool], width: usize, reach: f64) {
    let (w, count) = (width as isize, bounds.len());
    let steps = [-w - 1, -w, -w + 1, -1, 1, w - 1, w, w + 1];
    let around = |cell: usize| {
        let near = steps
            .into_iter()
            .filter_map(move |by| cell.checked_add_signed(by));
        near.filter(move |to| *to < count)
    };
    let mut left = bounds.to_vec();
    for seed in 0..count {
        if !std::mem::take(&mut left[seed]) {
            continue;
        }
        let cells = spread(seed, around, |cell| std::mem::take(&mut left[cell]));
        // The first group is the rim, with everything that is connected to it.
        if seed > 0 && is_within(|| cells.cells(), width, reach) {
            cells.cells().for_each(|cell| bounds[cell] = false);
        }
    }
}

fn is_within<C: ExactSizeIterator<Item = usize>>(
    cells: impl Fn() -> C,
    width: usize,
    reach: f64,
) -> bool {
    let count = cells().len() as f64;
    // A disc of that radius has no more cells than this.
    if count > std::f64::consts::PI * (reach + 1.0) * (reach + 1.0) {
        return false;
    }
    let places = || cells().map(|cell| Vector2::new((cell % width) as f64, (cell / width) as f64));
    let middle = places().sum::<Vector2<f64>>() / count.max(1.0);
    places().all(|place| (place - middle).length() <= reach)
}
