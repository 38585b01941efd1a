//! Occupancy grid in growing blocks.
//!
//! In: points in the robot frame and the pose they were seen from. Out: log-odds per cell.
//!
//! 1. Each cell keeps l = ln(p / (1 - p)), 0 where nothing is known (Celej §2; Moravec & Elfes 1985).
//! 2. A beam adds `miss` to the cells it crossed and `hit` to the one it ended in; within one scan a hit wins over
//!    a miss, so that neighbouring beams do not rub out thin walls.
//! 3. l is clamped so that a map can change its mind; p = 1 - 1/(1 + eˡ) (erratum to Celej eq. (3), see the
//!    specification).
//!
//! Storage: blocks of 64 x 64 cells in a directory that grows with the robot's way. A block knows the revision of its
//! last change, so that a display fetches only what changed.
//!
//! Near the robot most cells are crossed by many beams of a scan, and count once. So beams only mark cells, a bit each
//! and a run of a row at a time: the marks of a block are 1 kB, its cells 16 kB. Then each marked cell is changed once.

use nalgebra::{Point2, Vector2};

use super::ray::{Run, runs_on_ray};
use super::{BlockIndex, CellIndex, CellRect, CellState};
use crate::geom::Pose2;
use crate::points::Points;

/// Cells along one side of a block.
pub const BLOCK_CELLS: usize = 64;
const BLOCK: i32 = BLOCK_CELLS as i32;
const BLOCK_BITS: u32 = BLOCK_CELLS.trailing_zeros();

/// How sightings change the grid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GridConfig {
    /// Side of a cell, m. Default 0.05; smaller is sharper and slower.
    pub resolution: f64,
    /// Probability that a cell is occupied given that a beam ended in it. Default 0.7 (lidar); Celej's preset is 0.8.
    pub hit: f64,
    /// Probability that a cell is occupied given that a beam crossed it. Default 0.4 (lidar); Celej's preset is 0.2.
    pub miss: f64,
    /// Probabilities are kept in [`clamp`, 1 - `clamp`]. Default 0.02; larger changes its mind sooner.
    pub clamp: f64,
    /// Cells count as occupied above this probability. Default 0.65, as in ROS map_server.
    pub occupied_above: f64,
    /// Cells count as free below this probability. Default 0.35.
    pub free_below: f64,
    /// Most blocks the grid may hold; beams beyond are dropped. Default 65 536 blocks: 16 GB would be absurd, this is
    /// 268 million cells, 0.67 km² at 5 cm.
    pub max_blocks: usize,
}

impl Default for GridConfig {
    fn default() -> Self {
        Self {
            resolution: 0.05,
            hit: 0.7,
            miss: 0.4,
            clamp: 0.02,
            occupied_above: 0.65,
            free_below: 0.35,
            max_blocks: 65_536,
        }
    }
}

/// Why a [`GridConfig`] cannot be used.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum GridError {
    /// A field outside of its range.
    #[error("grid: {field} is {value}, expected {expected}")]
    Config {
        /// The field.
        field: &'static str,
        /// What stands there.
        value: f64,
        /// What may stand there.
        expected: &'static str,
    },
}

impl GridConfig {
    /// Celej's own figures: prior 0.5, hit 0.8, miss 0.2.
    #[must_use]
    pub fn celej() -> Self {
        Self {
            hit: 0.8,
            miss: 0.2,
            ..Self::default()
        }
    }

    /// # Errors    [`GridError::Config`] naming the first field out of range.
    pub fn validate(&self) -> Result<(), GridError> {
        let check = |field, value: f64, low: f64, high: f64, expected| {
            if value > low && value < high {
                Ok(())
            } else {
                Err(GridError::Config {
                    field,
                    value,
                    expected,
                })
            }
        };
        check(
            "resolution",
            self.resolution,
            1e-3,
            10.0,
            "between 0.001 and 10 m",
        )?;
        check("hit", self.hit, 0.5, 1.0, "between 0.5 and 1")?;
        check("miss", self.miss, 0.0, 0.5, "between 0 and 0.5")?;
        check("clamp", self.clamp, 0.0, 0.5, "between 0 and 0.5")?;
        check(
            "occupied_above",
            self.occupied_above,
            0.5,
            1.0,
            "between 0.5 and 1",
        )?;
        check("free_below", self.free_below, 0.0, 0.5, "between 0 and 0.5")
    }
}

