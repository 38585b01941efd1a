//! A map of small pieces of surface, made for matching: the piece nearest to a place is found by
//! one look.
//!
//! In: oriented points in the frame of the map. Out: [`Surfel`]s, and the one nearest to any place
//! within `reach`.
//!
//! 1. Space is cut into cells of `cell` metres. A new point that falls on a surfel of the same
//!    direction nearer than a cell is averaged into it, so that the noise of many scans shrinks;
//!    else it becomes a new surfel.
//! 2. Each surfel writes itself into all cells whose centre is within `reach` and nearer to it than
//!    to the one that stands there. Matching then needs no search: it reads the cell (the idea of a
//!    likelihood field, with the surface itself in place of a likelihood, so that residuals are
//!    exact and not rounded to cells).
//!
//! Cells live in blocks under a square directory around the map's origin: a map holds memory only
//! along its walls.

use nalgebra::{Point2, Vector2};

use crate::bounds::config;
use crate::points::OrientedPoint;

/// Sightings after which a surfel moves no slower.
const MAX_WEIGHT: f64 = 30.0;

config! {
    /// How surfels are kept.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct SurfelConfig {
        /// Side of a cell, m. Default 0.05.
        pub cell: f64 = 0.05,
        /// How far a surfel can be found, m. Default 0.35; larger forgives worse starts and costs
        /// memory and time.
        pub reach: f64 = 0.35,
        /// Half of the side of the square that the map covers, m. Default 64; points beyond are
        /// dropped.
        pub half_side: f64 = 64.0,
    }
}

/// A small piece of surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Surfel {
    /// Mean of the points that made it, m.
    pub position: Point2<f64>,
    /// Unit normal towards the free side.
    pub normal: Vector2<f64>,
    /// Number of sightings, at most `MAX_WEIGHT`.
    pub weight: f64,
}

/// Surfels with their index.
#[derive(Clone, Debug)]
pub struct SurfelMap {
    config: SurfelConfig,
    surfels: Vec<Surfel>,
    /// The place of the frame's origin in cells from the lower left corner of the square.
    origin: Vector2<f64>,
    /// Blocks along one side of the directory.
    side: i32,
    directory: Vec<u32>,
    blocks: Vec<[Entry; BLOCK * BLOCK]>,
}

const BLOCK: usize = 16;
const NO_BLOCK: u32 = u32::MAX;

/// The nearest surfel, and its squared distance from the cell's centre.
#[derive(Clone, Copy, Debug)]
struct Entry {
    surfel: u32,
    squared: f32,
}

const NOTHING: Entry = Entry {
    surfel: u32::MAX,
    squared: f32::INFINITY,
};

impl SurfelMap {
    /// An empty map around its own origin.
    #[must_use]
    pub fn new(config: SurfelConfig) -> Self {
        Self::around(Point2::origin(), config)
    }

    /// An empty map of the square around `middle`, in the same frame as that.
    #[must_use]
    pub fn around(middle: Point2<f64>, config: SurfelConfig) -> Self {
        let blocks = (config.half_side / (config.cell * BLOCK as f64))
            .ceil()
            .clamp(1.0, 1024.0);
        let side = 2 * blocks as i32;
        let half = Vector2::repeat(f64::from(side) * 0.5 * BLOCK as f64);
        Self {
            origin: half - middle.coords * (1.0 / config.cell),
            config,
            surfels: vec![],
            side,
            directory: vec![NO_BLOCK; (side * side) as usize],
            blocks: vec![],
        }
    }

    /// The index laid again over surfels that were kept.
    #[must_use]
    pub fn from_surfels(config: SurfelConfig, surfels: Vec<Surfel>) -> Self {
        let mut map = Self::new(config);
        map.surfels = surfels;
        for index in 0..map.surfels.len() {
            map.stamp(index);
        }
        map
    }

    /// All surfels.
    #[must_use]
    pub fn surfels(&self) -> &[Surfel] {
        &self.surfels
    }

