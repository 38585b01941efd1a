//! What one map says of walls of another that lie somewhere in it.

use nalgebra::Point2;

use crate::geom::Pose2;
use crate::map::{CellIndex, CellState, Grid};

/// A wall agrees that lies nearer to an occupied cell than this, m, ...
const AGREES_WITHIN: f64 = 0.1;
/// ... and contradicts if none is nearer than this, and the cells around are free.
const CONTRADICTS_BEYOND: f64 = 0.25;
/// Of the walls of either map of which the other says something, this part has to agree.
const LEAST_PART: f64 = 0.92;

/// What one map says of the walls of the other.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Said {
    pub(super) agree: usize,
    pub(super) contradict: usize,
    pub(super) total: usize,
}

impl Said {
    /// What `grid` says of `walls` that lie at `pose` in it.
    pub(super) fn of(walls: &[Point2<f64>], pose: &Pose2, grid: &Grid) -> Self {
        let mut said = Self {
            total: walls.len(),
            ..Self::default()
        };
        for wall in walls {
            match says(grid, *pose * *wall) {
                Says::Agrees => said.agree += 1,
                Says::Contradicts => said.contradict += 1,
                Says::Nothing => {}
            }
        }
        said
    }

    fn part_of_all(&self, walls: usize) -> f64 {
        (walls as f64 / self.total.max(1) as f64).min(1.0)
    }

    pub(super) fn agrees(&self) -> f64 {
        self.part_of_all(self.agree)
    }

    pub(super) fn contradicts(&self) -> f64 {
        self.part_of_all(self.contradict)
    }

    /// Whether nearly all agrees of which something is said.
    pub(super) fn fits(&self) -> bool {
        self.agree as f64 >= LEAST_PART * (self.agree + self.contradict) as f64
    }
}

enum Says {
    Agrees,
    Contradicts,
    Nothing,
}

/// What a grid says of a wall at a place.
fn says(grid: &Grid, place: Point2<f64>) -> Says {
    let cells = |metres: f64| (metres / grid.resolution()).ceil() as i32;
    let (near, far) = (cells(AGREES_WITHIN), cells(CONTRADICTS_BEYOND));
    let middle = grid.cell_at(place);
    let mut is_free = true;
    let mut nearest = i32::MAX;
    for row in -far..=far {
        for col in -far..=far {
            let cell = CellIndex::new(
                middle.col.saturating_add(col),
                middle.row.saturating_add(row),
            );
            let away = col.abs().max(row.abs());
            match grid.state(cell) {
                CellState::Occupied => nearest = nearest.min(away),
                CellState::Free => {}
                CellState::Unknown if away <= 1 => is_free = false,
                CellState::Unknown => {}
            }
        }
    }
    match nearest {
        _ if nearest <= near => Says::Agrees,
        i32::MAX if is_free => Says::Contradicts,
        _ => Says::Nothing,
    }
}
