//! The built-in worlds, one file each.
//!
//! | name | what it tests |
//! |---|---|
//! | `arena` | walls and boxes on one floor (TDK 2016 fig. 6.4); small enough for infra-red rangers |
//! | `doors` | rooms with door gaps: lines that look like one wall from afar (the TDK "door problem") |
//! | `office` | a corridor with rooms and furniture (Pilch 2016 §4.6) |
//! | `corridor` | 30 m without a feature: registration alone cannot tell how far the robot drove (Pilch 2016 fig. 4.4) |
//! | `loop` | a ring of more than 60 m: the accumulated error has to be corrected by closing the loop |
//! | `maze` | narrow passages that look alike, dead ends, several loops |
//! | `lab` | a corridor and a laboratory (Celej §3), with walls of glass and dark cupboards |
//! | `warehouse` | 1 000 walls: racks in rows that repeat, black pallets, a showcase of glass |
//! | `crowd` | a hall in which ten people walk and stop |
//! | `look-alikes` | ten equal rooms inside a ring corridor: every place has another that looks the same |
//! | `parallel` | four equal corridors side by side: from inside one, nothing shows which it is |
//! | `campus` | 50 000 walls: to measure the speed of the sensors |
//!
//! Partitions have two faces 0.10 m apart, door gaps are at least 0.9 m wide.

mod arena;
mod campus;
mod corridor;
mod crowd;
mod doors;
mod lab;
mod look_alikes;
mod maze;
mod office;
mod parallel;
mod ring;
#[cfg(test)]
mod tests;
mod warehouse;

use super::{Material, World};
use crate::geom::Pose2;

/// The name of a world, and the function that builds it.
type Entry = (&'static str, fn() -> World);

/// The one list of built-in worlds; commands, page and tests take their names from it.
const BUILTIN: [Entry; 12] = [
    ("arena", arena::world),
    ("doors", doors::world),
    ("office", office::world),
    ("corridor", corridor::world),
    ("loop", ring::world),
    ("maze", maze::world),
    ("lab", lab::world),
    ("warehouse", warehouse::world),
    ("crowd", crowd::world),
    ("look-alikes", look_alikes::world),
    ("parallel", parallel::world),
    ("campus", campus::world),
];

/// Names of the built-in worlds.
pub const NAMES: [&str; BUILTIN.len()] = names();

const fn names() -> [&'static str; BUILTIN.len()] {
    let mut names = [""; BUILTIN.len()];
    let mut index = 0;
    while index < names.len() {
        names[index] = BUILTIN[index].0;
        index += 1;
    }
    names
}

/// Thickness of a partition, m.
const PARTITION: f64 = 0.10;

/// The built-in world with this name; `None` if there is none.
#[must_use]
pub fn builtin(name: &str) -> Option<World> {
    let (_, world) = BUILTIN.iter().find(|(known, _)| *known == name)?;
    Some(world())
}

/// An empty hall from (0, 0) to an opposite corner; the robot starts at `start` and faces along x.
fn hall(name: &str, start: (f64, f64), (width, height): (f64, f64)) -> World {
    let corners = [(0.0, 0.0), (width, 0.0), (width, height), (0.0, height)];
    World::new(name, Pose2::new(start.0, start.1, 0.0)).with_room(&corners)
}

/// Adds a partition along x at `y`, from `x0` to `x1`, with gaps (from, to) in ascending order.
fn partition_along_x(world: World, y: f64, x0: f64, x1: f64, gaps: &[(f64, f64)]) -> World {
    let (low, high) = (y - 0.5 * PARTITION, y + 0.5 * PARTITION);
    solid_parts(x0, x1, gaps).fold(world, |w, (from, to)| w.with_box((from, low), (to, high)))
}

/// Adds a partition along y at `x`, from `y0` to `y1`, with gaps (from, to) in ascending order.
fn partition_along_y(world: World, x: f64, y0: f64, y1: f64, gaps: &[(f64, f64)]) -> World {
    let (low, high) = (x - 0.5 * PARTITION, x + 0.5 * PARTITION);
    solid_parts(y0, y1, gaps).fold(world, |w, (from, to)| w.with_box((low, from), (high, to)))
}

/// Adds a partition along y at `x`, of glass panes 0.2 m wide between opaque posts. One can look
/// through it but, unlike bare glass, it is not mistaken for free room: the gaps between the posts
/// are too narrow for a robot.
fn glazing_along_y(world: World, x: f64, y0: f64, y1: f64) -> World {
    let pane = World::with_box(world, (x - 0.01, y0), (x + 0.01, y1)).made_of(Material::Glass);
    let half = 0.5 * PARTITION;
    let posts = ((y1 - y0) / 0.3).ceil() as u32;
    (0..=posts).fold(pane, |world, post| {
        let y = y0 + (y1 - y0) * f64::from(post) / f64::from(posts);
        world.with_box((x - half, y - half), (x + half, y + half))
    })
}

/// The solid parts between `first` and `last` that gaps (from, to), in ascending order, leave:
/// where the wall of a partition with doors stands.
pub fn solid_parts(first: f64, last: f64, gaps: &[(f64, f64)]) -> impl Iterator<Item = (f64, f64)> {
    let begins = std::iter::once(first).chain(gaps.iter().map(|g| g.1));
    let ends = gaps.iter().map(|g| g.0).chain(std::iter::once(last));
    begins.zip(ends)
}
