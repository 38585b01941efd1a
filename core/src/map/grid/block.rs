//! A square of cells, with the marks of the scan that is being inserted.

use super::BLOCK_CELLS;

/// The configuration in log-odds.
#[derive(Clone, Copy, Debug)]
pub(super) struct Odds {
    pub(super) hit: f32,
    pub(super) miss: f32,
    pub(super) limit: f32,
    pub(super) occupied: f32,
    pub(super) free: f32,
}

#[derive(Clone, Debug)]
pub(super) struct Block {
    pub(super) cells: Box<[f32]>,
    /// What the scan being inserted sees in it; nothing between scans.
    pub(super) marks: Box<Marks>,
    pub(super) is_marked: bool,
    pub(super) revision: u64,
}

/// One bit for each cell, row by row.
#[derive(Clone, Debug)]
pub(super) struct Marks {
    pub(super) hits: [u64; BLOCK_CELLS],
    pub(super) misses: [u64; BLOCK_CELLS],
}

impl Default for Marks {
    fn default() -> Self {
        Self {
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
}

impl Block {
    /// Once per cell: where a beam ended, that others crossed it does not count.
    pub(super) fn write_marks(&mut self, odds: &Odds) {
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
