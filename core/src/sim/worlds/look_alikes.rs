//! `look-alikes`, 23.6 x 10.8 m: ten rooms with the same furniture, surrounded by a corridor.
//!
//! ```text
//! y 10.8 +--------------------------------+
//!        |            corridor            |
//!    9.0 |   +-= --+-= --+-= --+-= --+    |
//!        |   |     |     |     |     |    |      five rooms in a row, each 4 m wide
//!    5.4 |   +-----+-----+-----+-----+    |
//!        |   |     |     |     |     |    |
//!    1.8 |   +-- =-+-- =-+-- =-+-- =-+    |
//!        |            corridor            |
//!      0 +--------------------------------+
//! ```
//!
//! Rotated by half a turn, the building looks the same. Every place has another that looks just
//! like it, and only the route there shows which one it is. Closing loops by looks alone goes wrong
//! here.

use super::{hall, partition_along_x, partition_along_y};
use crate::sim::World;

/// Width and height of the building, m.
const SIZE: (f64, f64) = (23.6, 10.8);
/// Width of the corridor, m.
const CORRIDOR: f64 = 1.8;
const ROOMS: usize = 5;
/// Width of a room, m.
const ROOM: f64 = 4.0;
/// Where the door of a room begins and ends, m from its corner.
const DOOR: (f64, f64) = (2.4, 3.4);

pub(super) fn world() -> World {
    let world = hall("look-alikes", (1.0, 0.9), SIZE).with_goal((15.2, 7.8));
    let world = partitions(world);
    (0..ROOMS).fold(world, |world, room| {
        let corner = (CORRIDOR + ROOM * room as f64, CORRIDOR);
        let world = furniture(world, |(x, y)| (corner.0 + x, corner.1 + y));
        furniture(world, |(x, y)| half_turn((corner.0 + x, corner.1 + y)))
    })
}

fn partitions(world: World) -> World {
    let (left, right) = (CORRIDOR, SIZE.0 - CORRIDOR);
    let (low, high) = (CORRIDOR, SIZE.1 - CORRIDOR);
    let south: Vec<(f64, f64)> = (0..ROOMS)
        .map(|room| left + ROOM * room as f64)
        .map(|x| (x + DOOR.0, x + DOOR.1))
        .collect();
    let turned = |&(from, to): &(f64, f64)| (SIZE.0 - to, SIZE.0 - from);
    let north: Vec<(f64, f64)> = south.iter().rev().map(turned).collect();
    let world = partition_along_x(world, low, left, right, &south);
    let world = partition_along_x(world, high, left, right, &north);
    let world = partition_along_x(world, 0.5 * SIZE.1, left, right, &[]);
    (0..=ROOMS).fold(world, |world, room| {
        partition_along_y(world, left + ROOM * room as f64, low, high, &[])
    })
}

/// A desk, a cupboard and a pillar, placed by `place`, which maps coordinates relative to the
/// corner of a room.
fn furniture(world: World, place: impl Fn((f64, f64)) -> (f64, f64)) -> World {
    let boxed = |world: World, a: (f64, f64), b: (f64, f64)| {
        let (a, b) = (place(a), place(b));
        world.with_box((a.0.min(b.0), a.1.min(b.1)), (a.0.max(b.0), a.1.max(b.1)))
    };
    let world = boxed(world, (0.05, 1.0), (0.65, 2.0));
    let world = boxed(world, (3.0, 3.05), (3.95, 3.55));
    world
        .with_turned_box(place((2.0, 2.1)), (1.0, 0.5), 0.3)
        .with_pillar(place((3.5, 1.8)), 0.15)
}

/// Where a place ends up when the building is rotated by half a turn.
fn half_turn((x, y): (f64, f64)) -> (f64, f64) {
    (SIZE.0 - x, SIZE.1 - y)
}
