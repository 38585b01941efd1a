//! `parallel`, 24 x 10.8 m: four equal corridors side by side, joined at both ends.
//!
//! ```text
//! y 10.8 +----------------------------+
//!        |          '        ,        |
//!        |   +--------------------+   |
//!        |          '        ,        |      four corridors, each with the same
//!        |   +--------------------+   |      two pilasters at the same places
//!        |          '        ,        |
//!        |   +--------------------+   |
//!        |          '        ,        |
//!      0 +----------------------------+
//!       x 0   1.8             22.2   24
//! ```
//!
//! From within a corridor nothing shows which one it is, and in the middle hardly anything shows
//! how far along it the robot is. The error gathered on the way up and down is as large as the
//! distance to the next corridor.

use super::hall;
use crate::sim::World;

const CORRIDORS: usize = 4;
/// Width of a corridor and of the ways that join them, m.
const WIDTH: f64 = 1.8;
/// Thickness of the blocks between two corridors, m.
const BETWEEN: f64 = 1.2;
/// Length of the building, m.
const LENGTH: f64 = 24.0;

pub(super) fn world() -> World {
    let pitch = WIDTH + BETWEEN;
    let height = pitch * CORRIDORS as f64 - BETWEEN;
    let hall = hall("parallel", (1.0, 0.9), (LENGTH, height)).with_goal((12.0, height - 0.9));
    let corridor = |world: World, index: usize| {
        let low = pitch * index as f64;
        let high = low + WIDTH;
        world
            .with_box((7.0, high - 0.3), (7.4, high))
            .with_box((15.0, low), (15.6, low + 0.25))
    };
    let between = |world: World, index: usize| {
        let low = pitch * index as f64 + WIDTH;
        world.with_box((WIDTH, low), (LENGTH - WIDTH, low + BETWEEN))
    };
    let world = (0..CORRIDORS).fold(hall, corridor);
    (1..CORRIDORS).fold(world, |world, index| between(world, index - 1))
}
