//! A square of cells, and the marks that a scan makes in it.

use std::sync::Arc;

use super::{BLOCK_CELLS, BlockIndex};
use crate::lanes::Lanes;

/// The configuration, in log-odds.
#[derive(Clone, Copy, Debug)]
pub(super) struct Odds {
    pub(super) hit: f32,
    pub(super) miss: f32,
    pub(super) limit: f32,
    pub(super) occupied: f32,
    pub(super) free: f32,
}

/// Log-odds in rows from the lower left cell.
pub(super) type Cells = [f32; BLOCK_CELLS * BLOCK_CELLS];

#[derive(Clone, Debug)]
pub(super) struct Block {
    /// Shared with other blocks of the same content (and with copies of the grid) until something
    /// is written.
    cells: Arc<Cells>,
    /// Cells that are as free as the clamp allows, a bit each: another miss changes nothing there.
    /// In a room that has been seen for a while nearly all cells are like that.
    least: Box<[u64; BLOCK_CELLS]>,
    /// Index of its marks in the scan being inserted; `None` between scans.
    pub(super) marks: Option<usize>,
    pub(super) revision: u64,
}

/// The marks of the scan being inserted in one block: one bit for each cell, row by row.
#[derive(Clone, Debug)]
pub(super) struct Marks {
    pub(super) block: BlockIndex,
    pub(super) hits: [u64; BLOCK_CELLS],
    pub(super) misses: [u64; BLOCK_CELLS],
}

impl Marks {
    pub(super) fn none(block: BlockIndex) -> Self {
        Self {
            block,
            hits: [0; BLOCK_CELLS],
            misses: [0; BLOCK_CELLS],
        }
    }
}

impl Odds {
    #[inline]
    pub(super) fn change(&self, cell: &mut f32, by: f32) {
        *cell = (*cell + by).clamp(-self.limit, self.limit);
    }

    /// Adds a miss to the cells of a row whose bits are set. Returns which of them are then as free
    /// as the clamp allows.
    #[inline(always)]
    fn miss_cells<L: Lanes>(
        &self,
        machine: L::Machine,
        row: &mut [f32; BLOCK_CELLS],
        misses: u64,
    ) -> u64 {
        let eights = row.as_chunks_mut::<8>().0.iter_mut();
        let bytes = misses.to_le_bytes().into_iter();
        let are_least = eights
            .zip(bytes)
            .map(|(cells, bits)| L::add_where(machine, cells, bits, self.miss, -self.limit));
        let mut bits = [0; 8];
        bits.iter_mut()
            .zip(are_least)
            .for_each(|(bits, are)| *bits = are);
        u64::from_le_bytes(bits)
    }
}

impl Block {
    pub(super) fn new(cells: &Arc<Cells>) -> Self {
        Self {
            cells: cells.clone(),
            least: Box::new([0; BLOCK_CELLS]),
            marks: None,
            revision: 0,
        }
    }

    /// Replaces the cells by these; cells that are as free as the clamp allows hold `least`.
    pub(super) fn take_over(&mut self, cells: Arc<Cells>, least: f32) {
        let rows = cells.as_chunks::<BLOCK_CELLS>().0;
        for (bits, row) in self.least.iter_mut().zip(rows) {
            let are = row.iter().enumerate();
            *bits = are.fold(0, |bits, (at, cell)| bits | u64::from(*cell <= least) << at);
        }
        self.cells = cells;
    }

    #[inline]
    pub(super) fn cells(&self) -> &Cells {
        &self.cells
    }

    /// Writes marks into the cells and clears them, once per cell: in a cell where a beam ended,
    /// other beams that crossed it do not count. `free` is a block of cells that are all as free as
    /// the clamp allows.
    #[inline(always)]
    pub(super) fn write<L: Lanes>(
        &mut self,
        machine: L::Machine,
        marks: &mut Marks,
        odds: &Odds,
        free: &Arc<Cells>,
    ) {
        let hits = std::mem::replace(&mut marks.hits, [0; BLOCK_CELLS]);
        let misses = std::mem::replace(&mut marks.misses, [0; BLOCK_CELLS]);
        let rows = hits.iter().zip(&misses).zip(self.least.iter());
        if rows.fold(0, |any, ((hit, miss), least)| any | hit | miss & !least) == 0 {
            return;
        }
        let rows = Arc::make_mut(&mut self.cells)
            .as_chunks_mut::<BLOCK_CELLS>()
            .0;
        let rows = rows.iter_mut().zip(self.least.iter_mut());
        for ((row, least), (hit, miss)) in rows.zip(hits.into_iter().zip(misses)) {
            if hit != 0 {
                for_runs(row, hit, |cell| odds.change(cell, odds.hit));
                *least &= !hit;
            }
            let miss = miss & !hit & !*least;
            if miss != 0 {
                *least = odds.miss_cells::<L>(machine, row, miss);
            }
        }
        if self.least.iter().all(|row| *row == u64::MAX) {
            self.cells = free.clone();
        }
    }
}

/// Visits the cells of a row whose bits are set, run by run, because a processor handles long runs
/// fast.
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
