//! `arena`, 5 x 4 m: walls and boxes on one floor, after TDK 2016 fig. 6.4.
//!
//! From everywhere, something stands within the 1.5 m range of the infra-red rangers.

use super::hall;
use crate::sim::{SensorKind, World};

pub(super) fn world() -> World {
    let mut world = hall("arena", (0.6, 0.7), (5.0, 4.0))
        .with_box((1.3, 1.1), (1.8, 1.6))
        .with_box((2.9, 0.0), (3.1, 1.0))
        .with_box((0.0, 2.5), (1.0, 2.6))
        .with_turned_box((2.6, 2.6), (0.7, 0.4), 0.5)
        .with_box((3.7, 2.9), (3.8, 4.0))
        .with_box((4.3, 1.5), (5.0, 1.9))
        .with_goal((4.4, 3.4));
    world.sensor = SensorKind::Rangers;
    world
}
