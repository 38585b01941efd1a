//! `warehouse`, 40 x 30 m, 1 000 walls: nine rows of racks with aisles that look alike.
//!
//! Every rack is six pallets between seven posts; the gaps beside a post are 0.15 m, enough for
//! light but not for a robot. Some pallets are wrapped in black film, and a showcase has a front of
//! glass.

use super::hall;
use crate::sim::{Material, World};

const RACK_ROWS: usize = 9;
const BAYS: usize = 6;
/// Depth of a rack, m.
const DEPTH: f64 = 1.0;
/// Side of a post, m.
const POST: f64 = 0.1;
/// From one post to the next, m.
const BAY: f64 = 2.7;
/// One pallet in this many is black; coprime to [`BAYS`], so no two rows are alike.
const BLACK_EVERY: usize = 7;

pub(super) fn world() -> World {
    let mut world = hall("warehouse", (1.0, 1.2), (40.0, 30.0)).with_goal((39.0, 25.0));
    for row in 0..RACK_ROWS {
        let y = 2.4 + 2.9 * row as f64;
        for (half, x) in [2.0, 20.7].into_iter().enumerate() {
            world = rack(world, (x, y), (2 * row + half) * BAYS);
        }
    }
    along_the_walls(world)
}

/// One rack from its lower left corner; its pallets are numbered from `first` on.
fn rack(world: World, (x, y): (f64, f64), first: usize) -> World {
    let post = |world: World, bay: usize| {
        let x = x + BAY * bay as f64;
        world.with_box((x, y), (x + POST, y + DEPTH))
    };
    let pallet = |world: World, bay: usize| {
        let x = x + BAY * bay as f64 + POST + 0.15;
        // No two pallets of a rack stand alike, but all racks are alike: only black film
        // distinguishes one row from the next.
        let depth = DEPTH - 0.04 * ((first + 5 * bay) % 6) as f64;
        let is_black = (first + bay).is_multiple_of(BLACK_EVERY);
        let film = if is_black {
            Material::Dark
        } else {
            Material::Opaque
        };
        let world = world.with_box((x, y), (x + BAY - POST - 0.3, y + depth));
        world.made_of(film)
    };
    let world = (0..=BAYS).fold(world, post);
    (0..BAYS).fold(world, pallet)
}

/// Packing tables, chargers, pillars and the office along the northern and the southern wall.
fn along_the_walls(world: World) -> World {
    world
        // The office in the corner.
        .with_box((6.0, 27.9), (6.1, 30.0))
        .with_box((0.0, 27.9), (2.0, 28.0))
        .with_box((3.2, 27.9), (6.0, 28.0))
        // Packing.
        .with_box((9.0, 29.0), (11.4, 29.8))
        .with_box((13.0, 29.0), (15.4, 29.8))
        // A showcase: objects behind glass.
        .with_box((17.0, 29.0), (19.4, 29.8))
        .made_of(Material::Glass)
        .with_box((17.03, 29.03), (19.37, 29.77))
        .with_turned_box((24.0, 29.0), (1.2, 1.0), 0.3)
        .with_turned_box((28.0, 29.0), (1.2, 1.0), -0.2)
        .with_box((33.0, 29.3), (40.0, 30.0))
        // Chargers and things left standing about.
        .with_box((6.0, 0.0), (6.8, 0.5))
        .with_box((8.0, 0.0), (8.8, 0.5))
        .with_box((10.0, 0.0), (10.8, 0.5))
        .with_turned_box((26.0, 0.7), (1.2, 0.8), 0.4)
        .with_box((38.6, 0.0), (40.0, 0.6))
}
