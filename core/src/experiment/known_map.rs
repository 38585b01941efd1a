//! In: a configuration. Out: its settings of the estimation, with a known map where the method needs one.

use super::ExperimentConfig;
use crate::estimation::PriorLine;
use crate::geom::Segment;
use crate::slam::{Method, SlamConfig};

/// The settings of the estimation; a robot that is to find itself in a known map, and was given none, knows its world's walls.
pub(super) fn settings(config: &ExperimentConfig) -> SlamConfig {
    let mut slam = config.slam.clone();
    if config.method == Method::PriorMap && slam.prior_map.lines.is_empty() {
        let walls = config.world.walls();
        let walls: Vec<Segment> = walls.iter().map(|wall| wall.segment).collect();
        slam.prior_map.lines = PriorLine::of_walls(&walls, &config.world.start.inverse());
    }
    slam
}
