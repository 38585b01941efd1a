//! Surfels as bytes, with their index: a surfel stands in the cells that were near it when it was
//! first seen, and has moved since, so the index cannot be rebuilt from the surfels.

use nalgebra::Vector2;

use super::{BLOCK, NO_BLOCK, NOTHING, Surfel, SurfelConfig, SurfelMap, place_in_block};
use crate::snapshot::{Reader, Snapshot, SnapshotError, snapshot};

/// Allowed half side of a map and side of its cells in a file, m.
const HALF_SIDES: std::ops::RangeInclusive<f64> = 1.0..=1000.0;
const CELLS: std::ops::RangeInclusive<f64> = 0.01..=1.0;

snapshot!(Surfel {
    position,
    normal,
    weight,
});
snapshot!(
    SurfelConfig {
        cell,
        reach,
        half_side
    },
    |config| CELLS.contains(&config.cell)
        && HALF_SIDES.contains(&config.half_side)
        && (0.0..=2.0).contains(&config.reach),
    "cells, reach or side of a map of surfaces are out of bounds"
);

impl SurfelMap {
    /// The configuration of the map.
    #[must_use]
    pub fn config(&self) -> &SurfelConfig {
        &self.config
    }
}

/// Where the cells of a block are stored, row by row.
fn in_rows() -> impl Iterator<Item = usize> {
    let side = 0..BLOCK as i32;
    let row = |row: i32| (0..BLOCK as i32).map(move |col| place_in_block(col, row));
    side.flat_map(row)
}

/// For maps around their own origin, as those of submaps are; tiles are not saved.
impl Snapshot for SurfelMap {
    fn write(&self, out: &mut Vec<u8>) {
        let half = f64::from(self.cells.side) * 0.5 * BLOCK as f64;
        debug_assert_eq!(self.cells.origin, Vector2::repeat(half), "a tile is saved");
        self.config.write(out);
        self.surfels.write(out);
        // The blocks in the order in which they were made, each with its slot.
        let mut slots: Vec<(u32, u32)> = (self.cells.directory.iter().zip(0_u32..))
            .filter(|(block, _)| **block != NO_BLOCK)
            .map(|(block, slot)| (*block, slot))
            .collect();
        slots.sort_unstable();
        slots.len().write(out);
        let blocks = self.cells.blocks.iter().zip(&self.squared);
        for ((_, slot), (surfels, squared)) in slots.into_iter().zip(blocks) {
            slot.write(out);
            for (surfel, squared) in in_rows().map(|at| (surfels[at], squared[at])) {
                let stands = surfel != NOTHING;
                stands.then_some((surfel, squared)).write(out);
            }
        }
    }

    fn read(from: &mut Reader<'_>) -> Result<Self, SnapshotError> {
        let mut map = Self::new(from.field("config")?);
        map.surfels = from.field("surfels")?;
        let blocks: usize = from.field("blocks")?;
        from.rule(
            blocks <= map.cells.directory.len(),
            "more blocks than the map has room for",
        )?;
        for number in 0..blocks {
            let slot: u32 = from.field("slot")?;
            let room = map.cells.directory.get_mut(slot as usize);
            let free = room.filter(|block| **block == NO_BLOCK);
            let Some(number_of) = free else {
                return Err(from.refuse("a block stands where none can"));
            };
            *number_of = number as u32;
            map.push_block();
            let (Some(block), Some(distances)) =
                (map.cells.blocks.last_mut(), map.squared.last_mut())
            else {
                break;
            };
            for at in in_rows() {
                if let Some((surfel, squared)) = from.field::<Option<(u32, f32)>>("nearest")? {
                    let is_there = (surfel as usize) < map.surfels.len();
                    from.rule(is_there, "a cell names a surface that is not there")?;
                    (block[at], distances[at]) = (surfel, squared);
                }
            }
        }
        Ok(map)
    }
}
