//! Pictures of the distance to the nearest wall, one value for each known cell.
//!
//! In: a [`Grid`], the revision up to which the field is already known. Out: one byte a cell for
//! each block in which the field may have changed.
//!
//! 1. A byte holds distances up to the side of a block, [`BLOCK_CELLS`] cells. So a wall changes
//!    the field only in its own block and in the eight around it, and the cost depends on what has
//!    changed, not on the size of the map.
//! 2. Such blocks side by side are measured as one rectangle, a block wider on all sides, by the
//!    exact distance transform.
//! 3. Unknown cells stay unknown, whatever is near.

use std::collections::BTreeSet;

use super::{BLOCK_CELLS, BlockIndex, CellIndex, CellRect, CellState, DistanceField, Grid};

const BLOCK: i32 = BLOCK_CELLS as i32;
/// Steps between the least and the greatest value of a byte; the value for unknown is separate.
const STEPS: f64 = 254.0;

/// The value that a picture shows of a cell whose centre is d away from that of the nearest
/// occupied cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Field {
    /// d itself, m.
    Distance,
    /// exp(-d²/2σ²): how well a beam that ends there fits the map, 0 to 1.
    ///
    /// Source: Thrun, Burgard & Fox (2005), "Probabilistic Robotics", §6.4.
    Likelihood {
        /// Standard deviation of the error of surfaces and beam ends, m.
        sigma: f64,
    },
    /// The configuration space: how far a robot's centre there may move in any direction, m; 0 in
    /// places that it may not enter.
    Room {
        /// Distance that the robot's centre keeps from walls, m.
        keep: f64,
    },
}

/// A field in blocks, either some of them or all.
#[derive(Clone, Debug, PartialEq)]
pub struct FieldBlocks {
    /// The value of one step of a byte: m; for [`Field::Likelihood`] 1/254.
    pub step: f64,
    /// The blocks.
    pub blocks: Vec<BlockIndex>,
    /// The cells of one block after another, in rows from the lower left one: 0 unknown, else 1 +
    /// the value in steps, 255 for everything above. Only [`Field::Room`] without any room is shown
    /// as 1.
    pub bytes: Vec<u8>,
}

impl Field {
    /// The blocks of the field that may have changed since a revision of the grid.
    #[must_use]
    pub fn since(self, grid: &Grid, revision: u64) -> FieldBlocks {
        let mut field = FieldBlocks {
            step: self.step(grid.resolution()),
            blocks: vec![],
            bytes: vec![],
        };
        for [first, last] in runs(&near_changes(grid, revision)) {
            self.measure(grid, first, last, &mut field);
        }
        field
    }

    fn step(self, resolution: f64) -> f64 {
        match self {
            Self::Likelihood { .. } => 1.0 / STEPS,
            Self::Distance => BLOCK_CELLS as f64 * resolution / STEPS,
            // The room up to the farthest wall in sight: for walls beyond it, "at least that"
            // holds.
            Self::Room { keep } => {
                let most = (BLOCK_CELLS as f64 - 0.5) * resolution - keep;
                most.max(resolution) / STEPS
            }
        }
    }

    /// Measures the blocks of a row from `first` to `last`: step 2.
    fn measure(self, grid: &Grid, first: BlockIndex, last: BlockIndex, field: &mut FieldBlocks) {
        let cell = |block: BlockIndex, more: i32| {
            CellIndex::new((block.col + more) * BLOCK, (block.row + more) * BLOCK)
        };
        let rect = CellRect {
            min: cell(first, -1),
            max: cell(last, 2),
        };
        let states = grid.states(rect);
        let walls: Vec<bool> = states.iter().map(|s| *s == CellState::Occupied).collect();
        let distances = DistanceField::new(rect, grid.resolution(), &walls).into_distances();
        for (at, col) in (first.col..=last.col).enumerate() {
            field.blocks.push(BlockIndex { col, ..first });
            for row in BLOCK_CELLS..2 * BLOCK_CELLS {
                let from = row * rect.width() + (at + 1) * BLOCK_CELLS;
                let cells = states.iter().zip(&distances).skip(from).take(BLOCK_CELLS);
                let bytes = cells.map(|(state, distance)| match state {
                    CellState::Unknown => 0,
                    _ => self.byte(f64::from(*distance), grid.resolution()),
                });
                field.bytes.extend(bytes);
            }
        }
    }

