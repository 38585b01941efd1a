//! Where a building has room for a robot.

use nalgebra::Point2;

use super::BuildingError;
use crate::map::{CellIndex, CellRect, DistanceField};

/// For each cell of a raster, how far it is from the nearest obstacle.
pub(super) struct Room {
    width: usize,
    resolution: f64,
    field: DistanceField,
    stands: Vec<bool>,
}

impl Room {
    /// For a raster whose lower left corner is the origin; `stands` marks the cells where no robot
    /// can be.
    pub(super) fn new(width: usize, resolution: f64, stands: Vec<bool>) -> Self {
        let height = stands.len() / width.max(1);
        let rect = CellRect::of_size(width, height);
        Self {
            width,
            resolution,
            field: DistanceField::new(rect, resolution, &stands),
            stands,
        }
    }

    /// Excludes as a start everything that is connected to the border, if there is room inside.
    pub(super) fn without_outside(mut self, needed: f64) -> Self {
        let (width, height) = (self.width, self.stands.len() / self.width.max(1));
        let mut outside = self.stands.clone();
        let border = (0..width)
            .flat_map(|col| [col, (height - 1) * width + col])
            .chain((0..height).flat_map(|row| [row * width, row * width + width - 1]));
        let mut open: Vec<usize> = border.filter(|&at| !outside[at]).collect();
        while let Some(at) = open.pop() {
            if std::mem::replace(&mut outside[at], true) {
                continue;
            }
            let (col, row) = (at % width, at / width);
            let neighbours = [
                (col > 0).then(|| at - 1),
                (col + 1 < width).then(|| at + 1),
                (row > 0).then(|| at - width),
                (row + 1 < height).then(|| at + width),
            ];
            open.extend(neighbours.into_iter().flatten().filter(|&n| !outside[n]));
        }
        let inside = (0..outside.len()).filter(|&at| !outside[at]);
        if inside.map(|at| self.at(at)).fold(0.0, f64::max) >= needed {
            self.stands = outside;
        }
        self
    }

    /// Distance from the nearest cell where no robot can be, m; 0 outside the raster and in such
    /// cells.
    pub(super) fn clearance(&self, at: Point2<f64>) -> f64 {
        let cell = at / self.resolution;
        let (width, height) = (self.width, self.stands.len() / self.width.max(1));
        if !(0.0..width as f64).contains(&cell.x) || !(0.0..height as f64).contains(&cell.y) {
            return 0.0;
        }
        let index = cell.y as usize * self.width + cell.x as usize;
        match self.stands.get(index) {
            Some(false) => self.at(index),
            _ => 0.0,
        }
    }

    /// The centre of the first of the cells with most room.
    ///
    /// # Errors    [`BuildingError::NoRoom`].
    pub(super) fn roomiest(&self, needed: f64) -> Result<Point2<f64>, BuildingError> {
        let free = (0..self.stands.len()).filter(|&at| !self.stands[at]);
        let (widest, at) = free.fold((0.0, 0), |best, at| {
            let room = self.at(at);
            if room > best.0 { (room, at) } else { best }
        });
        if widest < needed {
            return Err(BuildingError::NoRoom { widest, needed });
        }
        let (col, row) = ((at % self.width) as f64, (at / self.width) as f64);
        Ok(Point2::new(col + 0.5, row + 0.5) * self.resolution)
    }

    /// A lower bound of the distance from the border of the nearest occupied cell.
    fn at(&self, index: usize) -> f64 {
        let height = self.stands.len() / self.width;
        let (col, row) = (index % self.width, index / self.width);
        // Where there are no obstacles, the border of the raster is the limit.
        let border = col.min(row).min(self.width - 1 - col).min(height - 1 - row) as f64;
        let far = (border + 1.0) * self.resolution;
        (self.field.at(CellIndex::new(col as i32, row as i32)) - 0.75 * self.resolution).min(far)
    }
}
