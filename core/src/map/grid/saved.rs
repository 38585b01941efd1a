//! A grid as bytes, exact to the bit.

use std::sync::Arc;

use super::{BLOCK_CELLS, BlockIndex, FreeCells, Grid, GridConfig};
use crate::snapshot::{Reader, Snapshot, SnapshotError, snapshot, snapshot_names};

snapshot!(BlockIndex { col, row });
snapshot_names!(FreeCells {
    Crossed = 0,
    Bresenham = 1,
    Area = 2,
});
snapshot!(GridConfig {
    resolution,
    hit,
    miss,
    clamp,
    free_cells,
    max_blocks,
});

impl Snapshot for Grid {
    fn write(&self, out: &mut Vec<u8>) {
        self.config.write(out);
        self.revision.write(out);
        self.is_beyond.write(out);
        self.block_count().write(out);
        for (index, block) in self.directory.iter() {
            index.write(out);
            block.revision.write(out);
            block.cells().write(out);
        }
    }

    fn read(from: &mut Reader<'_>) -> Result<Self, SnapshotError> {
        let config: GridConfig = from.field("config")?;
        let most = GridConfig::default().max_blocks;
        from.rule(
            config.max_blocks <= most,
            "more blocks than a grid may have",
        )?;
        let mut grid = Self::new(config).map_err(|error| from.refuse(error.to_string()))?;
        grid.revision = from.field("revision")?;
        grid.is_beyond = from.field("is_beyond")?;
        let blocks: usize = from.field("blocks")?;
        for _ in 0..blocks {
            let index: BlockIndex = from.field("index")?;
            let revision: u64 = from.field("revision")?;
            let cells: [f32; BLOCK_CELLS * BLOCK_CELLS] = from.field("cells")?;
            from.rule(
                revision <= grid.revision,
                "a block changed later than its grid",
            )?;
            let limit = grid.odds.limit;
            let in_bounds = |cell: &f32| (-limit..=limit).contains(cell);
            from.rule(cells.iter().all(in_bounds), "a cell is out of bounds")?;
            let (count, max) = (grid.block_count(), config.max_blocks);
            let slot = grid.directory.slot_or_create(index, max);
            from.rule(
                slot.is_some() && grid.block_count() > count,
                "a block stands where none can",
            )?;
            if let Some(block) = slot.and_then(|slot| grid.directory.blocks[slot].as_mut()) {
                block.restore(cells, revision, -limit, &grid.free);
            }
        }
        Ok(grid)
    }
}

impl super::block::Block {
    /// Replaces cells; those that are as free as the clamp allows hold `least`.
    fn restore(
        &mut self,
        cells: [f32; BLOCK_CELLS * BLOCK_CELLS],
        revision: u64,
        least: f32,
        free: &Arc<[f32; BLOCK_CELLS * BLOCK_CELLS]>,
    ) {
        let is_free = cells == **free;
        let shared = if is_free {
            free.clone()
        } else {
            Arc::new(cells)
        };
        self.take_over(shared, least);
        self.revision = revision;
    }
}