/// An occupancy grid that grows where the robot looks.
#[derive(Clone, Debug)]
pub struct Grid {
    config: GridConfig,
    odds: Odds,
    directory: Directory,
    revision: u64,
    /// Blocks that the scan being inserted has marked; empty between scans.
    marked: Vec<BlockIndex>,
}

/// The configuration in log-odds.
#[derive(Clone, Copy, Debug)]
struct Odds {
    hit: f32,
    miss: f32,
    limit: f32,
    occupied: f32,
    free: f32,
}

#[derive(Clone, Debug)]
struct Block {
    cells: Box<[f32]>,
    /// What the scan being inserted sees in it; nothing between scans.
    marks: Box<Marks>,
    is_marked: bool,
    revision: u64,
}

/// One bit for each cell, row by row.
#[derive(Clone, Debug)]
struct Marks {
    hits: [u64; BLOCK_CELLS],
    misses: [u64; BLOCK_CELLS],
}

impl Default for Marks {
    fn default() -> Self {
        Self {
            hits: [0; BLOCK_CELLS],
            misses: [0; BLOCK_CELLS],
        }
    }
}

/// Dense rectangle of block pointers that is laid anew, twice as large, when a block falls outside.
#[derive(Clone, Debug)]
struct Directory {
    origin: BlockIndex,
    cols: i32,
    rows: i32,
    blocks: Vec<Option<Block>>,
    count: usize,
}

impl Grid {
    /// An empty grid.
    ///
    /// # Errors    [`GridError::Config`] for a field out of range.
    pub fn new(config: GridConfig) -> Result<Self, GridError> {
        config.validate()?;
        let log_odds = |p: f64| libm::log(p / (1.0 - p)) as f32;
        Ok(Self {
            odds: Odds {
                hit: log_odds(config.hit),
                miss: log_odds(config.miss),
                limit: log_odds(1.0 - config.clamp),
                occupied: log_odds(config.occupied_above),
                free: log_odds(config.free_below),
            },
            config,
            directory: Directory {
                origin: BlockIndex { col: 0, row: 0 },
                cols: 0,
                rows: 0,
                blocks: vec![],
                count: 0,
            },
            revision: 0,
            marked: vec![],
        })
    }

    /// Side of a cell, m.
    #[must_use]
    pub fn resolution(&self) -> f64 {
        self.config.resolution
    }

    /// The configuration it was made with.
    #[must_use]
    pub fn config(&self) -> &GridConfig {
        &self.config
    }

    /// Grows by one with every change.
    #[must_use]
    pub fn revision(&self) -> u64 {
        self.revision
    }

    /// The cell that holds a point; far-away and non-finite points saturate.
    #[must_use]
    pub fn cell_at(&self, point: Point2<f64>) -> CellIndex {
        let scale = 1.0 / self.config.resolution;
        CellIndex {
            col: (point.x * scale).floor() as i32,
            row: (point.y * scale).floor() as i32,
        }
    }

    /// Centre of a cell.
    #[must_use]
    pub fn centre_of(&self, cell: CellIndex) -> Point2<f64> {
        let half = 0.5 * self.config.resolution;
        Point2::new(
            f64::from(cell.col) * self.config.resolution + half,
            f64::from(cell.row) * self.config.resolution + half,
        )
    }

