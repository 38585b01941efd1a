//! Whether hits lie on walls, in space known to be free, or in unknown space.
//!
//! In: the grid, a place, and its uncertainty. Out: what is known of that place.
//!
//! A hit violates free space if all cells within the uncertainty of its place are known to be free,
//! so that neither an error of the pose nor a wall beside it explains the hit.
//!
//! Source: Wang, Thorpe, Thrun, Hebert & Durrant-Whyte (2007), "Simultaneous localization, mapping
//! and moving object tracking", §IV, consistency-based detection.

use nalgebra::Point2;

use crate::geom::unit_vector;
use crate::map::{CellIndex, CellRect, CellState, Grid};

/// A hit within this many cells of an occupied cell belongs to what stands there.
const BESIDE: i32 = 1;
/// Number of points examined on each ring around a hit.
const ON_RING: usize = 16;

/// What is known of a place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Place {
    /// Occupied, or right beside an occupied cell.
    Wall,
    /// Certainly free.
    Free,
    /// Neither is certain.
    Unknown,
}

/// Looks up a place of the map that is known to within `doubt` metres.
pub(super) fn place(grid: &Grid, at: Point2<f64>, doubt: f64) -> Place {
    if is_beside_wall(grid, at) {
        return Place::Wall;
    }
    let is_free = |at| grid.state(grid.cell_at(at)) == CellState::Free;
    if !is_free(at) {
        return Place::Unknown;
    }
    // Rings a cell apart, the outermost at a radius of `doubt`.
    let rings = (doubt / grid.resolution()).ceil().clamp(1.0, 40.0) as usize;
    let around = |ring: usize| {
        let radius = doubt * ring as f64 / rings as f64;
        let step = std::f64::consts::TAU / ON_RING as f64;
        (0..ON_RING).map(move |part| at + unit_vector(part as f64 * step) * radius)
    };
    match (1..=rings).flat_map(around).all(is_free) {
        true => Place::Free,
        false => Place::Unknown,
    }
}

/// Whether a place lies in an occupied cell or right beside one.
pub(super) fn is_beside_wall(grid: &Grid, at: Point2<f64>) -> bool {
    let is_wall = |cell: CellIndex| grid.state(cell) == CellState::Occupied;
    let cell = grid.cell_at(at);
    // Most hits end in the cell of a wall.
    is_wall(cell) || CellRect::of(cell).grown(BESIDE).cells().any(is_wall)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::Pose2;
    use crate::map::{Evidence, GridConfig};

    /// 4 by 4 m of free space, with a wall along x = 1.
    fn grid() -> Grid {
        let mut grid = Grid::new(GridConfig::default()).unwrap();
        for _ in 0..5 {
            let rows = (0..80).map(|row| f64::from(row) * 0.05 - 1.975);
            let free = rows
                .clone()
                .map(|y| [Point2::new(-2.0, y), Point2::new(0.99, y)]);
            let evidence = Evidence {
                free: free.collect(),
                hits: rows.map(|y| Point2::new(1.02, y)).collect(),
            };
            grid.draw(&evidence, &Pose2::identity());
        }
        grid
    }

    #[test]
    fn free_is_what_is_free_all_around_as_far_as_it_is_uncertain() {
        let grid = grid();
        let at = |x: f64, doubt: f64| place(&grid, Point2::new(x, 0.0), doubt);
        assert_eq!(at(0.0, 0.1), Place::Free);
        assert_eq!(at(0.0, 0.9), Place::Free);
        assert_eq!(at(0.0, 1.1), Place::Unknown, "the wall may be it");
        assert_eq!(at(0.85, 0.1), Place::Free);
        assert_eq!(at(0.85, 0.3), Place::Unknown);
        assert_eq!(at(0.97, 0.1), Place::Wall);
        assert_eq!(at(1.2, 0.1), Place::Unknown, "nobody saw what is behind");
        assert_eq!(at(-1.95, 0.2), Place::Unknown);
        assert_eq!(at(50.0, 0.1), Place::Unknown);
    }
}
