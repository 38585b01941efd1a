//! Which part of a world can be explored.
//!
//! In: a world and the robot's radius. Out: a bitmap of the floor on which the robot can stand or
//! which it can see, the denominator of "explored fraction".
//!
//! 1. Flood from the start over cells whose centre is at least the radius away from every wall:
//!    there the robot's centre can be.
//! 2. From a lattice of those cells, look all round as far as a lidar sees; the cells that the rays
//!    cross before they meet a wall can be seen.
//! 3. Doors that open at some time count as open.
//! 4. Cells in or next to a wall do not count: whether a map calls them free or occupied is chance.

use std::f64::consts::TAU;

use nalgebra::{Point2, Vector2};

use super::{Caster, Fan, Material, Wall, World};

/// Rays from each look-out.
const RAYS: usize = 360;
/// How far to look, m: the range of an RPLIDAR.
const SIGHT: f64 = 12.0;
/// A place with no wall within this distance is outside the building, m.
const FARTHEST_WALL: f64 = 3.0 * SIGHT;
/// Distance between look-outs, m.
const LOOKOUT_SPACING: f64 = 0.5;
/// Bound on the look-outs; beyond it, they stand farther apart.
const MOST_LOOKOUTS: f64 = 8e3;
/// Bound on the cells of the bitmap; beyond it, the cells become larger.
const MOST_CELLS: f64 = 4e6;

/// A bitmap of the floor in the world frame.
#[derive(Clone, Debug, PartialEq)]
pub struct ReachableArea {
    /// Lower corner of the bitmap, world frame.
    pub low: Point2<f64>,
    /// Side of a cell, m.
    pub resolution: f64,
    /// Cells along x.
    pub cols: usize,
    /// Cells along y.
    pub rows: usize,
    /// Row by row from the lower corner: whether the robot can stand in the cell or see it.
    pub cells: Vec<bool>,
    /// Row by row: whether the robot's centre can be in the cell.
    pub standing: Vec<bool>,
}

/// The cells that a robot of `robot_radius` (m) can reach from the start of `world`, or see on the
/// way.
///
/// # Units    `resolution`: side of a cell, m; made larger if the world would need more than 4
/// million cells.
#[must_use]
pub fn reachable_area(world: &World, robot_radius: f64, resolution: f64) -> ReachableArea {
    let caster = caster_of(world);
    let mut area = ReachableArea::empty(world, resolution);
    area.flood(world.start.position(), robot_radius, &caster);
    area.look_round(&caster);
    area.leave_out_walls(&caster);
    area
}

fn caster_of(world: &World) -> Caster {
    let mut walls = world.walls();
    let never = world.doors.iter().filter(|door| !door.ever_opens());
    walls.extend(never.map(|door| Wall {
        segment: door.leaf,
        material: Material::Opaque,
    }));
    Caster::new(walls)
}

impl ReachableArea {
    /// Centres of the cells that count, world frame.
    pub fn centres(&self) -> impl Iterator<Item = Point2<f64>> {
        let counting = (0..self.cells.len()).filter(|&index| self.cells[index]);
        counting.map(|index| self.centre(index))
    }

    /// Centres of the cells in which the robot's centre can be, world frame.
    pub fn places(&self) -> impl Iterator<Item = Point2<f64>> {
        let standing = (0..self.standing.len()).filter(|&index| self.standing[index]);
        standing.map(|index| self.centre(index))
    }

    /// Part of the area for which `is_known` is true at the centre of the cell, world frame; 1 if
    /// nothing can be reached.
    #[must_use]
    pub fn known_fraction(&self, mut is_known: impl FnMut(Point2<f64>) -> bool) -> f64 {
        let (mut all, mut known) = (0_u64, 0_u64);
        for centre in self.centres() {
            all += 1;
            known += u64::from(is_known(centre));
        }
        if all == 0 {
            1.0
        } else {
            known as f64 / all as f64
        }
    }

    fn empty(world: &World, resolution: f64) -> Self {
        let (low, high) = world.bounds();
        let extent = high - low;
        let least = (extent.x.max(0.1) * extent.y.max(0.1) / MOST_CELLS).sqrt();
        let resolution = match resolution.is_finite() {
            true => resolution.max(least).max(1e-3),
            false => least.max(0.05),
        };
        let along = |metres: f64| (metres / resolution).ceil() as usize + 2;
        let (cols, rows) = (along(extent.x), along(extent.y));
        Self {
            low: low - Vector2::new(resolution, resolution),
            resolution,
            cols,
            rows,
            cells: vec![false; cols * rows],
            standing: vec![false; cols * rows],
        }
    }

    fn flood(&mut self, start: Point2<f64>, radius: f64, caster: &Caster) {
        let mut front: Vec<usize> = self.index_of(start).into_iter().collect();
        // The start itself is free (the world was checked), even if the centre of its cell is not.
        front.iter().for_each(|&index| self.standing[index] = true);
        while let Some(index) = front.pop() {
            for next in self.neighbours(index) {
                let is_new = !self.standing[next];
                if is_new && caster.clearance(self.centre(next), radius) >= radius {
                    self.standing[next] = true;
                    front.push(next);
                }
            }
        }
        self.cells.clone_from(&self.standing);
    }