    /// Log-odds of a cell, 0 where nothing is known.
    #[inline]
    #[must_use]
    pub fn log_odds(&self, cell: CellIndex) -> f32 {
        let (block, offset) = split(cell);
        self.directory.get(block).map_or(0.0, |b| b.cells[offset])
    }

    /// Probability that a cell is occupied, 0.5 where nothing is known.
    #[must_use]
    pub fn probability(&self, cell: CellIndex) -> f64 {
        1.0 - 1.0 / (1.0 + libm::exp(f64::from(self.log_odds(cell))))
    }

    /// What is believed of a cell.
    #[inline]
    #[must_use]
    pub fn state(&self, cell: CellIndex) -> CellState {
        self.state_of(self.log_odds(cell))
    }

    /// What is believed at the given log-odds.
    #[inline]
    #[must_use]
    pub fn state_of(&self, log_odds: f32) -> CellState {
        if log_odds > self.odds.occupied {
            CellState::Occupied
        } else if log_odds < self.odds.free {
            CellState::Free
        } else {
            CellState::Unknown
        }
    }

    /// Writes what one scan saw from `map_from_robot`.
    pub fn insert(&mut self, points: &Points, map_from_robot: &Pose2) {
        self.revision += 1;
        let scale = 1.0 / self.config.resolution;
        let in_cells = |p: Point2<f64>| Point2::from((*map_from_robot * p).coords * scale);
        for beam in points.hits() {
            let end = in_cells(beam.end_in_robot);
            let (index, offset) = split(CellIndex {
                col: end.x.floor() as i32,
                row: end.y.floor() as i32,
            });
            let slot = self.slot_to_mark(index);
            if let Some(marks) = self.directory.marks_in(slot) {
                marks.hits[offset / BLOCK_CELLS] |= 1 << (offset % BLOCK_CELLS);
            }
        }
        // Neighbouring runs of a ray nearly always lie in one block: look it up only where it changes.
        for beam in &points.beams {
            let (start, end) = (in_cells(beam.origin_in_robot), in_cells(beam.end_in_robot));
            let mut at: Option<(BlockIndex, Option<usize>)> = None;
            runs_on_ray(start, end, |run| {
                for (index, offset, cells) in run_by_block(run) {
                    let slot = match at {
                        Some((known, slot)) if known == index => slot,
                        _ => {
                            let slot = self.slot_to_mark(index);
                            at = Some((index, slot));
                            slot
                        }
                    };
                    if let Some(marks) = self.directory.marks_in(slot) {
                        marks.misses[offset] |= cells;
                    }
                }
            });
        }
        self.write_marked();
    }

    /// Believes a disc around `centre` to be free: the robot stands there, so nothing else does.
    pub fn clear_disc(&mut self, centre: Point2<f64>, radius: f64) {
        self.revision += 1;
        let reach = Vector2::new(radius, radius);
        let (low, high) = (self.cell_at(centre - reach), self.cell_at(centre + reach));
        for row in low.row..=high.row {
            for col in low.col..=high.col {
                let cell = CellIndex { col, row };
                if (self.centre_of(cell) - centre).norm() <= radius {
                    self.write_miss(cell);
                }
            }
        }
    }

    /// The rectangle of all blocks; `None` while the grid is empty.
    #[must_use]
    pub fn bounds(&self) -> Option<CellRect> {
        let mut bounds: Option<CellRect> = None;
        for (block, _) in self.directory.iter() {
            let min = CellIndex {
                col: block.col * BLOCK,
                row: block.row * BLOCK,
            };
            let max = CellIndex {
                col: min.col + BLOCK,
                row: min.row + BLOCK,
            };
            bounds = Some(bounds.map_or(CellRect { min, max }, |b| CellRect {
                min: CellIndex {
                    col: b.min.col.min(min.col),
                    row: b.min.row.min(min.row),
                },
                max: CellIndex {
                    col: b.max.col.max(max.col),
                    row: b.max.row.max(max.row),
                },
            }));
        }
        bounds
    }

