//! A map of small pieces of surface, made for matching: the piece nearest to a place is found by
//! one look-up.
//!
//! In: oriented points in the frame of the map. Out: [`Surfel`]s, and the one nearest to any place
//! within `reach`.
//!
//! 1. Space is cut into cells of `cell` metres. A new point that falls within a cell's side of a
//!    surfel of the same direction is averaged into it, so the noise of many scans shrinks;
//!    otherwise it becomes a new surfel.
//! 2. Each surfel writes itself into all cells whose centre is within `reach` and nearer to it than
//!    to the surfel already there. Matching then needs no search: it reads the cell (as in a
//!    likelihood field, but with the surface itself in place of a likelihood, so residuals are
//!    exact and not rounded to cells).
//!
//! Cells live in blocks under a square directory around the map's origin: a map holds memory only
//! along its walls. A surfel writes itself into eight cells at a time: to which of them it is
//! nearest is unpredictable, so testing them one by one costs more than writing all.

use nalgebra::{Point2, Vector2};
use pulp::NullaryFnOnce;

use crate::bounds::config;
use crate::geom::Length;
use crate::lanes::widened;
use crate::map::{CellIndex, CellRect};
use crate::points::OrientedPoint;

/// Cap on the weight of a surfel: after this many sightings it moves no slower.
const MAX_WEIGHT: f64 = 30.0;
/// A surface seen this often is real: not a person who walked by, nor a reflection.
pub(crate) const SEEN_OFTEN: f64 = 3.0;

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
    cells: Cells,
    /// For each cell, the squared distance of its surfel from its centre.
    squared: Vec<[f32; BLOCK * BLOCK]>,
}

/// Surfels with their index, without further insertion: half the memory.
#[derive(Clone, Debug)]
pub struct FixedSurfels {
    surfels: Vec<Surfel>,
    cells: Cells,
}

/// The nearest surfel of each cell.
#[derive(Clone, Debug)]
struct Cells {
    /// The frame's origin, in cells from the lower left corner of the square.
    origin: Vector2<f64>,
    /// Cells per metre.
    scale: f64,
    /// Blocks along one side of the square.
    side: i32,
    /// Column and row of the first block of the directory.
    first: (i32, i32),
    /// Columns of the directory.
    cols: i32,
    directory: Vec<u32>,
    blocks: Vec<[u32; BLOCK * BLOCK]>,
}

const BLOCK: usize = 16;
const NO_BLOCK: u32 = u32::MAX;

/// How many cells are written at a time.
const LANES: usize = 8;
/// Eight columns of a block, row by row.
type Rows<T> = [[T; LANES]];
/// Index for: no surfel is within reach.
const NOTHING: u32 = u32::MAX;

impl Surfel {
    fn average(&mut self, point: &OrientedPoint) {
        let total = self.weight + 1.0;
        // Only across the surface: along it the mean of the seen points means nothing.
        let across = self.normal.dot(&(point.position - self.position));
        self.position += self.normal * (across / total);
        let normal = self.normal * self.weight + point.normal;
        self.normal = normal / normal.length();
        self.weight = total.min(MAX_WEIGHT);
    }
}

impl SurfelMap {
    /// An empty map around its own origin.
    #[must_use]
    pub fn new(config: SurfelConfig) -> Self {
        Self::around(Point2::origin(), config)
    }

    /// An empty map of the square around `middle`, in the same frame as `middle`.
    #[must_use]
    pub fn around(middle: Point2<f64>, config: SurfelConfig) -> Self {
        let blocks = (config.half_side / (config.cell * BLOCK as f64))
            .ceil()
            .clamp(1.0, 1024.0);
        let side = 2 * blocks as i32;
        let half = Vector2::repeat(f64::from(side) * 0.5 * BLOCK as f64);
        let scale = 1.0 / config.cell;
        Self {
            config,
            surfels: vec![],
            cells: Cells {
                origin: half - middle.coords * scale,
                scale,
                side,
                first: (0, 0),
                cols: side,
                directory: vec![NO_BLOCK; (side * side) as usize],
                blocks: vec![],
            },
            squared: vec![],
        }
    }

