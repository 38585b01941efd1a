//! How far a grid reaches.

use super::{BLOCK, BLOCK_CELLS, CellIndex, CellRect, Grid};

impl Grid {
    /// The rectangle of all blocks; `None` while the grid is empty.
    #[must_use]
    pub fn bounds(&self) -> Option<CellRect> {
        let blocks = self.directory.iter().map(|(block, _)| CellRect {
            min: CellIndex::new(block.col * BLOCK, block.row * BLOCK),
            max: CellIndex::new((block.col + 1) * BLOCK, (block.row + 1) * BLOCK),
        });
        blocks.reduce(CellRect::around)
    }

    /// The smallest rectangle that holds all cells whose log-odds satisfy the condition; `None` if
    /// there is none.
    #[must_use]
    pub fn rect_where(&self, is_meant: impl Fn(f32) -> bool) -> Option<CellRect> {
        let mut found: Option<CellRect> = None;
        for (block, cells) in self.blocks_since(0) {
            let meant = cells
                .iter()
                .enumerate()
                .filter(|(_, odds)| is_meant(**odds));
            for (offset, _) in meant {
                let cell = CellRect::of(CellIndex::new(
                    block.col * BLOCK + (offset % BLOCK_CELLS) as i32,
                    block.row * BLOCK + (offset / BLOCK_CELLS) as i32,
                ));
                found = Some(found.map_or(cell, |rect| rect.around(cell)));
            }
        }
        found
    }
}