    /// The blocks that changed after `revision`, with their log-odds in rows from the lower left cell.
    pub fn blocks_since(&self, revision: u64) -> impl Iterator<Item = (BlockIndex, &[f32])> {
        self.directory
            .iter()
            .filter(move |(_, b)| b.revision > revision)
            .map(|(index, b)| (index, &*b.cells))
    }

    /// Number of blocks held.
    #[must_use]
    pub fn block_count(&self) -> usize {
        self.directory.count
    }

    /// The slot of a block that the scan being inserted sees; `None` where the grid may not grow there.
    fn slot_to_mark(&mut self, index: BlockIndex) -> Option<usize> {
        let slot = self
            .directory
            .slot_or_create(index, self.config.max_blocks)?;
        let block = self.directory.blocks.get_mut(slot)?.as_mut()?;
        if !block.is_marked {
            block.is_marked = true;
            self.marked.push(index);
        }
        Some(slot)
    }

    /// Writes the marks into the cells and takes them away.
    fn write_marked(&mut self) {
        for index in self.marked.drain(..) {
            if let Some(block) = self.directory.get_mut(index) {
                block.write_marks(&self.odds);
                block.revision = self.revision;
            }
        }
    }

    fn write_miss(&mut self, cell: CellIndex) {
        let (index, offset) = split(cell);
        let Some(slot) = self.directory.slot_or_create(index, self.config.max_blocks) else {
            return;
        };
        if let Some(Some(block)) = self.directory.blocks.get_mut(slot)
            && let Some(cell) = block.cells.get_mut(offset)
        {
            self.odds.change(cell, self.odds.miss);
            block.revision = self.revision;
        }
    }
}

impl Odds {
    #[inline]
    fn change(&self, cell: &mut f32, by: f32) {
        *cell = (*cell + by).clamp(-self.limit, self.limit);
    }
}

impl Block {
    /// Once per cell: where a beam ended, that others crossed it does not count.
    fn write_marks(&mut self, odds: &Odds) {
        let rows = self.cells.chunks_exact_mut(BLOCK_CELLS);
        let marks = self.marks.hits.iter_mut().zip(&mut self.marks.misses);
        for (row, (hits, misses)) in rows.zip(marks) {
            let (hit, miss) = (std::mem::take(hits), std::mem::take(misses));
            for_runs(row, hit, |cell| odds.change(cell, odds.hit));
            for_runs(row, miss & !hit, |cell| odds.change(cell, odds.miss));
        }
        self.is_marked = false;
    }
}

/// Visits the cells of a row whose bits are set, run by run: long runs are what a processor is good at.
#[inline]
fn for_runs(row: &mut [f32], mut bits: u64, visit: impl Fn(&mut f32)) {
    while bits != 0 {
        let start = bits.trailing_zeros();
        let len = (bits >> start).trailing_ones();
        let end = start + len;
        if let Some(run) = row.get_mut(start as usize..end as usize) {
            run.iter_mut().for_each(&visit);
        }
        bits &= u64::MAX.checked_shl(end).unwrap_or(0);
    }
}

/// Parts a run where it crosses into the next block, in its own direction: block, row in it, and the cells as bits.
#[inline]
fn run_by_block(run: Run) -> impl Iterator<Item = (BlockIndex, usize, u64)> {
    let (low, high) = (run.from.min(run.to), run.from.max(run.to));
    let (first, last) = (run.from >> BLOCK_BITS, run.to >> BLOCK_BITS);
    let step = if first <= last { 1 } else { -1 };
    (0..=(last - first).abs()).map(move |n| {
        let col = first + n * step;
        let from = low.max(col << BLOCK_BITS) & (BLOCK - 1);
        let to = high.min((col << BLOCK_BITS) | (BLOCK - 1)) & (BLOCK - 1);
        let cells = (u64::MAX >> (BLOCK - 1 - (to - from))) << from;
        let index = BlockIndex {
            col,
            row: run.row >> BLOCK_BITS,
        };
        (index, (run.row & (BLOCK - 1)) as usize, cells)
    })
}