    /// The index rebuilt over surfels that were kept, for further insertion.
    #[must_use]
    pub fn from_surfels(config: SurfelConfig, surfels: Vec<Surfel>) -> Self {
        let mut map = Self::new(config);
        // About as many as the walls of buildings fill.
        let blocks = surfels.len() / 4;
        map.cells.blocks.reserve(blocks);
        map.squared.reserve(blocks);
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

    /// The map for look-up only.
    #[must_use]
    pub fn fixed(mut self) -> FixedSurfels {
        self.cells.shrink_to_fit();
        FixedSurfels {
            surfels: self.surfels,
            cells: self.cells,
        }
    }

    /// The surfels alone, without their index.
    #[must_use]
    pub fn into_surfels(self) -> Vec<Surfel> {
        self.surfels
    }

    /// Adds points in the frame of the map.
    pub fn insert(&mut self, points: impl IntoIterator<Item = OrientedPoint>) {
        for point in points {
            let cell = self.cells.cell_of(point.position);
            if let Some(surfel) = self.under(&point) {
                surfel.average(&point);
            } else if self.cells.slot(cell).is_some() {
                self.surfels.push(Surfel {
                    position: point.position,
                    normal: point.normal,
                    weight: 1.0,
                });
                self.stamp(self.surfels.len() - 1);
            }
        }
    }

    /// Averages points, in the frame of the map, into the surfels that they fall on, as long as
    /// that makes them more certain. It adds no surfels, and stops moving them in the end: a robot
    /// may stand for hours.
    pub fn sharpen(&mut self, points: impl IntoIterator<Item = OrientedPoint>) {
        for point in points {
            if let Some(surfel) = self.under(&point)
                && surfel.weight < MAX_WEIGHT
            {
                surfel.average(&point);
            }
        }
    }

    /// The surfel that a point falls on.
    fn under(&mut self, point: &OrientedPoint) -> Option<&mut Surfel> {
        let near = self.config.cell * self.config.cell;
        let index = self.cells.nearest(point.position)?;
        let surfel = self.surfels.get_mut(index)?;
        let is_same = (surfel.position - point.position).norm_squared() < near
            && surfel.normal.dot(&point.normal) > 0.9;
        is_same.then_some(surfel)
    }

    /// The surfel nearest to a place, if one is within reach. Nearest means nearest to the centre
    /// of the place's cell.
    #[inline]
    #[must_use]
    pub fn nearest(&self, place: Point2<f64>) -> Option<&Surfel> {
        self.surfels.get(self.cells.nearest(place)?)
    }

    /// Adds a block that contains no surfel within reach.
    fn push_block(&mut self) {
        self.cells.blocks.push([NOTHING; BLOCK * BLOCK]);
        // A distance of exactly `reach` is still found.
        let farther = self.squared_reach().next_up();
        self.squared.push([farther; BLOCK * BLOCK]);
    }

    /// The square of `reach`.
    fn squared_reach(&self) -> f32 {
        (self.config.reach * self.config.reach) as f32
    }

    /// Eight columns of a block from `col` on, row by row from `row` on: the nearest surfel of each
    /// cell, and its distance.
    #[inline(always)]
    fn group_mut(&mut self, col: i32, row: i32) -> Option<(&mut Rows<u32>, &mut Rows<f32>)> {
        let (slot, first) = self.cells.slot((col, row))?;
        let block = *self.cells.directory.get(slot)? as usize;
        let surfels = self.cells.blocks.get_mut(block)?.get_mut(first..)?;
        let squared = self.squared.get_mut(block)?.get_mut(first..)?;
        Some((surfels.as_chunks_mut().0, squared.as_chunks_mut().0))
    }

    /// Writes one surfel into the cells to which it is nearest.
    fn stamp(&mut self, index: usize) {
        let (Some(surfel), Ok(number)) = (self.surfels.get(index), u32::try_from(index)) else {
            return;
        };
        let position = surfel.position;
        let (col, row) = self.cells.cell_of(position);
        let cells = (self.config.reach / self.config.cell).ceil() as i32;
        let last = self.cells.side * BLOCK as i32 - 1;
        let along = |middle: i32| [(middle - cells).max(0), (middle + cells).min(last)];
        let (cols, rows) = (along(col), along(row));
        self.make_blocks(position, cols, rows);
        widened(Stamp {
            map: self,
            number,
            position,
            cols,
            rows,
        });
    }

    /// Makes the blocks that contain cells within reach of `position`.
    fn make_blocks(&mut self, position: Point2<f64>, cols: [i32; 2], rows: [i32; 2]) {
        const SIDE: i32 = BLOCK as i32;
        let is_missing = |row: i32, col: i32| {
            let block = self
                .cells
                .directory
                .get((row * self.cells.side + col) as usize);
            block.is_none_or(|block| *block == NO_BLOCK)
        };
        let block_cols = cols[0] / SIDE..=cols[1] / SIDE;
        if (rows[0] / SIDE..=rows[1] / SIDE)
            .all(|row| block_cols.clone().all(|col| !is_missing(row, col)))
        {
            return;
        }
        let reach = self.squared_reach();
        let middle = self.cells.cell_of(position).0;
        for row in rows[0]..=rows[1] {
            let dy = Cells::centre(row, self.cells.origin.y, self.config.cell) - position.y;
            for block_col in block_cols.clone() {
                // The nearest of its columns.
                let col = middle.clamp(block_col * SIDE, block_col * SIDE + SIDE - 1);
                let dx = Cells::centre(col, self.cells.origin.x, self.config.cell) - position.x;
                let slot = (row / SIDE * self.cells.side + block_col) as usize;
                let is_near = (dx * dx + dy * dy) as f32 <= reach;
                if is_near && self.cells.directory.get(slot) == Some(&NO_BLOCK) {
                    self.cells.directory[slot] = self.cells.blocks.len() as u32;
                    self.push_block();
                }
            }
        }
    }
}

impl FixedSurfels {
    /// All surfels.
    #[must_use]
    pub fn surfels(&self) -> &[Surfel] {
        &self.surfels
    }

