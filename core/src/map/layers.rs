//! Two sensors with a grid each, and the fused map of both.
//!
//! In: the grid that the laser draws and the one that sonars draw, each by its own model. Out: the
//! log-odds of either, or of both together, for the blocks that changed.
//!
//! What two sensors say of a cell is independent given the cell, and the prior is even, so log-odds
//! add: l = l₁ + l₂, which is p = p₁ p₂ / (p₁ p₂ + (1 - p₁) (1 - p₂)). Each grid clamps its own, so
//! neither can outvote the other without limit: a pane of glass that the laser sees through and the
//! sonars hear comes out as undecided, or as a wall once they have heard it about nine times.
//!
//! Source: Celej §8 (sonars beside the laser, left open there); Thrun, Burgard & Fox (2005), §9.3.

use std::borrow::Cow;

use super::{BlockIndex, Grid};

/// One of the maps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Layer {
    /// The map of the main sensor, which the pose comes from.
    #[default]
    Main,
    /// The map of the sonars beside it.
    Sonar,
    /// The map of both.
    Fused,
}

impl Layer {
    /// All variants, with their names in settings and their names for people.
    pub const ALL: [(&'static str, Self, &'static str); 3] = [
        ("sensor", Self::Main, "the sensor's"),
        ("sonars", Self::Sonar, "the sonars'"),
        ("fused", Self::Fused, "both, fused"),
    ];
}

/// A grid, the grid of the sonars if any, and which of them is shown.
#[derive(Clone, Copy, Debug)]
pub struct Layers<'a> {
    /// Drawn by the main sensor, which the pose comes from.
    pub main: &'a Grid,
    /// Drawn by the sonars, in cells of the same size.
    pub sonar: Option<&'a Grid>,
    /// Which map is shown; without sonars always the main one.
    pub shown: Layer,
}

/// Revisions of two grids in one number that a double holds exactly.
const REVISION_BITS: u32 = 26;

impl<'a> Layers<'a> {
    /// Grows with every change of the map that is shown.
    #[must_use]
    pub fn revision(&self) -> u64 {
        match (self.shown, self.sonar) {
            (Layer::Sonar, Some(sonar)) => sonar.revision(),
            (Layer::Fused, Some(sonar)) => self.main.revision() << REVISION_BITS | sonar.revision(),
            _ => self.main.revision(),
        }
    }

    /// The blocks that changed after `revision`, with their log-odds in rows from the lower left
    /// cell.
    #[must_use]
    pub fn blocks_since(&self, revision: u64) -> Vec<(BlockIndex, Cow<'a, [f32]>)> {
        let one = |grid: &'a Grid| {
            let blocks = grid.blocks_since(revision);
            blocks
                .map(|(block, cells)| (block, Cow::Borrowed(cells)))
                .collect()
        };
        match (self.shown, self.sonar) {
            (Layer::Sonar, Some(sonar)) => one(sonar),
            (Layer::Fused, Some(sonar)) => fused_since(self.main, sonar, revision),
            _ => one(self.main),
        }
    }
}

fn fused_since<'a>(a: &'a Grid, b: &'a Grid, revision: u64) -> Vec<(BlockIndex, Cow<'a, [f32]>)> {
    let (since_a, since_b) = (
        revision >> REVISION_BITS,
        revision & ((1 << REVISION_BITS) - 1),
    );
    let changed = a.blocks_since(since_a).chain(b.blocks_since(since_b));
    let mut changed: Vec<BlockIndex> = changed.map(|(block, _)| block).collect();
    changed.sort_unstable();
    changed.dedup();
    let fused = |block| match (a.block(block), b.block(block)) {
        (Some(a), Some(b)) => a.iter().zip(b).map(|(a, b)| a + b).collect(),
        (Some(one), None) | (None, Some(one)) => Cow::Borrowed(one),
        (None, None) => Cow::Borrowed(&[][..]),
    };
    changed
        .into_iter()
        .map(|block| (block, fused(block)))
        .collect()
}

