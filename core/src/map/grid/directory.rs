//! The directory of blocks.

use std::sync::Arc;

use super::BLOCK_CELLS;
use super::block::{Block, Cells};
use crate::map::BlockIndex;

/// Dense rectangle of block pointers that is rebuilt, twice as large, when a block falls outside.
#[derive(Clone, Debug)]
pub(super) struct Directory {
    origin: BlockIndex,
    cols: i32,
    rows: i32,
    pub(super) blocks: Vec<Option<Block>>,
    pub(super) count: usize,
    /// The content of new blocks.
    unknown: Arc<Cells>,
}

impl Directory {
    pub(super) fn empty() -> Self {
        Self {
            origin: BlockIndex { col: 0, row: 0 },
            cols: 0,
            rows: 0,
            blocks: vec![],
            count: 0,
            unknown: Arc::new([0.0; BLOCK_CELLS * BLOCK_CELLS]),
        }
    }

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
    pub(super) fn get(&self, index: BlockIndex) -> Option<&Block> {
        self.slot(index).and_then(|slot| self.blocks[slot].as_ref())
    }

    pub(super) fn get_mut(&mut self, index: BlockIndex) -> Option<&mut Block> {
        let slot = self.slot(index)?;
        self.blocks.get_mut(slot)?.as_mut()
    }

    pub(super) fn slot_or_create(&mut self, index: BlockIndex, max_blocks: usize) -> Option<usize> {
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
            *entry = Some(Block::new(&self.unknown));
        }
        Some(slot)
    }

    /// Rebuilds the directory so that it holds `index`, with room to spare on the side that grew.
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
        // A stray beam far away must not create a directory for the whole distance.
        if i64::from(cols) * i64::from(rows) > 16 * max_blocks as i64 {
            return None;
        }
        let mut grown = Self {
            origin: BlockIndex { col, row },
            cols,
            rows,
            blocks: vec![],
            count: self.count,
            unknown: self.unknown.clone(),
        };
        grown.blocks.resize_with((cols * rows) as usize, || None);
        let old = std::mem::take(&mut self.blocks);
        for (slot, block) in old.into_iter().enumerate() {
            if let Some(at) = grown.slot(self.index_of(slot)) {
                grown.blocks[at] = block;
            }
        }
        *self = grown;
        Some(())
    }

    fn index_of(&self, slot: usize) -> BlockIndex {
        let (col, row) = (slot as i32 % self.cols, slot as i32 / self.cols);
        BlockIndex {
            col: self.origin.col + col,
            row: self.origin.row + row,
        }
    }

    pub(super) fn iter(&self) -> impl Iterator<Item = (BlockIndex, &Block)> {
        let blocks = self.blocks.iter().enumerate();
        blocks.filter_map(|(slot, block)| Some((self.index_of(slot), block.as_ref()?)))
    }
}