    /// The surfel nearest to a place, as [`SurfelMap::nearest`] gives it.
    #[inline]
    #[must_use]
    pub fn nearest(&self, place: Point2<f64>) -> Option<&Surfel> {
        self.surfels.get(self.cells.nearest(place)?)
    }

    /// Memory use.
    #[must_use]
    pub fn bytes(&self) -> usize {
        let index = size_of_val(&*self.cells.directory) + size_of_val(&*self.cells.blocks);
        size_of_val(&*self.surfels) + index
    }
}

impl Cells {
    #[inline]
    fn nearest(&self, place: Point2<f64>) -> Option<usize> {
        let (slot, offset) = self.slot(self.cell_of(place))?;
        let block = self.blocks.get(*self.directory.get(slot)? as usize)?;
        let surfel = *block.get(offset)?;
        (surfel != NOTHING).then_some(surfel as usize)
    }

    /// Column and row from the lower left corner of the square; non-finite input gives a cell
    /// outside.
    #[inline]
    fn cell_of(&self, place: Point2<f64>) -> (i32, i32) {
        let scale = self.scale;
        let side = f64::from(self.side) * BLOCK as f64;
        let at = |v: f64, origin: f64| {
            let v = v * scale + origin;
            // NaN compares false with everything; for non-negative numbers the cast is the floor.
            if v >= 0.0 && v < side { v as i32 } else { -1 }
        };
        (at(place.x, self.origin.x), at(place.y, self.origin.y))
    }

    #[inline]
    fn slot(&self, (col, row): (i32, i32)) -> Option<(usize, usize)> {
        const SIDE: i32 = BLOCK as i32;
        if col < 0 || row < 0 {
            return None;
        }
        let (block_col, block_row) = (col / SIDE - self.first.0, row / SIDE - self.first.1);
        if block_col < 0 || block_col >= self.cols || block_row < 0 {
            return None;
        }
        // In rows beyond the last one there is no slot.
        let slot = block_row * self.cols + block_col;
        Some((slot as usize, place_in_block(col % SIDE, row % SIDE)))
    }

    /// Reduces the directory to the rectangle that contains blocks: none can be added afterwards.
    fn shrink_to_fit(&mut self) {
        self.blocks.shrink_to_fit();
        let cols = self.cols;
        let slots = self.directory.iter().zip(0_i32..);
        let held = slots.filter(|(block, _)| **block != NO_BLOCK);
        let places = held.map(|(_, slot)| CellIndex::new(slot % cols, slot / cols));
        let Some(held) = places.map(CellRect::of).reduce(CellRect::around) else {
            return;
        };
        let kept = held.cells().map(|place| {
            let block = self.directory.get((place.row * cols + place.col) as usize);
            block.map_or(NO_BLOCK, |block| *block)
        });
        self.directory = kept.collect();
        self.first = (self.first.0 + held.min.col, self.first.1 + held.min.row);
        self.cols = held.max.col - held.min.col;
    }

