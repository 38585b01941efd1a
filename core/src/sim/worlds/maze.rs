//! `maze`, 11.7 x 9.1 m: passages 1.2 m wide that all look alike, dead ends, and five loops. The
//! goal is in the far corner.

use super::{PARTITION, partition_along_x, partition_along_y};
use crate::geom::Pose2;
use crate::sim::World;

/// From the middle of a passage to the middle of the next, m.
const PITCH: f64 = 1.3;

/// Seen from above, with the northern wall as the first row. A depth-first search carved it; five
/// walls were then removed, which makes loops.
const PLAN: [&str; 15] = [
    "+--+--+--+--+--+--+--+--+--+",
    "|                          |",
    "+  +--+  +--+--+  +--+--+  +",
    "|     |        |     |     |",
    "+  +  +  +  +  +--+--+  +  +",
    "|  |     |  |        |     |",
    "+  +--+--+  +--+--+  +  +  +",
    "|        |        |     |  |",
    "+--+  +  +--+--+  +--+--+  +",
    "|     |              |     |",
    "+  +--+--+--+--+--+  +  +--+",
    "|  |                 |     |",
    "+  +  +  +--+--+--+--+--+  +",
    "|  |  |                    |",
    "+--+--+--+--+--+--+--+--+--+",
];
const COLS: usize = 9;
const ROWS: usize = 7;

pub(super) fn world() -> World {
    let (width, height) = (PITCH * COLS as f64, PITCH * ROWS as f64);
    let outline = [(0.0, 0.0), (width, 0.0), (width, height), (0.0, height)];
    let middle = |cell: usize| (cell as f64 + 0.5) * PITCH;
    let start = Pose2::new(middle(0), middle(0), std::f64::consts::FRAC_PI_2);
    let goal = (middle(COLS - 1), middle(ROWS - 1));
    let mut world = (World::new("maze", start).with_room(&outline)).with_goal(goal);
    for row in 1..ROWS {
        let y = PITCH * row as f64;
        for (from, to) in runs(COLS, |col| is_wall(2 * (ROWS - row), 3 * col + 1)) {
            let (first, last) = ends(from, to, COLS);
            world = partition_along_x(world, y, first, last, &[]);
        }
    }
    for col in 1..COLS {
        let x = PITCH * col as f64;
        for (from, to) in runs(ROWS, |row| is_wall(2 * (ROWS - row) - 1, 3 * col)) {
            let (first, last) = ends(from, to, ROWS);
            world = partition_along_y(world, x, first, last, &[]);
        }
    }
    world
}

fn is_wall(line: usize, column: usize) -> bool {
    let drawn = PLAN.get(line).and_then(|l| l.as_bytes().get(column));
    drawn.is_some_and(|b| *b == b'-' || *b == b'|')
}

/// The stretches of wall without a gap, as (first, one past the last).
fn runs(count: usize, is_wall: impl Fn(usize) -> bool) -> Vec<(usize, usize)> {
    let mut runs: Vec<(usize, usize)> = Vec::new();
    for cell in (0..count).filter(|cell| is_wall(*cell)) {
        match runs.last_mut() {
            Some(last) if last.1 == cell => last.1 = cell + 1,
            _ => runs.push((cell, cell + 1)),
        }
    }
    runs
}

/// Where a wall between two joints begins and ends: half a thickness beyond them, so corners close,
/// but never beyond the outline.
fn ends(from: usize, to: usize, count: usize) -> (f64, f64) {
    let joint = |cell: usize| PITCH * cell as f64;
    let most = joint(count);
    let first = joint(from) - 0.5 * PARTITION;
    let last = joint(to) + 0.5 * PARTITION;
    (first.max(0.0), last.min(most))
}
