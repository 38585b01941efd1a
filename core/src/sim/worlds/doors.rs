//! `doors`, 8 x 6 m: four rooms whose partitions are in line with each other across the door gaps.
//! Each gap has a door, open until somebody shuts it.

use super::{hall, partition_along_x, partition_along_y};
use crate::geom::Segment;
use crate::sim::{Door, World};

pub(super) fn world() -> World {
    let world = hall("doors", (1.0, 1.0), (8.0, 6.0)).with_goal((7.3, 4.1));
    let world = partition_along_y(world, 3.2, 0.0, 6.0, &[(1.0, 1.9), (4.1, 5.0)]);
    let world = partition_along_x(world, 3.0, 0.0, 3.15, &[(1.2, 2.1)]);
    let world = partition_along_x(world, 3.4, 3.25, 8.0, &[(5.4, 6.3)]);
    let mut world = world
        .with_box((0.0, 4.6), (0.5, 5.6))
        .with_box((4.4, 0.0), (5.6, 0.5))
        .with_box((7.4, 1.6), (8.0, 2.6))
        .with_turned_box((7.0, 5.0), (0.8, 0.5), 0.6);
    let door = |a: [f64; 2], b: [f64; 2]| Door {
        leaf: Segment::new(a.into(), b.into()),
        is_open: true,
        switches: vec![],
    };
    world.doors = vec![
        door([3.2, 1.0], [3.2, 1.9]),
        door([3.2, 4.1], [3.2, 5.0]),
        door([1.2, 3.0], [2.1, 3.0]),
        door([5.4, 3.4], [6.3, 3.4]),
    ];
    world
}
