//! The topology of the built-in worlds, drawn exactly: the number of rooms, corridors and doors in
//! them is known by looking.
#![allow(clippy::unwrap_used)] // Helpers of tests may panic as tests do.
#![allow(missing_docs, reason = "a test binary has no public interface")]

use nalgebra::Point2;
use slamlab_core::geom::{Pose2, sin_cos};
use slamlab_core::map::{CellIndex, CellRect, CellState, RegionKind, Topology, TopologyConfig};
use slamlab_core::sim::{Caster, World, worlds};

const CELL: f64 = 0.05;

/// The world as a grid turned by `turn` holds it: walls, the floor that a flood fill from the start
/// reaches, the rest unknown.
fn drawn(world: &World, turn: f64) -> (CellRect, Vec<CellState>) {
    let (low, high) = world.bounds();
    // Offset by less than a cell, so no wall lies on the border between two cells.
    let map_from_world = Pose2::new(0.0137, 0.0091, turn);
    let corners = [
        (low.x, low.y),
        (high.x, low.y),
        (high.x, high.y),
        (low.x, high.y),
    ];
    let corners = corners.map(|(x, y)| (map_from_world * Point2::new(x, y)) / CELL);
    let over = |least: fn(f64, f64) -> f64, of: fn(&Point2<f64>) -> f64| {
        corners.iter().map(of).reduce(least).unwrap_or(0.0) as i32
    };
    let rect = CellRect {
        min: CellIndex::new(over(f64::min, |p| p.x) - 4, over(f64::min, |p| p.y) - 4),
        max: CellIndex::new(over(f64::max, |p| p.x) + 5, over(f64::max, |p| p.y) + 5),
    };
    let caster = Caster::new(world.walls());
    let centre = |index: usize| {
        let (col, row) = (index % rect.width(), index / rect.width());
        let at = Point2::new(
            f64::from(rect.min.col) + col as f64 + 0.5,
            f64::from(rect.min.row) + row as f64 + 0.5,
        ) * CELL;
        map_from_world.inverse() * at
    };
    // Distance from the centre of a cell within which a wall along the world's axes touches the
    // cell.
    let (sin, cos) = sin_cos(turn);
    let near = 0.5 * CELL * (sin.abs() + cos.abs());
    let mut states: Vec<CellState> = (0..rect.width() * rect.height())
        .map(|i| match caster.clearance(centre(i), near) < near {
            true => CellState::Occupied,
            false => CellState::Unknown,
        })
        .collect();
    let start = (map_from_world * world.start.position()) / CELL;
    let (col, row) = (
        start.x.floor() as i32 - rect.min.col,
        start.y.floor() as i32 - rect.min.row,
    );
    let mut front = vec![row as usize * rect.width() + col as usize];
    while let Some(at) = front.pop() {
        if states[at] == CellState::Unknown {
            states[at] = CellState::Free;
            front.extend([at - 1, at + 1, at - rect.width(), at + rect.width()]);
        }
    }
    (rect, states)
}

fn topology(name: &str, turn: f64) -> Topology {
    let world = worlds::builtin(name).unwrap();
    let (rect, states) = drawn(&world, turn);
    Topology::of_cells(rect, CELL, &states, &TopologyConfig::default())
}

/// World, rooms, corridors, widths of the doors.
fn check(name: &str, rooms: usize, corridors: usize, doors: &[f64]) {
    for degrees in [0.0, 15.0, 45.0] {
        let found = topology(name, f64::to_radians(degrees));
        let count = |kind| found.regions().iter().filter(|r| r.kind == kind).count();
        let told = (count(RegionKind::Room), count(RegionKind::Corridor));
        assert_eq!(
            told,
            (rooms, corridors),
            "{name} at {degrees}°: {:#?}",
            found.regions()
        );
        let mut widths: Vec<f64> = found.doors().iter().map(|door| door.width).collect();
        widths.sort_by(f64::total_cmp);
        assert_eq!(
            widths.len(),
            doors.len(),
            "{name} at {degrees}°: {widths:?}"
        );
        for (width, truth) in widths.iter().zip(doors) {
            assert!(
                (width - truth).abs() < 2.0 * CELL,
                "{name} at {degrees}°: {widths:?}"
            );
        }
    }
}

#[test]
fn halls_are_one_room_whatever_stands_in_them() {
    check("arena", 1, 0, &[]);
    check("crowd", 1, 0, &[]);
}

#[test]
fn bare_corridors_are_one_corridor() {
    check("corridor", 0, 1, &[]);
    check("loop", 0, 1, &[]);
    check("parallel", 0, 1, &[]);
}

#[test]
fn doors_has_four_rooms() {
    check("doors", 4, 0, &[0.9; 4]);
}

#[test]
fn office_has_eight_rooms_along_a_corridor() {
    check("office", 8, 1, &[1.0; 10]);
}

#[test]
fn look_alikes_has_ten_rooms_within_a_ring() {
    check("look-alikes", 10, 1, &[1.0; 10]);
}

#[test]
fn lab_has_a_laboratory_and_an_office_along_a_corridor() {
    check("lab", 2, 1, &[1.0, 1.0, 1.2]);
}

#[test]
fn warehouse_is_a_hall_with_an_office() {
    check("warehouse", 1, 1, &[1.2]);
}
