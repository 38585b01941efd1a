//! A route to a random place of a simulated world, for reports and tests.

use std::collections::VecDeque;

use nalgebra::Point2;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use slamlab_core::sim::Simulation;

const CELL: f64 = 0.1;

/// A route to a random place, by breadth-first search over cells with room for the robot; world
/// frame.
pub(crate) fn errand(sim: &Simulation, rng: &mut ChaCha8Rng) -> VecDeque<Point2<f64>> {
    let (low, high) = sim.world().bounds();
    let (columns, rows) = (
        ((high.x - low.x) / CELL) as usize + 1,
        ((high.y - low.y) / CELL) as usize + 1,
    );
    let centre = |i: usize| {
        Point2::new(
            low.x + (i % columns) as f64 * CELL,
            low.y + (i / columns) as f64 * CELL,
        )
    };
    let cell = |p: Point2<f64>| {
        ((p.y - low.y) / CELL).round() as usize * columns + ((p.x - low.x) / CELL).round() as usize
    };
    let start = cell(sim.truth().position());
    let room = |i: usize| i == start || sim.caster().clearance(centre(i), 1.0) > 0.24;
    let mut from = vec![usize::MAX; columns * rows];
    from[start] = start;
    let (mut queue, mut reached) = (VecDeque::from([start]), vec![]);
    while let Some(i) = queue.pop_front() {
        reached.push(i);
        for next in [
            i + 1,
            i.wrapping_sub(1),
            i + columns,
            i.wrapping_sub(columns),
        ] {
            if next < from.len() && from[next] == usize::MAX && room(next) {
                from[next] = i;
                queue.push_back(next);
            }
        }
    }
    let mut at = reached[rng.random_range(0..reached.len())];
    let mut route = VecDeque::from([centre(at)]);
    while at != start {
        at = from[at];
        route.push_front(centre(at));
    }
    route
}
