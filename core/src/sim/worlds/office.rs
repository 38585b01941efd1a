//! `office`, 16 x 12 m: a corridor, eight rooms, furniture, after Pilch 2016 §4.6.
//!
//! ```text
//! y 12 +--------+--------+--------+--------+
//!      |        |        =        |        |
//!  6.9 +--= =---+-= =----+---= =--+--= =---+
//!      |               corridor            |
//!  5.1 +---= =--+----= =-+-= =----+---= =--+
//!      |        =        |        |        |
//!    0 +--------+--------+--------+--------+
//!     x 0       4.2      8        12      16
//! ```

use super::{hall, partition_along_x, partition_along_y};
use crate::sim::World;

pub(super) fn world() -> World {
    let world = hall("office", (1.0, 6.0), (16.0, 12.0)).with_goal((14.0, 10.0));
    furniture(partitions(world))
}

fn partitions(world: World) -> World {
    let south = [(1.8, 2.8), (6.4, 7.4), (8.8, 9.8), (13.6, 14.6)];
    let north = [(1.2, 2.2), (4.9, 5.9), (10.2, 11.2), (12.8, 13.8)];
    let world = partition_along_x(world, 5.1, 0.0, 16.0, &south);
    let world = partition_along_x(world, 6.9, 0.0, 16.0, &north);
    let world = partition_along_y(world, 4.2, 0.0, 5.05, &[(0.6, 1.6)]);
    let world = partition_along_y(world, 8.0, 0.0, 5.05, &[]);
    let world = partition_along_y(world, 12.0, 0.0, 5.05, &[]);
    let world = partition_along_y(world, 4.2, 6.95, 12.0, &[]);
    let world = partition_along_y(world, 8.0, 6.95, 12.0, &[(10.2, 11.2)]);
    partition_along_y(world, 12.0, 6.95, 12.0, &[])
}

/// Desks, cupboards, pillars; everywhere at least 0.8 m remain to drive through.
fn furniture(world: World) -> World {
    world
        // South, from west to east.
        .with_box((0.0, 3.2), (0.6, 4.4))
        .with_box((1.6, 0.0), (3.0, 0.7))
        .with_box((6.9, 0.0), (7.95, 1.2))
        .with_turned_box((5.6, 3.2), (1.2, 0.6), 0.4)
        .with_box((8.05, 1.5), (8.65, 3.0))
        .with_box((10.4, 0.0), (11.95, 0.6))
        .with_pillar((10.6, 2.9), 0.2)
        .with_box((15.2, 0.0), (16.0, 1.6))
        .with_turned_box((13.6, 2.2), (1.4, 0.7), -0.3)
        // North, from west to east.
        .with_box((0.0, 9.4), (0.7, 10.9))
        .with_box((2.6, 11.3), (4.15, 12.0))
        .with_turned_box((6.2, 9.6), (1.4, 0.7), 0.2)
        .with_box((4.25, 11.4), (5.6, 12.0))
        .with_box((11.3, 8.4), (11.95, 9.8))
        .with_turned_box((9.6, 9.2), (0.8, 0.8), 0.7)
        .with_box((15.3, 8.0), (16.0, 9.5))
        .with_pillar((13.6, 8.8), 0.25)
        .with_box((12.05, 11.3), (13.2, 12.0))
        // In the corridor, at its ends.
        .with_box((0.0, 6.55), (0.4, 6.85))
        .with_box((15.5, 5.15), (16.0, 5.5))
}