    /// The byte of a known cell.
    fn byte(self, distance: f64, resolution: f64) -> u8 {
        let step = self.step(resolution);
        // There may be a nearer wall out of sight.
        let is_far = distance > BLOCK_CELLS as f64 * resolution;
        let distance = if is_far { f64::INFINITY } else { distance };
        let steps = match self {
            Self::Distance => (distance / step).round(),
            Self::Likelihood { sigma } => {
                let off = distance / sigma;
                (libm::exp(-0.5 * off * off) / step).round()
            }
            // As in `plan::GridSpace`: the wall may be anywhere in its cell.
            Self::Room { keep } => ((distance - 0.5 * resolution - keep) / step).ceil(),
        };
        1 + steps.clamp(0.0, STEPS) as u8
    }
}

/// The blocks that changed and their neighbours, as far as the grid has them; row by row.
fn near_changes(grid: &Grid, revision: u64) -> Vec<BlockIndex> {
    let changed = grid.blocks_since(revision).map(|(block, _)| block);
    let around = |block: BlockIndex| {
        let rows = block.row - 1..=block.row + 1;
        rows.flat_map(move |row| (block.col - 1..=block.col + 1).map(move |col| (row, col)))
    };
    let near: BTreeSet<(i32, i32)> = changed.flat_map(around).collect();
    let blocks = near.into_iter().map(|(row, col)| BlockIndex { col, row });
    blocks
        .filter(|block| grid.block(*block).is_some())
        .collect()
}

/// First and last of each group of blocks side by side.
fn runs(blocks: &[BlockIndex]) -> impl Iterator<Item = [BlockIndex; 2]> {
    let beside = |a: &BlockIndex, b: &BlockIndex| a.row == b.row && a.col + 1 == b.col;
    let runs = blocks.chunk_by(beside);
    runs.filter_map(|run| Some([*run.first()?, *run.last()?]))
}

#[cfg(test)]
mod tests {
    use nalgebra::Point2;

    use super::*;
    use crate::geom::Length;
    use crate::geom::Pose2;
    use crate::map::{Evidence, GridConfig};

    const RESOLUTION: f64 = 0.05;
    const ALL: [Field; 3] = [
        Field::Distance,
        Field::Likelihood { sigma: 0.1 },
        Field::Room { keep: 0.2 },
    ];

    /// A robot at `eye` sees these points, four times.
    fn look(grid: &mut Grid, eye: [f64; 2], hits: &[[f64; 2]]) {
        let point = |[x, y]: [f64; 2]| Point2::new(x, y);
        let evidence = Evidence {
            free: hits.iter().map(|hit| [point(eye), point(*hit)]).collect(),
            hits: hits.iter().copied().map(point).collect(),
        };
        (0..4).for_each(|_| grid.draw(&evidence, &Pose2::identity()));
    }

    /// Walls in several blocks, near and far from their borders, some of them right of and above
    /// missing blocks.
    fn seen() -> Grid {
        let mut grid = Grid::new(GridConfig::default()).unwrap();
        look(
            &mut grid,
            [0.52, 0.53],
            &[[3.17, 3.18], [-3.3, 0.4], [3.3, 9.7]],
        );
        look(&mut grid, [-12.0, 4.4], &[[-12.0, 6.41], [-6.0, 4.43]]);
        grid
    }

    fn all(field: &FieldBlocks) -> Vec<(CellIndex, u8)> {
        let cells = field.bytes.chunks(BLOCK_CELLS * BLOCK_CELLS);
        let cell = |block: BlockIndex, at: usize| {
            CellIndex::new(
                block.col * BLOCK + (at % BLOCK_CELLS) as i32,
                block.row * BLOCK + (at / BLOCK_CELLS) as i32,
            )
        };
        let blocks = field.blocks.iter().zip(cells);
        blocks
            .flat_map(|(block, bytes)| {
                let bytes = bytes.iter().enumerate();
                bytes.map(move |(at, byte)| (cell(*block, at), *byte))
            })
            .collect()
    }

