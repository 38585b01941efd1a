//! Occupancy grid in growing blocks.
//!
//! In: points in the robot frame (or the [`Evidence`] they give) and the pose they were seen from.
//! Out: log-odds per cell.
//!
//! 1. Each cell keeps l = ln(p / (1 - p)), 0 where nothing is known (Celej §2; Moravec & Elfes
//!    1985).
//! 2. A beam adds `miss` to the cells that it leaves free ([`FreeCells`]) and `hit` to the cell
//!    where it ends; within one scan a hit overrides a miss, so that neighbouring beams do not
//!    erase thin walls.
//! 3. l is clamped so that a cell can still change its state; p = 1 - 1/(1 + eˡ) (erratum to Celej
//!    eq. (3), see the specification).
//!
//! Storage: blocks of 64 x 64 cells in a directory that grows as the robot explores. A block stores
//! the revision of its last change, so a display fetches only what changed. A block in which every
//! cell is as free as the clamp allows costs half a kilobyte: it shares its cells with other such
//! blocks until something is written.
//!
//! Near the robot most cells are crossed by many beams of a scan, but count once. So beams only
//! mark cells, a bit each and a slice of a row or column at a time, on a canvas as large as the
//! scan. Then each marked cell is updated once, eight side by side, except those that are already
//! as free as the clamp allows.

mod area;
mod block;
mod canvas;
mod config;
mod directory;
mod edited;
mod extent;
mod figures;
mod free_cells;
#[cfg(test)]
mod free_cells_tests;
mod saved;
mod states;
#[cfg(test)]
mod tests;

use std::sync::Arc;

use nalgebra::Point2;

use self::area::Area;
use self::block::{Cells, Marks, Odds};
use self::directory::Directory;
use super::{BlockIndex, CellIndex, CellRect, CellState, Evidence};
use crate::geom::Pose2;
use crate::lanes::{self, Kernel, Lanes};
use crate::points::Points;

pub(crate) use self::canvas::Canvas;
pub use self::config::{GridConfig, GridError};
pub use self::figures::CellFigures;
pub use self::free_cells::FreeCells;
pub use self::states::without_stripes;

/// Cells along one side of a block.
pub const BLOCK_CELLS: usize = 64;
const BLOCK: i32 = BLOCK_CELLS as i32;
const BLOCK_BITS: u32 = BLOCK_CELLS.trailing_zeros();

/// Cells count as occupied above this probability, as in ROS map_server.
const OCCUPIED_ABOVE: f64 = 0.65;
/// Cells count as free below this probability.
const FREE_BELOW: f64 = 0.35;

/// An occupancy grid that grows with what is seen.
#[derive(Clone, Debug)]
pub struct Grid {
    config: GridConfig,
    odds: Odds,
    /// Cells that are all as free as the clamp allows, shared by the blocks that consist of such
    /// cells.
    free: Arc<Cells>,
    directory: Directory,
    revision: u64,
    /// Whether something was seen where the grid may not grow.
    is_beyond: bool,
    /// Marks of the scan being inserted, in the first `marked` places; cleared between scans, while
    /// the memory is kept.
    marks: Vec<Marks>,
    marked: usize,
    area: Area,
    canvas: Canvas,
}

impl Grid {
    /// An empty grid.
    ///
    /// # Errors    [`GridError::Bounds`] for a value out of its bounds.
    pub fn new(config: GridConfig) -> Result<Self, GridError> {
        config.validate()?;
        let log_odds = |p: f64| libm::log(p / (1.0 - p)) as f32;
        let limit = log_odds(1.0 - config.clamp);
        Ok(Self {
            free: Arc::new([-limit; BLOCK_CELLS * BLOCK_CELLS]),
            odds: Odds {
                hit: log_odds(config.hit),
                miss: log_odds(config.miss),
                limit,
                occupied: log_odds(OCCUPIED_ABOVE),
                free: log_odds(FREE_BELOW),
            },
            config,
            directory: Directory::empty(),
            revision: 0,
            is_beyond: false,
            marks: vec![],
            marked: 0,
            area: Area::default(),
            canvas: Canvas::default(),
        })
    }

    /// Side of a cell, m.
    #[must_use]
    pub fn resolution(&self) -> f64 {
        self.config.resolution
    }

    /// The configuration of the grid.
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
        CellIndex::holding(point * scale)
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