#[inline]
fn split(cell: CellIndex) -> (BlockIndex, usize) {
    let block = BlockIndex {
        col: cell.col >> BLOCK_BITS,
        row: cell.row >> BLOCK_BITS,
    };
    let offset = (cell.row & (BLOCK - 1)) * BLOCK + (cell.col & (BLOCK - 1));
    (block, offset as usize)
}

impl Directory {
    #[inline]
    fn slot(&self, index: BlockIndex) -> Option<usize> {
        let (col, row) = (
            index.col.wrapping_sub(self.origin.col),
            index.row.wrapping_sub(self.origin.row),
        );
        (col >= 0 && col < self.cols && row >= 0 && row < self.rows)
            .then(|| (row * self.cols + col) as usize)
    }

    #[inline]
    fn get(&self, index: BlockIndex) -> Option<&Block> {
        self.slot(index).and_then(|slot| self.blocks[slot].as_ref())
    }

    fn get_mut(&mut self, index: BlockIndex) -> Option<&mut Block> {
        let slot = self.slot(index)?;
        self.blocks.get_mut(slot)?.as_mut()
    }

    #[inline]
    fn marks_in(&mut self, slot: Option<usize>) -> Option<&mut Marks> {
        let block = self.blocks.get_mut(slot?)?.as_mut()?;
        Some(&mut block.marks)
    }

    fn slot_or_create(&mut self, index: BlockIndex, max_blocks: usize) -> Option<usize> {
        let slot = match self.slot(index) {
            Some(slot) => slot,
            None => {
                self.grow(index, max_blocks)?;
                self.slot(index)?
            }
        };
        let entry = &mut self.blocks[slot];
        if entry.is_none() {
            if self.count >= max_blocks {
                return None;
            }
            self.count += 1;
            *entry = Some(Block {
                cells: vec![0.0; BLOCK_CELLS * BLOCK_CELLS].into_boxed_slice(),
                marks: Box::default(),
                is_marked: false,
                revision: 0,
            });
        }
        Some(slot)
    }

    /// Lays the directory anew so that it holds `index`, with room to spare on the side that grew.
    fn grow(&mut self, index: BlockIndex, max_blocks: usize) -> Option<()> {
        let span = |origin: i32, len: i32, at: i32| {
            let (low, high) = if len == 0 {
                (at, at + 1)
            } else {
                (origin.min(at), (origin + len).max(at + 1))
            };
            let spare = (high - low) / 2 + 1;
            let low = if at < origin {
                low.checked_sub(spare)?
            } else {
                low
            };
            let high = if at >= origin + len {
                high.checked_add(spare)?
            } else {
                high
            };
            Some((low, high.checked_sub(low)?))
        };
        let (col, cols) = span(self.origin.col, self.cols, index.col)?;
        let (row, rows) = span(self.origin.row, self.rows, index.row)?;
        // A stray beam far away must not lay out a directory for the whole way there.
        if i64::from(cols) * i64::from(rows) > 16 * max_blocks as i64 {
            return None;
        }
        let mut grown = Self {
            origin: BlockIndex { col, row },
            cols,
            rows,
            blocks: vec![],
            count: self.count,
        };
        grown.blocks.resize_with((cols * rows) as usize, || None);
        let old = std::mem::take(&mut self.blocks);
        for (slot, block) in old.into_iter().enumerate() {
            let (col, row) = (slot as i32 % self.cols, slot as i32 / self.cols);
            let at = BlockIndex {
                col: self.origin.col + col,
                row: self.origin.row + row,
            };
            if let Some(slot) = grown.slot(at) {
                grown.blocks[slot] = block;
            }
        }
        *self = grown;
        Some(())
    }