    /// The memory that it takes.
    #[must_use]
    pub fn bytes(&self) -> usize {
        size_of_val(&*self.surfels) + size_of_val(&*self.directory) + size_of_val(&*self.blocks)
    }

    /// The surfels alone, without their index.
    #[must_use]
    pub fn into_surfels(self) -> Vec<Surfel> {
        self.surfels
    }

    /// Adds points in the frame of the map.
    pub fn insert(&mut self, points: impl IntoIterator<Item = OrientedPoint>) {
        let near = self.config.cell * self.config.cell;
        for point in points {
            let found = self.nearest_index(point.position).and_then(|index| {
                let surfel = self.surfels.get_mut(index)?;
                let same = (surfel.position - point.position).norm_squared() < near
                    && surfel.normal.dot(&point.normal) > 0.9;
                same.then_some(surfel)
            });
            if let Some(surfel) = found {
                let total = surfel.weight + 1.0;
                // Only across the surface: along it the mean of the points seen means nothing.
                let across = surfel.normal.dot(&(point.position - surfel.position));
                surfel.position += surfel.normal * (across / total);
                let normal = surfel.normal * surfel.weight + point.normal;
                surfel.normal = normal / normal.norm();
                surfel.weight = total.min(MAX_WEIGHT);
            } else if self.slot(self.cell_of(point.position)).is_some() {
                self.surfels.push(Surfel {
                    position: point.position,
                    normal: point.normal,
                    weight: 1.0,
                });
                self.stamp(self.surfels.len() - 1);
            }
        }
    }

    /// The surfel nearest to a place, if one is within reach. Near means near to the centre of the
    /// place's cell.
    #[inline]
    #[must_use]
    pub fn nearest(&self, place: Point2<f64>) -> Option<&Surfel> {
        self.surfels.get(self.nearest_index(place)?)
    }

    #[inline]
    fn nearest_index(&self, place: Point2<f64>) -> Option<usize> {
        let (slot, offset) = self.slot(self.cell_of(place))?;
        let block = self.blocks.get(*self.directory.get(slot)? as usize)?;
        let entry = block.get(offset)?;
        (entry.surfel != u32::MAX).then_some(entry.surfel as usize)
    }

    /// Column and row from the lower left corner of the square; not finite becomes a cell outside.
    #[inline]
    fn cell_of(&self, place: Point2<f64>) -> (i32, i32) {
        let scale = 1.0 / self.config.cell;
        let side = f64::from(self.side) * BLOCK as f64;
        let at = |v: f64, origin: f64| {
            let v = v * scale + origin;
            // NaN compares false with everything; of what is not negative, the cast is the floor.
            if v >= 0.0 && v < side { v as i32 } else { -1 }
        };
        (at(place.x, self.origin.x), at(place.y, self.origin.y))
    }

    #[inline]
    fn slot(&self, (col, row): (i32, i32)) -> Option<(usize, usize)> {
        const SIDE: i32 = BLOCK as i32;
        let cells = self.side * SIDE;
        if col < 0 || row < 0 || col >= cells || row >= cells {
            return None;
        }
        let slot = (row / SIDE) * self.side + col / SIDE;
        let offset = (row % SIDE) * SIDE + col % SIDE;
        Some((slot as usize, offset as usize))
    }