    /// Log-odds of a cell, 0 if it is unknown.
    #[inline]
    #[must_use]
    pub fn log_odds(&self, cell: CellIndex) -> f32 {
        let (block, offset) = split(cell);
        self.directory.get(block).map_or(0.0, |b| b.cells()[offset])
    }

    /// Probability that a cell is occupied, 0.5 if it is unknown.
    #[must_use]
    pub fn probability(&self, cell: CellIndex) -> f64 {
        1.0 - 1.0 / (1.0 + libm::exp(f64::from(self.log_odds(cell))))
    }

    /// The believed state of a cell.
    #[inline]
    #[must_use]
    pub fn state(&self, cell: CellIndex) -> CellState {
        self.state_of(self.log_odds(cell))
    }

    /// The believed state at the given log-odds.
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

    /// Writes what one scan saw, from `map_from_robot`.
    pub fn insert(&mut self, points: &Points, map_from_robot: &Pose2) {
        self.draw(&Evidence::of(points), map_from_robot);
    }

    /// Writes the evidence of one scan, seen from `map_from_robot`.
    pub fn draw(&mut self, evidence: &Evidence, map_from_robot: &Pose2) {
        self.revision += 1;
        let scale = 1.0 / self.config.resolution;
        let in_cells = |p: Point2<f64>| Point2::from((*map_from_robot * p).coords * scale);
        for hit in &evidence.hits {
            let (index, offset) = split(CellIndex::holding(in_cells(*hit)));
            if let Some(marks) = self.marks_of(index) {
                self.marks[marks].hits[offset / BLOCK_CELLS] |= 1 << (offset % BLOCK_CELLS);
            }
        }
        let ways = evidence.free.iter();
        self.mark_free(ways.map(|way| way.map(in_cells)));
        self.write_marked();
    }

    /// The blocks that changed after `revision`, with their log-odds in rows from the lower left
    /// cell.
    pub fn blocks_since(&self, revision: u64) -> impl Iterator<Item = (BlockIndex, &[f32])> {
        self.directory
            .iter()
            .filter(move |(_, b)| b.revision > revision)
            .map(|(index, b)| (index, &b.cells()[..]))
    }

    /// Log-odds of a block in rows from the lower left cell; `None` if nothing was drawn there.
    #[must_use]
    pub fn block(&self, index: BlockIndex) -> Option<&[f32]> {
        self.directory.get(index).map(|b| &b.cells()[..])
    }

    /// Number of blocks held.
    #[must_use]
    pub fn block_count(&self) -> usize {
        self.directory.count
    }

    /// Whether everything that was seen is in the grid. Only what lies beyond its limits is
    /// missing.
    ///
    /// # Errors    [`GridError::Full`] once something was seen in a block that the grid may not
    /// have: either it already has [`GridConfig::max_blocks`], or the block lies so far away that
    /// the directory would become much larger than that.
    pub fn is_whole(&self) -> Result<(), GridError> {
        if self.is_beyond {
            return Err(GridError::Full {
                blocks: self.block_count(),
                max_blocks: self.config.max_blocks,
            });
        }
        Ok(())
    }

    /// Where a block is in the directory, made if need be; `None` if the grid may not grow there.
    fn slot(&mut self, index: BlockIndex) -> Option<usize> {
        let slot = self.directory.slot_or_create(index, self.config.max_blocks);
        self.is_beyond |= slot.is_none();
        slot
    }

    /// The index of the marks of a block in the scan being inserted; `None` if the grid may not
    /// grow there.
    fn marks_of(&mut self, index: BlockIndex) -> Option<usize> {
        let slot = self.slot(index)?;
        let block = self.directory.blocks.get_mut(slot)?.as_mut()?;
        if block.marks.is_none() {
            match self.marks.get_mut(self.marked) {
                Some(marks) => marks.block = index,
                None => self.marks.push(Marks::none(index)),
            }
            block.marks = Some(self.marked);
            self.marked += 1;
        }
        block.marks
    }

    /// Writes the marks into the cells and clears them.
    fn write_marked(&mut self) {
        lanes::run(WriteMarks(self));
        self.marked = 0;
    }
}

struct WriteMarks<'a>(&'a mut Grid);

impl Kernel for WriteMarks<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, machine: L::Machine) {
        let grid = self.0;
        for marks in grid.marks.iter_mut().take(grid.marked) {
            if let Some(block) = grid.directory.get_mut(marks.block) {
                block.write::<L>(machine, marks, &grid.odds, &grid.free);
                block.marks = None;
                block.revision = grid.revision;
            }
        }
    }
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