    fn iter(&self) -> impl Iterator<Item = (BlockIndex, &Block)> {
        self.blocks.iter().enumerate().filter_map(|(slot, block)| {
            let (col, row) = (slot as i32 % self.cols, slot as i32 / self.cols);
            block.as_ref().map(|b| {
                (
                    BlockIndex {
                        col: self.origin.col + col,
                        row: self.origin.row + row,
                    },
                    b,
                )
            })
        })
    }
}

#[cfg(test)]
mod tests {
    use std::collections::{BTreeMap, BTreeSet};

    use proptest::prelude::*;

    use super::*;
    use crate::map::cells_on_ray;
    use crate::points::Beam;
    use crate::robot::Stamp;

    fn beam_to(end: (f64, f64), is_hit: bool) -> Points {
        let end_in_robot = Point2::new(end.0, end.1);
        let beam = Beam {
            beam_idx: 0,
            origin_in_robot: Point2::origin(),
            end_in_robot,
            range: end_in_robot.coords.norm(),
            sigma: 0.01,
            is_hit,
        };
        Points {
            stamp: Stamp(0),
            sensor_in_robot: Point2::origin(),
            bearing_sigma: 0.0,
            beams: vec![beam],
        }
    }

    fn grid() -> Grid {
        Grid::new(GridConfig::default()).unwrap()
    }

    #[test]
    fn beam_clears_its_way_and_marks_its_end() {
        let mut grid = grid();
        grid.insert(&beam_to((1.0, 0.02), true), &Pose2::new(0.02, 0.0, 0.0));
        let at = |x: f64| grid.probability(grid.cell_at(Point2::new(x, 0.02)));
        assert!((at(0.5) - 0.4).abs() < 1e-6);
        assert!((at(1.02) - 0.7).abs() < 1e-6);
        assert!((at(1.2) - 0.5).abs() < 1e-12);
    }

    #[test]
    fn repeated_sightings_follow_bayes_until_the_clamp() {
        let mut grid = grid();
        let cell = grid.cell_at(Point2::new(1.01, 0.0));
        let mut odds: f64 = 1.0;
        for _ in 0..3 {
            grid.insert(&beam_to((1.01, 0.0), true), &Pose2::identity());
            odds *= 0.7 / 0.3;
            assert!((grid.probability(cell) - odds / (1.0 + odds)).abs() < 1e-6);
        }
        for _ in 0..50 {
            grid.insert(&beam_to((1.01, 0.0), true), &Pose2::identity());
        }
        assert!((grid.probability(cell) - 0.98).abs() < 1e-6);
        for _ in 0..50 {
            grid.insert(&beam_to((2.0, 0.0), false), &Pose2::identity());
        }
        assert_eq!(grid.state(cell), CellState::Free);
    }

    /// Log-odds of each cell ever seen, by the definition: per scan the set of cells hit, and of cells crossed but not hit.
    #[derive(Default)]
    struct Naive(BTreeMap<(i32, i32), f32>);