    fn look_round(&mut self, caster: &Caster) {
        // Thin out rows and columns so that there are no more look-outs than allowed.
        let bound = (self.cells.len() as f64 / MOST_LOOKOUTS).sqrt().ceil();
        let spacing = ((LOOKOUT_SPACING / self.resolution).max(bound) as usize).max(1);
        let Some(mut fan) = Fan::new(RAYS, 0.0, TAU / RAYS as f64) else {
            return;
        };
        for row in (0..self.rows).step_by(spacing) {
            for col in (0..self.cols).step_by(spacing) {
                let index = row * self.cols + col;
                if self.standing.get(index) == Some(&true) {
                    caster.cast_fan(self.centre(index), 0.0, FARTHEST_WALL, &mut fan);
                    self.look_from(self.centre(index), &fan);
                }
            }
        }
    }

    fn look_from(&mut self, eye: Point2<f64>, fan: &Fan) {
        for (beam, distance) in fan.distances().iter().enumerate() {
            // No wall, no floor: outside the building nothing counts.
            let Some(direction) = fan.direction(beam).filter(|_| distance.is_finite()) else {
                continue;
            };
            // In cells, once: a step then takes two additions. Walls end the ray before the rim
            // does.
            let from = (eye - self.low) / self.resolution;
            for step in 1..(distance.min(SIGHT) / self.resolution) as usize {
                let at = from + direction * step as f64;
                let index = at.y as usize * self.cols + at.x as usize;
                if let Some(cell) = self.cells.get_mut(index) {
                    *cell = true;
                }
            }
        }
    }

    fn leave_out_walls(&mut self, caster: &Caster) {
        for index in 0..self.cells.len() {
            let is_clear =
                || caster.clearance(self.centre(index), self.resolution) >= self.resolution;
            self.cells[index] = self.cells[index] && is_clear();
        }
    }

    pub(super) fn centre(&self, index: usize) -> Point2<f64> {
        let (row, col) = (index / self.cols, index % self.cols);
        self.low + Vector2::new(col as f64 + 0.5, row as f64 + 0.5) * self.resolution
    }

    fn index_of(&self, point: Point2<f64>) -> Option<usize> {
        let at = (point - self.low) / self.resolution;
        let is_inside =
            (0.0..self.cols as f64).contains(&at.x) && (0.0..self.rows as f64).contains(&at.y);
        is_inside.then(|| at.y as usize * self.cols + at.x as usize)
    }

    fn neighbours(&self, index: usize) -> impl Iterator<Item = usize> + use<> {
        let (cols, rows) = (self.cols, self.rows);
        let (row, col) = (index / cols, index % cols);
        let around = [
            (row, col.wrapping_sub(1)),
            (row, col + 1),
            (row.wrapping_sub(1), col),
            (row + 1, col),
        ];
        around
            .into_iter()
            .filter(move |&(r, c)| r < rows && c < cols)
            .map(move |(r, c)| r * cols + c)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::Pose2;

    fn square(half: f64) -> World {
        World::new("square", Pose2::identity()).with_room(&[
            (-half, -half),
            (half, -half),
            (half, half),
            (-half, half),
        ])
    }

    #[test]
    fn an_empty_room_counts_but_for_its_rim() {
        let area = reachable_area(&square(2.0), 0.11, 0.05);
        // Everything but the cells nearer than one cell to the wall.
        let metres = area.centres().count() as f64 * 0.05 * 0.05;
        assert!((metres - 3.9 * 3.9).abs() < 0.3, "{metres}");
        assert_eq!(area.known_fraction(|_| true), 1.0);
        assert!((area.known_fraction(|p| p.x > 0.0) - 0.5).abs() < 0.02);
    }

    #[test]
    fn what_is_behind_closed_walls_does_not_count_and_what_is_seen_through_a_gap_does() {
        let closed = square(2.0).with_walls(&[(1.0, -2.0), (1.0, 2.0)]);
        let area = reachable_area(&closed, 0.11, 0.05);
        assert!(area.centres().all(|p| p.x < 1.0 && p.x > -2.0));
        // A slit of 0.1 m lets light through, but no robot.
        let slit = square(2.0)
            .with_walls(&[(1.0, -2.0), (1.0, -0.05)])
            .with_walls(&[(1.0, 0.05), (1.0, 2.0)]);
        let area = reachable_area(&slit, 0.11, 0.05);
        let behind = area.centres().filter(|p| p.x > 1.05).count();
        assert!(behind > 200, "{behind}");
        let standing = area.standing.iter().enumerate().filter(|(_, s)| **s);
        assert!(standing.map(|(i, _)| area.centre(i)).all(|p| p.x < 1.0));
    }

    #[test]
    fn a_world_without_walls_is_only_its_bitmap() {
        let area = reachable_area(&World::new("void", Pose2::identity()), 0.11, 0.05);
        assert!(area.centres().count() <= area.cells.len());
        let _ = reachable_area(&square(2.0), 0.11, f64::NAN);
    }
}
