//! Cells set by a person, regardless of what beams said of them.

use std::sync::Arc;

use nalgebra::Point2;

use super::{BLOCK, BLOCK_CELLS, BlockIndex, Grid, split};
use crate::geom::ring_holds;
use crate::map::{CellIndex, cells_on_ray};

impl Grid {
    /// Makes the cells unknown whose centres lie within a polygon, in whichever direction its
    /// corners go round.
    pub fn forget_within(&mut self, corners: &[Point2<f64>]) {
        let resolution = self.config.resolution;
        let corners: Vec<Point2<f64>> = corners.iter().map(|c| c / resolution).collect();
        let Some(first) = corners.first() else {
            return;
        };
        let (low, high) =
            (corners.iter()).fold((*first, *first), |(low, high), c| (low.inf(c), high.sup(c)));
        let side = f64::from(BLOCK);
        let meets = |index: &BlockIndex| {
            let (x, y) = (f64::from(index.col) * side, f64::from(index.row) * side);
            x <= high.x && x + side >= low.x && y <= high.y && y + side >= low.y
        };
        let blocks = self.directory.iter().map(|(index, _)| index);
        for index in blocks.filter(meets).collect::<Vec<_>>() {
            let within = |offset: &usize| {
                let cell = Point2::new(
                    f64::from(index.col) * side + (offset % BLOCK_CELLS) as f64 + 0.5,
                    f64::from(index.row) * side + (offset / BLOCK_CELLS) as f64 + 0.5,
                );
                ring_holds(&corners, cell)
            };
            let offsets: Vec<usize> = (0..BLOCK_CELLS * BLOCK_CELLS).filter(within).collect();
            self.set(index, &offsets, 0.0);
        }
    }

    /// Makes the cells from one place to another as surely occupied as the clamp allows.
    pub fn occupy(&mut self, from: Point2<f64>, to: Point2<f64>) {
        let scale = 1.0 / self.config.resolution;
        let mut cells: Vec<CellIndex> = vec![];
        cells_on_ray(from * scale, to * scale, |cell| cells.push(cell));
        let limit = self.odds.limit;
        for cell in cells {
            let (index, offset) = split(cell);
            if self.slot(index).is_some() {
                self.set(index, &[offset], limit);
            }
        }
    }

    /// Gives cells of an existing block these log-odds; if they already have them, nothing changes.
    fn set(&mut self, index: BlockIndex, offsets: &[usize], odds: f32) {
        let (revision, least) = (self.revision + 1, -self.odds.limit);
        let Some(block) = self.directory.get_mut(index) else {
            return;
        };
        let is_other = |offset: &&usize| block.cells()[**offset].to_bits() != odds.to_bits();
        if !offsets.iter().any(|offset| is_other(&offset)) {
            return;
        }
        let mut cells = *block.cells();
        for &offset in offsets {
            cells[offset] = odds;
        }
        block.take_over(Arc::new(cells), least);
        block.revision = revision;
        self.revision = revision;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::{CellState, Evidence, GridConfig};

    fn seen() -> Grid {
        let mut grid = Grid::new(GridConfig::default()).unwrap();
        let ends = (0..200).map(|at| Point2::new(5.0, 0.02 * f64::from(at) - 2.0));
        let evidence = Evidence {
            free: ends.clone().map(|end| [Point2::origin(), end]).collect(),
            hits: ends.collect(),
        };
        for _ in 0..5 {
            grid.draw(&evidence, &crate::geom::Pose2::identity());
        }
        grid
    }

    #[test]
    fn what_lies_within_is_forgotten_and_nothing_else() {
        for turned in [false, true] {
            let mut grid = seen();
            let before = grid.clone();
            let mut corners =
                [(4.0, -0.5), (6.0, -0.5), (6.0, 0.5), (4.0, 0.5)].map(|(x, y)| Point2::new(x, y));
            if turned {
                corners.reverse();
            }
            grid.forget_within(&corners);
            for col in 0..130 {
                for row in -50..50 {
                    let cell = CellIndex { col, row };
                    let at = grid.centre_of(cell);
                    let is_within = at.x > 4.0 && at.x < 6.0 && at.y.abs() < 0.5;
                    let odds = if is_within {
                        0.0
                    } else {
                        before.log_odds(cell)
                    };
                    assert_eq!(grid.log_odds(cell), odds, "{at}");
                }
            }
            assert!(grid.revision() > before.revision());
        }
    }

    #[test]
    fn a_line_is_occupied_and_drawn_over_like_any_wall() {
        let mut grid = seen();
        let (from, to) = (Point2::new(2.0, -0.5), Point2::new(2.0, 0.5));
        assert_eq!(
            grid.state(grid.cell_at(Point2::new(2.0, 0.1))),
            CellState::Free
        );
        grid.occupy(from, to);
        for step in 0..20 {
            let at = Point2::new(2.0, -0.49 + 0.05 * f64::from(step));
            assert_eq!(grid.state(grid.cell_at(at)), CellState::Occupied, "{at}");
        }
        assert_eq!(
            grid.state(grid.cell_at(Point2::new(2.1, 0.1))),
            CellState::Free
        );
        let revision = grid.revision();
        grid.occupy(from, to);
        assert_eq!(grid.revision(), revision, "nothing changed");
        let beam = Evidence {
            free: vec![[Point2::origin(), Point2::new(4.0, 0.0)]],
            hits: vec![],
        };
        let cell = grid.cell_at(Point2::new(2.0, 0.0));
        let odds = grid.log_odds(cell);
        grid.draw(&beam, &crate::geom::Pose2::identity());
        assert!(grid.log_odds(cell) < odds);
    }

    #[test]
    fn what_is_not_finite_changes_nothing_and_does_not_end_the_program() {
        let mut grid = seen();
        grid.forget_within(&[]);
        grid.forget_within(&[Point2::new(f64::NAN, 0.0); 3]);
        grid.occupy(Point2::new(f64::NAN, 0.0), Point2::new(1.0, f64::INFINITY));
    }
}