#[cfg(test)]
mod tests {
    use nalgebra::Point2;

    use super::*;
    use crate::geom::Pose2;
    use crate::map::{BLOCK_CELLS, CellIndex, Evidence, GridConfig};

    /// A grid of its own model in which a beam along x ended at `end` some times.
    fn seen(hit: f64, miss: f64, end: f64, times: usize) -> Grid {
        let config = GridConfig {
            hit,
            miss,
            ..GridConfig::default()
        };
        let mut grid = Grid::new(config).unwrap();
        let evidence = Evidence {
            free: vec![[Point2::new(0.01, 0.01), Point2::new(end, 0.01)]],
            hits: vec![Point2::new(end, 0.01)],
        };
        (0..times).for_each(|_| grid.draw(&evidence, &Pose2::identity()));
        grid
    }

    fn probability(layers: &Layers, cell: CellIndex) -> f64 {
        let size = BLOCK_CELLS as i32;
        let blocks = layers.blocks_since(0);
        let (_, cells) = blocks
            .iter()
            .find(|(block, _)| {
                (block.col, block.row) == (cell.col.div_euclid(size), cell.row.div_euclid(size))
            })
            .unwrap();
        let odds = cells[(cell.row.rem_euclid(size) * size + cell.col.rem_euclid(size)) as usize];
        1.0 - 1.0 / (1.0 + libm::exp(f64::from(odds)))
    }

    #[test]
    fn the_fused_map_is_bayes_rule_cell_by_cell() {
        // A pane at 1 m: the laser sees the wall behind it, at 4 m, in another block; the sonars
        // hear the pane.
        let (laser, sonar) = (seen(0.7, 0.4, 4.01, 3), seen(0.6, 0.45, 1.01, 2));
        let layers = |shown| Layers {
            main: &laser,
            sonar: Some(&sonar),
            shown,
        };
        for col in [0, 5, 19, 20, 21, 40, 79, 80] {
            let cell = CellIndex { col, row: 0 };
            let (p, q) = (laser.probability(cell), sonar.probability(cell));
            let both = p * q / (p * q + (1.0 - p) * (1.0 - q));
            let found = probability(&layers(Layer::Fused), cell);
            assert!(
                (found - both).abs() < 1e-6,
                "{col}: {found}, expected {both}"
            );
            assert!((probability(&layers(Layer::Main), cell) - p).abs() < 1e-6);
        }
        let pane = CellIndex { col: 20, row: 0 };
        assert!(probability(&layers(Layer::Sonar), pane) > 0.6);
    }

    #[test]
    fn only_blocks_that_changed_in_either_are_given() {
        let (laser, mut sonar) = (seen(0.7, 0.4, 4.01, 3), seen(0.6, 0.45, 1.01, 2));
        let known = Layers {
            main: &laser,
            sonar: Some(&sonar),
            shown: Layer::Fused,
        };
        assert_eq!(known.blocks_since(0).len(), 2);
        let revision = known.revision();
        assert!(known.blocks_since(revision).is_empty());
        let near = Evidence {
            free: vec![[Point2::new(0.01, 0.01), Point2::new(0.5, 0.5)]],
            hits: vec![],
        };
        sonar.draw(&near, &Pose2::identity());
        let later = Layers {
            main: &laser,
            sonar: Some(&sonar),
            shown: Layer::Fused,
        };
        let changed = later.blocks_since(revision);
        assert_eq!(changed.len(), 1);
        assert!(later.revision() > revision);
        assert_eq!((changed[0].0.col, changed[0].0.row), (0, 0));
    }

    #[test]
    fn without_sonars_every_view_is_the_main_one() {
        let laser = seen(0.7, 0.4, 4.01, 3);
        for (_, shown, _) in Layer::ALL {
            let layers = Layers {
                main: &laser,
                sonar: None,
                shown,
            };
            assert_eq!(layers.revision(), 3);
            assert_eq!(layers.blocks_since(0).len(), 2);
        }
    }
}
