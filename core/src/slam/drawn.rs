//! What is drawn for a method without a map of its own.
//!
//! A robot that is lost in its prior map needs a map to drive by, but what it then draws must not
//! get into the main grid. So it draws a second grid, which is dropped when the robot is found.

use crate::estimation::{Localisation, PoseQuality};
use crate::map::{Grid, GridConfig, GridError};

/// The map, and the temporary map of a lost robot.
#[derive(Debug)]
pub(super) struct Drawn {
    config: GridConfig,
    grid: Grid,
    /// Begun when the robot got lost.
    while_lost: Option<Grid>,
    /// How often one replaced the other.
    changes: u64,
}

impl Drawn {
    pub(super) fn new(config: GridConfig) -> Result<Self, GridError> {
        Ok(Self {
            config,
            grid: Grid::new(config)?,
            while_lost: None,
            changes: 0,
        })
    }

    /// The grid that shows where the robot is.
    pub(super) fn grid(&self) -> &Grid {
        self.while_lost.as_ref().unwrap_or(&self.grid)
    }

    /// Grows by one whenever [`Self::grid`] gives another grid than before.
    pub(super) fn changes(&self) -> u64 {
        self.changes
    }

    /// The grid to draw into, given what the method says of its pose.
    pub(super) fn grid_for(
        &mut self,
        quality: Option<PoseQuality>,
    ) -> Result<&mut Grid, GridError> {
        let is_known = quality.is_none_or(|q| q.localisation == Localisation::Localised);
        if is_known {
            self.changes += u64::from(self.while_lost.take().is_some());
            return Ok(&mut self.grid);
        }
        if self.while_lost.is_none() {
            self.changes += 1;
            self.while_lost = Some(Grid::new(self.config)?);
        }
        Ok(self.while_lost.as_mut().unwrap_or(&mut self.grid))
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Point2;

    use super::*;
    use crate::geom::Pose2;
    use crate::map::{CellState, Evidence};

    #[test]
    fn what_a_lost_robot_draws_is_gone_when_it_is_found_and_the_map_is_there_again() {
        let mut drawn = Drawn::new(GridConfig::default()).unwrap();
        let of = |localisation| {
            Some(PoseQuality {
                localisation,
                ..PoseQuality::default()
            })
        };
        let at = |x: f64| Evidence {
            free: vec![],
            hits: vec![Point2::new(x, 0.02); 5],
        };
        let mut draw = |quality, x: f64| {
            let grid = drawn.grid_for(quality).unwrap();
            grid.draw(&at(x), &Pose2::identity());
            let is_wall = |x: f64| {
                let cell = drawn.grid().cell_at(Point2::new(x, 0.02));
                drawn.grid().state(cell) == CellState::Occupied
            };
            (
                [is_wall(1.02), is_wall(2.02), is_wall(3.02)],
                drawn.changes(),
            )
        };
        assert_eq!(draw(None, 1.02), ([true, false, false], 0));
        assert_eq!(
            draw(of(Localisation::Lost), 2.02),
            ([false, true, false], 1)
        );
        let both = ([false, true, true], 1);
        assert_eq!(draw(of(Localisation::Ambiguous), 3.02), both);
        let again = ([true, true, false], 2);
        assert_eq!(draw(of(Localisation::Localised), 2.02), again);
    }
}
