//! The map that dead reckoning alone would have drawn.
//!
//! In: scans, and the poses by dead reckoning. Out: an occupancy grid in which each scan lies at
//! that pose. It shows why a robot needs more than its wheels: walls come out double, and corridors
//! bent.
//!
//! Like the estimated map it is drawn from keyframes: scans of a robot that stands still would only
//! make the same walls thicker.

use crate::geom::{Length, Pose2};
use crate::map::Grid;
use crate::points::Points;

/// A scan is drawn after this distance, m, ...
const SHIFT: f64 = 0.1;
/// ... or after this turn, rad.
const TURN: f64 = 0.1;

/// A map by dead reckoning; its frame is that of the map, where the robot began.
#[derive(Clone, Debug)]
pub(super) struct DeadReckonedMap {
    grid: Grid,
    /// The pose by dead reckoning at the last scan that was drawn.
    drawn_at: Option<Pose2>,
}

impl DeadReckonedMap {
    /// Draws into `grid`, which must be empty.
    pub(super) fn new(grid: Grid) -> Self {
        Self {
            grid,
            drawn_at: None,
        }
    }

    pub(super) fn grid(&self) -> &Grid {
        &self.grid
    }

    /// Draws what was seen at the pose by dead reckoning, once the robot has moved a little
    /// farther.
    pub(super) fn scan(&mut self, points: &Points, map_from_robot: &Pose2) {
        let is_new = self.drawn_at.is_none_or(|before| {
            let way = before.delta_to(map_from_robot);
            way.position().coords.length() >= SHIFT || way.heading().abs() >= TURN
        });
        if is_new {
            self.grid.insert(points, map_from_robot);
            self.drawn_at = Some(*map_from_robot);
        }
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Point2;

    use super::*;
    use crate::experiment::{Experiment, ExperimentConfig};
    use crate::map::{CellState, GridConfig};
    use crate::pilot::Mode;
    use crate::points::fixture::scan_of;
    use crate::sim::{SensorModel, worlds};

    fn occupied_near(grid: &Grid, at: Point2<f64>) -> bool {
        let cell = grid.cell_at(at);
        let mut around = (-1..=1).flat_map(|col| (-1..=1).map(move |row| (col, row)));
        around.any(|(col, row)| {
            let mut near = cell;
            near.col += col;
            near.row += row;
            grid.state(near) == CellState::Occupied
        })
    }

    /// Checked with the truth: each scan that is drawn lies on the true walls once it is moved from
    /// its pose by dead reckoning to the true pose.
    #[test]
    fn walls_lie_where_the_wheels_have_them() {
        let world = worlds::builtin("arena").unwrap();
        let config = ExperimentConfig {
            mode: Mode::Explore,
            ..ExperimentConfig::new(
                world,
                crate::robot::RobotModel::rp6(),
                SensorModel::lidar(),
                3,
            )
        };
        let mut run = Experiment::new(config).unwrap();
        run.draw_dead_reckoned();
        for _ in 0..600 {
            run.step().unwrap();
        }
        let session = run.session();
        let grid = session.dead_reckoned().unwrap();
        let points = session.slam().points().unwrap();
        let moved = session.slam().motion_since_scan().inverse();
        let by_wheels = session.dead_reckoning() * moved;
        let part = |pose: &Pose2| {
            let ends: Vec<Point2<f64>> =
                (points.hits().map(|beam| *pose * beam.end_in_robot)).collect();
            let on_walls = ends.iter().filter(|end| occupied_near(grid, **end));
            on_walls.count() as f64 / ends.len() as f64
        };
        let off = by_wheels.delta_to(&(run.truth() * moved));
        assert!(
            off.position().coords.length() > 0.2,
            "the wheels drift: {off:?}"
        );
        // What was seen just now was drawn just before, with next to no drift in between. But beams
        // passed through some of those walls when the dead-reckoned pose was elsewhere. And walls
        // are long: at the true pose, too, some hits lie on a wall.
        let [there, in_truth] = [by_wheels, run.truth() * moved].map(|pose| part(&pose));
        assert!(there > 0.5, "{there}");
        assert!(in_truth < there - 0.2, "{in_truth} of {there}");
    }

    #[test]
    fn a_robot_that_stands_draws_once() {
        let mut map = DeadReckonedMap::new(Grid::new(GridConfig::default()).unwrap());
        let points = scan_of(vec![]);
        for _ in 0..5 {
            map.scan(&points, &Pose2::identity());
        }
        assert_eq!(map.grid().revision(), 1);
        map.scan(&points, &Pose2::new(0.0, 0.05, 0.05));
        assert_eq!(map.grid().revision(), 1);
        map.scan(&points, &Pose2::new(0.0, 0.11, 0.0));
        map.scan(&points, &Pose2::new(0.0, 0.11, 0.11));
        assert_eq!(map.grid().revision(), 3);
    }
}