    impl Naive {
        fn insert(&mut self, points: &Points, map_from_robot: &Pose2, config: &GridConfig) {
            let scale = 1.0 / config.resolution;
            let in_cells = |p: Point2<f64>| Point2::from((*map_from_robot * p).coords * scale);
            let (mut hits, mut crossed) = (BTreeSet::new(), BTreeSet::new());
            for beam in &points.beams {
                let end = in_cells(beam.end_in_robot);
                if beam.is_hit {
                    hits.insert((end.x.floor() as i32, end.y.floor() as i32));
                }
                cells_on_ray(in_cells(beam.origin_in_robot), end, |c| {
                    crossed.insert((c.col, c.row));
                });
            }
            let log_odds = |p: f64| libm::log(p / (1.0 - p)) as f32;
            let limit = log_odds(1.0 - config.clamp);
            for cell in hits.union(&crossed) {
                let by = log_odds(if hits.contains(cell) {
                    config.hit
                } else {
                    config.miss
                });
                let value = self.0.entry(*cell).or_default();
                *value = (*value + by).clamp(-limit, limit);
            }
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 64, ..ProptestConfig::default() })]
        #[test]
        fn every_cell_is_that_of_the_naive_grid(
            scans in proptest::collection::vec(
                (
                    (-9.0..9.0_f64, -9.0..9.0_f64, -3.2..3.2_f64),
                    proptest::collection::vec(((-12.0..12.0_f64, -12.0..12.0_f64), any::<bool>()), 0..40),
                ),
                1..12,
            ),
            grain in prop_oneof![Just(0.0), Just(0.5)],
        ) {
            // Half of the cases have their ends on the borders of cells, where rounding decides.
            let snap = |v: f64| if grain > 0.0 { (v / grain).round() * grain } else { v };
            let config = GridConfig::default();
            let (mut grid, mut naive) = (grid(), Naive::default());
            for ((x, y, heading), ends) in &scans {
                let pose = Pose2::new(snap(*x), snap(*y), if grain > 0.0 { 0.0 } else { *heading });
                let mut points = beam_to((0.0, 0.0), false);
                points.beams = ends
                    .iter()
                    .flat_map(|&(end, is_hit)| beam_to((snap(end.0), snap(end.1)), is_hit).beams)
                    .collect();
                grid.insert(&points, &pose);
                naive.insert(&points, &pose, &config);
            }
            let mut known = 0;
            for (block, cells) in grid.blocks_since(0) {
                for (offset, value) in cells.iter().enumerate() {
                    let (col, row) = ((offset % BLOCK_CELLS) as i32, (offset / BLOCK_CELLS) as i32);
                    let expected = naive.0.get(&(block.col * BLOCK + col, block.row * BLOCK + row));
                    known += usize::from(expected.is_some());
                    prop_assert_eq!(value.to_bits(), expected.copied().unwrap_or(0.0).to_bits());
                }
            }
            prop_assert_eq!(known, naive.0.len());
        }
    }

    #[test]
    fn grows_to_all_sides_and_keeps_what_it_knew() {
        let mut grid = grid();
        let ends = [
            (30.0, 0.0),
            (-30.0, 1.0),
            (0.0, 40.0),
            (1.0, -40.0),
            (-90.0, -90.0),
        ];
        for end in ends {
            grid.insert(&beam_to(end, true), &Pose2::identity());
        }
        for end in ends {
            assert_eq!(
                grid.state(grid.cell_at(Point2::new(end.0, end.1))),
                CellState::Occupied,
                "{end:?}"
            );
        }
        let bounds = grid.bounds().unwrap();
        assert!(bounds.min.col <= -1800 && bounds.max.row >= 800);
    }

    #[test]
    fn absurd_points_take_no_memory() {
        let mut grid = grid();
        grid.insert(&beam_to((1e7, 1e7), true), &Pose2::identity());
        grid.insert(&beam_to((f64::NAN, 0.0), true), &Pose2::identity());
        assert!(grid.block_count() <= 70_000);
    }

    #[test]
    fn only_changed_blocks_are_reported() {
        let mut grid = grid();
        grid.insert(&beam_to((30.0, 0.0), true), &Pose2::identity());
        let before = grid.revision();
        grid.insert(&beam_to((1.0, 1.0), true), &Pose2::identity());
        let changed: Vec<_> = grid
            .blocks_since(before)
            .map(|(b, _)| (b.col, b.row))
            .collect();
        assert_eq!(changed, [(0, 0)]);
        assert_eq!(grid.blocks_since(0).count(), grid.block_count());
    }

    #[test]
    fn bad_configuration_is_named() {
        let config = GridConfig {
            resolution: 0.0,
            ..GridConfig::default()
        };
        let error = Grid::new(config).unwrap_err().to_string();
        assert_eq!(
            error,
            "grid: resolution is 0, expected between 0.001 and 10 m"
        );
    }
}
