//! `lab`, 20 x 10.2 m: a corridor and a laboratory, after the map of Celej §3.
//!
//! ```text
//! y 10.2 +-----------------+----------+
//!        |   laboratory    : office   |
//!        |                 :          |
//!  2.2   +--= =-------= =--+---= =----+
//!        |         corridor           |
//!    0   +----------------------------+
//!      x 0                 13        20
//! ```
//!
//! The wall between laboratory and office (`:`) is glass, and so is the screen around the robot
//! cell; the cupboards of the corridor are dark.

use super::{glazing_along_y, hall, partition_along_x, partition_along_y};
use crate::sim::{Material, World};

pub(super) fn world() -> World {
    let world = hall("lab", (1.0, 1.1), (20.0, 10.2)).with_goal((18.6, 8.8));
    let gaps = [(2.0, 3.0), (9.6, 10.8), (16.0, 17.0)];
    let world = partition_along_x(world, 2.2, 0.0, 20.0, &gaps);
    let world = partition_along_y(world, 13.0, 2.25, 4.0, &[]);
    let world = glazing_along_y(world, 13.0, 4.05, 10.15);
    office(laboratory(corridor(world)))
}

fn corridor(world: World) -> World {
    world
        .with_box((4.4, 0.0), (5.9, 0.45))
        .made_of(Material::Dark)
        .with_box((11.8, 0.0), (13.0, 0.45))
        .made_of(Material::Dark)
        .with_box((18.9, 0.0), (20.0, 0.6))
        .with_pillar((7.9, 2.0), 0.15)
}

/// Benches in rows, the robot cell behind its screen, a rack.
fn laboratory(world: World) -> World {
    glazing_along_y(world, 10.0, 8.0, 10.15)
        .with_box((1.6, 5.0), (4.8, 5.8))
        .with_box((1.6, 7.4), (4.8, 8.2))
        .with_box((0.0, 9.6), (3.2, 10.2))
        .with_box((6.2, 5.0), (8.4, 5.8))
        .with_turned_box((7.4, 7.9), (1.0, 0.6), 0.5)
        .with_box((5.4, 9.6), (7.8, 10.2))
        .with_box((11.0, 9.0), (12.0, 9.9))
        .with_pillar((10.4, 5.4), 0.2)
        .with_box((12.3, 2.3), (12.95, 3.6))
        .made_of(Material::Dark)
}

fn office(world: World) -> World {
    world
        .with_box((14.6, 8.9), (16.4, 9.7))
        .with_box((14.6, 5.6), (16.4, 6.4))
        .with_box((19.4, 3.0), (20.0, 5.4))
        .made_of(Material::Dark)
        .with_turned_box((18.0, 6.8), (1.2, 0.6), -0.4)
}