    /// The centre of a column or row, m.
    #[inline(always)]
    fn centre(cell: i32, origin: f64, side: f64) -> f64 {
        (f64::from(cell) + 0.5 - origin) * side
    }
}

/// Where the cell of a column and a row of its block is stored: the rows of the first eight columns
/// come first. So cells that lie near each other are near in memory, whatever the direction of the
/// wall.
#[inline]
fn place_in_block(col: i32, row: i32) -> usize {
    const SIDE: i32 = BLOCK as i32;
    const STEP: i32 = LANES as i32;
    (col / STEP * (SIDE * STEP) + row * STEP + col % STEP) as usize
}

/// Writes a surfel into those of the cells between `cols` and `rows` to which it is nearest; the
/// blocks of such cells must exist. In single precision: twice as many cells at a time.
struct Stamp<'a> {
    map: &'a mut SurfelMap,
    number: u32,
    position: Point2<f64>,
    cols: [i32; 2],
    rows: [i32; 2],
}

impl NullaryFnOnce for Stamp<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        const STEP: i32 = LANES as i32;
        const SIDE: i32 = BLOCK as i32;
        let Self {
            map,
            number,
            position,
            cols,
            rows,
        } = self;
        let (reach, origin, cell) = (map.squared_reach(), map.cells.origin, map.config.cell);
        for group in cols[0] / STEP..=cols[1] / STEP {
            let across: [f32; LANES] = std::array::from_fn(|lane| {
                let middle = Cells::centre(group * STEP + lane as i32, origin.x, cell);
                let dx = (middle - position.x) as f32;
                dx * dx
            });
            let nearest = across.iter().copied().fold(f32::INFINITY, f32::min);
            for block_row in rows[0] / SIDE..=rows[1] / SIDE {
                let low = block_row * SIDE;
                let (first, last) = (rows[0].max(low), rows[1].min(low + SIDE - 1));
                let Some((surfels, squared)) = map.group_mut(group * STEP, first) else {
                    continue;
                };
                for ((row, surfels), squared) in (first..=last).zip(surfels).zip(squared) {
                    let middle = Cells::centre(row, origin.y, cell);
                    let dy = (middle - position.y) as f32;
                    let dy = dy * dy;
                    if nearest + dy > reach {
                        continue;
                    }
                    // The compiler knows that copies do not overlap.
                    let (before, kept) = (*squared, *surfels);
                    let here = across.map(|dx| dx + dy);
                    *squared = std::array::from_fn(|lane| match here[lane] < before[lane] {
                        true => here[lane],
                        false => before[lane],
                    });
                    *surfels = std::array::from_fn(|lane| match here[lane] < before[lane] {
                        true => number,
                        false => kept[lane],
                    });
                }
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
            let brute = map.surfels().iter().map(|s| (s.position - place).length()).fold(f64::INFINITY, f64::min);
            // Distances are taken from the cell's centre, at most 0.036 m off.
            match map.nearest(place) {
                Some(found) => prop_assert!((found.position - place).length() <= brute + 2.0 * 0.036),
                None => prop_assert!(brute >= 0.35 - 0.036),
            }
        }
    }

    proptest! {
        #[test]
        fn what_is_only_looked_at_is_found_as_before(
            places in proptest::collection::vec((-5.0..5.0_f64, -5.0..5.0_f64), 0..40),
            looks in proptest::collection::vec((-70.0..70.0_f64, -6.0..6.0_f64), 40),
            middle in -90.0..90.0_f64,
        ) {
            let mut map = SurfelMap::around(Point2::new(middle, -middle), SurfelConfig::default());
            let about = |x: f64, y: f64| Point2::new(middle + x, y - middle);
            map.insert(places.iter().map(|&(x, y)| {
                let at = about(x, y);
                point(at.x, at.y, (1.0, 0.0))
            }));
            let fixed = map.clone().fixed();
            for (x, y) in looks.into_iter().chain(places) {
                prop_assert_eq!(fixed.nearest(about(x, y)), map.nearest(about(x, y)));
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
    fn what_is_known_is_sharpened_and_not_for_ever() {
        let wall = |x: f64| point(x, 0.51, (-1.0, 0.0));
        let mut map = SurfelMap::new(SurfelConfig::default());
        map.insert([wall(1.0), wall(1.0), wall(1.0)]);
        map.sharpen([wall(1.04)]);
        assert!((map.surfels()[0].position.x - 1.01).abs() < 1e-12);
        // The other side of the wall, and an unknown place.
        map.sharpen([point(1.02, 0.51, (1.0, 0.0)), point(3.0, 0.0, (-1.0, 0.0))]);
        assert_eq!(map.surfels().len(), 1);
        map.sharpen(std::iter::repeat_n(wall(1.01), 100));
        let before = map.surfels()[0];
        map.sharpen(std::iter::repeat_n(wall(1.03), 100));
        assert_eq!(map.surfels()[0], before);
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