    /// Writes one surfel into the cells to which it is nearest.
    fn stamp(&mut self, index: usize) {
        let Some(surfel) = self.surfels.get(index) else {
            return;
        };
        let position = surfel.position;
        let (col, row) = self.cell_of(position);
        let cells = (self.config.reach / self.config.cell).ceil() as i32;
        let (origin, cell) = (self.origin, self.config.cell);
        let centre = |c: i32, origin: f64| (f64::from(c) + 0.5 - origin) * cell;
        let reach = (self.config.reach * self.config.reach) as f32;
        let Ok(surfel) = u32::try_from(index) else {
            return;
        };
        let last = self.side * BLOCK as i32 - 1;
        for r in (row - cells).max(0)..=(row + cells).min(last) {
            let dy = centre(r, origin.y) - position.y;
            let squared = |c: i32| {
                let dx = centre(c, origin.x) - position.x;
                (dx * dx + dy * dy) as f32
            };
            // What lies within reach in a row is one piece.
            let (mut from, mut to) = ((col - cells).max(0), (col + cells).min(last));
            while from <= to && squared(from) > reach {
                from += 1;
            }
            while from <= to && squared(to) > reach {
                to -= 1;
            }
            // One look into the directory for each block.
            while from <= to {
                let end = to.min(from | (BLOCK as i32 - 1));
                let Some((slot, offset)) = self.slot((from, r)) else {
                    break;
                };
                let block = &mut self.directory[slot];
                if *block == NO_BLOCK {
                    *block = self.blocks.len() as u32;
                    self.blocks.push([NOTHING; BLOCK * BLOCK]);
                }
                let row = &mut self.blocks[*block as usize][offset..];
                for (c, entry) in (from..=end).zip(row) {
                    let squared = squared(c);
                    if squared < entry.squared {
                        *entry = Entry { surfel, squared };
                    }
                }
                from = end + 1;
            }
        }
    }
}

mod saved;

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn point(x: f64, y: f64, normal: (f64, f64)) -> OrientedPoint {
        OrientedPoint {
            position: Point2::new(x, y),
            normal: Vector2::new(normal.0, normal.1),
        }
    }

    proptest! {
        #[test]
        fn nearest_is_that_of_brute_force_up_to_half_a_cell(
            places in proptest::collection::vec((-3.0..3.0_f64, -3.0..3.0_f64), 1..60),
            x in -3.5..3.5_f64, y in -3.5..3.5_f64,
        ) {
            let mut map = SurfelMap::new(SurfelConfig { half_side: 4.0, ..SurfelConfig::default() });
            map.insert(places.iter().map(|&(x, y)| point(x, y, (1.0, 0.0))));
            let place = Point2::new(x, y);
            let brute = map.surfels().iter().map(|s| (s.position - place).norm()).fold(f64::INFINITY, f64::min);
            // Distances are taken from the cell's centre, at most 0.036 m off.
            match map.nearest(place) {
                Some(found) => prop_assert!((found.position - place).norm() <= brute + 2.0 * 0.036),
                None => prop_assert!(brute >= 0.35 - 0.036),
            }
        }
    }

    #[test]
    fn sightings_of_one_place_average_out() {
        let mut map = SurfelMap::new(SurfelConfig::default());
        for offset in [0.01, -0.01, 0.005, -0.005] {
            map.insert([point(1.0 + offset, 0.51, (-1.0, 0.0))]);
        }
        assert_eq!(map.surfels().len(), 1);
        assert!((map.surfels()[0].position.x - 1.0).abs() < 1e-12);
        assert!((map.surfels()[0].weight - 4.0).abs() < 1e-12);
    }

    #[test]
    fn two_sides_of_a_wall_stay_two() {
        let mut map = SurfelMap::new(SurfelConfig::default());
        map.insert([point(1.0, 0.0, (-1.0, 0.0)), point(1.03, 0.0, (1.0, 0.0))]);
        assert_eq!(map.surfels().len(), 2);
    }

    #[test]
    fn points_outside_or_not_finite_are_dropped() {
        let mut map = SurfelMap::new(SurfelConfig {
            half_side: 2.0,
            ..SurfelConfig::default()
        });
        map.insert([
            point(90.0, 0.0, (1.0, 0.0)),
            point(f64::NAN, 0.0, (1.0, 0.0)),
            point(0.0, f64::INFINITY, (1.0, 0.0)),
        ]);
        assert!(map.surfels().is_empty());
        assert!(map.nearest(Point2::new(f64::NAN, 1e300)).is_none());
    }
}
