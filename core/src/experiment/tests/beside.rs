//! Sonars beside a lidar: they do not change the run, and draw a map that agrees with the lidar's.

use std::f64::consts::FRAC_PI_2;

use super::*;
use crate::map::{BLOCK_CELLS, CellIndex, CellState, Layer, Layers};
use crate::sim::sensors::SonarModel;

fn driven(sonars_beside: Option<SonarModel>) -> Experiment {
    let world = worlds::builtin("arena").unwrap();
    let robot = world.robot.model();
    let config = ExperimentConfig {
        sonars_beside,
        ..ExperimentConfig::new(world, robot, SensorKind::Lidar.model(), 4)
    };
    let mut run = Experiment::new(config).unwrap();
    for _ in 0..300 {
        run.step().unwrap();
    }
    run
}

#[test]
fn sonars_beside_change_no_bit_of_the_run_and_draw_a_map_of_their_own() {
    // Rough walls: smooth ones reflect the sound away at a flat angle, and sonars then take a
    // twentieth of what they call free to be free where the lidar sees a wall.
    let rough = SonarModel {
        specular_angle: FRAC_PI_2,
        ..SonarModel::default()
    };
    let (alone, both) = (driven(None), driven(Some(rough)));
    assert_eq!(alone.truth(), both.truth());
    assert_eq!(alone.session().estimate(), both.session().estimate());
    let (lidar, layers) = (both.session().slam().grid(), both.session().slam().layers());
    for (block, cells) in alone.session().slam().grid().blocks_since(0) {
        assert_eq!(lidar.block(block), Some(cells));
    }
    assert!(alone.session().slam().layers().sonar.is_none());
    assert_ne!(alone.state_hash(), both.state_hash());
    // What the sonars firmly know to be free, the lidar does not know to be occupied.
    let sonar = layers.sonar.unwrap();
    let (mut free, mut denied) = (0, 0);
    let shown = Layers {
        shown: Layer::Sonar,
        ..layers
    };
    for (block, cells) in shown.blocks_since(0) {
        for (offset, odds) in cells.iter().enumerate() {
            let cell = CellIndex::new(
                block.col * BLOCK_CELLS as i32 + (offset % BLOCK_CELLS) as i32,
                block.row * BLOCK_CELLS as i32 + (offset / BLOCK_CELLS) as i32,
            );
            let is_free = sonar.state_of(*odds) == CellState::Free;
            free += usize::from(is_free);
            denied += usize::from(is_free && lidar.state(cell) == CellState::Occupied);
        }
    }
    assert!(free > 2000, "{free}");
    // What remains: noise of the range, echoes of others, cells that a wall cuts.
    assert!(denied * 40 < free, "{denied} of {free}");
}
