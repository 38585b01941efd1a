//! The cells that a straight beam crosses.
//!
//! Source: Amanatides & Woo (1987), "A fast voxel traversal algorithm for ray tracing", in two
//! dimensions: every cell that the line enters is visited once, in order. (Bresenham's line, as in
//! Celej §2, skips cells that the beam only nicks.)

use nalgebra::Point2;

use super::CellIndex;

/// Visits the cells from `start` to `end`, both given in cells (metres / resolution), the cell of
/// `end` last.
///
/// Work is bounded by the number of cells between the ends; ends that are not finite visit nothing.
pub fn cells_on_ray(start: Point2<f64>, end: Point2<f64>, mut visit: impl FnMut(CellIndex)) {
    if !are_in_reach(start, end) {
        return;
    }
    let mut cell = CellIndex::holding(start);
    let last = CellIndex::holding(end);
    let steps = (last.col - cell.col).unsigned_abs() + (last.row - cell.row).unsigned_abs();
    let delta = end - start;
    let (step_col, mut t_col, dt_col) = axis(start.x, delta.x);
    let (step_row, mut t_row, dt_row) = axis(start.y, delta.y);
    visit(cell);
    for _ in 0..steps {
        // Rounding must not carry an axis past its last cell: then the other axis steps.
        let col_done = cell.col == last.col;
        let row_done = cell.row == last.row;
        // Without a branch, because the direction is unpredictable; both sums start before it is
        // known.
        let (next_col, next_row) = (t_col + dt_col, t_row + dt_row);
        let along_col = !col_done & (row_done | (t_col < t_row));
        t_col = if along_col { next_col } else { t_col };
        t_row = if along_col { t_row } else { next_row };
        cell.col += if along_col { step_col } else { 0 };
        cell.row += if along_col { 0 } else { step_row };
        visit(cell);
    }
}

pub(super) fn are_in_reach(start: Point2<f64>, end: Point2<f64>) -> bool {
    let mut coordinates = start.coords.iter().chain(end.coords.iter());
    coordinates.all(|c| c.is_finite() && c.abs() < 1e9)
}

/// Direction of the step, line parameter at the first border, and parameter difference between
/// borders.
fn axis(start: f64, delta: f64) -> (i32, f64, f64) {
    if delta > 0.0 {
        (1, (start.floor() + 1.0 - start) / delta, 1.0 / delta)
    } else if delta < 0.0 {
        (-1, (start.floor() - start) / delta, -1.0 / delta)
    } else {
        (0, f64::INFINITY, f64::INFINITY)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn cells(start: (f64, f64), end: (f64, f64)) -> Vec<(i32, i32)> {
        let mut cells = vec![];
        cells_on_ray(
            Point2::new(start.0, start.1),
            Point2::new(end.0, end.1),
            |c| cells.push((c.col, c.row)),
        );
        cells
    }

    #[test]
    fn straight_rays() {
        assert_eq!(
            cells((0.5, 0.5), (3.5, 0.5)),
            [(0, 0), (1, 0), (2, 0), (3, 0)]
        );
        assert_eq!(cells((0.5, 0.5), (0.5, -1.5)), [(0, 0), (0, -1), (0, -2)]);
        assert_eq!(cells((0.5, 0.5), (0.6, 0.6)), [(0, 0)]);
        assert!(cells((0.5, f64::NAN), (0.6, 0.6)).is_empty());
    }

    proptest! {
        #[test]
        fn every_cell_that_the_beam_enters_is_visited_once_in_order(
            ax in -20.0..20.0_f64, ay in -20.0..20.0_f64, bx in -20.0..20.0_f64, by in -20.0..20.0_f64,
        ) {
            let visited = cells((ax, ay), (bx, by));
            prop_assert_eq!(visited[0], (ax.floor() as i32, ay.floor() as i32));
            prop_assert_eq!(visited[visited.len() - 1], (bx.floor() as i32, by.floor() as i32));
            for pair in visited.windows(2) {
                prop_assert_eq!((pair[1].0 - pair[0].0).abs() + (pair[1].1 - pair[0].1).abs(), 1);
            }
            // Oracle: dense samples along the beam fall into visited cells only.
            for i in 0..=2000 {
                let t = f64::from(i) / 2000.0;
                let p = (ax + t * (bx - ax), ay + t * (by - ay));
                let near_border = (p.0 - p.0.round()).abs() < 1e-6 || (p.1 - p.1.round()).abs() < 1e-6;
                prop_assert!(near_border || visited.contains(&(p.0.floor() as i32, p.1.floor() as i32)));
            }
        }
    }
}