    /// Steps of a cell, from its distance to the nearest of all occupied cells.
    fn brute(field: Field, grid: &Grid, walls: &[Point2<f64>], cell: CellIndex) -> f64 {
        let from = grid.centre_of(cell);
        let distances = walls.iter().map(|wall| (wall - from).length());
        let d = distances.fold(f64::INFINITY, f64::min);
        let reach = 64.0 * RESOLUTION;
        let d = if d > reach { f64::INFINITY } else { d };
        match field {
            Field::Distance => 254.0 * d.min(reach) / reach,
            Field::Likelihood { sigma } => 254.0 * libm::exp(-d * d / (2.0 * sigma * sigma)),
            Field::Room { keep } => {
                let most = reach - 0.025 - keep;
                254.0 * (d - 0.025 - keep).clamp(0.0, most) / most
            }
        }
    }

    #[test]
    fn every_known_cell_tells_its_distance_from_all_walls() {
        let grid = seen();
        for field in ALL {
            let shown = field.since(&grid, 0);
            assert_eq!(shown.blocks.len(), grid.block_count());
            let cells = all(&shown);
            let walls: Vec<_> = cells
                .iter()
                .filter(|(cell, _)| grid.state(*cell) == CellState::Occupied)
                .map(|(cell, _)| grid.centre_of(*cell))
                .collect();
            assert!(walls.len() >= 5);
            for (cell, byte) in cells {
                if grid.state(cell) == CellState::Unknown {
                    assert_eq!(byte, 0, "{cell:?}");
                    continue;
                }
                let (expected, found) = (brute(field, &grid, &walls, cell), f64::from(byte) - 1.0);
                if matches!(field, Field::Room { .. }) && byte == 255 {
                    // Shown as "at least this".
                    assert!(expected > 253.0, "{cell:?}: {expected}");
                }
                assert!(
                    (found - expected).abs() < 1.0 + 1e-6 && (found > 0.0 || expected < 0.6),
                    "{field:?} {cell:?}: {found}, expected {expected}"
                );
            }
        }
    }

    #[test]
    fn what_changed_makes_the_old_field_the_new_one() {
        let mut grid = seen();
        for field in ALL {
            let mut known: std::collections::BTreeMap<_, _> =
                all(&field.since(&grid, 0)).into_iter().collect();
            let revision = grid.revision();
            assert!(field.since(&grid, revision).blocks.is_empty());
            // The last cell of a block: its changes reach into the next one too.
            let x = 3.17 - 0.1 * known.len() as f64 / 1e6;
            look(&mut grid, [0.52, 0.53], &[[x, 2.9], [1.0, 3.19]]);
            let changed = field.since(&grid, revision);
            assert!(!changed.blocks.is_empty() && changed.blocks.len() < grid.block_count());
            known.extend(all(&changed));
            assert_eq!(known, all(&field.since(&grid, 0)).into_iter().collect());
        }
    }

    #[test]
    fn a_grid_without_walls_is_free_as_far_as_a_byte_tells() {
        let grid = Grid::new(GridConfig::default()).unwrap();
        assert!(Field::Distance.since(&grid, 0).blocks.is_empty());
        let mut grid = grid;
        let evidence = Evidence {
            free: vec![[Point2::new(0.0, 0.0), Point2::new(2.0, 0.0)]],
            hits: vec![],
        };
        (0..4).for_each(|_| grid.draw(&evidence, &Pose2::identity()));
        let shown = Field::Distance.since(&grid, 0);
        assert!(shown.bytes.contains(&255));
        assert!(shown.bytes.iter().all(|byte| [0, 255].contains(byte)));
        let shown = Field::Likelihood { sigma: 0.1 }.since(&grid, 0);
        assert!(shown.bytes.iter().all(|byte| [0, 1].contains(byte)));
    }
}
