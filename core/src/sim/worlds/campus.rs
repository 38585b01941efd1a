//! `campus`, 360 x 240 m, 50 000 walls: 120 houses of eight furnished rooms, with trees between
//! them. Its purpose is to measure the speed of the sensors; nobody explores it in an afternoon.
//!
//! Built from a fixed seed: doors, furniture and trees differ from house to house. Some houses have
//! a front of glass, some a dark one.
//!
//! ```text
//! y 20 +-----+-----+-----+-----+
//!      |     |     |     |     |
//!   13 +-= =-+-= =-+-= =-+-= =-+
//!      =        corridor       =
//!   11 +-= =-+-= =-+-= =-+-= =-+
//!      |     |     |     |     |
//!    4 +-----+-----+-----+-----+
//!    x 3     9     15    21    27
//! ```

use nalgebra::Point2;
use rand::seq::SliceRandom;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::{hall, partition_along_x, partition_along_y};
use crate::geom::sin_cos;
use crate::sim::{Material, Shape, World};

/// Walls in all.
const WALLS: usize = 50_000;
/// Plots from west to east and from south to north, and their sides, m.
const PLOTS: (usize, usize) = (12, 10);
const PLOT: (f64, f64) = (30.0, 24.0);
const SEED: u64 = 2016;

/// A house on its plot: from west to east and from south to north, m.
const WEST: f64 = 3.0;
const EAST: f64 = 27.0;
const SOUTH: f64 = 4.0;
const NORTH: f64 = 20.0;
const CORRIDOR: (f64, f64) = (11.0, 13.0);
const ROOM_WIDTH: f64 = 6.0;
const ROOMS: usize = 4;
const DOOR: f64 = 1.0;

pub(super) fn world() -> World {
    let (width, height) = (PLOTS.0 as f64 * PLOT.0, PLOTS.1 as f64 * PLOT.1);
    // The goal is at the eastern end of the first corridor.
    let mut world = hall("campus", (1.5, 1.5), (width, height)).with_goal((28.5, 12.0));
    let mut rng = ChaCha8Rng::seed_from_u64(SEED);
    let plots = PLOTS.0 * PLOTS.1;
    for plot in 0..plots {
        let (col, row) = ((plot % PLOTS.0) as f64, (plot / PLOTS.0) as f64);
        let corner = (col * PLOT.0, row * PLOT.1);
        world = trees(house(world, corner, &mut rng), corner, &mut rng);
        let walls = WALLS * (plot + 1) / plots;
        world = furnish(world, corner, walls, &mut rng);
    }
    world
}

/// Walls, partitions and doors of one house.
fn house(world: World, (x, y): (f64, f64), rng: &mut ChaCha8Rng) -> World {
    let mut door = |from: f64| {
        let at = from + rng.random_range(0.4..ROOM_WIDTH - DOOR - 0.4);
        (at, at + DOOR)
    };
    let room = |k: usize| x + WEST + ROOM_WIDTH * k as f64;
    let mut doors = || -> Vec<(f64, f64)> { (0..ROOMS).map(|k| door(room(k))).collect() };
    let (south_doors, north_doors) = (doors(), doors());
    let entrance = (y + CORRIDOR.0 + 0.5, y + CORRIDOR.1 - 0.5);
    let front = match rng.random_range(0..4) {
        0 => Material::Glass,
        1 => Material::Dark,
        _ => Material::Opaque,
    };
    let (west, east) = (x + WEST, x + EAST);
    let (south, north) = (y + SOUTH, y + NORTH);
    let world = partition_along_x(world, south, west, east, &[]).made_of(front);
    let world = partition_along_x(world, north, west, east, &[]);
    let world = partition_along_y(world, west, south, north, &[entrance]);
    let world = partition_along_y(world, east, south, north, &[entrance]);
    let world = partition_along_x(world, y + CORRIDOR.0, west, east, &south_doors);
    let world = partition_along_x(world, y + CORRIDOR.1, west, east, &north_doors);
    (1..ROOMS).fold(world, |world, k| {
        let world = partition_along_y(world, room(k), south, y + CORRIDOR.0, &[]);
        partition_along_y(world, room(k), y + CORRIDOR.1, north, &[])
    })
}

/// Six trees with eight sides each, between this house and the next.
fn trees(world: World, (x, y): (f64, f64), rng: &mut ChaCha8Rng) -> World {
    (0..6).fold(world, |world, k| {
        let east = x + 5.0 * f64::from(k) + rng.random_range(2.0..4.0);
        let north = y + 22.0 + rng.random_range(-0.8..0.8);
        let radius = rng.random_range(0.1..0.3);
        world.with(Shape::Polygon(octagon((east, north), radius)))
    })
}

fn octagon((x, y): (f64, f64), radius: f64) -> Vec<Point2<f64>> {
    let corner = |k: u32| {
        let (sin, cos) = sin_cos(std::f64::consts::FRAC_PI_4 * f64::from(k));
        Point2::new(x + radius * cos, y + radius * sin)
    };
    (0..8).map(corner).collect()
}

/// Chairs, tables and boxes in the rooms, until the world has `walls`: each in a place of its own,
/// 1.6 m from the next, so a robot can pass between any two.
fn furnish(world: World, (x, y): (f64, f64), walls: usize, rng: &mut ChaCha8Rng) -> World {
    let mut places = Vec::new();
    for room in 0..2 * ROOMS {
        let west = x + WEST + ROOM_WIDTH * (room % ROOMS) as f64;
        let south = y + if room < ROOMS { SOUTH } else { CORRIDOR.1 };
        for place in 0..12 {
            let (col, row) = (f64::from(place % 3), f64::from(place / 3));
            places.push((west + 1.4 + 1.6 * col, south + 1.1 + 1.6 * row));
        }
    }
    places.shuffle(rng);
    let missing = walls.saturating_sub(world.wall_count()) / 4;
    let add = |world: World, (x, y)| {
        let mut near = |middle: f64| middle + rng.random_range(-0.08..0.08);
        let middle = (near(x), near(y));
        let size = (rng.random_range(0.2..0.55), rng.random_range(0.2..0.55));
        world.with_turned_box(middle, size, rng.random_range(-1.5..1.5))
    };
    places.into_iter().take(missing).fold(world, add)
}
