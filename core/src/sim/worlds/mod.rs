//! The built-in worlds, one file each.
//!
//! | name | what it asks of a robot |
//! |---|---|
//! | `arena` | walls and boxes on one floor (TDK 2016 fig. 6.4); small enough for infra-red rangers |
//! | `doors` | rooms with door gaps: lines that look like one wall from afar (the TDK "door problem") |
//! | `office` | a corridor with rooms and furniture (Pilch 2016 §4.6) |
//! | `corridor` | 30 m without a feature: registration alone cannot tell how far it drove (Pilch 2016 fig. 4.4) |
//! | `loop` | a ring of more than 60 m: the error that gathers has to be closed |
//!
//! Partitions have two faces 0.10 m apart, door gaps are at least 0.9 m wide.

mod arena;
mod corridor;
mod doors;
mod office;
mod ring;

use super::World;

/// Names of the built-in worlds.
pub const NAMES: [&str; 5] = ["arena", "doors", "office", "corridor", "loop"];

/// Thickness of a partition, m.
const PARTITION: f64 = 0.10;

/// The built-in world of this name; `None` where there is none.
#[must_use]
pub fn builtin(name: &str) -> Option<World> {
    match name {
        "arena" => Some(arena::world()),
        "doors" => Some(doors::world()),
        "office" => Some(office::world()),
        "corridor" => Some(corridor::world()),
        "loop" => Some(ring::world()),
        _ => None,
    }
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

/// What the gaps leave of the way from `first` to `last`.
fn solid_parts(first: f64, last: f64, gaps: &[(f64, f64)]) -> impl Iterator<Item = (f64, f64)> {
    let begins = std::iter::once(first).chain(gaps.iter().map(|g| g.1));
    let ends = gaps.iter().map(|g| g.0).chain(std::iter::once(last));
    begins.zip(ends)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sim::{RobotKind, reachable_area};

    #[test]
    fn every_name_is_a_world_that_the_robot_can_start_in() {
        for name in NAMES {
            let world = builtin(name).unwrap();
            assert_eq!(world.name, name);
            // Room to turn and to see: twice the radius.
            assert_eq!(
                world.validate(2.0 * RobotKind::Rp6.model().radius()),
                Ok(()),
                "{name}"
            );
        }
        assert!(builtin("atlantis").is_none());
    }

    #[test]
    fn every_world_is_closed_and_its_rooms_are_connected() {
        for (name, least, most) in [
            ("arena", 16.0, 20.0),
            ("doors", 40.0, 48.0),
            ("office", 150.0, 192.0),
            ("corridor", 55.0, 60.0),
            ("loop", 120.0, 150.0),
        ] {
            let world = builtin(name).unwrap();
            let area = reachable_area(&world, 0.11, 0.05);
            let metres = area.square_metres();
            assert!(metres > least && metres < most, "{name}: {metres} m²");
            // Closed: the flood never came to the rim of the bitmap.
            let rim = area.standing.iter().enumerate().filter(|(i, _)| {
                let (row, col) = (i / area.cols, i % area.cols);
                row == 0 || col == 0 || row + 1 == area.rows || col + 1 == area.cols
            });
            assert!(rim.clone().all(|(_, stands)| !stands), "{name} leaks");
            // Connected, for a robot that keeps 0.25 m off the walls: nearly all that the small one reaches is in sight.
            let wide = reachable_area(&world, 0.35, 0.05);
            assert!(
                wide.count() as f64 > 0.97 * area.count() as f64,
                "{name}: {} of {}",
                wide.count(),
                area.count()
            );
            if let Some(goal) = world.goal {
                let near = area.centres().any(|p| (p - goal).norm() < 0.05);
                assert!(near, "{name}: goal cannot be reached");
            }
        }
    }
}
